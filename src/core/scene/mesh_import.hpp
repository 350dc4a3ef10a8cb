// The door: everything that enters a scene is welded, checked and cut into convex facets here.
#pragma once

#include <shadowcut/scene.hpp>
#include <span>
#include <vector>

namespace shadowcut {

// What counts as rounding; see Scene.
struct Tolerances {
  double flatness, coplanarity;
};

// an edge's line id leaves room for its flags in 32 bits
inline constexpr std::size_t max_edges = std::size_t{1} << 29;

// Whose plane it is: that of the facet, or one through the corners of all facets whose planes name
// this one; its front is the facet's, or the opposite side. Facets of one group have several planes
// where they look to both sides, and where they are of very different tilt.
struct PlaneOrigin {
  std::uint32_t facet;
  bool opposite;
};

// An object as it enters: world frame; all indices count from its own first.
struct Admitted {
  std::vector<Vec3> vertices;  // welded
  std::vector<Plane> planes;
  std::vector<Facet> facets;
  std::vector<Corner> corners;
  std::vector<Edge> edges;
  std::vector<Face> faces;
  std::vector<Issue> issues;
  bool closed;  // what Sides::automatic means here
  double signed_volume;
  std::vector<std::uint32_t> vertex_of;  // by the mesh's vertices; none: not finite
  std::vector<PlaneOrigin> origins;      // by plane
  std::uint32_t aligned;                 // see Object
  double aligned_by;
};
Admitted admit(const Mesh& mesh, const Pose& pose, const Tolerances& tolerances);

// What a rigid motion changes of an object that has been admitted: positions, planes, areas.
struct Carried {
  std::vector<Vec3> vertices;
  std::vector<Plane> planes;  // by the object's planes
  std::vector<double> areas;  // by face
};
// False when more than that may change, so that admit() has to look at everything again: the motion
// is not rigid, a face is not one facet, positions are welded otherwise, a face is no longer flat
// or convex. Facets that share a plane go on doing so: `first_plane` is that of the object's.
bool carry(const Mesh& mesh, std::span<const std::uint32_t> vertex_of,
           std::span<const PlaneOrigin> origins, const Pose& to, const Tolerances& tolerances,
           const Scene& scene, const Object& object, std::uint32_t first_plane, Carried& out);

}  // namespace shadowcut
