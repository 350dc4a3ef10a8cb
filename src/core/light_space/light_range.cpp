#include "light_space/light_range.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace shadowcut {
namespace {

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
  return (a + t * d - p).norm();
}

double distance_to_facet(const Scene& scene, const Facet& facet, const Vec3& p) {
  const auto corners = scene.corners_of(facet);
  const Plane& plane = scene.planes()[facet.plane];
  bool inside = true;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 &a = scene.vertices()[corners[i].vertex],
               &b = scene.vertices()[corners[(i + 1) % corners.size()].vertex];
    inside = inside && plane.normal.dot((b - a).cross(p - a)) >= 0;
    nearest = std::min(nearest, distance_to_segment(p, a, b));
  }
  return inside ? std::abs(plane.normal.dot(p - plane.point)) : nearest;
}

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// The smallest angle between the axis and the directions from the light to the facet.
double angle_to_facet(const Scene& scene, const Facet& facet, const Vec3& light, const Vec3& axis) {
  const auto corners = scene.corners_of(facet);
  int left = 0, right = 0;
  double smallest = std::numbers::pi;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = scene.vertices()[corners[i].vertex] - light,
               b = scene.vertices()[corners[(i + 1) % corners.size()].vertex] - light;
    const Vec3 n = a.cross(b);
    (n.dot(axis) > 0 ? left : right) += 1;
    smallest = std::min(smallest, angle_between(a, axis));
    const Vec3 closest = axis - n * (n.dot(axis) / n.squaredNorm());  // in the plane of a and b
    if (a.cross(closest).dot(n) > 0 && closest.cross(b).dot(n) > 0)
      smallest = std::min(smallest, angle_between(closest, axis));
  }
  // The axis passes through the facet, not through its mirror image behind the light.
  const Plane& plane = scene.planes()[facet.plane];
  const double ahead = plane.normal.dot(plane.point - light) * plane.normal.dot(axis);
  return (left == 0 || right == 0) && ahead > 0 ? 0 : smallest;
}

}  // namespace

bool within_range(const Scene& scene, const Face& face, const Light& light) {
  if (light.kind != Light::Kind::point) return true;
  const auto facets = scene.facets().subspan(face.first_facet, face.facet_count);
  const bool in_range =
      !std::isfinite(light.range) || std::any_of(facets.begin(), facets.end(), [&](const Facet& f) {
        return distance_to_facet(scene, f, light.position) <= light.range;
      });
  if (!in_range || !light.spot) return in_range;
  const Vec3 axis = light.spot->axis.stableNormalized();
  return std::any_of(facets.begin(), facets.end(), [&](const Facet& f) {
    return angle_to_facet(scene, f, light.position, axis) <= light.spot->half_angle;
  });
}

}  // namespace shadowcut
