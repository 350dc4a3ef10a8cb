// On which sides of a line, or of another plane, the corners of a cone are.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "predicates/cell_predicates.hpp"
#include "predicates/cone.hpp"

namespace shadowcut {

// Where the corners of a cone change from one side of a line to the other.
struct SideChange {
  std::uint32_t corner;  // the last one before the edge that crosses the line, or the corner on it
  bool on;               // the corner is on the line
};

// For every corner of a cone the sign of a covector n: positive, negative, or "on". On means that
// the floating-point filter leaves the sign open, or, after decide(), that the sign is zero.
class CornerSides {
 public:
  // Tests all corners of c against n. `bound`: |n.r| up to which a sign is open. `spill` holds the
  // signs of more than 64 corners, and must outlive this. Writes behind the last corner of c.
  CornerSides(Cone& c, const double n[3], double bound, std::vector<std::int8_t>& spill)
      : count_(c.count) {
    SHADOWCUT_ASSERT(c.count >= 1 && c.count < c.capacity && bound >= 0);
    if (count_ > 64) {
      test_large(c, n, bound, spill);
      return;
    }
    ConeCorner* k = c.corners();
#if defined(__SSE2__)
    k[count_] = k[0];  // an odd corner is tested together with this copy; capacity is even
    const __m128d xy = _mm_loadu_pd(n), z = _mm_set1_pd(n[2]), hi = _mm_set1_pd(bound),
                  lo = _mm_set1_pd(-bound);
    for (std::uint32_t i = 0; i < count_; i += 2) {
      const __m128d a = _mm_mul_pd(xy, _mm_loadu_pd(k[i].r)),
                    b = _mm_mul_pd(xy, _mm_loadu_pd(k[i + 1].r));
      const __m128d zs = _mm_mul_pd(z, _mm_loadh_pd(_mm_load_sd(k[i].r + 2), k[i + 1].r + 2));
      const __m128d s = _mm_add_pd(_mm_add_pd(_mm_unpacklo_pd(a, b), _mm_unpackhi_pd(a, b)), zs);
      positive_ |= static_cast<std::uint64_t>(_mm_movemask_pd(_mm_cmpgt_pd(s, hi))) << i;
      negative_ |= static_cast<std::uint64_t>(_mm_movemask_pd(_mm_cmplt_pd(s, lo))) << i;
    }
    positive_ &= all(), negative_ &= all();
#else
    for (std::uint32_t i = 0; i < count_; ++i) {
      const double s = dot(n, k[i].r);
      positive_ |= std::uint64_t{s > bound} << i, negative_ |= std::uint64_t{s < -bound} << i;
    }
#endif
  }

  bool positive() const { return positive_ != 0; }
  bool negative() const { return negative_ != 0; }
  bool any_on() const { return large_ ? count_on() != 0 : (positive_ | negative_) != all(); }
  std::uint32_t count_on() const {
    if (large_) return static_cast<std::uint32_t>(std::count(large_, large_ + count_, 0));
    std::uint32_t n = 0;
    for (std::uint64_t rest = (positive_ | negative_) ^ all(); rest != 0; rest &= rest - 1) ++n;
    return n;
  }
  int operator[](std::uint32_t i) const {
    SHADOWCUT_ASSERT(i < count_);
    if (large_) return large_[i];
    return static_cast<int>(positive_ >> i & 1) - static_cast<int>(negative_ >> i & 1);
  }

  // Replaces every open sign, of corner i, by sign(i).
  template <class Sign>
  void decide(const Sign& sign) {
    for (std::uint32_t i = 0; i < count_; ++i) {
      if ((*this)[i] != 0) continue;
      const int s = sign(i);
      SHADOWCUT_ASSERT(s >= -1 && s <= 1);
      if (large_) {
        large_[i] = static_cast<std::int8_t>(s);
        positive_ |= s > 0, negative_ |= s < 0;
      } else {
        positive_ |= std::uint64_t{s > 0} << i, negative_ |= std::uint64_t{s < 0} << i;
      }
    }
  }

  // Calls f(i) for every edge i both of whose ends are on.
  template <class F>
  void for_each_on_edge(const F& f) const {
    if (large_) {
      for (std::uint32_t i = 0; i < count_; ++i) {
        if (large_[i] == 0 && large_[i + 1 == count_ ? 0 : i + 1] == 0) f(i);
      }
      return;
    }
    const std::uint64_t on = (positive_ | negative_) ^ all();
    for (std::uint64_t both = on & (on >> 1 | (on & 1) << (count_ - 1)); both != 0;
         both &= both - 1)
      f(static_cast<std::uint32_t>(std::countr_zero(both)));
  }

