// The invariants of the trees, checked. Every one is stated where it is tested. Numbers 1 to 3, 8
// and 9 cost no arithmetic.

#include <algorithm>
#include <cmath>

#include "support/message.hpp"
#include "svbsp/cell_grid.hpp"
#include "svbsp/svbsp_tree.hpp"

namespace shadowcut {
namespace {

class TreeCheck {
 public:
  TreeCheck(const SvbspTree& tree, const LightSpace* space)
      : tree_(tree),
        space_(space),
        reached_(tree.nodes().size(), 0),
        held_(tree.pieces.pieces().size(), 0),
        uses_(tree.lines.all().size(), 0) {}

  std::string run() {
    std::string problem = check_links();
    if (problem.empty()) problem = check_pieces();
    if (problem.empty()) problem = check_uses();
    if (problem.empty()) problem = check_entries();
    return problem;
  }

 private:
  // 1. Nodes form a tree: each that is not released is reached exactly once, and links lead back.
  std::string check_links() {
    std::size_t marks = 0;
    std::vector<Place> pending{Place::root()};
    std::string problem;
    while (!pending.empty() && problem.empty()) {
      const Place place = pending.back();
      pending.pop_back();
      const Branch here = tree_.branch(place);
      if (here.is_out()) {
        problem = check_leaf(place, here);
        continue;
      }
      const NodeId node = here.node();
      if (node.value() >= reached_.size() || reached_[node.value()]++)
        return message("a node is missing or reached twice", node.value());
      if (tree_.links(node).parent != place)
        return message("a node's link does not lead back", node.value());
      pending.push_back(Place(node, 0));
      if (here.is_sp()) {
        pending.push_back(Place(node, 1));
        marks += tree_.links(node).is_marked();
        use(tree_.node(node).line());
        problem = check_sp_node(node);
      } else {
        problem = check_pp_node(node);
      }
    }
    if (!problem.empty()) return problem;
    for (std::size_t i = 0; i < reached_.size(); ++i) {
      if (!reached_[i] != tree_.links(NodeId(i)).is_released())
        return message("a node is not reached, or it is released and is reached", i);
    }
    for (std::size_t i = 0; i < held_.size(); ++i) {
      if (!held_[i] != (tree_.pieces[PieceId(i)].kind == Piece::Kind::free))
        return message("a piece is nowhere in the tree, or it is free and in the tree", i);
    }
    if (marks != tree_.marked_nodes()) return message("marked nodes are counted wrongly", marks);
    return {};
  }

  // 2. A piece that rests at a leaf does not cast, and knows its leaf.
  std::string check_leaf(Place place, Branch leaf) {
    for (PieceId p = leaf.first_piece(); p.valid(); p = tree_.pieces[p].next) {
      if (p.value() >= held_.size() || held_[p.value()]++)
        return message("a leaf's list is broken", place.value());
      const Piece& piece = tree_.pieces[p];
      if (piece.kind != Piece::Kind::at_leaf || piece.leaf() != place)
        return message("a piece at a leaf does not know it", p.value());
      if (tree_.tables().casts(piece.facet))
        return message("a casting piece rests at a leaf without a shadow volume", p.value());
    }
    return {};
  }

  std::string check_sp_node(NodeId node) const {
    const NodeLinks& links = tree_.links(node);
    if (links.is_marked()) {
      if (tree_.node(node).child[0].is_empty() || tree_.node(node).child[1].is_empty())
        return message("a marked node has an empty side", node.value());
    } else if (links.owner.value() >= held_.size() ||
               tree_.pieces[links.owner].kind != Piece::Kind::owner) {
      return message("an SP-node's owner owns nothing", node.value());
    }
    return {};
  }

  // 3. A PP-node has an owner that casts, and a list of pieces behind it or coplanar with it; each
  // knows the node.
  std::string check_pp_node(NodeId node) {
    const PieceId owner = tree_.node(node).owner();
    if (owner.value() >= held_.size() || held_[owner.value()]++)
      return message("a PP-node's owner is missing or owns twice", node.value());
    if (tree_.pieces[owner].kind != Piece::Kind::owner || tree_.pieces[owner].node() != node)
      return message("a PP-node's owner does not know it", node.value());
    if (!tree_.tables().casts(tree_.pieces[owner].facet))
      return message("a PP-node's owner does not cast", node.value());
    for (PieceId p = tree_.links(node).first; p.valid(); p = tree_.pieces[p].next) {
      if (p.value() >= held_.size() || held_[p.value()]++)
        return message("a PP-node's list is broken", node.value());
      const Piece& piece = tree_.pieces[p];
      if (piece.kind != Piece::Kind::behind && piece.kind != Piece::Kind::coplanar)
        return message("a piece in a list is of the wrong kind", p.value());
      if (piece.node() != node)
        return message("a piece in a list does not know its PP-node", p.value());
    }
    return {};
  }

