#include "scene/mesh_import.hpp"

#include <tsl/robin_map.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "scene/convex_decomposition.hpp"
#include "scene/coplanar_groups.hpp"
#include "scene/distinct.hpp"
#include "scene/plane_fit.hpp"
#include "support/hash.hpp"

namespace shadowcut {
namespace {

// Disjoint sets of faces.
class UnionFind {
 public:
  explicit UnionFind(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[root(a)] = root(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

class MeshImporter : private ImportedMesh {
 public:
  MeshImporter(const Mesh& mesh, const Pose& pose, const Tolerances& tolerances)
      : mesh_(mesh), pose_(pose), tolerances_(tolerances) {
    mirrored_ = pose.linear().determinant() < 0;
    weld();
  }

  ImportedMesh run() {
    edge_ids_.reserve(mesh_.face_count() * 2);
    OutlineSet outlines(mesh_.face_count());
    for (std::uint32_t f = 0; f < mesh_.face_count(); ++f) {
      Face face{0, f, static_cast<std::uint32_t>(facets.size()), 0, 0.0};
      if (take_loops(f)) {
        if (outlines.enter(loops_)) cut(f, face);
        else report(f, Reason::duplicate);
      }
      faces.push_back(face);
      if (face.facet_count) note_connectivity();
      else outline_face_.push_back(invalid_index);
    }
    decide_sides();
    share_planes();
    SHADOWCUT_ASSERT(planes.size() == origins.size() && faces.size() == outline_face_.size());
    return std::move(static_cast<ImportedMesh&>(*this));
  }

 private:
  void weld() {
    const std::size_t n = mesh_.vertices.size();
    vertex_of.resize(n);
    PositionSet known(vertices, n);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 v = world(pose_, mesh_.vertices[i]);
      if (!v.allFinite()) {
        vertex_of[i] = invalid_index;
        continue;
      }
      const auto next = static_cast<std::uint32_t>(vertices.size());
      vertices.push_back(v);
      vertex_of[i] = known.enter(next);
      if (vertex_of[i] == next) local_.push_back(mesh_.vertices[i]);
      else vertices.pop_back();
    }
  }

  void report(std::uint32_t face, Reason reason, std::string detail = {}) {
    Issue& issue = issues.emplace_back();
    issue.face = face, issue.reason = reason, issue.detail = std::move(detail);
  }

  // Fills loops_ with the face's welded loops. False: refused, and said so.
  bool take_loops(std::uint32_t f) {
    loops_.resize(mesh_.loop_count(f));
    bool repeated = false;
    for (std::size_t k = 0; k < loops_.size(); ++k) {
      Loop& out = loops_[k];
      out.clear();
      for (const std::uint32_t i : mesh_.loop(f, k)) {
        if (i >= vertex_of.size())
          return report(f, Reason::index_out_of_range, "index " + std::to_string(i)), false;
        if (vertex_of[i] == invalid_index) return report(f, Reason::non_finite), false;
        if (!out.empty() && out.back() == vertex_of[i]) {
          repeated = true;
        } else {
          out.push_back(vertex_of[i]);
        }
      }
      while (out.size() > 1 && out.front() == out.back()) out.pop_back(), repeated = true;
      Loop distinct = out;
      std::sort(distinct.begin(), distinct.end());
      if (std::unique(distinct.begin(), distinct.end()) - distinct.begin() < 3)
        return report(f, Reason::too_few_corners), false;
      if (mirrored_) std::reverse(out.begin(), out.end());
    }
    if (loops_.empty()) return report(f, Reason::too_few_corners), false;
    if (repeated) report(f, Reason::repeated_corner);
    return true;
  }

  Fit fit(std::span<const Loop> loops) const {
    return fit_plane(loops, [this](std::uint32_t v) -> const Vec3& { return vertices[v]; });
  }

  // Cuts the figure in loops_ into facets of `face`.
  void cut(std::uint32_t f, Face& face) {
    SHADOWCUT_ASSERT(face.facet_count == 0 && !loops_.empty());
    const Fit whole = fit(loops_);
    if (!std::isfinite(whole.diameter) || !std::isfinite(whole.area))
      return report(f, Reason::non_finite, "its extent is not representable");
    if (whole.zero) return report(f, Reason::zero_area);

    points_.clear();
    std::vector<Loop> flat;
    std::vector<std::uint32_t> back;
    for (const Loop& l : loops_) {
      flat.emplace_back();
      for (const std::uint32_t v : l) {
        flat.back().push_back(static_cast<std::uint32_t>(points_.size()));
        points_.push_back(flattened(vertices[v], whole.plane.normal));
        back.push_back(v);
      }
    }
    const bool is_flat = whole.plane.flatness <= tolerances_.flatness * whole.diameter;
    // out and back along one edge: nothing that a bridge to a hole would do
    for (const Loop& l : loops_) {
      for (std::size_t i = 0; i < l.size(); ++i) {
        if (l[i] == l[(i + 2) % l.size()])
          return report(f, Reason::self_intersecting, "it turns back on itself");
      }
    }
    std::vector<Loop> parts;
    if (flat.size() == 1 && is_convex(points_, flat[0]) && (is_flat || flat[0].size() == 3)) {
      parts = std::move(flat);
    } else if (convex_parts(points_, std::move(flat), is_flat, parts) != ConvexResult::ok) {
      return report(f, Reason::self_intersecting);
    }
    if (!is_flat && whole.plane.flatness > 0 && parts.size() > 1) {
      char detail[80];
      std::snprintf(detail, sizeof detail, "a corner lies %.3g off the plane, %.3g of the diameter",
                    whole.plane.flatness, whole.plane.flatness / whole.diameter);
      report(f, Reason::not_flat, detail);
    }
    if (is_flat) planes.push_back(whole.plane);
    for (Loop& part : parts) {
      for (std::uint32_t& i : part) i = back[i];
      const Fit own = fit(std::span(&part, 1));
      if (own.zero) continue;  // a sliver that only rounding sees: it has no area to be lit
      if (!is_flat) planes.push_back(own.plane);
      facets.push_back({f, static_cast<std::uint32_t>(planes.size() - 1),
                        static_cast<std::uint32_t>(corners.size()),
                        static_cast<std::uint32_t>(part.size())});
      ++face.facet_count;
      face.area += own.area;
      for (std::size_t i = 0; i < part.size(); ++i)
        corners.push_back({part[i], edge_id(part[i], part[(i + 1) % part.size()])});
    }
    if (face.facet_count == 0) report(f, Reason::zero_area);
  }

  std::uint32_t edge_id(std::uint32_t from, std::uint32_t to) {
    SHADOWCUT_ASSERT(from < vertices.size() && to < vertices.size());
    const Edge e{std::min(from, to), std::max(from, to)};
    const auto [found, fresh] = edge_ids_.try_emplace(std::uint64_t{e.a} << 32 | e.b,
                                                      static_cast<std::uint32_t>(edges.size()));
    if (fresh) edges.push_back(e);
    return (found->second << 1) | (from > to ? 1u : 0u);
  }

  // The outline, not the facets, says what a face is joined to: cutting may have left out straight
  // corners.
  void note_connectivity() {
    outline_face_.push_back(static_cast<std::uint32_t>(outline_.size()));
    for (const Loop& l : loops_) {
      for (std::size_t i = 0; i < l.size(); ++i)
        outline_.push_back(edge_id(l[i], l[(i + 1) % l.size()]));
    }
  }

  // Six times the volume of the cone from a point over a face, in units of size^3.
  double sixfold_cone(const Face& face, const Vec3& from, double size) const {
    double sixfold = 0;
    for (std::uint32_t k = 0; k < face.facet_count; ++k) {
      const Facet& facet = facets[face.first_facet + k];
      const auto corner = [&](std::uint32_t i) {
        return ((vertices[corners[facet.first_corner + i].vertex] - from) / size).eval();
      };
      const Vec3 a = corner(0);
      for (std::uint32_t i = 1; i + 1 < facet.corner_count; ++i)
        sixfold += a.dot(corner(i).cross(corner(i + 1)));
    }
    return sixfold;
  }

  // The closed parts of a mesh bound a solid if each has a positive volume.
  void decide_sides() {
    std::vector<std::uint32_t> forward(edges.size(), invalid_index),
        backward(edges.size(), invalid_index);
    const bool each_side_once = note_faces_of_edges(forward, backward);
    bool shared_by_two = true;
    UnionFind parts(faces.size());
    for (std::size_t e = 0; e < edges.size(); ++e) {
      if ((forward[e] == invalid_index) != (backward[e] == invalid_index)) shared_by_two = false;
      if (forward[e] != invalid_index && backward[e] != invalid_index)
        parts.join(forward[e], backward[e]);
    }
    const bool any = std::any_of(outline_face_.begin(), outline_face_.end(),
                                 [](std::uint32_t begin) { return begin != invalid_index; });
    const bool outward = measure_volumes(parts);
    closed = any && each_side_once && shared_by_two && outward;
  }

  // By edge: the face whose outline runs along it, and the face whose outline runs against it.
  // False: two outlines run along an edge in one direction.
  bool note_faces_of_edges(std::vector<std::uint32_t>& forward,
                           std::vector<std::uint32_t>& backward) const {
    bool each_side_once = true;
    for (std::uint32_t f = 0, next = 0; f < faces.size(); f = next) {
      do ++next;
      while (next < faces.size() && outline_face_[next] == invalid_index);
      if (outline_face_[f] == invalid_index) continue;
      const std::size_t end = next < faces.size() ? outline_face_[next] : outline_.size();
      for (std::size_t i = outline_face_[f]; i < end; ++i) {
        auto& side = (outline_[i] & 1 ? backward : forward)[outline_[i] >> 1];
        if (side != invalid_index) each_side_once = false;
        side = f;
      }
    }
    return each_side_once;
  }

  // The volume of every part, seen from a corner of its own and in units of its own size: parts far
  // apart or of very different size do not disturb each other. False: a part has none, or is
  // inside out.
  bool measure_volumes(UnionFind& parts) {
    std::vector<Eigen::AlignedBox3d> box(faces.size());
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
      for (std::uint32_t k = 0; k < faces[f].facet_count; ++k) {
        const Facet& facet = facets[faces[f].first_facet + k];
        for (std::uint32_t i = 0; i < facet.corner_count; ++i)
          box[parts.root(f)].extend(vertices[corners[facet.first_corner + i].vertex]);
      }
    }
    std::vector<double> sixfold(faces.size(), 0.0);
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
      if (outline_face_[f] == invalid_index) continue;
      const std::uint32_t root = parts.root(f);
      const Facet& first = facets[faces[root].first_facet];
      const Vec3& from = vertices[corners[first.first_corner].vertex];
      sixfold[root] += sixfold_cone(faces[f], from, box[root].sizes().maxCoeff());
    }
    bool outward = true;
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
      if (outline_face_[f] == invalid_index || parts.root(f) != f) continue;
      const double size = box[f].sizes().maxCoeff();
      signed_volume += sixfold[f] / 6 * size * size * size;
      if (!(sixfold[f] > 0)) outward = false;
    }
    return outward;
  }

