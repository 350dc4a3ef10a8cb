// The vector of a light, whatever its kind: the position of a point light, the direction of a
// directional light.
#pragma once

#include <shadowcut/scene.hpp>

namespace shadowcut::testing {

inline Vec3& vector_of(Light& light) {
  return light.kind == Light::Kind::point ? light.position : light.direction;
}
inline const Vec3& vector_of(const Light& light) {
  return light.kind == Light::Kind::point ? light.position : light.direction;
}

}  // namespace shadowcut::testing
