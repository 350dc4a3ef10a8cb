// Pieces taken out of a tree that have to be inserted again.
#pragma once

#include <vector>

#include "svbsp/svbsp_tree.hpp"

namespace shadowcut {

class DisplacedPieces {
 public:
  struct Displaced {
    Cone* cone;
    Place place;  // from which it is inserted again
  };

  // Takes a piece, which is in no place any more, out of the tree.
  void take(SvbspTree& tree, PieceId piece, Place place, Workspace& w) {
    SHADOWCUT_ASSERT(tree.pieces[piece].kind != Piece::Kind::free);
    pieces_.push_back({tree.cone_of(tree.pieces[piece], w.pool), place});
    tree.release_piece(piece);
  }
  // All pieces of a list.
  void take_list(SvbspTree& tree, PieceId first, Place place, Workspace& w) {
    while (first.valid()) {
      const PieceId next = tree.pieces[first].next;
      take(tree, first, place, w);
      first = next;
    }
  }

  std::vector<Displaced>& all() { return pieces_; }
  std::span<const Displaced> all() const { return pieces_; }
  std::size_t size() const { return pieces_.size(); }

  // Inserts the pieces, those that cast first. `merge`: pieces that come to a PP-node's list merge
  // with pieces of their facet there.
  void insert(SvbspTree& tree, bool merge, Workspace& w);

 private:
  std::vector<Displaced> pieces_;
};

}  // namespace shadowcut
