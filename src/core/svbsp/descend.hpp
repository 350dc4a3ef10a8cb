// The one way down a tree of dividing planes: for insertion, the k-d tree, fragment emission, the
// light overlay and the error bound.
//
// Depth first. Nothing recurses, so no depth overflows.
#pragma once

#include "clipping/clip.hpp"
#include "svbsp/nodes.hpp"

namespace shadowcut {

// What a descent asks. Visitors derive from this and hide what they need.
//
//   CellPredicates cell_predicates()
//       lines and signs, as they are now
//   bool stops_at(Place place, TreeBranch here, std::uint32_t& tag)
//       whether a cone stops at a place. It must at leaves.
//   void arrive(Cone* cone, Place place)
//       the cone has stopped; takes the cone
struct DescentVisitor {
  // The side of a cut that goes on first (0 positive, 1 negative): the order of arrivals.
  static constexpr std::uint32_t first_side = 0;
  // Whether a node may serve an edge of the cone that lies on it as the end of the cell; see
  // mark_bounded_edges().
  bool bounds(NodeId, const Cone&) { return true; }
  // The id under which a cut along a node's line is known from now on.
  LineId name_of_cut(const DividingLine& line) { return line.id; }
  // A cone has been cut in two. Takes the cone.
  void was_cut(Cone* cone, Workspace& w) { w.pool.give_back(cone); }
  // Takes a cone at a PP-node; returns what goes on in front of it, or null.
  Cone* pass_pp_node(Cone* cone, NodeId) { return cone; }

  SignCounts counts;
  std::uint64_t sign_tests = 0;
};

// Sends a cone past an SP-node, or a node of the k-d tree. Returns the side on which it goes on. A
// cone on both sides is cut: it goes on as the part on the visitor's first side, and its other part
// is `cut_off`, which is null otherwise.
template <class Visitor>
std::uint32_t pass_sp_node(Cone*& cone, DividingLine line, NodeId node, Workspace& w,
                           Visitor& visitor, Cone*& cut_off) {
  SHADOWCUT_ASSERT(cone && cone->count >= 3);
  cut_off = nullptr;
  visitor.sign_tests += cone->count;
  const CornerSides sides =
      sides_of_line(*cone, line, visitor.cell_predicates(), w.spill, visitor.counts);
  if (sides.positive() && sides.negative()) {
    line.id = visitor.name_of_cut(line);
    Cone* whole = cone;
    Cone* parts[2];
    split(*whole, sides, line, true, visitor.cell_predicates(), w.pool, parts[0], parts[1]);
    cone = parts[Visitor::first_side], cut_off = parts[1 - Visitor::first_side];
    visitor.was_cut(whole, w);
    return Visitor::first_side;
  }
  const std::uint32_t side = sides.negative() ? 1 : 0;
  if (sides.any_on()) {
    mark_bounded_edges(*cone, sides, line, side, visitor.cell_predicates(),
                       [&](EdgeRef) { return visitor.bounds(node, *cone); });
  }
  return side;
}

// Sends a cone down from a place. Takes the cone. Tree: branch(place), dividing_line(node).
// `tag` goes with the cone and its parts, and is the visitor's to change.
template <class Tree, class Visitor>
void descend(const Tree& tree, Cone* first, Place from, std::uint32_t tag, Workspace& w,
             Visitor& visitor) {
  const std::size_t bottom = w.pending.size();
  w.pending.push_back({first, from.value(), tag});
  while (w.pending.size() > bottom) {
    auto [cone, at, way] = w.pending.back();
    w.pending.pop_back();
    SHADOWCUT_ASSERT(cone != nullptr);
    Place place(at);
    while (cone) {
      const auto here = tree.branch(place);
      if (visitor.stops_at(place, here, way)) {
        visitor.arrive(cone, place);
        break;
      }
      if (here.is_pp()) {
        cone = visitor.pass_pp_node(cone, here.node());
        place = Place(here.node(), 0);
        continue;
      }
      Cone* cut_off;
      const std::uint32_t side =
          pass_sp_node(cone, tree.dividing_line(here.node()), here.node(), w, visitor, cut_off);
      place = Place(here.node(), side);
      if (cut_off) w.pending.push_back({cut_off, Place(here.node(), 1 - side).value(), way});
    }
  }
}

}  // namespace shadowcut