  // With corners on both sides: where the sign goes from positive to negative, and back.
  void changes(SideChange& down, SideChange& up) const {
    SHADOWCUT_ASSERT(positive() && negative());
    if (!large_ && (positive_ | negative_) == all()) {
      // bit i: corner i+1's
      const auto behind = [&](std::uint64_t m) { return (m >> 1 | m << (count_ - 1)) & all(); };
      down = {static_cast<std::uint32_t>(std::countr_zero(positive_ & behind(negative_))), false};
      up = {static_cast<std::uint32_t>(std::countr_zero(negative_ & behind(positive_))), false};
      return;
    }
    const auto next = [this](std::uint32_t i) { return i + 1 == count_ ? 0 : i + 1; };
    for (std::uint32_t i = 0; i < count_; ++i) {
      const int here = (*this)[i];
      if (here == 0) continue;
      const std::uint32_t j = next(i);
      std::uint32_t k = j;
      while ((*this)[k] == 0) k = next(k);
      if ((*this)[k] != here)
        (here > 0 ? down : up) = (*this)[j] == 0 ? SideChange{j, true} : SideChange{i, false};
    }
  }

 private:
  std::uint64_t all() const { return ~std::uint64_t{0} >> (64 - count_); }

  void test_large(const Cone& c, const double n[3], double bound, std::vector<std::int8_t>& spill) {
    spill.resize(count_);
    large_ = spill.data();
    for (std::uint32_t i = 0; i < count_; ++i) {
      const double s = dot(n, c.corners()[i].r);
      spill[i] = static_cast<std::int8_t>(s > bound ? 1 : s < -bound ? -1 : 0);
      positive_ |= s > bound, negative_ |= s < -bound;
    }
  }

  std::uint32_t count_;
  std::uint64_t positive_ = 0, negative_ = 0;  // up to 64 corners: a bit each; beyond: whether any
  std::int8_t* large_ = nullptr;               // beyond 64 corners: each
};

// A line that divides light space: an SP-node's, or a dividing line of the k-d tree.
struct DividingLine {
  const double* n;
  float error;
  LineId id;
  // |n.r| up to which a sign of the cone's corners is open.
  double bound(const Cone& cone) const {
    return static_cast<double>(error) + static_cast<double>(cone.error) + sign_slack;
  }
};

// The sides of a dividing line on which the corners of a cone are; decided exactly in the exact
// kernel.
inline CornerSides sides_of_line(Cone& cone, const DividingLine& line,
                                 const CellPredicates& predicates, std::vector<std::int8_t>& spill,
                                 SignCounts& counts) {
  CornerSides sides(cone, line.n, line.bound(cone), spill);
  if (sides.any_on()) {
    if (predicates.is_exact()) {
      sides.decide([&](std::uint32_t i) {
        return predicates.side(cone.span(), i, cone.facet, line.id, counts);
      });
    }
    counts.on += sides.count_on();
  }
  return sides;
}

// The plane of one facet against another plane: d.r > 0 for rays along which the facet (`own`) is
// nearer to the light. The planes must be different records.
struct PlaneDifference {
  double d[3];
  double size, error;  // |d|, about; absolute, of d

  PlaneDifference(const PlaneCovector& own, const double q[3], float q_error)
      : d{own.q[0] - q[0], own.q[1] - q[1], own.q[2] - q[2]} {
    size = std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2]);
    SHADOWCUT_ASSERT(own.error >= 0 && q_error >= 0);
    error =
        static_cast<double>(own.error) + static_cast<double>(q_error) + 2 * unit_roundoff * size;
  }
  // |d.r| up to which a sign of the cone's corners is open.
  double bound(const Cone& cone) const {
    return error + size * (static_cast<double>(cone.error) + sign_slack);
  }
  // d.r = 0 as a line: where the two planes cross.
  Line line() const {
    const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    return {{d[0] / length, d[1] / length, d[2] / length},
            std::nextafter(static_cast<float>(error / length + 2 * unit_roundoff), INFINITY),
            invalid_index,
            invalid_index};
  }
};

// The sides of another plane on which the corners of a cone are (positive: nearer to the light);
// decided exactly in the exact kernel. `other`: index of that plane.
inline CornerSides sides_of_plane(Cone& cone, const PlaneDifference& nearer, std::uint32_t other,
                                  const CellPredicates& predicates, std::vector<std::int8_t>& spill,
                                  SignCounts& counts) {
  CornerSides sides(cone, nearer.d, nearer.bound(cone), spill);
  if (predicates.is_exact()) {
    sides.decide([&](std::uint32_t i) {
      return predicates.nearer(cone.span(), i, cone.facet, other, counts);
    });
  }
  counts.on += sides.count_on();
  return sides;
}

}  // namespace shadowcut
