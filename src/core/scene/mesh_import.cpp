#include "scene/mesh_import.hpp"

#include <tsl/robin_map.h>
#include <tsl/robin_set.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <tuple>

#include "numbers/error_free.hpp"
#include "scene/convex_decomposition.hpp"
#include "scene/coplanar_groups.hpp"
#include "support/hash.hpp"

namespace shadowcut {
namespace {

struct PositionHash {
  std::size_t operator()(const Vec3& v) const {
    std::uint64_t bits[3];
    std::memcpy(bits, v.data(), sizeof bits);
    return mix(bits[0] + mix(bits[1] + mix(bits[2])));
  }
};

// Positions by their indices into an array of distinct positions.
class PositionSet {
 public:
  PositionSet(const std::vector<Vec3>& positions, std::size_t expected)
      : indices_(0, Hash{&positions}, Equal{&positions}) {
    indices_.reserve(expected);
  }
  // Enters position i. Returns i, or the index of an equal position entered before.
  std::uint32_t enter(std::uint32_t i) { return *indices_.insert(i).first; }

 private:
  struct Hash {
    const std::vector<Vec3>* positions;
    std::size_t operator()(std::uint32_t i) const { return PositionHash()((*positions)[i]); }
  };
  struct Equal {
    const std::vector<Vec3>* positions;
    bool operator()(std::uint32_t i, std::uint32_t j) const {
      return (*positions)[i] == (*positions)[j];
    }
  };
  tsl::robin_set<std::uint32_t, Hash, Equal> indices_;
};

// The outlines of the faces kept so far, to find duplicates. Outlines are numbered from 0.
class OutlineSet {
 public:
  explicit OutlineSet(std::size_t expected) : known_(0, Hash{this}, Equal{this}) {
    known_.reserve(expected);
  }
  OutlineSet(const OutlineSet&) = delete;  // the table refers to it
  OutlineSet& operator=(const OutlineSet&) = delete;

  // Enters the outline of a face; false if there is an equal one. Each loop is turned to begin with
  // its smallest corner.
  bool enter(std::span<const Loop> loops) {
    const std::size_t begin = corners_.size();
    for (const Loop& l : loops) {
      const auto smallest =
          static_cast<std::size_t>(std::min_element(l.begin(), l.end()) - l.begin());
      for (std::size_t i = 0; i < l.size(); ++i) corners_.push_back(l[(smallest + i) % l.size()]);
    }
    std::uint64_t hash = loops.size();
    for (std::size_t i = begin; i < corners_.size(); ++i) hash = mix(hash + corners_[i]);
    hashes_.push_back(hash);
    begins_.push_back(corners_.size());
    if (known_.insert(static_cast<std::uint32_t>(hashes_.size() - 1)).second) return true;
    hashes_.pop_back(), begins_.pop_back();
    corners_.resize(begin);
    return false;
  }

 private:
  struct Hash {
    const OutlineSet* set;
    std::size_t operator()(std::uint32_t i) const { return set->hashes_[i]; }
  };
  struct Equal {
    const OutlineSet* set;
    bool operator()(std::uint32_t i, std::uint32_t j) const {
      const auto a = set->outline(i), b = set->outline(j);
      return std::equal(a.begin(), a.end(), b.begin(), b.end());
    }
  };
  std::span<const std::uint32_t> outline(std::uint32_t i) const {
    return std::span(corners_).subspan(begins_[i], begins_[i + 1] - begins_[i]);
  }

  std::vector<std::uint32_t> corners_;
  std::vector<std::size_t> begins_{0};  // into corners_; one more than outlines
  std::vector<std::uint64_t> hashes_;   // by outline
  tsl::robin_set<std::uint32_t, Hash, Equal> known_;
};

// The plane through a loop's first corner with Newell's normal. The arithmetic is on differences
// from that corner, scaled to size one, so that neither a far-away face nor a huge or tiny one
// loses digits.
struct Fit {
  Plane plane;
  double area = 0;      // of the whole figure, holes taken off
  double diameter = 0;  // of its bounding box
  bool zero = true;     // no area that rounding could not have made
};

template <class Loops, class Position>
Fit fit_plane(const Loops& loops, const Position& position) {
  Fit out;
  const Vec3 origin = position(loops[0][0]);
  Eigen::AlignedBox3d box;
  for (const std::uint32_t v : loops[0]) box.extend(position(v));
  const double extent = box.sizes().maxCoeff();
  out.diameter = box.sizes().stableNorm();
  if (!std::isfinite(extent) || extent == 0) return out;
  int exponent;
  std::frexp(extent, &exponent);
  // a power of two: short numbers stay short
  const double size = std::ldexp(1.0, std::min(exponent, 1023));
  Vec3 sum = Vec3::Zero();
  double magnitude = 0;
  for (std::size_t k = 0; k < loops.size(); ++k) {
    Vec3 n = Vec3::Zero();
    const Loop& l = loops[k];
    const Vec3 first = (position(l[0]) - origin) / size;
    for (std::size_t i = 1; i + 1 < l.size(); ++i) {
      const Vec3 u = (position(l[i]) - origin) / size - first,
                 v = (position(l[i + 1]) - origin) / size - first;
      n += u.cross(v);
      magnitude += u.norm() * v.norm();
    }
    // A hole takes its area off, whichever way it runs.
    if (k > 0 && n.dot(sum) > 0) n = -n;
    sum += n;
  }
  const double length = sum.norm();
  // Every term of a cross product carries at most five roundings of its own and one for each
  // addition behind it.
  out.zero = length <= (8.0 + static_cast<double>(loops[0].size())) * unit_roundoff * magnitude;
  if (out.zero) return out;
  out.plane.normal = sum / length;
  out.plane.exact_normal = sum * std::ldexp(1.0, -std::ilogb(sum.cwiseAbs().maxCoeff()));
  out.plane.point = origin;
  out.plane.flatness = 0;
  for (const Loop& l : loops) {
    for (const std::uint32_t v : l)
      out.plane.flatness =
          std::max(out.plane.flatness, std::abs(out.plane.normal.dot(position(v) - origin)));
  }
  out.area = length / 2 * size * size;
  // Over the face's least width, which is no less than area / diameter.
  out.plane.tilt =
      (out.plane.flatness + 8 * unit_roundoff * size) / size / (length / 2 / (out.diameter / size));
  if (out.area == 0) out.zero = true;
  return out;
}

Vec3 world(const Pose& pose, const Vec3& local) {
  return (pose * local).unaryExpr([](double c) { return c == 0 ? 0.0 : c; });  // one zero
}

// Straight down the normal's largest component: those coordinates are the input's own, so every
// turn of a loop of them is exact.
Vec2 flattened(const Vec3& v, const Vec3& normal) {
  Eigen::Index drop;
  normal.cwiseAbs().maxCoeff(&drop);
  return {v[(drop + 1) % 3] * (normal[drop] > 0 ? 1 : -1), v[(drop + 2) % 3]};
}

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
  std::vector<Loop> loops_;               // of the face at hand
  std::vector<Vec2> points_;              // of the face at hand, flattened
  // directed edges of the kept outlines; where each face's begin
  std::vector<std::uint32_t> outline_, outline_face_;
};

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

ImportedMesh import_mesh(const Mesh& mesh, const Pose& pose, const Tolerances& tolerances) {
  return MeshImporter(mesh, pose, tolerances).run();
}

}  // namespace shadowcut
