// One cone on its way down a cell's tree (CS95, section 2): the paper's three cases.
#pragma once

#include "svbsp/descend.hpp"
#include "svbsp/svbsp_tree.hpp"

namespace shadowcut {

// SP-nodes cut the cone (pass_sp_node(), descend.hpp). A PP-node stores the part behind its plane,
// shadowed; the part in front goes on. At an OUT leaf the cone's shadow volume is attached.
class Insertion : public DescentVisitor {
 public:
  // `merge`: pieces that come to a PP-node's list merge with pieces of their facet there.
  Insertion(SvbspTree& tree, bool merge, Workspace& w) : tree_(tree), merge_(merge), w_(w) {}
  Insertion(const Insertion&) = delete;
  Insertion& operator=(const Insertion&) = delete;
  ~Insertion();  // adds the counts of signs to the tree's

  CellPredicates cell_predicates() const { return tree_.predicates(); }
  bool stops_at(Place, Branch here, std::uint32_t&) const { return here.is_out(); }
  // Under edits, a node of another object may go while this facet stays: the node serves as an end
  // only where it cuts the facet itself.
  bool bounds(NodeId node, const Cone& cone) const;
  // A cone on both sides of the plane is cut by it (cut_by_plane()).
  Cone* pass_pp_node(Cone* cone, NodeId pp);
  // At a leaf. A facet that does not cast rests there.
  void arrive(Cone* cone, Place leaf);

 private:
  // Cuts a cone along the line in which its facet's plane crosses another plane. The line becomes
  // an SP-node of the part in front when that part attaches its shadow volume.
  void cut_by_plane(const Cone& cone, const CornerSides& sides, const PlaneDifference& nearer,
                    std::uint32_t other, Cone*& front, Cone*& behind);
  void rest_in_list(Cone* cone, Piece::Kind kind, NodeId pp);
  // Pieces that rested at a leaf without casting go on from there, below the new shadow volume.
  void push_resting_pieces(Place leaf);
  // Replaces a leaf by the shadow volume of a piece: an SP-node for each edge at which the cell
  // does not already end, then the piece's PP-node.
  void attach_shadow_volume(const Cone& cone, Place leaf);

  SvbspTree& tree_;
  bool merge_;
  Workspace& w_;
};

}  // namespace shadowcut
