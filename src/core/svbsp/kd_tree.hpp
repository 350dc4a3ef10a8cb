// The balanced prefix above the SVBSP trees: a k-d tree of plain dividing planes through the light,
// by median splits of the facets' ray directions. Each cell is an SVBSP tree of its own, built by
// one thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clipping/clip.hpp"
#include "svbsp/nodes.hpp"

namespace shadowcut {

class KdTree {
 public:
  // One unit ray for each facet. `far`: the rays are in a bundle around the third axis
  // (LightSpace::far), otherwise anywhere. Adds its dividing lines to `lines`. `facets_per_cell`:
  // where it stops dividing; 0: one cell.
  KdTree(std::vector<Vec3> rays, bool far, std::uint32_t facets_per_cell, LineTable& lines);

  class Branch {  // leads to a node, or to a cell
   public:
    static Branch cell(CellId i) { return Branch(i.value() << 1 | 1); }
    static Branch node(NodeId i) { return Branch(i.value() << 1); }
    bool is_cell() const { return bits_ & 1; }
    bool is_pp() const { return false; }
    CellId cell() const {
      SHADOWCUT_ASSERT(is_cell());
      return CellId(bits_ >> 1);
    }
    NodeId node() const {
      SHADOWCUT_ASSERT(!is_cell());
      return NodeId(bits_ >> 1);
    }

   private:
    explicit Branch(std::uint32_t bits) : bits_(bits) {}
    std::uint32_t bits_;
  };

  std::size_t cell_count() const { return cell_above_.size(); }
  std::size_t node_count() const { return nodes_.size(); }
  std::uint32_t depth_of(CellId cell) const {
    SHADOWCUT_ASSERT(cell.value() < depth_.size());
    return depth_[cell.value()];
  }
  // As descend() asks.
  Branch branch(Place place) const {
    return place.is_root() ? root_ : nodes_[place.node().value()].side[place.side()];
  }
  DividingLine dividing_line(NodeId node) const {
    const LineId id = nodes_[node.value()].line;
    const Line& line = (*lines_)[id];
    return {line.n, line.error, id};
  }

  // The part of a cone that a descent delivers to one cell. Takes the cone; null if nothing of it
  // gets there.
  Cone* part_in(CellId cell, Cone* cone, const CellPredicates& predicates, Workspace& w) const;

 private:
  struct Node {
    LineId line;
    Branch side[2];  // positive, negative
  };

  const LineTable* lines_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> depth_;            // by cell
  std::vector<Place> cell_above_, node_above_;  // by cell, by node: where the branch to it hangs
  Branch root_ = Branch::cell(CellId(0u));
};

}  // namespace shadowcut
