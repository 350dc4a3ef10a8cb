// Faces cut by the node end there on both sides. The halves on the small side have been taken out
// of the tree; the lists of their entries lead to the halves on the large side. Where two halves
// merge under the PP-node of the large side, they do; otherwise that PP-node gets a copy of the
// node just above itself.

#include "svbsp/join.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "clipping/merge_convex.hpp"
#include "svbsp/displaced.hpp"

namespace shadowcut {
namespace {

bool has_edge_on(std::span<const ConeCorner> corners, LineId line) {
  return std::any_of(corners.begin(), corners.end(),
                     [line](const ConeCorner& c) { return c.edge.line() == line; });
}

bool has_side(std::span<const ConeCorner> corners, EdgeRef edge) {
  return std::any_of(corners.begin(), corners.end(),
                     [edge](const ConeCorner& c) { return same_side(c.edge, edge); });
}

class Joining {
 public:
  Joining(SvbspTree& tree, NodeId node, Workspace& w)
      : tree_(tree),
        node_(node),
        place_(tree.links(node).parent),
        line_(tree.node(node).line()),
        w_(w) {}

  // `side`: the smaller side of the node.
  void run(std::uint32_t side) {
    SHADOWCUT_ASSERT(side <= 1 && tree_.links(node_).is_marked());
    take_apart(tree_.node(node_).child[side]);
    const std::vector<PieceId> others = halves_on_large_side();
    rename_lines_of_halves();
    for (const PieceId other : others) {
      const LineId name = local_name(line_);
      const bool is_owner = tree_.pieces[other].kind == Piece::Kind::owner;
      tree_.pieces.rename_edges(other, line_, name, is_owner, tree_.lines);
      if (!is_owner || merge_with_half(other, name)) continue;
      const auto corners = tree_.pieces.corners(other);
      const auto cut = std::find_if(corners.begin(), corners.end(),
                                    [name](const ConeCorner& c) { return c.edge.line() == name; });
      SHADOWCUT_ASSERT(cut != corners.end());
      add_sp_node_above(tree_.pieces[other].node(), cut->edge, other);
    }
    tree_.put(place_, tree_.node(node_).child[1 - side]);
    tree_.release_node(node_, true);
    tree_.log_change(place_);
    SHADOWCUT_ASSERT(tree_.links(node_).is_released());
    ++tree_.counts.joined;
    for (auto& half : halves_.all()) half.place = place_;
    halves_.insert(tree_, true, w_);
  }

 private:
  // Releases everything below a branch, and leaves the cones of its pieces, the upper ones first.
  void take_apart(Branch branch) {
    std::vector<Branch> pending{branch};
    while (!pending.empty()) {
      const Branch here = pending.back();
      pending.pop_back();
      if (here.is_out()) {
        halves_.take_list(tree_, here.first_piece(), Place::root(), w_);
        continue;
      }
      const NodeId node = here.node();
      if (here.is_sp()) {
        pending.push_back(tree_.node(node).child[1]);
      } else {
        halves_.take(tree_, tree_.node(node).owner(), Place::root(), w_);
        halves_.take_list(tree_, tree_.links(node).first, Place::root(), w_);
      }
      pending.push_back(tree_.node(node).child[0]);
      tree_.release_node(node, here.is_sp());
    }
  }

  // The pieces on the large side that the node has cut, from above: a piece may grow only as far
  // as what it is in front of.
  std::vector<PieceId> halves_on_large_side() const {
    std::vector<std::pair<std::uint32_t, PieceId>> found;  // how deep below the node; piece
    std::vector<EntryId> seen;
    for (const auto& half : halves_.all()) {
      if (!has_edge_on(half.cone->span(), line_)) continue;
      if (std::find(seen.begin(), seen.end(), half.cone->entry) != seen.end()) continue;
      seen.push_back(half.cone->entry);
      for (PieceId p = tree_.pieces.entry(half.cone->entry).first; p.valid();
           p = tree_.pieces[p].after) {
        if (!has_edge_on(tree_.pieces.corners(p), line_)) continue;
        if (const std::uint32_t depth = depth_below_node(p); depth != invalid_index)
          found.emplace_back(depth, p);
      }
    }
    std::sort(found.begin(), found.end());
    std::vector<PieceId> out;
    for (const auto& [depth, piece] : found) out.push_back(piece);
    return out;
  }

