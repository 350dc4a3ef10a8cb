// Polygons of facets in world space: corners, areas, constructions.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "fragments/emission_context.hpp"
#include "predicates/cell_predicates.hpp"

namespace shadowcut {

// The area of a polygon given corner by corner, as its part along the plane's normal: linear in the
// corners, so the areas of parts add up.
class AreaSum {
 public:
  explicit AreaSum(const Vec3& first) : origin_(first) {}
  void add(const Vec3& x) {
    const Vec3 spoke = x - origin_;
    doubled_ += last_.cross(spoke);
    last_ = spoke;
  }
  double area(const Vec3& normal) const { return std::abs(doubled_.dot(normal)) / 2; }

 private:
  Vec3 origin_, last_ = Vec3::Zero(), doubled_ = Vec3::Zero();
};

// Whether a facet's area can be taken from its corners. The region of a facet is its plane cut by
// its cone. Where its corners are flat only up to rounding, corners and region differ by as much,
// and by more where the light nearly lies in the plane; areas are the region's, so that they add
// up. Elsewhere the corners serve.
bool area_from_corners(const EmissionContext& context, FacetId facet);

// A polygon of a facet in world space: counter-clockwise seen from the light, as many corners as
// the cone has. Returns its area.
double place_polygon(const EmissionContext& context, const CellPredicates& predicates,
                     FacetId facet, std::span<const ConeCorner> cone, PointCache& points,
                     Vec3* out);

// What the corners of a polygon are, from corner `first` of the block on.
void note_constructions(const EmissionContext& context, const CellPredicates& predicates,
                        std::span<const ConeCorner> cone, std::size_t first, Block& block);

// The area of a facet's region. in_light: its plane cut by its cone of light (for facets that
// entered); otherwise what its corners enclose.
double area_of_facet(const EmissionContext& context, FacetId facet, bool in_light);

// Options::min_feature: whether a fragment is too small to be emitted. A fragment that no cut
// divides from its facet is always emitted.
bool is_below_min_feature(const EmissionContext& context, FacetId facet,
                          std::span<const ConeCorner> cone, std::span<const Vec3> corners,
                          double area);

}  // namespace shadowcut
