#include "fragments/fragment_store.hpp"

#include <algorithm>
#include <cmath>

#include "fragments/conforming.hpp"
#include "support/progress.hpp"

namespace shadowcut {

void FragmentStore::emit_all(std::uint32_t update, const std::function<void(double)>& report) {
  if (incremental_) {
    emit_incremental(update);
  } else {
    emit_static(report);
  }
}

void FragmentStore::emit_incremental(std::uint32_t update) {
  cells_.clear();
  cells_.reserve(grid_.size());
  for (std::size_t c = 0; c < grid_.size(); ++c) cells_.emplace_back(CellId(c));
  blocks_.resize(grid_.size() + 1);
  parallel_for(grid_.size(), 1, [&](std::size_t c) {
    cells_[c].start(grid_[CellId(c)], context_, workspaces_.local(), blocks_[c], update);
  });
  const std::size_t facets = context_.scene.facets().size();
  away_.assign(facets, invalid_index);
  away_born_.assign(facets, update);
  CellOutput out;
  emit_all_away(out);
  for (std::uint32_t i = 0; i < out.block.fragments.size(); ++i)
    away_[out.block.fragments[i].facet] = i;
  blocks_.back() = std::move(out.block);
  away_corners_.clear();
}

void FragmentStore::emit_static(const std::function<void(double)>& report) {
  std::vector<CellOutput> outputs(grid_.size() + 1);
  Progress progress(report, 0.8, 1, grid_.size());
  parallel_for(grid_.size(), 1, [&](std::size_t c) {
    emit_cell(grid_[CellId(c)], CellId(c), context_, workspaces_.local(), outputs[c]);
    progress.step();
  });
  emit_all_away(outputs.back());
  // Areas first: the conforming form moves corners by their last bits, and leaves out slivers that
  // are nothing but those bits.
  emitted_areas_.assign(context_.scene.faces().size(), {});
  for (const CellOutput& o : outputs) {
    for (const Fragment& f : o.block.fragments)
      (f.lit ? emitted_areas_[f.face].lit : emitted_areas_[f.face].shadowed) += f.area;
  }
  if (context_.form == Form::conforming) make_conforming(context_.scene, outputs);
  blocks_.clear();
  blocks_.reserve(outputs.size());
  for (CellOutput& o : outputs) blocks_.push_back(std::move(o.block));
}

// Sides turned away: one shadowed fragment for each facet. The block has room for its corners.
Fragment FragmentStore::emit_away(FacetId id, std::uint32_t first_corner, Block& block) const {
  const Facet& facet = context_.tables.facet(id);
  std::uint32_t at = first_corner;
  SHADOWCUT_ASSERT(first_corner + facet.corner_count <= block.corners.size());
  for (const Corner& c : context_.scene.corners_of(facet)) {
    block.corners[at] = context_.scene.vertices()[c.vertex];
    if (context_.constructions) block.constructions[at] = {{}, {}, c.vertex};
    ++at;
  }
  return {away_fragment_id(grid_.size(), id),
          facet.face,
          id.value(),
          invalid_index,
          first_corner,
          facet.corner_count,
          false,
          area_of_facet(context_, id, false)};
}

void FragmentStore::emit_all_away(CellOutput& out) const {
  Block& block = out.block;
  for (std::size_t i = 0; i < context_.scene.facets().size(); ++i) {
    const FacetId facet(i);
    if (!context_.visibility.is_away(facet)) continue;
    const auto first = static_cast<std::uint32_t>(block.corners.size());
    const auto corners = context_.scene.corners_of(context_.tables.facet(facet));
    block.corners.resize(first + corners.size());
    if (context_.constructions) block.constructions.resize(block.corners.size());
    block.fragments.push_back(emit_away(facet, first, block));
    if (!context_.keeps_lines()) continue;
    for (const Corner& c : corners) out.edge_lines.push_back(c.edge >> 1);
  }
}

void FragmentStore::grow(std::size_t facets) {
  if (away_.size() < facets) away_.resize(facets, invalid_index), away_born_.resize(facets, 0u);
}

bool FragmentStore::add_away(FacetId facet, std::uint32_t update, AreaChange& change) {
  if (!incremental_) return false;
  Block& block = blocks_.back();
  const std::uint32_t first =
      away_corners_.take(block.corners, context_.tables.facet(facet).corner_count);
  if (context_.constructions) block.constructions.resize(block.corners.size());
  const Fragment f = emit_away(facet, first, block);
  SHADOWCUT_ASSERT(away_[facet.value()] == invalid_index);
  away_[facet.value()] = static_cast<std::uint32_t>(block.fragments.size());
  away_born_[facet.value()] = update;
  block.fragments.push_back(f);
  away_added_.push_back(f.id);
  change = {f.face, false, true, f.area};
  return true;
}

bool FragmentStore::remove_away(FacetId facet, std::uint32_t update, AreaChange& change) {
  if (!incremental_ || away_[facet.value()] == invalid_index) return false;
  Block& block = blocks_.back();
  const std::uint32_t index = away_[facet.value()];
  const Fragment f = block.fragments[index];
  if (away_born_[facet.value()] != update) gone_.push_back(f.id);
  away_corners_.give_back(f.first_corner, f.corner_count);
  change = {f.face, false, false, f.area};
  SHADOWCUT_ASSERT(index < block.fragments.size() && f.facet == facet.value());
  block.fragments[index] = block.fragments.back();
  away_[block.fragments[index].facet] = index;
  block.fragments.pop_back();
  away_[facet.value()] = invalid_index;
  return true;
}

void FragmentStore::begin_update() {
  gone_.clear();
  away_added_.clear();
  before_.clear();
}

void FragmentStore::note_all_gone(std::uint32_t update, bool edited, bool rebuilt) {
  if (incremental_) {
    for (std::size_t c = 0; c < cells_.size(); ++c) cells_[c].list_old(blocks_[c], update, gone_);
    for (const Fragment& f : blocks_.back().fragments) {
      if (away_born_[f.facet] != update) gone_.push_back(f.id);
    }
  } else if (!rebuilt) {
    for (const Block& block : edited ? before_ : blocks_) {
      for (const Fragment& f : block.fragments) gone_.push_back(f.id);
    }
  }
}

void FragmentStore::list_all(LightChanges& changes) const {
  changes.gone = gone_;
  for (const Block& block : blocks_) {
    for (std::uint32_t i = 0; i < block.fragments.size(); ++i)
      changes.added.push_back({block.fragments[i].id, i});
  }
}

void FragmentStore::list_changes(std::span<const CellId> touched, LightChanges& changes) {
  changes.gone = gone_;
  std::size_t gone = changes.gone.size(), added = away_added_.size();
  for (const CellId c : touched)
    gone += cells_[c.value()].gone().size(), added += cells_[c.value()].most_added();
  changes.gone.reserve(gone);
  changes.added.reserve(added);
  for (const CellId c : touched) {
    CellFragments& cell = cells_[c.value()];
    changes.gone.insert(changes.gone.end(), cell.gone().begin(), cell.gone().end());
    cell.list_added(changes.added);
  }
  sort_unique(away_added_);
  for (const FragmentId& id : away_added_) {
    if (away_[id.piece] != invalid_index) changes.added.push_back({id, away_[id.piece]});
  }
}

namespace {

// A fragment and its block.
struct Located {
  const Block* block;
  const Fragment* fragment;
};

std::vector<Located> sorted_by_id(const std::vector<Block>& blocks) {
  std::vector<Located> all;
  for (const Block& block : blocks) {
    for (const Fragment& f : block.fragments) all.push_back({&block, &f});
  }
  std::sort(all.begin(), all.end(),
            [](const Located& a, const Located& b) { return a.fragment->id < b.fragment->id; });
  return all;
}

// 0 and -0 differ: a mirror of the fragments holds either.
bool same_bits(const Vec3& x, const Vec3& y) {
  return std::equal(x.begin(), x.end(), y.begin(), [](double c, double d) {
    return c == d && std::signbit(c) == std::signbit(d);
  });
}

bool same_fragment(const Located& a, const Located& b) {
  const Fragment &f = *a.fragment, &g = *b.fragment;
  const auto x = a.block->corners_of(f), y = b.block->corners_of(g);
  return f.face == g.face && f.facet == g.facet && f.caster == g.caster && f.lit == g.lit &&
         f.area == g.area && std::equal(x.begin(), x.end(), y.begin(), y.end(), same_bits);
}

}  // namespace

// Against before_: fragments that are equal to the bit have not changed.
void FragmentStore::list_differences(LightChanges& changes) const {
  changes.gone = gone_;
  const std::vector<Located> before = sorted_by_id(before_), now = sorted_by_id(blocks_);
  const auto lost = [&](const Located& a) { changes.gone.push_back(a.fragment->id); };
  const auto found = [&](const Located& a) {
    changes.added.push_back(
        {a.fragment->id, static_cast<std::uint32_t>(a.fragment - a.block->fragments.data())});
  };
  auto b = before.begin();
  auto n = now.begin();
  while (b != before.end() || n != now.end()) {
    if (n == now.end() || (b != before.end() && b->fragment->id < n->fragment->id)) {
      lost(*b++);
    } else if (b == before.end() || n->fragment->id < b->fragment->id) {
      found(*n++);
    } else {
      if (!same_fragment(*b, *n)) lost(*b), found(*n);
      ++b, ++n;
    }
  }
}

const Fragment* FragmentStore::find(FragmentId id) const {
  if (id.cell >= blocks_.size()) return nullptr;
  const auto& fragments = blocks_[id.cell].fragments;
  if (!incremental_) {
    const auto f = std::find_if(fragments.begin(), fragments.end(),
                                [&](const Fragment& g) { return g.id == id; });
    return f == fragments.end() ? nullptr : &*f;
  }
  std::uint32_t i = invalid_index;
  if (id.cell < cells_.size()) {
    i = cells_[id.cell].find(id);
  } else if (id.place == invalid_index && id.piece < away_.size()) {
    i = away_[id.piece];
  }
  return i == invalid_index ? nullptr : &fragments[i];
}

std::uint64_t FragmentStore::bytes(CellId cell) const {
  const Block& block = blocks_[cell.value()];
  return block.fragments.size() * sizeof(Fragment) + block.corners.size() * sizeof(Vec3) +
         (incremental_ && cell.value() < cells_.size() ? cells_[cell.value()].bytes() : 0);
}

std::string FragmentStore::validate(CellId cell) const {
  if (!incremental_) return {};
  return cells_[cell.value()].validate(grid_[cell], context_, blocks_[cell.value()]);
}

}  // namespace shadowcut
