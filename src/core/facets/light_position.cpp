#include "facets/light_position.hpp"

#include <algorithm>
#include <cmath>

#include "numbers/error_free.hpp"

namespace shadowcut {

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

// By the winding number: the solid angles of all triangles, signed (Van Oosterom & Strackee 1983),
// add up to 4 pi inside, to 0 outside, and to something between on the surface: at an edge or a
// vertex the solid takes up a part of all directions.
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
