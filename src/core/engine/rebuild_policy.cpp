#include "engine/rebuild_policy.hpp"

#include <algorithm>

namespace shadowcut {
namespace {

constexpr double growth_allowed = 1.1;        // of a cell, by edits
constexpr double growth_with_backoff = 1.75;  // while it waits
constexpr std::uint64_t edits_per_entry = 4;  // allowed when several objects move
constexpr std::size_t movers_remembered = 4;  // by a cell
constexpr std::uint32_t largest_backoff = 6;

// A large face that comes last is cut by everything that was there before it, and one that goes
// leaves all that was behind it to be inserted last: the cell had better be built again.
bool is_much(const SvbspTree& tree, std::size_t pieces) {
  return pieces >= 16 && 12 * pieces >= tree.pieces.piece_count();
}

}  // namespace

void RebuildPolicy::start(std::size_t cells) { cells_.assign(cells, {}); }

void RebuildPolicy::note_built(CellId id, const SvbspTree& tree) {
  Cell& cell = cells_[id.value()];
  const std::size_t entries = std::max<std::size_t>(tree.pieces.entry_count(), 1);
  cell.nodes_per_entry = static_cast<double>(tree.node_count()) / static_cast<double>(entries);
  cell.edits = cell.changes_of_mover = 0;
  cell.shattered = false;
}

void RebuildPolicy::note_removal(CellId id, const SvbspTree& tree, std::size_t pieces) {
  Cell& cell = cells_[id.value()];
  cell.shattered = cell.shattered || is_much(tree, pieces);
}

void RebuildPolicy::note_mover(CellId id, std::uint32_t object, std::uint32_t update) {
  Cell& cell = cells_[id.value()];
  SHADOWCUT_ASSERT(cell.movers.size() <= movers_remembered);
  ++cell.edits;
  auto& movers = cell.movers;
  const auto known = std::find_if(movers.begin(), movers.end(),
                                  [object](const Mover& m) { return m.object == object; });
  if (known != movers.end()) {
    known->times += known->update != update;
    known->update = update;
    std::rotate(known, known + 1, movers.end());
    return;
  }
  ++cell.changes_of_mover;
  if (movers.size() == movers_remembered) movers.erase(movers.begin());
  movers.push_back({object, update, 1});
}

void RebuildPolicy::note_insertion(CellId id, const SvbspTree& tree, EntryId entry,
                                   std::uint32_t object) {
  if (!is_much(tree, tree.pieces.entry(entry).pieces)) return;
  Cell& cell = cells_[id.value()];
  cell.shattered = true;
  for (Mover& m : cell.movers) {
    if (m.object == object) m.times = 0;
  }
}

bool RebuildPolicy::should_rebuild(CellId id, const SvbspTree& tree) const {
  SHADOWCUT_ASSERT(id.value() < cells_.size());
  const Cell& cell = cells_[id.value()];
  const std::size_t entries = tree.pieces.entry_count();
  const auto exceeds = [&](double growth) {
    return static_cast<double>(tree.node_count()) >
           growth * cell.nodes_per_entry * static_cast<double>(entries) + 4;
  };
  const std::uint32_t backoff = exceeds(growth_with_backoff) ? 0 : cell.backoff;
  if (cell.changes_of_mover == 0 && cell.edits < entries << backoff) return false;
  return cell.shattered || exceeds(growth_allowed) ||
         (cell.edits > edits_per_entry * entries + 64 &&
          cell.changes_of_mover >= movers_remembered);
}

std::vector<std::uint32_t> RebuildPolicy::movers_at_leaves(
    CellId id, const SvbspTree& tree, std::span<const std::uint32_t> objects) const {
  std::vector<std::uint32_t> at_leaves;
  for (const Mover& m : cells_[id.value()].movers) {
    const bool here = std::binary_search(objects.begin(), objects.end(), m.object);
    if (m.times >= 2 * objects.size() && here && tree.tables().objects[m.object].casts_shadows &&
        at_leaves.size() < objects.size() / 4)
      at_leaves.push_back(m.object);
  }
  return at_leaves;
}

void RebuildPolicy::note_rebuilt(CellId id, const SvbspTree& tree) {
  Cell& cell = cells_[id.value()];
  cell.backoff = cell.changes_of_mover == 0 ? std::min(cell.backoff + 1, largest_backoff) : 0;
  note_built(id, tree);
  SHADOWCUT_ASSERT(cell.edits == 0 && !cell.shattered);
  ++cell.rebuilds;
}

}  // namespace shadowcut
