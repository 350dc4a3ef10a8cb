// The tree's kind of number. What lies behind the light space, from cone.hpp to light_tree.cpp, is
// compiled twice: with doubles, for the kernels fast and exact, and with floats, for single. The
// code is the same; it stands in a namespace named after its numbers, and light_shadows.hpp is what
// both look like from outside.
//
// Floats: rays, lines and planes are reckoned in double and rounded once, which their bounds know;
// everything after that is float, with the same bounds in units of a float's rounding.
#pragma once

#include <cmath>
#include <limits>

#include "light_space.hpp"

#if defined(SHADOWCUT_SINGLE)
#define SHADOWCUT_NUMBERS single_numbers
#else
#define SHADOWCUT_NUMBERS double_numbers
#endif

namespace shadowcut::SHADOWCUT_NUMBERS {

#if defined(SHADOWCUT_SINGLE)
using Real = float;
#else
using Real = double;
#endif

inline constexpr double roundoff = std::numeric_limits<Real>::epsilon() / 2;
inline constexpr double sign_slack = 4 * roundoff;    // of one dot product of unit vectors
inline constexpr double corner_slack = 3 * roundoff;  // of one cross product of unit vectors

using Line = LineOf<Real>;
using PlaneRay = PlaneRayOf<Real>;
using VertexRay = VertexRayOf<Real>;

// Three numbers of this length rounded: what that adds to their error, as a float that is no less.
inline float rounded_error(float error, double length) {
  if constexpr (sizeof(Real) == sizeof(double)) return error;
  return static_cast<float>((static_cast<double>(error) + roundoff * length) * (1 + 0x1p-20));
}
inline Line rounded(const LineOf<double>& l) {
  return {{static_cast<Real>(l.n[0]), static_cast<Real>(l.n[1]), static_cast<Real>(l.n[2])},
          rounded_error(l.error, 1),
          l.a,
          l.b};
}
inline VertexRay rounded(const VertexRayOf<double>& v) {
  return {{static_cast<Real>(v.r[0]), static_cast<Real>(v.r[1]), static_cast<Real>(v.r[2])},
          rounded_error(v.error, 1)};
}
inline PlaneRay rounded(const PlaneRayOf<double>& p) {
  const double length = std::sqrt(p.q[0] * p.q[0] + p.q[1] * p.q[1] + p.q[2] * p.q[2]);
  return {{static_cast<Real>(p.q[0]), static_cast<Real>(p.q[1]), static_cast<Real>(p.q[2])},
          rounded_error(p.error, length)};
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
