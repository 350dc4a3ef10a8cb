// Exact signs and corners of light space, computed from the input's own doubles.
//
// Rays, lines and planes are functions of a vertex x, of the two ends of an edge, or of a plane
// (Plane::exact_normal m, Plane::point p). These doubles are taken as exact:
//   ray of x              point light L: x - L
//                         directional light d, with largest component d_z:
//                         (x d_z - z d_x, y d_z - z d_y, d_z) sgn d_z
//   line of an edge a, b  the covector ray(a) x ray(b), up to a positive factor
//   plane                 q = numerator / denominator
//                         point light: m / m.(p - L); directional: (m_x, m_y, -m.p) / m.d
//   line of a crossing    q_P - q_Q, up to a positive factor
//   corner of two lines   their cross product; the corners of a cone run round it one way, which
//                         decides between the product and its opposite
//
// Laws (tests/unit/predicates_test.cpp has one test for each):
//   1. side(l, x) is the sign of the real number. For an edge that number is the volume spanned by
//      the light, the two ends and x, as the light space's frame shows it, or its mirror image.
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
  // The vertex whose ray the corner is (or whose opposite ray). Null: the corner is where two lines
  // meet, of the edges that come to the corner (in) and leave it (out).
  const Vec3* vertex;
  bool opposite;
  const LightLine *in, *out;
  bool in_negative, out_negative;  // the inside of the line is where it is negative
};

class ExactPredicates {
 public:
  ExactPredicates(const Light& light, const LightSpace& space);

  // Every position and normal must be noted before a question about it. Not thread-safe; all other
  // members are.
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
  double smallest_ = INFINITY, largest_ = 0;  // of all noted numbers except zeros
};

}  // namespace shadowcut
