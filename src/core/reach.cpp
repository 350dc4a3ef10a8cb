// See reach.hpp.

#include "reach.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "light_space.hpp"

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

bool within_reach(const Scene& scene, const Face& face, const Light& light) {
  if (light.kind != Light::Kind::point) return true;
  const auto facets = scene.facets().subspan(face.first_facet, face.facet_count);
  const bool in_range =
      !std::isfinite(light.range) || std::any_of(facets.begin(), facets.end(), [&](const Facet& f) {
        return distance_to_facet(scene, f, light.at) <= light.range;
      });
  if (!in_range || !light.spot) return in_range;
  const Vec3 axis = light.spot->axis.stableNormalized();
  return std::any_of(facets.begin(), facets.end(), [&](const Facet& f) {
    return angle_to_facet(scene, f, light.at, axis) <= light.spot->half_angle;
  });
}

// By the winding number: the solid angles of all triangles, signed (Van Oosterom & Strackee 1983),
// add up to 4 pi inside, to 0 outside, and to something between on the surface: at an edge or a
// vertex the solid takes up a part of all directions.
bool meets_all_corners(const Scene& scene, const Facet& facet, const Vec3& light) {
  const Plane& plane = scene.planes()[facet.plane];
  const double side = plane.normal.dot(plane.point - light) > 0 ? 1 : -1;
  const auto corners = scene.corners_of(facet);
  return std::all_of(corners.begin(), corners.end(), [&](const Corner& c) {
    const Vec3 ray = scene.vertices()[c.vertex] - light;
    return side * plane.normal.dot(ray) >
           2 * (8 * unit_roundoff * ray.stableNorm() + plane.flatness);
  });
}

bool in_or_on_solid(const Scene& scene, const Object& object, const Vec3& p) {
  Eigen::AlignedBox3d box;
  for (std::uint32_t i = 0; i < object.vertex_count; ++i)
    box.extend(scene.vertices()[object.first_vertex + i]);
  // Corners are turned and moved with some roundings of their coordinates.
  const double slack = 8 * unit_roundoff *
                       std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
  if (!(box.exteriorDistance(p) <= slack)) return false;
  double sum = 0;
  for (std::uint32_t f = object.first_face; f < object.first_face + object.face_count; ++f) {
    const Face& face = scene.faces()[f];
    for (std::uint32_t k = 0; k < face.facet_count; ++k) {
      const auto corners = scene.corners_of(scene.facets()[face.first_facet + k]);
      const auto to = [&](std::size_t i) {
        return (scene.vertices()[corners[i].vertex] - p).stableNormalized().eval();
      };
      const Vec3 a = to(0);
      for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
        const Vec3 b = to(i), c = to(i + 1);
        const double det = a.dot(b.cross(c));
        // seen edge-on: nothing, or, from within the triangle, a half-space of uncertain sign
        if (std::abs(det) < 1e-12) continue;
        sum += 2 * std::atan2(det, 1 + a.dot(b) + b.dot(c) + c.dot(a));
      }
    }
  }
  return std::abs(sum) > 1e-6;
}

}  // namespace shadowcut