  std::string check_pieces() {
    for (std::size_t i = 0; i < tree_.pieces.pieces().size(); ++i) {
      const Piece& piece = tree_.pieces[PieceId(i)];
      if (piece.kind == Piece::Kind::free) continue;
      for (const ConeCorner& c : tree_.pieces.corners(piece)) use(c.edge.line());
      if (!space_) continue;
      Cone* cone = tree_.cone_of(piece, pool_);
      std::string problem = check_geometry(piece, *cone, i);
      pool_.give_back(cone);
      if (!problem.empty()) return problem;
    }
    return {};
  }

  std::string check_geometry(const Piece& piece, Cone& cone, std::size_t i) {
    std::vector<std::uint8_t> edge_bounded(cone.count, 0);
    std::string problem = check_against_nodes_above(piece, cone, edge_bounded, i);
    if (problem.empty() && piece.kind == Piece::Kind::owner)
      problem = check_edges(cone, edge_bounded, i);
    if (problem.empty() && piece.kind != Piece::Kind::owner && piece.kind != Piece::Kind::at_leaf)
      problem = check_against_own_node(piece, cone, i);
    return problem;
  }

  // A piece may have been cut further since it passed a node. Then its corners are in what passed,
  // but are other numbers: of a true corner the node's function was no more than twice the bound on
  // the wrong side, and a number made later differs from that by the bound once more.
  static constexpr double since_cut = 3;

  // A facet's corners are on its plane up to its flatness. The light sees them off by as much over
  // their distance, and the loop as convex up to that, so a corner may be on the wrong side of
  // another of the facet's edges.
  double bend(const Cone& cone) const {
    const PlaneCovector& ray = tree_.tables().covector_of(cone.facet);
    double nearest = INFINITY;
    for (const ConeCorner& c : cone.span()) {
      nearest = std::min(nearest, (space_->back(c.r, ray.q) - space_->frame().center).norm());
    }
    return 8 * tree_.tables().plane_of(cone.facet).flatness /
           (space_->far() ? space_->frame().scale : nearest);
  }

  std::string check_against_nodes_above(const Piece& piece, Cone& cone,
                                        std::vector<std::uint8_t>& edge_bounded, std::size_t i) {
    const double bent = bend(cone);
    Place place =
        piece.kind == Piece::Kind::at_leaf ? piece.leaf() : tree_.links(piece.node()).parent;
    for (; !place.is_root(); place = tree_.links(place.node()).parent) {
      const Node& node = tree_.node(place.node());
      if (tree_.is_pp(place.node())) {
        // 4. A piece in the front subtree of a PP-node is nowhere certainly behind its plane.
        const PlaneDifference nearer(tree_.tables().covector_of(piece.facet), node.n, node.error);
        if (CornerSides(cone, nearer.d, since_cut * nearer.bound(cone), spill_).negative())
          return message("a piece in front of a PP-node reaches behind it", i);
        continue;
      }
      // 5. A piece is on its cell's side of every SP-node above it.
      const DividingLine line = tree_.dividing_line(place.node());
      const CornerSides sides(cone, line.n, since_cut * line.bound(cone) + bent, spill_);
      const int wrong = place.side() == 1 ? 1 : -1;
      for (std::uint32_t k = 0; k < cone.count; ++k) {
        if (sides[k] == wrong) return message("a piece reaches out of its cell", i);
        const std::uint32_t j = k + 1 == cone.count ? 0 : k + 1;
        if (cone.corners()[k].edge.line() == line.id || (sides[k] == 0 && sides[j] == 0))
          edge_bounded[k] = 1;
      }
    }
    return {};
  }

  // 6. An owner's piece fills its PP-node's cell: an SP-node, of its own or another's, or a plane
  // of the k-d tree is at every edge.
  std::string check_edges(Cone& cone, std::vector<std::uint8_t>& edge_bounded, std::size_t i) {
    const LineTable& lines = tree_.tables().lines;
    for (std::uint32_t l = lines.first_kd_line(); lines.is_kd_line(LineId(l)); ++l) {
      const Line& plane = lines[LineId(l)];
      const DividingLine line{plane.n, plane.error, LineId(l)};
      const CornerSides sides(cone, plane.n, line.bound(cone), spill_);
      sides.for_each_on_edge([&](std::uint32_t k) { edge_bounded[k] = 1; });
    }
    if (std::find(edge_bounded.begin(), edge_bounded.end(), 0) != edge_bounded.end())
      return message("an edge of a PP-node's owner has no SP-node", i);
    return {};
  }

  // 7. A piece in a PP-node's list is nowhere certainly in front of its plane, and a coplanar piece
  // is nowhere certainly off it.
  std::string check_against_own_node(const Piece& piece, Cone& cone, std::size_t i) {
    const LightTables& tables = tree_.tables();
    const Node& node = tree_.node(piece.node());
    if (tables.plane_index(tree_.owner_facet(piece.node())) == tables.plane_index(piece.facet))
      return {};
    const PlaneDifference nearer(tables.covector_of(piece.facet), node.n, node.error);
    const CornerSides sides(cone, nearer.d, nearer.bound(cone), spill_);
    if (sides.positive() || (sides.negative() && piece.kind == Piece::Kind::coplanar))
      return message("a piece behind a PP-node reaches in front of it", i);
    return {};
  }

