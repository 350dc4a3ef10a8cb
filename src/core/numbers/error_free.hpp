// Error-free transformations: a sum or a product of two doubles as a rounded double and its exact
// rounding error. Exact as long as no number leaves the range of double.
//
// Sources: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates", 1997 (two_sum, two_product); T. J. Dekker, "A Floating-Point Technique for Extending
// the Available Precision", 1971. Round-to-even and unfused operations.
#pragma once

namespace shadowcut {

inline constexpr double unit_roundoff = 0x1p-53;

struct TwoDoubles {
  double high, low;  // |low| is at most half an ulp of high
};

inline TwoDoubles two_sum(double a, double b) {
  const double s = a + b, from_b = s - a;
  return {s, (a - (s - from_b)) + (b - from_b)};
}

inline TwoDoubles fast_two_sum(double a, double b) {  // |a| >= |b|, or a is 0
  const double s = a + b;
  return {s, b - (s - a)};
}

inline TwoDoubles two_product(double a, double b) {
  constexpr double splitter = 0x1p27 + 1;
  const double p = a * b, as = splitter * a, bs = splitter * b;
  const double ah = as - (as - a), bh = bs - (bs - b), al = a - ah, bl = b - bh;
  return {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
}

}  // namespace shadowcut
