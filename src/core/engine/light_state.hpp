// Everything that the engine holds for one light, and the order in which its parts work: which
// facets enter (FacetVisibility), their numbers (LightTables), the trees (CellGrid), the fragments
// (FragmentStore), the areas (AreaLedger), when cells are built again (RebuildPolicy).
#pragma once

#include <memory>
#include <shadowcut/shadows.hpp>
#include <span>
#include <string>
#include <vector>

#include "engine/area_ledger.hpp"
#include "engine/cell_statistics.hpp"
#include "engine/rebuild_policy.hpp"
#include "facets/facet_visibility.hpp"
#include "facets/insertion_order.hpp"
#include "fragments/fragment_store.hpp"
#include "fragments/overlay.hpp"
#include "svbsp/cell_grid.hpp"

namespace shadowcut {

class LightState {
 public:
  // Builds. The scene must outlive the state.
  LightState(const Scene& scene, const Light& light, const Options& options);
  LightState(const LightState&) = delete;
  LightState& operator=(const LightState&) = delete;

  const Shadows& shadows() const { return shadows_; }
  Shadows take_shadows() { return std::move(shadows_); }
  const Fragment* find(FragmentId id) const { return fragments_.find(id); }
  LightView view() const { return {grid_, fragments_.context(), shadows_}; }
  // Of every face, how much could be in another state; see Engine::uncertain_area.
  std::vector<double> error_bound() const;
  // Every invariant; empty when all hold.
  std::string validate() const;
  // The invariants that cost no arithmetic, of the cells that this update has touched.
  std::string validate_touched() const;

  // An update is one call of begin_update, any number of edits, and finish_update, which lists what
  // has changed.
  //   rebuild         builds everything again, for a light that may be another; reuses its memory
  //   remove_objects  takes objects out, while the scene still holds them as they were inserted
  //   insert_objects  inserts them again, or what the scene now holds in their place. The same
  //                   objects must have been removed.
  void begin_update();
  void rebuild(const Light& light);
  void remove_objects(std::span<const std::uint32_t> objects);
  void insert_objects(std::span<const std::uint32_t> objects);
  void finish_update(LightChanges& changes);
  // Instead of edits and finish_update: the light has been removed.
  void remove_light(LightChanges& changes);

 private:
  bool is_exact() const { return options_.kernel == Kernel::exact; }
  void note_all_gone();
  void build();
  void sum_up();
  void start_edits();

  template <class Edit>
  void edit_cells(std::span<const CellId> cells, std::size_t work, const Edit& edit);
  void finish_edit(std::span<const CellId> cells);
  void note_location_list(std::uint32_t object);
  void absorb_away(FacetId facet, bool added);
  bool suits_light_space(std::span<const std::uint32_t> objects) const;
  void grow();
  void prepare_objects(std::span<const std::uint32_t> objects);
  void insert_into_cells(std::span<const FacetId> order);
  void rebuild_cell(CellId cell);
  void emit_again();

  const Scene& scene_;
  Options options_;
  Light light_;
  LightSpace space_;
  PerThread<Workspace> workspaces_;
  LightTables tables_;
  FacetVisibility visibility_;
  InsertionOrder order_;
  CellGrid grid_;
  Shadows shadows_;
  FragmentStore fragments_;
  AreaLedger areas_;
  RebuildPolicy policy_;
  CellStatistics statistics_;

  // Of this update.
  std::uint32_t update_ = 0;
  bool rebuilt_ = false, edited_ = false;
  std::vector<CellId> touched_;
  std::vector<std::uint32_t> touched_in_;  // by cell: the update in which it was touched last
  std::vector<CellId> batch_;              // cells changed since objects were removed
};

}  // namespace shadowcut
