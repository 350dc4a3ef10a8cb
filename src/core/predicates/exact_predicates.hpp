// Exact signs and corners of light space: what the numbers of rays, lines and planes stand for,
// decided from the input's own doubles.
//
// Everything is a number of a vertex x, of an edge's two ends, or of a plane (Plane::exact_normal,
// Plane::point), all taken as they are:
//   ray of x              point light: x - L. Directional light d, its largest component d_z: (x
//                         d_z - z d_x, y d_z - z d_y, d_z) sgn d_z
//   line of an edge a, b  the covector ray(a) x ray(b), but for a positive factor
//   plane                 q = numerator / denominator; point light: m / m.(p - L); directional:
//                         (m_x, m_y, -m.p) / m.d
//   line of a crossing    q_P - q_Q, but for a positive factor
//   corner of two lines   their cross product; the corners of a cone run round it one way, which
//                         decides between it and its opposite
//
// Laws (tests/predicates_test.cpp has one test for each):
//   1. side(l, x) is the sign of the real number: for an edge, of the volume that the light, its
//     two ends and x span, as the light space's
//      frame shows it, or its mirror image.
//   2. side is 0 at either end of an edge, and at every corner that the line itself cuts.
//   3. Turning an edge round changes the sign and nothing else.
//   4. nearer(p, q, x) = -nearer(q, p, x), and 0 for one plane twice.
//   5. Multiplying all coordinates by a power of two changes no sign; nor does moving all of them,
//     where the sums are exact.
//   6. All that holds at any magnitude, as long as the input is finite.
//   7. point() is within one ulp of the exact corner in each coordinate.
#pragma once

#include <cmath>
#include <shadowcut/shadows.hpp>

#include "light_space/light_space.hpp"

namespace shadowcut {

// A corner of a cone.
struct ExactCorner {
  const Vec3* vertex;  // whose ray it is, or its opposite; or null, and then
  bool opposite;
  const LightLine *in, *out;       // the lines of the edges that come to it and leave it,
  bool in_negative, out_negative;  // whose insides are where they are negative
};

class ExactPredicates {
 public:
  ExactPredicates(const Light& light, const LightSpace& space);

  // All positions and normals, before they are asked about. Not thread-safe; everything else is.
  void note_position(const Vec3& x) { note(x, unit_); }
  void note_normal(const Vec3& m) { note(m, 1); }
  void note_object(const Scene& scene, const Object& object);

  int side(const LightLine& line, const ExactCorner& corner) const;
  // Along the corner's ray, plane p is met nearer to the light than q (1), farther (-1), or at the
  // same point (0).
  int nearer(const Plane& p, const Plane& q, const ExactCorner& corner) const;
  // The plane's front faces the light (1), its back (-1), or it contains the light (0).
  int orientation(const Plane& p) const;
  // The ray of x meets the plane (1), its continuation behind the light does (-1), or neither (0).
  int ahead(const Plane& p, const Vec3& x) const;
  bool is_null(const LightLine& line) const;  // an edge seen end on
  bool contains(const Plane& p, const Vec3& x) const;
  // Of length one within a few roundings, in the frame of the light space.
  VertexRay ray(const ExactCorner& corner) const;
  // Where the corner's ray meets the plane.
  Vec3 point(const Plane& plane, const ExactCorner& corner) const;

 private:
  template <class N>
  struct Space;
  template <class Question>
  auto ask(bool crossing, const Question& question) const;
  template <class Question>
  int sign_of(bool crossing, const Question& question) const;
  bool is_tame(bool crossing) const;
  void note(const Vec3& v, double unit);

  bool point_;
  Vec3 light_;
  LightSpace::Frame frame_;
  int axis_[3];
  int handed_ = 1;                            // whether the light space's frame keeps orientation
  double unit_ = 1;                           // makes coordinates about one
  double smallest_ = INFINITY, largest_ = 0;  // of all numbers, but zeros
};

}  // namespace shadowcut
