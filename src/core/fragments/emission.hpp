// The fragments of pieces (CS95, section 2): the one path from a tree to fragments, for static
// builds and for edits.
//
// A piece behind a PP-node is one shadowed fragment. A piece on a PP-node (its owner, or coplanar
// with it) is cut by what is in front: the SP-nodes of the front subtree, down to the places whose
// branch is in one state. Leaves there are lit, and the regions of PP-nodes are shadowed by their
// faces.
#pragma once

#include <span>
#include <vector>

#include "fragments/branch_states.hpp"
#include "fragments/polygon.hpp"
#include "svbsp/descend.hpp"

namespace shadowcut {

// Whether a piece gives fragments.
inline bool emits(const EmissionContext& context, const Piece& piece) {
  return piece.kind != Piece::Kind::free && !context.visibility.blocks_only(piece.facet) &&
         context.receives(piece.facet);
}

// Marks on places, for an update that looks only at what has changed: see emit_in_front().
class MarkedWays {
 public:
  // Starts with no place marked.
  void restart() { ++round_; }
  void grow(std::size_t places) { marks_.resize(places, 0); }
  void clear() { marks_.clear(); }
  std::size_t size() const { return marks_.size(); }

  std::uint32_t way() const { return 2 * round_; }
  bool is_marked(Place place) const { return mark(place) >= way(); }
  bool is_all(Place place) const { return mark(place) == way() + 1; }
  // A way leads to changes; `all`: everything below the place has changed.
  void mark_way(Place place) {
    std::uint32_t& m = marks_[place.value()];
    if (m < way()) m = way();
  }
  void mark_all(Place place) {
    SHADOWCUT_ASSERT(place.value() < marks_.size());
    marks_[place.value()] = way() + 1;
  }

 private:
  std::uint32_t mark(Place place) const {
    SHADOWCUT_ASSERT(place.value() < marks_.size());
    return marks_[place.value()];
  }
  std::vector<std::uint32_t> marks_;  // by place
  std::uint32_t round_ = 0;
};

// Sink: add(PieceId piece, std::uint32_t place, BranchState state,
//           std::span<const ConeCorner> corners), with the value of the place in front of the
// piece's PP-node that the fragment fills, or none.
template <class Sink>
class FragmentEmitter {
 public:
  FragmentEmitter(const SvbspTree& tree, const BranchStates& states, const EmissionContext& context,
                  Workspace& w, Sink& sink)
      : tree_(tree), states_(states), context_(context), w_(w), sink_(sink) {}

  // All fragments of a piece.
  void emit_piece(PieceId id) {
    const Piece& piece = tree_.pieces[id];
    if (!emits(context_, piece)) return;
    if (!piece.is_in_front()) {
      const BranchState state =
          piece.kind == Piece::Kind::at_leaf ? BranchState::lit() : shadow_of(tree_, piece.node());
      return sink_.add(id, invalid_index, state, tree_.pieces.corners(piece));
    }
    const Place front(piece.node(), 0);
    const BranchState state = states_.of(tree_, tree_.branch(front));
    if (!state.is_mixed()) return sink_.add(id, front.value(), state, tree_.pieces.corners(piece));
    emit_in_front(id, nullptr);
  }

  // The fragments of a piece in front of its PP-node. `ways`: of these only the fragments at
  // places below those marked as changed altogether, reached by marked ways; null: all fragments.
  void emit_in_front(PieceId id, const MarkedWays* ways) {
    SHADOWCUT_ASSERT(!ways || ways->size() == 2 * tree_.nodes().size());
    const Piece& piece = tree_.pieces[id];
    if (!emits(context_, piece)) return;
    Visitor visitor{{}, *this, id, ways};
    descend(tree_, tree_.cone_of(piece, w_.pool), Place(piece.node(), 0),
            ways ? following : everything, w_, visitor);
  }

 private:
  static constexpr std::uint32_t everything = 0, following = 1;  // a cone's tag

  struct Visitor : DescentVisitor {
    FragmentEmitter& emitter;
    PieceId piece;
    const MarkedWays* ways;
    BranchState state = BranchState::mixed();

    Visitor(DescentVisitor base, FragmentEmitter& e, PieceId p, const MarkedWays* m)
        : DescentVisitor(base), emitter(e), piece(p), ways(m) {}
    CellPredicates cell_predicates() const { return emitter.tree_.predicates(); }
    bool stops_at(Place place, Branch here, std::uint32_t& tag) {
      state = BranchState::mixed();
      if (tag == following) {
        if (!ways->is_marked(place)) return true;  // nothing has changed here
        if (ways->is_all(place)) tag = everything;
      }
      const BranchState found = emitter.states_.of(emitter.tree_, here);
      if (found.is_mixed()) return false;
      if (tag == everything) state = found;
      return true;
    }
    void arrive(Cone* cone, Place place) {
      if (!state.is_mixed())
        emitter.sink_.add(piece, place.value(), state, std::as_const(*cone).span());
      emitter.w_.pool.give_back(cone);
    }
  };

  const SvbspTree& tree_;
  const BranchStates& states_;
  const EmissionContext& context_;
  Workspace& w_;
  Sink& sink_;
};

}  // namespace shadowcut