  // 8. A line of the cell's own is counted as often as nodes and pieces use it.
  std::string check_uses() const {
    for (std::size_t i = 0; i < uses_.size(); ++i) {
      const std::uint32_t counted = tree_.lines.all()[i].uses;
      if (uses_[i] != (counted == invalid_index ? 0 : counted))
        return message("a line's uses are counted wrongly", i);
    }
    return {};
  }

  // 9. An entry holds its facet's pieces.
  std::string check_entries() const {
    std::size_t listed = 0;
    for (std::size_t i = 0; i < tree_.pieces.entries().size(); ++i) {
      const EntryId id(i);
      const Entry& entry = tree_.pieces.entry(id);
      if (!entry.facet.valid()) continue;
      std::uint32_t count = 0;
      for (PieceId p = entry.first; p.valid(); p = tree_.pieces[p].after, ++count) {
        if (count > tree_.pieces.pieces().size())
          return message("an entry's list runs in a circle", i);
        if (tree_.pieces[p].entry != id || tree_.pieces[p].facet != entry.facet)
          return message("an entry holds another entry's piece", i);
      }
      if (count != entry.pieces) return message("an entry's pieces are counted wrongly", i);
      listed += count;
    }
    if (listed != tree_.pieces.piece_count()) return "a piece is in no entry";
    return {};
  }

  void use(LineId line) {
    if (is_local(line)) ++uses_[line.value() - first_local_line];
  }

  const SvbspTree& tree_;
  const LightSpace* space_;
  std::vector<std::uint8_t> reached_, held_;  // by node, by piece
  std::vector<std::uint32_t> uses_;           // by local line
  ConePool pool_;
  std::vector<std::int8_t> spill_;
};

}  // namespace

std::string validate(const SvbspTree& tree, const LightSpace* space) {
  return TreeCheck(tree, space).run();
}

// 12. Location lists hold every entry once, under its own object; a facet that enters has an entry,
// and no other facet has one.
std::string CellGrid::validate_locations() const {
  std::size_t listed = 0, entries = 0;
  const std::size_t facets = scene_.facets().size();
  std::vector<std::uint8_t> has_entry(facets, 0);
  for (const SvbspTree& cell : cells_) {
    for (const Entry& e : cell.pieces.entries()) entries += e.facet.valid();
  }
  for (std::size_t o = 0; o < locations_.size(); ++o) {
    for (Location l = locations_[o]; l.cell.valid();
         l = (*this)[l.cell].pieces.entry(l.entry).next) {
      if (l.cell.value() >= cells_.size() ||
          l.entry.value() >= (*this)[l.cell].pieces.entries().size())
        return message("a location leads nowhere", o);
      const FacetId facet = (*this)[l.cell].pieces.entry(l.entry).facet;
      if (!facet.valid() || tables_.object_of(facet) != o)
        return message("a location leads to another object's entry", o);
      has_entry[facet.value()] = 1;
      if (++listed > entries) return message("location lists run in a circle", o);
    }
  }
  if (listed != entries) return "an entry is in no location list";
  for (std::size_t f = 0; f < facets; ++f) {
    if (visibility_.enters(FacetId(f)) != static_cast<bool>(has_entry[f]))
      return message("a facet that entered has no location, or one that did not has", f);
  }
  return {};
}

// 13. A marked node's line, if it is not the cell's own, is in a block that its object has left and
// that counts it; other nodes' lines are those of their objects as they are.
std::string CellGrid::validate_lines() const {
  const LineTable& lines = tables_.lines;
  std::vector<std::uint32_t> planes(lines.block_count(), 0);
  for (const SvbspTree& cell : cells_) {
    std::vector<shadowcut::Branch> pending{cell.branch(Place::root())};
    while (!pending.empty()) {
      const shadowcut::Branch here = pending.back();
      pending.pop_back();
      if (here.is_out()) continue;
      const Node& node = cell.node(here.node());
      pending.push_back(node.child[0]);
      if (!here.is_sp()) continue;
      pending.push_back(node.child[1]);
      if (is_local(node.line())) continue;
      const std::size_t at = here.node().value();
      if (!std::equal(node.n, node.n + 3, lines[node.line()].n))
        return message("a node's line has changed", at);
      const NodeLinks& links = cell.links(here.node());
      const std::uint32_t block = lines.block_of_line(node.line());
      if (links.is_marked()) {
        ++planes[block];
      } else if (block !=
                 lines.block_of_object(tables_.object_of(cell.pieces[links.owner].facet))) {
        return message("a node's line is another object's", at);
      }
    }
  }
  for (std::size_t b = 0; b < planes.size(); ++b) {
    if (planes[b] != lines.planes_left(b))
      return message("planes left behind are counted wrongly", b);
    if (planes[b] != 0 && !lines.is_left(b))
      return message("an object shares lines with planes left behind", b);
  }
  return {};
}

}  // namespace shadowcut
