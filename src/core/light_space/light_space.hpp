// Light space: rays from the light as three numbers, in which every question of the tree is linear.
//
// A light is one projective map of space, (r, h) = T (x - C, 1), that takes the light to infinity
// along h:
//   - points on one ray from the light have r in one direction;
//   - a face's plane is a covector q with q.r = h on the plane, so along a ray r the point with the
//     greater q.r is nearer to the light;
//   - a plane through the light is a covector n: n.r = 0.
// Three frames differ only in T:
//   near point light   C = the light, r = (x - C) / scale, h = 1
//                      (q.r is 1 / distance along the ray)
//   far point light    C = the scene's centre, r sheared and scaled to the scene's size:
//                      the light's distance cancels by algebra, not in digits
//   directional light  the far frame's limit (1 / distance to the light = 0)
//
// Numbers of the fast kernel. u = 2^-53. Rays of vertices and normals of lines have length 1
// (within rounding), and carry an absolute bound on the distance from the true unit vector (up to a
// positive factor). A corner cut from two lines is their cross product as it is: length <= 1, error
// <= err1 + err2 + 3u. So a sign test n.r is decided when |n.r| > err(n) + err(r) + 4u. (|r| <= 1;
// three products and two sums lose at most 3u |n| |r|; the fourth u pays for second-order terms and
// for the unit lengths' own rounding.)
#pragma once

#include <cmath>
#include <cstdint>
#include <shadowcut/scene.hpp>
#include <vector>

#include "numbers/error_free.hpp"

namespace shadowcut {

// A plane through the light; as seen from the light, a line.
struct Line {
  double n[3];
  float error;
  // Of an edge: its vertices, whose rays are on the line.
  std::uint32_t a = invalid_index, b = invalid_index;
};

// The vertex in whose ray the lines of two edges meet; none if the edges share no vertex.
inline std::uint32_t shared_vertex(const Line& l, const Line& m) {
  if (l.a == invalid_index || m.a == invalid_index) return invalid_index;
  return l.a == m.a || l.a == m.b ? l.a : l.b == m.a || l.b == m.b ? l.b : invalid_index;
}

// The plane of a face in light space.
struct PlaneCovector {
  double q[3];
  // Absolute, of q. Includes the flatness of the plane: two planes nearer together than the input
  // is flat are in contact.
  float error;
};

// The ray from the light to a vertex.
struct VertexRay {
  double r[3];
  float error;
};

// Whether the front of a plane faces the light (toward) or its back does (away). The public enum
// Facing is about the side of a facet that receives light; FacetVisibility derives it from this.
enum class Orientation : std::uint8_t { toward, away, edge_on };

class LightSpace {
 public:
  // `box` bounds the scene. It only conditions the numbers: points outside it are allowed.
  LightSpace(const Light& light, const Eigen::AlignedBox3d& box);

  VertexRay ray(const Vec3& x) const;
  // The line through the edge a -> b: positive on the left as the light sees the edge, or in its
  // mirror image (see handedness()). Line::a and b are not set.
  Line line(const Vec3& a, const Vec3& b) const;
  PlaneCovector plane(const Plane& p) const;  // not for planes seen edge-on
  Orientation orientation(const Plane& p) const;
  // The direction of the plane as a covector of length one. Unlike q it exists for planes seen
  // edge-on.
  Vec3 covector(const Plane& p) const;
  // A linear function of r, divided by this weight, is linear on the plane q (at the point where r
  // meets q).
  double weight(const double r[3], const double q[3]) const {
    const double h = q[0] * r[0] + q[1] * r[1] + q[2] * r[2];
    return far_ ? r[2] + sign_ * scale_ * h * inverse_depth_ : h;
  }
  // The distance, to first order, by which the point back(r, q) moves along its ray when q moves
  // by 1.
  double pull(const double r[3], const double q[3]) const {
    const double w = std::abs(weight(r, q)),
                 length = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    return far_ ? 2 * scale_ * length / w : scale_ * length * length / (w * w);
  }
  // The largest distance, to first order, by which x moves in its plane p when its ray, of length
  // one, moves by 1.
  double spread(const Vec3& x, const Plane& p) const;
  // For a point x at distance 1 from the plane: the largest distance from x to the point where the
  // ray of x meets the plane.
  double slide(const Vec3& x, const Plane& p) const;
  // The point where the ray r meets the plane q.
  Vec3 back(const double r[3], const double q[3]) const {
    const double h = q[0] * r[0] + q[1] * r[1] + q[2] * r[2];
    if (far_) return back_from_far({r[0], r[1], r[2]}, h);
    const double s = scale_ / h;
    return {center_[0] + r[0] * s, center_[1] + r[1] * s, center_[2] + r[2] * s};
  }

  // The parameters of the frame, for ExactPredicates.
  struct Frame {
    bool far;
    Vec3 center;
    int axis[3];
    double sign, scale;
  };
  Frame frame() const { return {far_, center_, {axis_[0], axis_[1], axis_[2]}, sign_, scale_}; }
  // Two points with short coordinates. The plane through them and the light is n, up to rounding.
  std::pair<Vec3, Vec3> span(const Vec3& n) const;

  // +1 when a loop that runs counter-clockwise seen from the light does so in r too (its lines
  // positive inside), else -1.
  int handedness() const { return handedness_; }
  bool far() const { return far_; }
  // The distance from the frame's centre to the farthest point of a box, or of the scene.
  double reach(const Eigen::AlignedBox3d& box) const {
    return std::max(
        scale_, (box.min() - center_).cwiseAbs().cwiseMax((box.max() - center_).cwiseAbs()).norm());
  }

 private:
  struct Raw {
    Vec3 r;
    double error;  // absolute
  };
  Vec3 back_from_far(const Vec3& r, double h) const;
  Raw raw_ray(const Vec3& x) const;
  double awayness(const Plane& p, double& error, double& tilted) const;

  bool far_;
  Vec3 center_;
  int axis_[3] = {0, 1, 2};           // far: which world axes play x, y, z
  double shear_x_ = 0, shear_y_ = 0;  // far: d_x / d_z, d_y / d_z
  double inverse_depth_ = 0;          // far: 1 / d_z; directional: 0
  double sign_ = 1;                   // far: of d_z
  // The size of the scene as the light sees it, a power of two: neither tiny nor huge scenes leave
  // the range of float and double.
  double scale_ = 1, inverse_scale_ = 1;
  int handedness_ = 1;
};

}  // namespace shadowcut