  // How many nodes below the node a piece is; none: it is not below the node.
  std::uint32_t depth_below_node(PieceId piece) const {
    const Piece& p = tree_.pieces[piece];
    std::uint32_t depth = 0;
    for (Place place = p.kind == Piece::Kind::at_leaf ? p.leaf() : tree_.links(p.node()).parent;
         !place.is_root(); place = tree_.links(place.node()).parent) {
      if (place.node() == node_) return depth;
      ++depth;
    }
    return invalid_index;
  }

  // The node's line, and lines that only nodes of the small side stood for, live on under local
  // names.
  LineId local_name(LineId line) {
    if (is_local(line)) return line;
    for (const auto& [known, name] : names_) {
      if (known == line) return name;
    }
    SHADOWCUT_ASSERT(line.valid());
    names_.emplace_back(line, tree_.add_local_copy(line));
    return names_.back().second;
  }

  // Edges of the halves are bounded only by nodes that go on bounding the cell, and by the k-d
  // tree.
  void rename_lines_of_halves() {
    std::vector<LineId> above;
    for (Place p = place_; !p.is_root(); p = tree_.links(p.node()).parent) {
      if (!tree_.is_pp(p.node())) above.push_back(tree_.node(p.node()).line());
    }
    const LightTables& tables = tree_.tables();
    for (const auto& half : halves_.all()) {
      const std::uint32_t object = tables.object_of(half.cone->facet);
      for (ConeCorner& c : half.cone->span()) {
        const LineId line = c.edge.line();
        if (!c.edge.bounded() || std::find(above.begin(), above.end(), line) != above.end() ||
            tables.lines.is_kd_line(line))
          continue;
        const bool own = tables.lines.is_own(tables.objects[object], object, line);
        c.edge = EdgeRef(own ? line : local_name(line), c.edge.negative());
      }
    }
  }

  // An SP-node between a PP-node and what is above it: the PP-node on the inside of the edge.
  void add_sp_node_above(NodeId pp, EdgeRef edge, PieceId owner) {
    const Place place = tree_.links(pp).parent;
    Place inside = place;
    SHADOWCUT_ASSERT(tree_.branch(place).is_pp() && tree_.branch(place).node() == pp);
    tree_.add_sp_node(inside, edge, owner);
    tree_.put(inside, Branch::pp(pp));
    tree_.log_change(place);
  }

  // Merges an owner's piece, which ends at the node on this line, with its other half, where they
  // are. Takes the half out of halves_.
  bool merge_with_half(PieceId piece, LineId line) {
    const NodeId pp = tree_.pieces[piece].node();
    std::vector<ConeCorner> whole;
    SHADOWCUT_ASSERT(tree_.pieces[piece].kind == Piece::Kind::owner && tree_.is_pp(pp));
    auto& halves = halves_.all();
    for (auto h = halves.begin(); h != halves.end(); ++h) {
      Cone& half = *h->cone;
      const CellPredicates predicates = tree_.predicates();
      if (half.entry != tree_.pieces[piece].entry ||
          !ConvexMerger(predicates)
               .merge(tree_.pieces.corners(piece), half.span(), half.facet, line, whole) ||
          !fits_below(half, tree_.links(pp).parent))
        continue;
      std::vector<EdgeRef> open;
      if (!find_open_edges(half, piece, whole, open)) continue;
      tree_.replace_corners(piece, whole);
      tree_.pieces[piece].error = std::max(tree_.pieces[piece].error, half.error);
      for (const EdgeRef e : open) add_sp_node_above(pp, e, piece);
      w_.pool.give_back(h->cone);
      halves.erase(h);
      return true;
    }
    return false;
  }

