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

  void decide_sides() {
    std::vector<std::uint32_t> forward(edges.size(), invalid_index),
        backward(edges.size(), invalid_index);
    std::vector<std::uint32_t> part(faces.size());
    std::iota(part.begin(), part.end(), 0u);
    const auto find = [&](std::uint32_t i) {
      while (part[i] != i) i = part[i] = part[part[i]];
      return i;
    };
    bool any = false;
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
      if (outline_face_[f] == invalid_index) continue;
      any = true;
      std::size_t end = outline_.size();
      for (std::uint32_t g = f + 1; g < faces.size(); ++g) {
        if (outline_face_[g] != invalid_index) {
          end = outline_face_[g];
          break;
        }
      }
      for (std::size_t i = outline_face_[f]; i < end; ++i) {
        auto& side = (outline_[i] & 1 ? backward : forward)[outline_[i] >> 1];
        if (side != invalid_index) closed = false;
        side = f;
      }
    }
    for (std::size_t e = 0; e < edges.size(); ++e) {
      if ((forward[e] == invalid_index) != (backward[e] == invalid_index)) closed = false;
      if (forward[e] != invalid_index && backward[e] != invalid_index)
        part[find(forward[e])] = find(backward[e]);
    }
    // Every part's volume, seen from a corner of its own and in units of its own size: parts far
    // apart or of very different size do not disturb each other.
    std::vector<Eigen::AlignedBox3d> box(faces.size());
    const auto corner_of = [&](const Face& face, std::uint32_t i) -> const Vec3& {
      return vertices[corners[facets[face.first_facet].first_corner + i].vertex];
    };
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
      for (std::uint32_t k = 0; k < faces[f].facet_count; ++k) {
        const Facet& facet = facets[faces[f].first_facet + k];
        for (std::uint32_t i = 0; i < facet.corner_count; ++i)
          box[find(f)].extend(vertices[corners[facet.first_corner + i].vertex]);
      }
    }
    std::vector<double> sixfold(faces.size(), 0.0);
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
      const std::uint32_t root = find(f);
      if (outline_face_[f] != invalid_index)
        sixfold[root] +=
            sixfold_cone(faces[f], corner_of(faces[root], 0), box[root].sizes().maxCoeff());
    }
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
      if (outline_face_[f] == invalid_index || find(f) != f) continue;
      const double size = box[f].sizes().maxCoeff();
      signed_volume += sixfold[f] / 6 * size * size * size;
      if (!(sixfold[f] > 0)) closed = false;
    }
    closed = closed && any;
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
