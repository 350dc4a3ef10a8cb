// The smallest feature kept (Options::min_feature): of the two parts of a cut the smaller one goes if it is less than that. The larger one
// stays whatever its size, so nothing vanishes whole.
#pragma once

#include <algorithm>
#include <cmath>

#include "lines.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {

struct FeatureSize {
  double area;         // on the facet's plane
  double solid_angle;  // as a point light sees it
};

// Van Oosterom & Strackee 1983 for the solid angle of a triangle.
inline FeatureSize feature_size(const LightTables& tables, const Cone& cone) {
  const std::uint32_t plane = tables.facets[cone.facet].plane;
  const auto at = [&](std::uint32_t i) { return tables.space->back(cone.corners()[i].r, tables.planes[plane].q); };
  const Vec3 first = at(0), a = (first - tables.light_at).stableNormalized();
  Vec3 last = at(1), b = (last - tables.light_at).stableNormalized(), doubled = Vec3::Zero();
  double angle = 0;
  for (std::uint32_t i = 2; i < cone.count; ++i) {
    const Vec3 x = at(i), c = (x - tables.light_at).stableNormalized();
    doubled += (last - first).cross(x - first);
    angle += 2 * std::atan2(a.dot(b.cross(c)), 1 + a.dot(b) + b.dot(c) + c.dot(a));
    last = x, b = c;
  }
  return {std::abs(doubled.dot(tables.scene_planes[plane].normal)) / 2, std::abs(angle)};
}

// Which of the two parts of a cut goes; null: neither.
inline Cone* too_small(const LightTables& tables, Cone* a, Cone* b) {
  const MinFeature& least = tables.least;
  if (least.area == 0 && least.solid_angle == 0) return nullptr;
  const FeatureSize size_a = feature_size(tables, *a), size_b = feature_size(tables, *b);
  const FeatureSize& smaller = size_a.area < size_b.area ? size_a : size_b;
  return smaller.area < least.area || smaller.solid_angle < least.solid_angle ? size_a.area < size_b.area ? a : b : nullptr;
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
