// The invariants of one light's state, checked.

#include "engine/light_state.hpp"
#include "support/message.hpp"

namespace shadowcut {
namespace {

// 14. A face's fragments, and what was dropped, add up to its area, as far as corners can say that
// carry a rounding of their distance from the light and of their own coordinates: for a needle far
// away, or a face seen at a grazing angle, which prolongs it, that is more than a share of its
// area.
std::string check_areas(const LightView& light) {
  const Scene& scene = light.context.scene;
  const LightSpace& space = light.context.space;
  for (std::size_t f = 0; f < light.shadows.areas.size(); ++f) {
    const FaceArea& a = light.shadows.areas[f];
    if (a.facing == Facing::ignored || a.facing == Facing::refused) continue;
    Eigen::AlignedBox3d box;
    double spread = 0;
    const Face& face = scene.faces()[f];
    for (const Facet& facet : scene.facets().subspan(face.first_facet, face.facet_count)) {
      for (const Corner& c : scene.corners_of(facet)) {
        const Vec3& x = scene.vertices()[c.vertex];
        box.extend(x);
        if (a.facing == Facing::toward)
          spread = std::max(spread, space.spread(x, scene.planes()[facet.plane]));
      }
    }
    const double reach =
        space.reach(box) + box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).norm();
    const double rounding = (64 * reach + 8 * spread) * unit_roundoff * box.diagonal().norm();
    if (!(std::abs(a.lit + a.shadowed + a.dropped - a.area) <= 1e-9 * a.area + rounding))
      return message("a face's lit and shadowed areas do not add up to its area", f);
  }
  return {};
}

}  // namespace

std::string LightState::validate_touched() const {
  for (const CellId c : touched_) {
    std::string problem = shadowcut::validate(grid_[c], nullptr);
    if (problem.empty()) problem = fragments_.validate(c);
    if (!problem.empty()) return problem;
  }
  return {};
}

std::string LightState::validate() const {
  for (std::size_t c = 0; c < grid_.size(); ++c) {
    std::string problem = shadowcut::validate(grid_[CellId(c)], &space_);
    if (problem.empty()) problem = fragments_.validate(CellId(c));
    if (!problem.empty()) return "cell " + std::to_string(c) + ": " + problem;
  }
  if (options_.tuning.incremental) {
    if (std::string problem = grid_.validate_locations(); !problem.empty()) return problem;
    if (std::string problem = grid_.validate_lines(); !problem.empty()) return problem;
  }
  return check_areas(view());
}

}  // namespace shadowcut
