// Building the state of one light.

#include "engine/light_state.hpp"

#include "facets/fill_tables.hpp"
#include "fragments/error_bound.hpp"
#include "support/clock.hpp"

namespace shadowcut {
namespace {

Eigen::AlignedBox3d box_of(const Scene& scene) {  // of what the light has to do with
  Eigen::AlignedBox3d box;
  for (const Facet& facet : scene.facets()) {
    if (facet.corner_count == 0) continue;
    const Object& object = scene.objects()[scene.faces()[facet.face].object];
    if (!object.casts_shadows && !object.receives_shadows) continue;
    for (const Corner& c : scene.corners_of(facet)) box.extend(scene.vertices()[c.vertex]);
  }
  return box;
}

}  // namespace

LightState::LightState(const Scene& scene, const Light& light, const Options& options)
    : scene_(scene),
      options_(options),
      light_(light),
      space_(light, {}),
      visibility_(scene_, space_, tables_, workspaces_),
      order_(scene_, tables_, visibility_, options.tuning.order, options.tuning.seed),
      grid_(scene_, tables_, visibility_,
            {options.tuning.incremental, options.tuning.join_threshold}, workspaces_),
      fragments_(grid_,
                 {scene_, space_, tables_, visibility_, light_, options.form, options.constructions,
                  options.min_feature},
                 options.tuning.incremental && options.form != Form::conforming, shadows_.blocks,
                 workspaces_),
      areas_(fragments_.context(), shadows_.areas, shadows_.stats),
      statistics_(grid_, fragments_, policy_, shadows_.stats) {
  begin_update();
  rebuild(light);
}

void LightState::begin_update() {
  ++update_;
  rebuilt_ = edited_ = false;
  touched_.clear();
  batch_.clear();
  fragments_.begin_update();
  areas_.begin_update();
}

// Before a rebuild.
void LightState::note_all_gone() {
  areas_.note_all();
  if (!shadows_.blocks.empty()) fragments_.note_all_gone(update_, edited_, rebuilt_);
  rebuilt_ = true;
  batch_.clear();
}

void LightState::rebuild(const Light& light) {
  note_all_gone();
  light_ = light;
  space_ = LightSpace(light, box_of(scene_));
  build();
}

void LightState::build() {
  const auto start = Clock::now();
  shadows_.stats = {};
  tables_.refer_to(scene_);
  if (is_exact()) {
    tables_.exact = std::make_unique<ExactPredicates>(light_, space_);
    for (const Object& object : scene_.objects()) tables_.exact->note_object(scene_, object);
  }
  visibility_.decide_all(light_);
  fill_tables(scene_, space_, visibility_, tables_);
  const std::vector<FacetId> order = order_.of_scene();
  grid_.divide(options_.tuning.facets_per_cell ? order_.middle_rays(order) : std::vector<Vec3>(),
               space_.far(), options_.tuning.facets_per_cell);
  if (is_exact()) set_exact_kd_lines(space_, tables_);
  grid_.build(order, options_.progress);
  shadows_.stats.build_ms = ms_since(start);

  const auto built = Clock::now();
  policy_.start(grid_.size());
  fragments_.emit_all(update_, options_.progress);
  sum_up();
  if (options_.tuning.incremental) start_edits();
  shadows_.stats.emit_ms = ms_since(built);
}

// Areas and statistics, after all fragments have been emitted.
void LightState::sum_up() {
  Stats& s = shadows_.stats;
  if (fragments_.is_incremental()) {
    areas_.start();
    const auto absorb = [this](const FragmentStore::AreaChange& c) { areas_.absorb(c); };
    for (std::size_t c = 0; c < grid_.size(); ++c) fragments_.take_area_changes(CellId(c), absorb);
    for (const Fragment& f : shadows_.blocks.back().fragments)
      absorb({f.face, f.lit, true, f.area});
    areas_.total_up(rebuilt_);
  } else {
    areas_.start(fragments_.emitted_areas(), shadows_.blocks);
  }
  for (const Face& face : scene_.faces()) s.faces += face.object != invalid_index;
  s.facets = visibility_.entered();
  s.cells = grid_.size();
  s.nodes = s.sp_nodes = grid_.kd_tree().node_count();
  statistics_.start();
  for (std::size_t c = 0; c < grid_.size(); ++c)
    s.depth = std::max(s.depth, grid_.kd_tree().depth_of(CellId(c)) + grid_[CellId(c)].depth());
  s.bytes += tables_.lines.size() * sizeof(Line) + tables_.rays.size() * sizeof(VertexRay) +
             tables_.planes.size() * sizeof(PlaneCovector);
}

std::vector<double> LightState::error_bound() const {
  if (is_exact()) return std::vector<double>(scene_.faces().size(), 0.0);
  return shadowcut::error_bound(view());
}

}  // namespace shadowcut
