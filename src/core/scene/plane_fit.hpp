// The plane of a face, and a face as a plane figure.
#pragma once

#include <algorithm>
#include <cmath>
#include <shadowcut/scene.hpp>

#include "numbers/error_free.hpp"
#include "scene/convex_decomposition.hpp"

namespace shadowcut {

// The plane through a loop's first corner with Newell's normal. The arithmetic is on differences
// from that corner, scaled to size one, so that neither a far-away face nor a huge or tiny one
// loses digits.
struct Fit {
  Plane plane;
  double area = 0;      // of the whole figure, holes taken off
  double diameter = 0;  // of its bounding box
  bool zero = true;     // no area that rounding could not have made
};

template <class Loops, class Position>
Fit fit_plane(const Loops& loops, const Position& position) {
  Fit out;
  const Vec3 origin = position(loops[0][0]);
  Eigen::AlignedBox3d box;
  for (const std::uint32_t v : loops[0]) box.extend(position(v));
  const double extent = box.sizes().maxCoeff();
  out.diameter = box.sizes().stableNorm();
  if (!std::isfinite(extent) || extent == 0) return out;
  int exponent;
  std::frexp(extent, &exponent);
  // a power of two: short numbers stay short
  const double size = std::ldexp(1.0, std::min(exponent, 1023));
  Vec3 sum = Vec3::Zero();
  double magnitude = 0;
  for (std::size_t k = 0; k < loops.size(); ++k) {
    Vec3 n = Vec3::Zero();
    const Loop& l = loops[k];
    const Vec3 first = (position(l[0]) - origin) / size;
    for (std::size_t i = 1; i + 1 < l.size(); ++i) {
      const Vec3 u = (position(l[i]) - origin) / size - first,
                 v = (position(l[i + 1]) - origin) / size - first;
      n += u.cross(v);
      magnitude += u.norm() * v.norm();
    }
    // A hole takes its area off, whichever way it runs.
    if (k > 0 && n.dot(sum) > 0) n = -n;
    sum += n;
  }
  const double length = sum.norm();
  // Every term of a cross product carries at most five roundings of its own and one for each
  // addition behind it.
  out.zero = length <= (8.0 + static_cast<double>(loops[0].size())) * unit_roundoff * magnitude;
  if (out.zero) return out;
  out.plane.normal = sum / length;
  out.plane.exact_normal = sum * std::ldexp(1.0, -std::ilogb(sum.cwiseAbs().maxCoeff()));
  out.plane.point = origin;
  out.plane.flatness = 0;
  for (const Loop& l : loops) {
    for (const std::uint32_t v : l)
      out.plane.flatness =
          std::max(out.plane.flatness, std::abs(out.plane.normal.dot(position(v) - origin)));
  }
  out.area = length / 2 * size * size;
  // Over the face's least width, which is no less than area / diameter.
  out.plane.tilt =
      (out.plane.flatness + 8 * unit_roundoff * size) / size / (length / 2 / (out.diameter / size));
  if (out.area == 0) out.zero = true;
  return out;
}

inline Vec3 world(const Pose& pose, const Vec3& local) {
  return (pose * local).unaryExpr([](double c) { return c == 0 ? 0.0 : c; });  // one zero
}

// Straight down the normal's largest component: those coordinates are the input's own, so every
// turn of a loop of them is exact.
inline Vec2 flattened(const Vec3& v, const Vec3& normal) {
  Eigen::Index drop;
  normal.cwiseAbs().maxCoeff(&drop);
  return {v[(drop + 1) % 3] * (normal[drop] > 0 ? 1 : -1), v[(drop + 2) % 3]};
}

}  // namespace shadowcut
