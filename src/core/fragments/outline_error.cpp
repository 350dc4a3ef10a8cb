#include "fragments/outline_error.hpp"

#include <algorithm>

namespace shadowcut {

// No less than the area of a facet's region, its plane cut by its cone, as the exact kernel has it,
// and no less than what its corners enclose: with what rounding of coordinates adds. Where some
// corner's ray does not meet the plane there is no region.
double OutlineError::most_area(FacetId facet) const {
  const Plane& plane = context_.tables.plane_of(facet);
  const int front = exact_.orientation(plane);
  std::vector<Vec3> points;
  for (const Corner& c : context_.scene.corners_of(context_.tables.facet(facet))) {
    const Vec3& x = context_.scene.vertices()[c.vertex];
    const bool meets = front != 0 && exact_.ahead(plane, x) > 0;
    points.push_back(meets ? exact_.point(plane, {&x, false, nullptr, nullptr, false, false}) : x);
  }
  SHADOWCUT_ASSERT(points.size() >= 3);
  AreaSum sum(points[0]);
  double perimeter = 0, extent = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Vec3 &x = points[k], &next = points[(k + 1) % points.size()];
    sum.add(next);
    perimeter += (next - x).norm(), extent = std::max(extent, x.cwiseAbs().maxCoeff());
  }
  const bool in_light = context_.visibility.facing(facet) == Facing::toward;
  const double area = std::max(sum.area(plane.normal), area_of_facet(context_, facet, in_light));
  return area * (1 + 64 * unit_roundoff) +
         perimeter * (4 * unit_roundoff * extent + 8 * unit_roundoff * perimeter);
}

double OutlineError::most_area_of_face(std::uint32_t f) const {
  const Face& face = context_.scene.faces()[f];
  double most = 0;
  for (std::uint32_t i = face.first_facet; i < face.first_facet + face.facet_count; ++i)
    most += most_area(FacetId(i));
  return most;
}

// How thick a facet seen edge-on may be, in light space. All its edges are in one great circle as
// seen from the light, up to this thickness; but around a light inside it they run once round the
// circle, and what they bound is half of all directions.
double OutlineError::thickness_of(FacetId facet) const {
  const auto corners = context_.scene.corners_of(context_.tables.facet(facet));
  const auto at = [&](std::size_t k) -> const Vec3& {
    return context_.scene.vertices()[corners[k % corners.size()].vertex];
  };
  std::vector<Vec3> rays;
  for (std::size_t k = 0; k < corners.size(); ++k) rays.emplace_back(context_.space.ray(at(k)).r);
  double thickness = 0;
  Vec3 axis = Vec3::Zero(), turn = Vec3::Zero();
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Line edge = context_.space.line(at(k), at(k + 1));
    const Vec3 n(edge.n);
    if (!n.allFinite()) return 2;
    double farthest = 0;
    for (const Vec3& ray : rays) farthest = std::max(farthest, std::abs(n.dot(ray)));
    thickness = std::max(thickness, farthest + static_cast<double>(edge.error) + sign_slack);
    if (axis.isZero()) axis = n;
    const double cosine = std::clamp(rays[k].dot(rays[(k + 1) % rays.size()]), -1.0, 1.0);
    turn += (n.dot(axis) < 0 ? -1 : 1) * std::acos(cosine) * axis;
  }
  return turn.norm() > 3 ? 2 : std::min(2 * thickness, 2.0);
}

// How thick the facets are, all together, that were left out because they are seen edge-on, and
// exactly are not. They themselves are uncertain whole. A facet that is not quite convex is in the
// tree as if it were: that moves its edges by its kink.
double OutlineError::thickness_left_out(std::vector<double>& uncertain) const {
  double thickness = 0;
  ConePool pool;
  const Scene& scene = context_.scene;
  for (std::uint32_t i = 0; i < scene.facets().size(); ++i) {
    const FacetId id(i);
    const Facet& facet = scene.facets()[i];
    if (facet.corner_count == 0 || context_.visibility.facing(id) == Facing::out_of_reach) continue;
    const Object& object = scene.objects()[context_.tables.object_of(id)];
    if (context_.visibility.enters(id)) {
      Cone* cone = context_.visibility.cone_of(id, pool);
      thickness += 2 * kink(*cone);
      pool.give_back(cone);
    }
    if (context_.visibility.orientation(id) != Orientation::edge_on) continue;
    const int front = exact_.orientation(context_.tables.plane_of(id));
    if (front == 0 || (front < 0 && object.sides == Sides::closed &&
                       !context_.visibility.light_is_inside(object, context_.light)))
      continue;
    if (object.receives_shadows) uncertain[facet.face] += most_area(id);
    if (object.casts_shadows) thickness += thickness_of(id);
  }
  return thickness;
}

// By how much the loop is not convex as the light sees it.
double OutlineError::kink(const Cone& cone) const {
  double deepest = 0;
  for (std::uint32_t k = 0; k < cone.count; ++k)
    deepest = std::max(deepest, -context_.visibility.turn_behind(cone, k));
  return deepest;
}

// What is uncertain of a facet as a whole: where facets that were left out may shadow it, and where
// its edges are, as its corners are on its plane up to its flatness only.
double OutlineError::of_facet(FacetId facet, double thickness) const {
  const Plane& plane = context_.tables.plane_of(facet);
  const auto corners = context_.scene.corners_of(context_.tables.facet(facet));
  double spread = 0, slide = 0, perimeter = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec3 &x = context_.scene.vertices()[corners[k].vertex],
               &next = context_.scene.vertices()[corners[(k + 1) % corners.size()].vertex];
    perimeter += (next - x).norm();
    spread = std::max(spread, context_.space.spread(x, plane));
    slide = std::max(slide, context_.space.slide(x, plane));
  }
  return perimeter *
         (thickness * spread + slide * (2 * plane.flatness + 8 * unit_roundoff * perimeter));
}

void OutlineError::add(std::vector<double>& uncertain) const {
  const double thickness = thickness_left_out(uncertain);
  for (std::uint32_t i = 0; i < context_.scene.facets().size(); ++i) {
    if (context_.visibility.facing(FacetId(i)) == Facing::toward)
      uncertain[context_.scene.facets()[i].face] += of_facet(FacetId(i), thickness);
  }
}

}  // namespace shadowcut
