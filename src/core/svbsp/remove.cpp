// Taking facets out of a cell's tree (CS95, section 3).
//
// (a) A piece behind a PP-node, coplanar with it, or at a leaf is taken out of a list.
// (b) A PP-node gives way to what is in front of it, and the pieces behind it are inserted there.
// (c) Its SP-nodes are marked. A marked node with an empty side gives way to its other side. A node
//     with something on both sides is joined (join.cpp) if its smaller side is small; otherwise it
//     stays, as a plain dividing plane, until a later edit leaves one side empty or small.
//
// Why a marked node with an empty side may go: an edge relies on a node only where the node has cut
// the face, and then the other half of the face is on the node's other side, which is not empty; or
// where node and face are of one object, and then the face is gone too. (Displaced pieces are
// inserted before any node goes; otherwise their side would look empty.)

#include "svbsp/displaced.hpp"
#include "svbsp/join.hpp"

namespace shadowcut {
namespace {

class Removal {
 public:
  Removal(SvbspTree& tree, Workspace& w) : tree_(tree), w_(w) {}

  std::size_t run(std::span<const EntryId> entries) {
    SHADOWCUT_ASSERT(w_.pending.empty());
    for (const EntryId e : entries) take_out_pieces(e);
    for (const NodeId pp : pp_nodes_) take_out_pp_node(pp);
    const std::size_t displaced = displaced_.size();
    for (const EntryId e : entries) tree_.pieces.release_entry(e);
    displaced_.insert(tree_, false, w_);
    for (const Place place : shrunk_) clear_up(place, false);
    if (tree_.settings().join_threshold > 0) {
      for (const Place place : shrunk_) clear_up(place, true);
    }
    SHADOWCUT_ASSERT(displaced_.size() == 0);
    tree_.finish_removal();
    return displaced;
  }

 private:
  // Owners stay, with their SP-nodes marked, until their PP-nodes go.
  void take_out_pieces(EntryId entry) {
    SHADOWCUT_ASSERT(tree_.pieces.entry(entry).facet.valid());
    for (PieceId p = tree_.pieces.entry(entry).first; p.valid();) {
      const Piece& piece = tree_.pieces[p];
      const PieceId next = piece.after;
      if (piece.kind == Piece::Kind::owner) {
        pp_nodes_.push_back(piece.node());
        mark_planes_of(p);
      } else {
        if (piece.kind == Piece::Kind::at_leaf) shrunk_.push_back(piece.leaf());
        tree_.unlink(p);
        tree_.release_piece(p);
      }
      p = next;
    }
  }

  // The SP-nodes that a piece attached are in one row above its PP-node; marked nodes may be
  // between them.
  void mark_planes_of(PieceId piece) {
    for (Place place = tree_.links(tree_.pieces[piece].node()).parent; !place.is_root();
         place = tree_.links(place.node()).parent) {
      const NodeLinks& links = tree_.links(place.node());
      if (links.is_marked()) continue;
      if (links.owner != piece) return;
      tree_.mark(place.node());
    }
  }

  void take_out_pp_node(NodeId pp) {
    SHADOWCUT_ASSERT(tree_.is_pp(pp) && tree_.pieces[tree_.node(pp).owner()].node() == pp);
    displaced_.take_list(tree_, tree_.links(pp).first, Place(pp, 0), w_);
    const Place place = tree_.links(pp).parent;
    tree_.put(place, tree_.node(pp).child[0]);
    tree_.release_piece(tree_.node(pp).owner());
    tree_.release_node(pp, false);
    tree_.log_change(place);
    shrunk_.push_back(Place(pp, 0));
  }

  // Goes up from a place through marked nodes and removes the nodes that can go.
  void clear_up(Place place, bool joining) {
    for (place = tree_.resolve(place); !place.is_root();) {
      const NodeId node = place.node();
      if (!tree_.links(node).is_marked()) return;
      const Place above = tree_.links(node).parent;
      if (!collapse(node) && joining) join(tree_, node, w_);
      place = above;
    }
  }

  // A marked node with an empty side gives way to its other side.
  bool collapse(NodeId node) {
    SHADOWCUT_ASSERT(tree_.links(node).is_marked());
    const Branch a = tree_.node(node).child[0], b = tree_.node(node).child[1];
    if (!a.is_empty() && !b.is_empty()) return false;
    const Place place = tree_.links(node).parent;
    tree_.put(place, a.is_empty() ? b : a);
    tree_.release_node(node, true);
    tree_.log_change(place);
    return true;
  }

  SvbspTree& tree_;
  Workspace& w_;
  std::vector<NodeId> pp_nodes_;  // to be taken out
  std::vector<Place> shrunk_;     // places below which the tree has become smaller
  DisplacedPieces displaced_;
};

}  // namespace

std::size_t remove(SvbspTree& tree, std::span<const EntryId> entries, Workspace& w) {
  return Removal(tree, w).run(entries);
}

}  // namespace shadowcut