  // Edges of the half at which neither the half nor the piece ends already. False: the node that
  // bounds the piece on some line may be on the piece's edge and not on the half's.
  bool find_open_edges(const Cone& half, PieceId piece, std::span<const ConeCorner> whole,
                       std::vector<EdgeRef>& open) const {
    bool sure = true;
    const std::span<const ConeCorner> mine = std::as_const(tree_.pieces).corners(piece);
    for (const ConeCorner& c : half.span()) {
      if (c.edge.bounded() || !has_side(whole, c.edge)) continue;
      const auto known = std::find_if(
          mine.begin(), mine.end(), [&](const ConeCorner& k) { return same_side(k.edge, c.edge); });
      if (known == mine.end()) {
        open.push_back(c.edge);
      } else if (known->edge.bounded()) {
        sure = false;
      }
    }
    return sure;
  }

  // Whether a cone is on the way's side of every node from a place up to, and without, the node.
  bool fits_below(Cone& cone, Place place) const {
    const LightTables& tables = tree_.tables();
    const CellPredicates predicates = tree_.predicates();
    const std::uint32_t own = tables.plane_index(cone.facet);
    SignCounts counts;
    for (; place.node() != node_; place = tree_.links(place.node()).parent) {
      const NodeId here = place.node();
      if (tree_.is_pp(here)) {
        const std::uint32_t other = tables.plane_index(tree_.owner_facet(here));
        const PlaneDifference nearer(tables.planes[own], tree_.node(here).n,
                                     tree_.node(here).error);
        if (other == own) continue;
        if (sides_of_plane(cone, nearer, other, predicates, w_.spill, counts).negative())
          return false;
        continue;
      }
      const CornerSides sides =
          sides_of_line(cone, tree_.dividing_line(here), predicates, w_.spill, counts);
      if (place.side() == 1 ? sides.positive() : sides.negative()) return false;
    }
    return true;
  }

  SvbspTree& tree_;
  NodeId node_;
  Place place_;  // of the node
  LineId line_;  // of the node
  Workspace& w_;
  DisplacedPieces halves_;                        // the small side
  std::vector<std::pair<LineId, LineId>> names_;  // line, local copy
};

// The side of an SP-node with fewer nodes below it, if they are no more than `limit`; 2 if both
// sides have more.
std::uint32_t smaller_side(const SvbspTree& tree, NodeId node, std::uint32_t limit) {
  std::vector<Branch> pending[2];
  std::uint32_t nodes = 0;
  for (const int side : {0, 1}) pending[side].push_back(tree.node(node).child[side]);
  for (;;) {
    for (const std::uint32_t side : {0u, 1u}) {
      auto& rest = pending[side];
      while (!rest.empty() && rest.back().is_out()) rest.pop_back();
      if (rest.empty()) return side;
      const Branch here = rest.back();
      rest.pop_back();
      rest.push_back(tree.node(here.node()).child[0]);
      if (here.is_sp()) rest.push_back(tree.node(here.node()).child[1]);
    }
    if (++nodes > limit) return 2;
  }
}

}  // namespace

bool join(SvbspTree& tree, NodeId node, Workspace& w) {
  SHADOWCUT_ASSERT(tree.links(node).is_marked());
  const std::uint32_t side = smaller_side(tree, node, tree.settings().join_threshold);
  if (side == 2) return false;
  Joining(tree, node, w).run(side);
  return true;
}

void merge_in_list(SvbspTree& tree, PieceId piece, NodeId pp) {
  SHADOWCUT_ASSERT(tree.is_pp(pp) && tree.pieces[piece].node() == pp);
  std::vector<ConeCorner> whole;
  for (PieceId p = tree.links(pp).first; p.valid();) {
    const Piece &other = tree.pieces[p], &own = tree.pieces[piece];
    const PieceId next = other.next;
    const CellPredicates predicates = tree.predicates();
    if (p != piece && other.entry == own.entry && other.kind == own.kind &&
        ConvexMerger(predicates)
            .merge(tree.pieces.corners(piece), tree.pieces.corners(p), other.facet, LineId(),
                   whole)) {
      const float error = other.error;
      tree.unlink(p);
      tree.release_piece(p);
      tree.replace_corners(piece, whole);
      tree.pieces[piece].error = std::max(tree.pieces[piece].error, error);
      p = tree.links(pp).first;  // the larger piece may merge with a piece passed over
      continue;
    }
    p = next;
  }
}

}  // namespace shadowcut
