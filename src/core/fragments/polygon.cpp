#include "fragments/polygon.hpp"

#include <algorithm>

namespace shadowcut {
namespace {

// The point of a ray in the facet's plane. Where a light nearly touches the plane the numbers may
// have no such point: then any point of the facet serves.
Vec3 on_plane(const EmissionContext& context, FacetId facet, const double r[3]) {
  const Vec3 x = context.space.back(r, context.tables.covector_of(facet).q);
  if (x.allFinite()) return x;
  return context.scene.vertices()[context.scene.corners_of(context.tables.facet(facet))[0].vertex];
}

const Vec3& normal_of(const EmissionContext& context, FacetId facet) {
  return context.tables.plane_of(facet).normal;
}

// As a point light sees it: triangles by Van Oosterom & Strackee 1983.
double solid_angle(std::span<const Vec3> corners, const Vec3& light) {
  const auto to = [&](std::size_t i) { return (corners[i] - light).stableNormalized().eval(); };
  const Vec3 a = to(0);
  Vec3 b = to(1);
  double angle = 0;
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const Vec3 c = to(i);
    angle += 2 * std::atan2(a.dot(b.cross(c)), 1 + a.dot(b) + b.dot(c) + c.dot(a));
    b = c;
  }
  return std::abs(angle);
}

}  // namespace

bool area_from_corners(const EmissionContext& context, FacetId facet) {
  constexpr double flat = 900 * unit_roundoff;
  const double flatness = context.tables.plane_of(facet).flatness;
  const double area = context.scene.faces()[context.tables.face_of(facet).value()].area;
  return flatness * flatness <= flat * flat * area && !context.visibility.grazed(facet);
}

namespace {

// The exact kernel's corners are the true ones, rounded.
double place_exactly(const EmissionContext& context, const CellPredicates& predicates,
                     FacetId facet, std::span<const ConeCorner> cone, PointCache& points,
                     Vec3* out) {
  SHADOWCUT_ASSERT(cone.size() >= 2 && context.tables.is_exact());
  const auto count = static_cast<std::uint32_t>(cone.size());
  const bool reversed = context.space.handedness() < 0;
  const auto own = context.scene.corners_of(context.tables.facet(facet));
  // A corner where two edges of one of the facet's own vertices meet is that vertex.
  const auto vertex = [&](std::uint32_t i) {
    if (cone[i].vertex != invalid_index) return cone[i].vertex;
    const std::uint32_t v = predicates.shared_vertex(incoming(cone, i), cone[i].edge);
    return std::any_of(own.begin(), own.end(), [v](const Corner& c) { return c.vertex == v; })
               ? v
               : invalid_index;
  };
  const auto at = [&](std::uint32_t i) { return predicates.point(cone, i, facet, points); };
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t i = reversed ? count - 1 - k : k;
    const std::uint32_t v = vertex(i);
    out[k] = v == invalid_index ? at(i) : context.scene.vertices()[v];
  }
  const bool will_do = area_from_corners(context, facet);
  AreaSum sum(will_do ? out[0] : at(0));
  for (std::uint32_t k = 1; k < count; ++k) sum.add(will_do ? out[k] : at(k));
  return sum.area(normal_of(context, facet));
}

}  // namespace

double place_polygon(const EmissionContext& context, const CellPredicates& predicates,
                     FacetId facet, std::span<const ConeCorner> cone, PointCache& points,
                     Vec3* out) {
  if (predicates.is_exact()) return place_exactly(context, predicates, facet, cone, points, out);
  SHADOWCUT_ASSERT(cone.size() >= 2);
  const std::size_t count = cone.size();
  const bool reversed = context.space.handedness() < 0;
  const double* q = context.tables.covector_of(facet).q;
  const Vec3* vertices = context.scene.vertices().data();
  const bool will_do = area_from_corners(context, facet);
  if (will_do) {
    for (std::size_t k = 0; k < count; ++k) {
      const ConeCorner& c = cone[reversed ? count - 1 - k : k];
      out[k] = c.vertex == invalid_index ? context.space.back(c.r, q) : vertices[c.vertex];
    }
    AreaSum sum(out[0]);
    for (std::size_t k = 1; k < count; ++k) sum.add(out[k]);
    // Every corner has a part in it: no point at infinity hides from it.
    if (const double area = sum.area(normal_of(context, facet)); std::isfinite(area)) return area;
  }
  const auto at = [&](std::size_t k) {
    return on_plane(context, facet, cone[reversed ? count - 1 - k : k].r);
  };
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t v = cone[reversed ? count - 1 - k : k].vertex;
    out[k] = v == invalid_index ? at(k) : vertices[v];
  }
  AreaSum sum(will_do ? out[0] : at(0));
  for (std::size_t k = 1; k < count; ++k) sum.add(will_do ? out[k] : at(k));
  return sum.area(normal_of(context, facet));
}

void note_constructions(const EmissionContext& context, const CellPredicates& predicates,
                        std::span<const ConeCorner> cone, std::size_t first, Block& block) {
  block.constructions.resize(block.corners.size());
  SHADOWCUT_ASSERT(first + cone.size() <= block.corners.size());
  const auto count = static_cast<std::uint32_t>(cone.size());
  const bool reversed = context.space.handedness() < 0;
  for (std::uint32_t k = 0; k < count; ++k) {
    Construction c = predicates.construction(cone, reversed ? count - 1 - k : k);
    if (reversed) std::swap(c.in, c.out);
    block.constructions[first + k] = c;
  }
}

double area_of_facet(const EmissionContext& context, FacetId facet, bool in_light) {
  const Plane& plane = context.tables.plane_of(facet);
  const bool project = in_light && !area_from_corners(context, facet);
  const auto corner = [&](const Corner& c) -> Vec3 {
    const Vec3& vertex = context.scene.vertices()[c.vertex];
    if (!project) return vertex;
    if (context.tables.exact)
      return context.tables.exact->point(plane, {&vertex, false, nullptr, nullptr, false, false});
    return on_plane(context, facet, context.tables.rays[c.vertex].r);
  };
  const auto corners = context.scene.corners_of(context.tables.facet(facet));
  AreaSum sum(corner(corners[0]));
  for (const Corner& c : corners.subspan(1)) sum.add(corner(c));
  return sum.area(plane.normal);
}

bool is_below_min_feature(const EmissionContext& context, FacetId facet,
                          std::span<const ConeCorner> cone, std::span<const Vec3> corners,
                          double area) {
  const MinFeature& least = context.min_feature;
  if (least.keeps_all()) return false;
  const bool is_whole = cone.size() == context.tables.facet(facet).corner_count &&
                        std::all_of(cone.begin(), cone.end(),
                                    [](const ConeCorner& c) { return c.vertex != invalid_index; });
  if (is_whole) return false;
  return area < least.area || (least.solid_angle > 0 &&
                               solid_angle(corners, context.light.position) < least.solid_angle);
}

}  // namespace shadowcut
