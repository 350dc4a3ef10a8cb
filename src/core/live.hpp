// The fragments of one cell, kept right while its tree is edited.
//
// A fragment hangs at two places: at its piece, and, if the piece is on a PP-node (its owner, or
// coplanar with it), at the place in front of that PP-node that it fills. There is one for every
// piece and every *settled* place: one whose branch is in one state throughout (lit, or shadowed by
// one object's faces) while the branch above is not. So a change of the tree concerns the fragments
// at the places where it happened, and, where states change, at places above: nothing else is
// looked at.
#pragma once

#include <cstdint>
#include <vector>

#include "emit.hpp"
#include "free_list.hpp"
#include "tree.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {

class LiveCell {
 public:
  // A change of a face's lit or shadowed area: of a fragment added (or taken away) with this area.
  struct AreaChange {
    std::uint32_t face;
    bool lit, added;
    double area;
  };

  LiveCell(std::uint32_t cell, bool merge) : cell_(cell), merge_(merge) {}

  // The tree says what happens to it.
  void changed(std::uint32_t place) { changed_.push_back(place); }
  void piece_added(std::uint32_t piece) { added_pieces_.push_back(piece); }
  void drop_piece(std::uint32_t piece);
  void drop_places_of(std::uint32_t node);
  // Names of places become final: before nodes are used again.
  template <class Resolve>
  void settle_places(const Resolve& resolve) {
    for (std::uint32_t& place : changed_) place = resolve(place);
  }

  // Hands out all fragments of a tree just built.
  void start(const CellTree& tree, const EmitTarget& target, Workspace& w, Block& block,
             std::uint32_t update);
  // The tree has been made anew: all fragments go, and are handed out again.
  void start_again(const CellTree& tree, const EmitTarget& target, Workspace& w);
  // Brings the fragments up to date with the tree. Before its first change in an update, `begin`
  // says which update it is, and where the fragments are.
  void begin(Block& block, std::uint32_t update);
  void settle(const CellTree& tree, const EmitTarget& target, Workspace& w);

  // Index into the block's fragments, or none.
  std::uint32_t find(FragmentId id) const;
  // Of this update.
  const std::vector<FragmentId>& gone() const { return gone_; }
  std::size_t most_added() const { return born_.size(); }
  // All that was there before this update, gone by now or not.
  void list_old(const Block& block, std::uint32_t update, std::vector<FragmentId>& out) const;
  void list_added(std::vector<LightChanges::Added>& out);
  std::vector<AreaChange>& area_changes() { return area_changes_; }

  // Every invariant; empty when all hold.
  std::string validate(const CellTree& tree, const EmitTarget& target, const Block& block) const;
  std::uint64_t bytes() const;

 private:
  struct Record {  // of a fragment, at the same index as the fragment in its block
    std::uint32_t at_place_next, at_place_previous, of_piece_next, of_piece_previous;
    std::uint32_t born, listed;  // updates
  };

  std::uint32_t state_of(const CellTree& tree, Child c) const;
  void forget_fragments();
  void make_room(const CellTree& tree);
  void emit_all(const CellTree& tree, const EmitTarget& target, Workspace& w);
  void drop(std::uint32_t fragment);
  void drop_below(const CellTree& tree, std::uint32_t place);
  bool find_state(const CellTree& tree, const EmitTarget& target, std::uint32_t node);
  void emit_in_front(const CellTree& tree, std::uint32_t piece, std::uint32_t way,
                     const EmitTarget& target, Workspace& w);
  void emit_piece(const CellTree& tree, std::uint32_t piece, const EmitTarget& target,
                  Workspace& w);
  void add(const CellTree& tree, std::uint32_t piece, std::uint32_t place, std::uint32_t state,
           std::span<const ConeCorner> cone, const EmitTarget& target, Workspace& w);

  std::uint32_t cell_;
  bool merge_;
  Block* block_ = nullptr;
  std::uint32_t update_ = 0;
  std::vector<Record> records_;
  std::vector<std::uint32_t> at_place_, of_piece_;  // first fragments, by place and by piece
  std::vector<std::uint32_t> states_;               // by node
  std::vector<std::uint32_t> visit_;                // by place: see settle()
  std::uint32_t visits_ = 0;
  RangeList free_corners_;
  std::vector<std::uint32_t> changed_, added_pieces_;
  std::vector<std::uint32_t> places_;  // still to be looked at, while one function runs
  std::vector<FragmentId> gone_, born_;
  std::vector<AreaChange> area_changes_;
};

}  // namespace shadowcut::SHADOWCUT_NUMBERS
