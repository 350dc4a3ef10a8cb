// What of a scene casts, as shadow volumes need it: the facets that stand between light and others,
// seen counter-clockwise from the light.
#pragma once

#include <shadowcut/scene.hpp>
#include <vector>

namespace shadowcut::render {

struct Caster {
  std::uint32_t facet;
  // into Scene::vertices(), counter-clockwise seen from the light
  std::vector<std::uint32_t> vertices;
};

// Of solids the facets that are turned to the light, of sheets all; not those whose plane the light
// is in, nor objects that do not cast.
std::vector<Caster> casters_of(const Scene& scene, const Light& light);

// The direction from the light through x; of any length.
inline Vec3 away_from(const Light& light, const Vec3& x) {
  return light.kind == Light::Kind::point ? Vec3(x - light.position) : light.direction;
}

}  // namespace shadowcut::render
