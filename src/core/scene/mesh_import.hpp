// Import of a mesh into a scene: positions are welded, faces are checked and cut into convex
// facets, nearly coplanar facets get one plane.
#pragma once

#include <optional>
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

// Where a plane comes from: it is the plane of the facet, or one through the corners of all facets
// whose planes name this facet. Its front is that of the facet, or the opposite side. Facets of one
// group have several planes where they look to both sides, and where their tilts differ widely.
struct PlaneOrigin {
  std::uint32_t facet;
  bool opposite;
};

// An object in the world frame. All indices count from its own first elements.
struct ImportedMesh : MeshArrays {
  std::vector<Issue> issues;
  bool closed = true;  // the meaning of Sides::automatic
  double signed_volume = 0;
  std::vector<std::uint32_t> vertex_of;  // by vertex of the mesh; invalid_index: not finite
  std::vector<PlaneOrigin> origins;      // by plane
  std::uint32_t aligned = 0;             // see Object
  double aligned_by = 0;
};
ImportedMesh import_mesh(const Mesh& mesh, const Pose& pose, const Tolerances& tolerances);

// A rigid motion of an object that has been imported.
struct RigidMotion {
  const Mesh& mesh;
  std::span<const std::uint32_t> vertex_of;  // see ImportedMesh
  std::span<const PlaneOrigin> origins;      // likewise
  const Pose& to;
  Tolerances tolerances;
};
// What a rigid motion changes.
struct MovedMesh {
  std::vector<Vec3> vertices;
  std::vector<Plane> planes;  // by the object's planes
  std::vector<double> areas;  // by face
};
// Empty when more than that may change, so that import_mesh() has to check everything again: the
// motion is not rigid, a face is not one facet, positions are welded otherwise, a face is no longer
// flat or convex. Facets that share a plane still do: `first_plane` is the object's first plane.
std::optional<MovedMesh> apply_rigid_motion(const RigidMotion& motion, const Scene& scene,
                                            const Object& object, std::uint32_t first_plane);

}  // namespace shadowcut