  // Which faces were meant to lie in one plane is asked of the mesh as it was given, so that no
  // motion of the object changes it. Only a pose that distorts may turn apart what is nearly one.
  void share_planes() {
    std::vector<Patch> patches;
    for (std::uint32_t k = 0; k < facets.size(); ++k) {
      if (k == 0 || facets[k].plane != facets[k - 1].plane) patches.push_back({k, k});
      patches.back().end_facet = k + 1;
    }
    std::vector<Plane> own;
    for (const Patch& p : patches) own.push_back(planes[facets[p.first_facet].plane]);
    std::vector<Membership> members(patches.size());
    for (std::uint32_t i = 0; i < members.size(); ++i) members[i] = {i, false};
    if (tolerances_.coplanarity > 0) {
      members = find_groups({facets, corners, local_}, patches, tolerances_.coplanarity,
                            std::sqrt(tolerances_.coplanarity) / distortion());
    }
    const std::vector<Plane> common =
        common_planes({facets, corners, vertices}, patches, own, members);

    std::vector<std::uint32_t> size(patches.size(), 0);  // of groups, by leader
    for (const Membership& m : members) ++size[m.leader];
    planes.clear();
    std::map<std::tuple<std::uint32_t, bool, int>, std::uint32_t> shared;
    for (std::uint32_t i = 0; i < patches.size(); ++i) {
      const auto next = static_cast<std::uint32_t>(planes.size());
      std::uint32_t plane = next;
      if (size[members[i].leader] > 1) {
        // A light nearer to a plane than its tilt sees it edge-on: what is much narrower must not
        // say so for the rest.
        const double wider = common[i].tilt / common[members[i].leader].tilt;
        const int narrowness = std::max(std::ilogb(wider), 0) / 6;
        plane = shared.emplace(std::tuple(members[i].leader, members[i].opposite, narrowness), next)
                    .first->second;
      }
      if (plane == next) {
        planes.push_back(common[i]);
        origins.push_back({patches[members[i].leader].first_facet, members[i].opposite});
      }
      planes[plane].tilt = std::max(planes[plane].tilt, common[i].tilt);
      for (std::uint32_t k = patches[i].first_facet; k < patches[i].end_facet; ++k)
        facets[k].plane = plane;
      note_alignment(patches[i], common[i], own[i]);
    }
  }

