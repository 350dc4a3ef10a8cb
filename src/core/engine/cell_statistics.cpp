#include "engine/cell_statistics.hpp"

namespace shadowcut {

void CellStatistics::start() {
  sums_.resize(grid_.size());
  for (std::size_t c = 0; c < grid_.size(); ++c) {
    sums_[c] = sums_of(CellId(c));
    add(sums_[c], true);
  }
}

void CellStatistics::update(CellId cell) {
  SHADOWCUT_ASSERT(cell.value() < sums_.size());
  Sums& sums = sums_[cell.value()];
  add(sums, false);
  sums = sums_of(cell);
  add(sums, true);
}

CellStatistics::Sums CellStatistics::sums_of(CellId cell) const {
  const SvbspTree& tree = grid_[cell];
  const TreeCounts& n = tree.counts;
  return {tree.node_count(),
          tree.pp_nodes(),
          tree.pieces.piece_count(),
          tree.lines.size(),
          n.predicates,
          n.signs.on,
          n.signs.by_identity,
          n.signs.by_exact,
          tree.marked_nodes(),
          n.joined,
          n.deferred,
          policy_.rebuilds(cell),
          tree.bytes() + fragments_.bytes(cell)};
}

void CellStatistics::add(const Sums& n, bool more) {
  Stats& s = stats_;
  const auto add = [more](std::uint64_t& sum, std::uint64_t k) { more ? sum += k : sum -= k; };
  add(s.nodes, n.nodes), add(s.sp_nodes, n.nodes - n.pp_nodes), add(s.pp_nodes, n.pp_nodes);
  add(s.pieces, n.pieces), add(s.crossing_lines, n.crossing_lines);
  add(s.predicates, n.predicates), add(s.on, n.on), add(s.marked_nodes, n.marked);
  add(s.by_identity, n.by_identity), add(s.by_exact, n.by_exact);
  s.by_filter = s.predicates - s.by_identity - s.by_exact;
  add(s.joined, n.joined), add(s.deferred, n.deferred), add(s.cells_rebuilt, n.rebuilds);
  add(s.bytes, n.bytes);
  SHADOWCUT_ASSERT(s.nodes == s.sp_nodes + s.pp_nodes &&
                   s.predicates >= s.by_identity + s.by_exact);
}

}  // namespace shadowcut
