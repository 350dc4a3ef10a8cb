// The rigid motion of an object that has been imported: positions, planes, areas.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "scene/coplanar_groups.hpp"
#include "scene/distinct.hpp"
#include "scene/mesh_import.hpp"
#include "scene/plane_fit.hpp"

namespace shadowcut {
namespace {

// The planes of an object whose faces are one facet each.
void move_planes(const Figure& figure, std::vector<Plane>& own,
                 std::span<const PlaneOrigin> origins, std::uint32_t first_plane,
                 std::vector<Plane>& out) {
  std::vector<Patch> patches;
  std::vector<Membership> members;
  bool shared = false;
  for (std::uint32_t k = 0; k < own.size(); ++k) {
    const PlaneOrigin& origin = origins[figure.facets[k].plane - first_plane];
    patches.push_back({k, k + 1});
    members.push_back({origin.facet, origin.opposite});
    shared = shared || origin.facet != k;
  }
  if (shared) own = common_planes(figure, patches, own, members);
  out.assign(origins.size(), Plane{});
  for (std::uint32_t k = 0; k < own.size(); ++k) {
    Plane& plane = out[figure.facets[k].plane - first_plane];
    const double tilt = std::max(plane.tilt, own[k].tilt);
    plane = own[k];
    plane.tilt = tilt;
  }
}

bool is_rigid(const Pose& from, const Pose& to) {
  const Eigen::Matrix3d turn = to.linear() * from.linear().inverse();
  return (turn.transpose() * turn - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-9 &&
         turn.determinant() > 0;
}

// False when the vertices are welded otherwise than before, or are not finite.
bool move_vertices(const RigidMotion& motion, const Object& object, std::vector<Vec3>& out) {
  out.resize(object.vertex_count);
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < motion.mesh.vertices.size(); ++i) {
    const Vec3 v = world(motion.to, motion.mesh.vertices[i]);
    const std::uint32_t welded = motion.vertex_of[i];
    if (welded == invalid_index || !v.allFinite()) return false;
    if (welded == next) {
      out[next++] = v;
    } else if (out[welded] != v) {
      return false;
    }
  }
  PositionSet apart(out, out.size());  // two positions may have become one
  for (std::uint32_t i = 0; i < out.size(); ++i) {
    if (apart.enter(i) != i) return false;
  }
  return true;
}

// One loop, as the only loop of a figure.
struct SingleLoop {
  Loop loop;
  std::size_t size() const { return 1; }
  const Loop& operator[](std::size_t) const { return loop; }
  const Loop* begin() const { return &loop; }
  const Loop* end() const { return &loop + 1; }
};

// The areas and planes of faces that are one facet each. False when a face is not one facet, or is
// no longer flat or convex.
bool move_faces(const RigidMotion& motion, const Scene& scene, const Object& object, MovedMesh& out,
                std::vector<Plane>& planes) {
  SingleLoop loops;
  std::vector<Vec2> points;
  std::vector<std::uint32_t> order;
  for (const Face& face : scene.faces().subspan(object.first_face, object.face_count)) {
    if (face.facet_count != 1) return false;
    loops.loop.clear();
    for (const Corner& c : scene.corners_of(scene.facets()[face.first_facet]))
      loops.loop.push_back(c.vertex - object.first_vertex);
    const Fit fit =
        fit_plane(loops, [&](std::uint32_t v) -> const Vec3& { return out.vertices[v]; });
    if (fit.zero || !std::isfinite(fit.diameter) || !std::isfinite(fit.area)) return false;
    const std::size_t n = loops.loop.size();
    if (n > 3 && !(fit.plane.flatness <= motion.tolerances.flatness * fit.diameter)) return false;
    points.clear(), order.clear();
    for (std::size_t i = 0; i < n; ++i) {
      if (out.vertices[loops.loop[i]] == out.vertices[loops.loop[(i + 1) % n]]) return false;
      points.push_back(flattened(out.vertices[loops.loop[i]], fit.plane.normal));
      order.push_back(static_cast<std::uint32_t>(i));
    }
    if (!is_convex(points, order)) return false;
    planes.push_back(fit.plane);
    out.areas.push_back(fit.area);
  }
  return true;
}

}  // namespace

std::optional<MovedMesh> apply_rigid_motion(const RigidMotion& motion, const Scene& scene,
                                            const Object& object, std::uint32_t first_plane) {
  MovedMesh out;
  std::vector<Plane> own;  // by facet, which is by face here
  if (!is_rigid(object.pose, motion.to) || !move_vertices(motion, object, out.vertices) ||
      !move_faces(motion, scene, object, out, own))
    return std::nullopt;
  const auto facets = scene.facets().subspan(object.first_facet, object.facet_count);
  move_planes({facets, scene.corners(), out.vertices, object.first_vertex}, own, motion.origins,
              first_plane, out.planes);
  return out;
}

}  // namespace shadowcut
