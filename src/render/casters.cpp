// See casters.hpp.
#include "casters.hpp"

#include <algorithm>

namespace shadowcut::render {

std::vector<Caster> casters_of(const Scene& scene, const Light& light) {
  std::vector<Caster> casters;
  for (std::uint32_t f = 0; f < scene.facets().size(); ++f) {
    const Facet& facet = scene.facets()[f];
    if (facet.corner_count == 0) continue;
    const Object& object = scene.objects()[scene.faces()[facet.face].object];
    const Plane& plane = scene.planes()[facet.plane];
    const double away = plane.normal.dot(away_from(light, plane.point));
    if (!object.casts_shadows || away == 0 || (away > 0 && object.sides == Sides::closed)) continue;
    Caster caster{f, {}};
    for (const Corner& corner : scene.corners_of(facet)) caster.vertices.push_back(corner.vertex);
    if (away > 0) std::reverse(caster.vertices.begin(), caster.vertices.end());
    casters.push_back(std::move(caster));
  }
  return casters;
}

}  // namespace shadowcut::render
