// The door: everything that enters a scene is welded, checked and cut into convex facets here.
#pragma once

#include <shadowcut/scene.hpp>
#include <span>
#include <vector>

namespace shadowcut {

inline constexpr std::size_t max_edges = std::size_t{1} << 29;  // an edge's line id leaves room for its flags in 32 bits

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
};
Admitted admit(const Mesh& mesh, const Pose& pose, double tolerance);

// What a rigid motion changes of an object that has been admitted: positions, planes, areas.
struct Carried {
  std::vector<Vec3> vertices;
  std::vector<Plane> planes;  // by facet
  std::vector<double> areas;  // by face
};
// False when more than that may change, so that admit() has to look at everything again: the motion is not rigid, a face is not one facet,
// positions are welded otherwise, a face is no longer flat or convex.
bool carry(const Mesh& mesh, std::span<const std::uint32_t> vertex_of, const Pose& to, double tolerance, const Scene& scene,
           const Object& object, Carried& out);

}  // namespace shadowcut
