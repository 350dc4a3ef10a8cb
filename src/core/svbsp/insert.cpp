// Insertion into a cell's tree (CS95, section 2).

#include <algorithm>

#include "svbsp/displaced.hpp"
#include "svbsp/insertion.hpp"
#include "svbsp/join.hpp"

namespace shadowcut {

Insertion::~Insertion() {
  tree_.counts.predicates += sign_tests;
  tree_.counts.signs.on += counts.on;
  tree_.counts.signs.by_identity += counts.by_identity;
  tree_.counts.signs.by_exact += counts.by_exact;
}

bool Insertion::bounds(NodeId node, const Cone& cone) const {
  if (!tree_.settings().edits) return true;
  const NodeLinks& links = tree_.links(node);
  return !links.is_marked() && tree_.tables().object_of(tree_.pieces[links.owner].facet) ==
                                   tree_.tables().object_of(cone.facet);
}

Cone* Insertion::pass_pp_node(Cone* cone, NodeId pp) {
  SHADOWCUT_ASSERT(tree_.is_pp(pp) && cone->entry.valid());
  const LightTables& tables = tree_.tables();
  const std::uint32_t own = tables.plane_index(cone->facet),
                      other = tables.plane_index(tree_.owner_facet(pp));
  if (own == other) {
    rest_in_list(cone, Piece::Kind::coplanar, pp);
    return nullptr;
  }
  const Node& node = tree_.node(pp);
  const PlaneDifference nearer(tables.planes[own], node.n, node.error);
  sign_tests += cone->count;
  const CornerSides sides =
      sides_of_plane(*cone, nearer, other, cell_predicates(), w_.spill, counts);
  if (sides.positive() && sides.negative()) {
    Cone *front, *behind;
    cut_by_plane(*cone, sides, nearer, other, front, behind);
    w_.pool.give_back(cone);
    rest_in_list(behind, Piece::Kind::behind, pp);
    return front;
  }
  if (sides.positive()) return cone;
  rest_in_list(cone, sides.negative() ? Piece::Kind::behind : Piece::Kind::coplanar, pp);
  return nullptr;
}

void Insertion::arrive(Cone* cone, Place leaf) {
  if (!tree_.tables().casts(cone->facet)) {
    tree_.rest_at_leaf(tree_.store(*cone, Piece::Kind::at_leaf, leaf.value()), leaf);
  } else {
    push_resting_pieces(leaf);
    attach_shadow_volume(*cone, leaf);
  }
  w_.pool.give_back(cone);
}

void Insertion::rest_in_list(Cone* cone, Piece::Kind kind, NodeId pp) {
  const PieceId piece = tree_.store(*cone, kind, pp.value());
  tree_.add_to_list(piece, pp);
  if (merge_) merge_in_list(tree_, piece, pp);
  w_.pool.give_back(cone);
}

void Insertion::cut_by_plane(const Cone& cone, const CornerSides& sides,
                             const PlaneDifference& nearer, std::uint32_t other, Cone*& front,
                             Cone*& behind) {
  const LightTables& tables = tree_.tables();
  const Plane &p = tables.plane_of(cone.facet), &q = tables.scene_planes[other];
  const LineId cut =
      tree_.lines.add(nearer.line(), {true, {p.exact_normal, p.point, q.exact_normal, q.point}});
  const Line& line = tree_.line(cut);
  split(cone, sides, {line.n, line.error, cut}, false, cell_predicates(), w_.pool, front, behind);
}

void Insertion::push_resting_pieces(Place leaf) {
  for (PieceId p = tree_.branch(leaf).first_piece(); p.valid();) {
    const PieceId next = tree_.pieces[p].next;
    w_.pending.push_back({tree_.cone_of(tree_.pieces[p], w_.pool), leaf.value(), 0});
    tree_.unlink(p);
    tree_.release_piece(p);
    p = next;
  }
}

void Insertion::attach_shadow_volume(const Cone& cone, Place leaf) {
  SHADOWCUT_ASSERT(tree_.branch(leaf).is_empty());
  const PieceId piece = tree_.store(cone, Piece::Kind::owner, leaf.value());
  Place place = leaf;
  for (const ConeCorner& c : cone.span()) {
    if (!c.edge.bounded()) tree_.add_sp_node(place, c.edge, piece);
  }
  tree_.add_pp_node(place, piece);
  tree_.log_change(leaf);
  SHADOWCUT_ASSERT(!tree_.branch(leaf).is_out());
}

EntryId insert(SvbspTree& tree, Cone* cone, Workspace& w) {
  const EntryId entry = tree.pieces.add_entry(cone->facet);
  cone->entry = entry;
  insert_at(tree, cone, Place::root(), w);
  SHADOWCUT_ASSERT(tree.pieces.entry(entry).pieces > 0);
  return entry;
}

void insert_at(SvbspTree& tree, Cone* cone, Place place, Workspace& w) {
  SHADOWCUT_ASSERT(tree.pieces.entry(cone->entry).facet == cone->facet);
  Insertion insertion(tree, false, w);
  descend(tree, cone, place, 0, w, insertion);
}

void DisplacedPieces::insert(SvbspTree& tree, bool merge, Workspace& w) {
  std::stable_partition(pieces_.begin(), pieces_.end(),
                        [&](const Displaced& d) { return tree.tables().casts(d.cone->facet); });
  Insertion insertion(tree, merge, w);
  for (const Displaced& d : pieces_) descend(tree, d.cone, tree.resolve(d.place), 0, w, insertion);
  pieces_.clear();
}

}  // namespace shadowcut
