// The fragments of one cell, kept right while its tree is edited.
//
// A fragment hangs at two places: at its piece, and, if the piece is on a PP-node (its owner, or
// coplanar with it), at the place in front of that PP-node that it fills. There is one fragment for
// every piece and every *uniform* place: a place whose branch is in one state throughout (lit, or
// shadowed by one object's faces) while the branch above is not. So a change of the tree concerns
// the fragments at the places where it happened and, where states change, at places above: nothing
// else is looked at.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fragments/emission.hpp"
#include "support/free_list.hpp"

namespace shadowcut {

class CellFragments {
 public:
  // A fragment came or went: its face's lit or shadowed area changes by its area.
  struct AreaChange {
    std::uint32_t face;
    bool lit, added;
    double area;
  };

  explicit CellFragments(CellId cell) : cell_(cell) {}

  // Emits all fragments of a tree just built.
  void start(const SvbspTree& tree, const EmissionContext& context, Workspace& w, Block& block,
             std::uint32_t update);
  // Before the first change of an update: which update it is, and where the fragments are.
  void begin(Block& block, std::uint32_t update);
  // The tree has been built again: all fragments go, and are emitted again.
  void restart(const SvbspTree& tree, const EmissionContext& context, Workspace& w);
  // Takes note of edits: drops what they made invalid.
  void apply(const EditLog& log);
  // Brings the fragments up to date with all edits applied.
  void emit_changes(const SvbspTree& tree, const EmissionContext& context, Workspace& w);

  // Index into the block's fragments, or none.
  std::uint32_t find(FragmentId id) const;
  // Of this update.
  const std::vector<FragmentId>& gone() const { return gone_; }
  std::size_t most_added() const { return born_.size(); }
  void list_added(std::vector<LightChanges::Added>& out);
  // All fragments that were there before this update, whether or not they have gone since.
  void list_old(const Block& block, std::uint32_t update, std::vector<FragmentId>& out) const;
  std::vector<AreaChange>& area_changes() { return area_changes_; }

  // Every invariant; empty when all hold.
  std::string validate(const SvbspTree& tree, const EmissionContext& context,
                       const Block& block) const;
  std::uint64_t bytes() const;

 private:
  struct Record {  // of a fragment, at the same index as the fragment in its block
    std::uint32_t at_place_next, at_place_previous, of_piece_next, of_piece_previous;
    std::uint32_t born, listed;  // updates
  };
  struct Sink;

  void forget_fragments();
  void grow(const SvbspTree& tree);
  void emit_all(const SvbspTree& tree, const EmissionContext& context, Workspace& w);
  void update_states(const SvbspTree& tree, const Scene& scene);
  std::vector<NodeId> mark_ways(const SvbspTree& tree);
  void add(const SvbspTree& tree, PieceId piece, std::uint32_t place, BranchState state,
           std::span<const ConeCorner> cone, const EmissionContext& context, Workspace& w);
  void drop(std::uint32_t fragment);
  void drop_below(const SvbspTree& tree, Place place);
  void drop_all_at(std::uint32_t& head) {
    while (head != invalid_index) drop(head);
  }
  void link(std::uint32_t fragment, const FragmentId& id);
  void relink(std::uint32_t fragment, const FragmentId& id);

  CellId cell_;
  Block* block_ = nullptr;
  std::uint32_t update_ = 0;
  std::vector<Record> records_;
  std::vector<std::uint32_t> at_place_, of_piece_;  // first fragments, by place and by piece
  BranchStates states_;
  MarkedWays ways_;
  RangeList free_corners_;
  std::vector<Place> changed_;         // since emit_changes()
  std::vector<PieceId> added_pieces_;  // likewise
  std::vector<Place> pending_;         // of drop_below()
  std::vector<FragmentId> gone_, born_;
  std::vector<AreaChange> area_changes_;
};

}  // namespace shadowcut