  void note_alignment(const Patch& patch, const Plane& plane, const Plane& own) {
    if (same_plane(plane, own)) return;
    aligned += patch.end_facet - patch.first_facet;
    aligned_by = std::max(aligned_by, distance_from(plane, {facets, corners, vertices}, patch));
  }

  // The most by which the pose can change an angle: 1 when it is rigid.
  double distortion() const {
    const auto scales = Eigen::JacobiSVD<Eigen::Matrix3d>(pose_.linear()).singularValues();
    const double ratio = scales[0] / scales[2];
    return ratio < 1 + 1e-9 ? 1 : ratio;
  }

  const Mesh& mesh_;
  const Pose& pose_;
  Tolerances tolerances_;
  bool mirrored_;
  std::vector<Vec3> local_;  // the welded vertices in the local frame
  struct EdgeHash {
    std::size_t operator()(std::uint64_t ends) const { return mix(ends); }
  };
  tsl::robin_map<std::uint64_t, std::uint32_t, EdgeHash> edge_ids_;  // by both ends
  std::vector<Loop> loops_;                                          // of the present face
  std::vector<Vec2> points_;  // of the present face, flattened
  // directed edges of the kept outlines; where each face's begin
  std::vector<std::uint32_t> outline_, outline_face_;
};

}  // namespace

ImportedMesh import_mesh(const Mesh& mesh, const Pose& pose, const Tolerances& tolerances) {
  return MeshImporter(mesh, pose, tolerances).run();
}

}  // namespace shadowcut
