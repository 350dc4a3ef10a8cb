// All fragments of one light: a block for each cell, and a block for sides turned away, which never
// enter a tree.
//
// In the forms pieces and merged, an engine's store is incremental: an update touches only what
// changed. Static casts, and the conforming form, emit everything.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "fragments/cell_fragments.hpp"
#include "fragments/static_fragments.hpp"
#include "svbsp/cell_grid.hpp"

namespace shadowcut {

class FragmentStore {
 public:
  using AreaChange = CellFragments::AreaChange;

  // The references must stay valid. `incremental`: for edits; not with Form::conforming.
  FragmentStore(const CellGrid& grid, const EmissionContext& context, bool incremental,
                std::vector<Block>& blocks, PerThread<Workspace>& workspaces)
      : grid_(grid),
        context_(context),
        incremental_(incremental),
        blocks_(blocks),
        workspaces_(workspaces) {}

  bool is_incremental() const { return incremental_; }
  const EmissionContext& context() const { return context_; }

  // Emits all fragments of trees just built, or edited. Areas of fragments by face are in
  // emitted_areas() unless the store is incremental.
  void emit_all(std::uint32_t update, const std::function<void(double)>& report);
  const std::vector<FaceArea>& emitted_areas() const { return emitted_areas_; }

  // Edits of the cells, for an incremental store. For each cell an update calls begin() first.
  // Different cells may be edited by different threads.
  void begin(CellId cell, std::uint32_t update) {
    if (incremental_) cells_[cell.value()].begin(blocks_[cell.value()], update);
  }
  void apply(CellId cell) {
    if (incremental_) cells_[cell.value()].apply(grid_[cell].log);
  }
  void emit_changes(CellId cell) {
    if (incremental_) cells_[cell.value()].emit_changes(grid_[cell], context_, workspaces_.local());
  }
  void restart(CellId cell) {
    if (incremental_) cells_[cell.value()].restart(grid_[cell], context_, workspaces_.local());
  }
  // take(change) gets every change of an area in a cell since the last call.
  template <class Take>
  void take_area_changes(CellId cell, const Take& take) {
    if (!incremental_) return;
    for (const AreaChange& change : cells_[cell.value()].area_changes()) take(change);
    cells_[cell.value()].area_changes().clear();
  }

  // Sides turned away. False: there was nothing to do.
  void grow(std::size_t facets);
  bool add_away(FacetId facet, std::uint32_t update, AreaChange& change);
  bool remove_away(FacetId facet, std::uint32_t update, AreaChange& change);

  // What an update changed.
  void begin_update();
  // Before the first edit of an update: keeps what a store that is not incremental compares with.
  void keep_before() {
    if (!incremental_) before_ = blocks_;
  }
  // Before a rebuild: everything that there was before this update will be gone. `edited`,
  // `rebuilt`: whether that has happened in this update.
  void note_all_gone(std::uint32_t update, bool edited, bool rebuilt);
  void list_gone(LightChanges& changes) const { changes.gone = gone_; }
  void list_all(LightChanges& changes) const;
  void list_changes(std::span<const CellId> touched, LightChanges& changes);
  void list_differences(LightChanges& changes) const;

  const Fragment* find(FragmentId id) const;
  std::uint64_t bytes(CellId cell) const;
  std::string validate(CellId cell) const;

 private:
  void emit_incremental(std::uint32_t update);
  void emit_static(const std::function<void(double)>& report);
  Fragment emit_away(FacetId facet, std::uint32_t first_corner, Block& block) const;
  void emit_all_away(CellOutput& out) const;

  const CellGrid& grid_;
  EmissionContext context_;
  bool incremental_;
  std::vector<Block>& blocks_;  // by cell, and the block of sides turned away
  PerThread<Workspace>& workspaces_;
  std::vector<CellFragments> cells_;
  std::vector<FaceArea> emitted_areas_;  // by face

  std::vector<std::uint32_t> away_;       // by facet: index of its fragment in the last block
  std::vector<std::uint32_t> away_born_;  // by facet: the update in which it came
  RangeList away_corners_;                // of the last block

  // Of this update.
  std::vector<FragmentId> gone_;        // besides those that the cells know
  std::vector<FragmentId> away_added_;  // may have gone again
  std::vector<Block> before_;
};

}  // namespace shadowcut
