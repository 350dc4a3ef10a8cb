// An exact running sum of doubles.
//
// Source: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates", 1997 (grow-expansion).
#pragma once

#include <numeric>
#include <vector>

#include "numbers/error_free.hpp"

namespace shadowcut {

// Exact however many terms are added and subtracted again: kept as doubles that do not overlap.
class ExactSum {
 public:
  void add(double x) {
    std::size_t kept = 0;
    for (double part : parts_) {
      const TwoDoubles s = two_sum(x, part);
      if (s.low != 0) parts_[kept++] = s.low;
      x = s.high;
    }
    parts_.resize(kept);
    if (x != 0) parts_.push_back(x);
  }
  double value() const { return std::accumulate(parts_.begin(), parts_.end(), 0.0); }

 private:
  std::vector<double> parts_;  // smallest first
};

}  // namespace shadowcut
