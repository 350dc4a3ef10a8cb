// Convex polygons in the world, and cutting them by planes: what brute force, scene BSP, ordered
// tree and tiling have in common, so that differences in speed are not differences of polygon code
// (Slater 1992, section 6).
//
// Plain doubles. A corner within `tolerance` of a plane is on it (length units; lighting.hpp says
// how it is chosen), and nothing is cut there. A polygon's edges remember which line they lie on: a
// shadow plane is made of that line and not of two corners, which after many cuts may be as near to
// each other as their own rounding.
#pragma once

#include <boost/container/small_vector.hpp>
#include <cstdint>
#include <shadowcut/scene.hpp>
#include <vector>

namespace shadowcut::compare {

// {x: normal . (x - point) = 0}; its front is where that is positive.
struct HalfSpace {
  Vec3 normal;
  Vec3 point;
  double above(const Vec3& x) const { return normal.dot(x - point); }
};

// The line that an edge lies on: an edge of the facet it was cut from, where its plane meets
// another one, or a plane through the light.
struct Carrier {
  enum class Kind : std::uint8_t { edge, plane, shadow_plane };
  Kind kind;
  // edge: of the corner it starts at, among the facet's; plane: into Scene::planes()
  std::uint32_t index;
};

struct PolygonCorner {
  Vec3 at;
  Carrier edge;  // to the next corner
};

struct Polygon {
  std::uint32_t facet = invalid_index;
  boost::container::small_vector<PolygonCorner, 6> corners;
};

Polygon polygon_of(const Scene& scene, std::uint32_t facet);
double area_of(const Polygon& polygon);

enum class Side : std::uint8_t { on, front, back, across };

// How a polygon stands to a plane: the corners' signed distances, those on the plane as zero.
struct Standing {
  Side side;
  boost::container::small_vector<double, 16> distances;
};
Standing stand(const Polygon& polygon, const HalfSpace& plane, double tolerance);

// The two parts of a polygon that stands across a plane; the edge between them gets that carrier.
struct Halves {
  Polygon front, back;
};
Halves split(const Polygon& polygon, const Standing& standing, Carrier cut);

// Cuts a polygon down to its part in front of a shadow plane. `rest`, if not null, gets the other
// part where there are two parts. False, and the polygon stays, if no part is in front.
bool keep_front(Polygon& polygon, const HalfSpace& plane, double tolerance,
                std::vector<Polygon>* rest = nullptr);

// Of all facets.
Eigen::AlignedBox3d box_of(const Scene& scene);

}  // namespace shadowcut::compare
