// The balanced prefix: a k-d tree of plain dividing planes through the light, by median splits of
// the facets' ray directions. Its cells are small trees of their own, built by one thread each.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lines.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {

class Prefix {
 public:
  // One unit ray for each facet. `far`: the rays lie in a bundle around the third axis
  // (LightSpace::far), otherwise anywhere. Appends its lines to `lines`.
  Prefix(std::vector<Vec3> rays, bool far, std::uint32_t facets_per_cell, std::vector<Line>& lines);

  struct Branch {  // a node, or a cell
    std::uint32_t bits;
    static Branch cell(std::uint32_t i) { return {i << 1 | 1}; }
    static Branch node(std::uint32_t i) { return {i << 1}; }
    bool is_cell() const { return bits & 1; }
    std::uint32_t index() const { return bits >> 1; }
  };
  struct Node {
    std::uint32_t line;
    Branch side[2];  // positive, negative
  };

  std::size_t cell_count() const { return cells_; }
  std::span<const Node> nodes() const { return nodes_; }
  Branch root() const { return root_; }
  std::uint32_t depth_of(std::uint32_t cell) const { return depth_[cell]; }

  // The part of a cone that filter() delivers to one cell. Takes the cone; null if none comes
  // there.
  Cone* part_in(std::uint32_t cell, Cone* cone, const Lines& lines, ConePool& pool,
                std::vector<std::int8_t>& spill) const {
    std::vector<Step> way;
    for (Step s = cell_above_[cell]; s.node != none; s = node_above_[s.node]) way.push_back(s);
    SignCounts counts;
    for (auto s = way.rbegin(); s != way.rend(); ++s) {
      const Line& line = lines(nodes_[s->node].line);
      Cone* cut_off;
      const std::uint32_t side = sift(
          cone, line.n, line.error, nodes_[s->node].line, lines, [](EdgeRef) { return true; }, pool,
          spill, cut_off, counts);
      if (side != s->side) std::swap(cone, cut_off);
      if (cut_off) pool.give_back(cut_off);
      if (!cone) return nullptr;
    }
    return cone;
  }

  // Filters a cone into the cells it meets; deliver(cell, cone) takes each part.
  template <class Deliver>
  void filter(Cone* cone, const Lines& lines, ConePool& pool, std::vector<std::int8_t>& spill,
              std::vector<Cone*>& pending, Deliver deliver) const {
    cone->at = root_.bits;
    SignCounts counts;
    const std::size_t bottom = pending.size();
    pending.push_back(cone);
    while (pending.size() > bottom) {
      cone = pending.back();
      pending.pop_back();
      Branch here{cone->at};
      while (!here.is_cell()) {
        const Node& node = nodes_[here.index()];
        const Line& line = lines(node.line);
        Cone* cut_off;
        here = node.side[sift(
            cone, line.n, line.error, node.line, lines, [](EdgeRef) { return true; }, pool, spill,
            cut_off, counts)];
        if (cut_off) {
          cut_off->at = node.side[1].bits;
          pending.push_back(cut_off);
        }
      }
      deliver(here.index(), cone);
    }
  }

 private:
  struct Step {
    std::uint32_t node, side;  // node: none above the root
  };

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> depth_;  // by cell
  std::vector<Step> cell_above_, node_above_;
  Branch root_ = Branch::cell(0);
  std::size_t cells_ = 0;
};

}  // namespace shadowcut::SHADOWCUT_NUMBERS
