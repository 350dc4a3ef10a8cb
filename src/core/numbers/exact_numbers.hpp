// Number types for the signs and roundings that plain doubles leave open. The formulas of
// predicates/exact_predicates.cpp are templates over the type:
//
//   Tracked    a sum of two doubles with a bound on its error: for corners, which need some bits
//              more than a double has
//   Expansion  a sum of doubles, exact as long as no part leaves the range of double: for signs.
//              Short numbers cost little
//   Wide       an integer times a power of two: exact for all exponents
//
// Sources: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates", 1997 (sums and products of expansions). Everything here needs round-to-even and
// unfused operations.
#pragma once

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdint>

#include "numbers/error_free.hpp"

namespace shadowcut {

// Parts that do not overlap, the smallest first, without zeros.
class Expansion {
 public:
  Expansion() = default;
  explicit Expansion(double x) {
    if (x != 0) parts_.push_back(x);
  }
  static Expansion difference(double a, double b) {
    Expansion e;
    e.push(two_sum(a, -b));
    return e;
  }

  int sign() const { return parts_.empty() ? 0 : parts_.back() > 0 ? 1 : -1; }
  // The number, to some hundred bits.
  TwoDoubles leading() const {
    TwoDoubles sum{0, 0};
    for (const double part : parts_) {
      const TwoDoubles s = two_sum(part, sum.high);
      sum = fast_two_sum(s.high, s.low + sum.low);
    }
    return sum;
  }

  friend Expansion operator+(const Expansion& a, const Expansion& b) {
    if (a.parts_.empty()) return b;
    if (b.parts_.empty()) return a;
    Expansion out;
    out.parts_.reserve(a.parts_.size() + b.parts_.size());
    auto i = a.parts_.begin(), j = b.parts_.begin();
    const auto next = [&] {
      if (j == b.parts_.end() || (i != a.parts_.end() && std::abs(*i) < std::abs(*j))) return *i++;
      return *j++;
    };
    double sum = next();
    while (i != a.parts_.end() || j != b.parts_.end()) {
      const TwoDoubles s = two_sum(sum, next());
      if (s.low != 0) out.parts_.push_back(s.low);
      sum = s.high;
    }
    if (sum != 0) out.parts_.push_back(sum);
    return out;
  }
  friend Expansion operator-(const Expansion& a, const Expansion& b) {
    Expansion minus = b;
    for (double& part : minus.parts_) part = -part;
    return a + minus;
  }
  friend Expansion operator*(const Expansion& a, const Expansion& b) {
    if (a.parts_.size() < b.parts_.size()) return b * a;
    Expansion out;
    for (const double part : b.parts_) out = out + a.times(part);
    if (out.parts_.size() > 8) out.compress();
    return out;
  }

 private:
  void push(const TwoDoubles& t) {
    if (t.low != 0) parts_.push_back(t.low);
    if (t.high != 0) parts_.push_back(t.high);
  }
  Expansion times(double x) const {
    Expansion out;
    out.parts_.reserve(2 * parts_.size());
    double sum = 0;
    for (const double part : parts_) {
      const TwoDoubles p = two_product(part, x);
      const TwoDoubles low = two_sum(sum, p.low);
      if (low.low != 0) out.parts_.push_back(low.low);
      const TwoDoubles high = fast_two_sum(p.high, low.high);
      if (high.low != 0) out.parts_.push_back(high.low);
      sum = high.high;
    }
    if (sum != 0) out.parts_.push_back(sum);
    return out;
  }
  void compress() {
    if (parts_.empty()) return;
    std::size_t bottom = parts_.size() - 1;
    double sum = parts_.back();
    for (std::size_t i = parts_.size() - 1; i-- > 0;) {
      const TwoDoubles s = fast_two_sum(sum, parts_[i]);
      sum = s.high;
      if (s.low == 0) continue;
      parts_[bottom--] = sum;
      sum = s.low;
    }
    parts_[bottom] = sum;
    std::size_t top = 0;
    for (std::size_t i = bottom + 1; i < parts_.size(); ++i) {
      const TwoDoubles s = fast_two_sum(parts_[i], sum);
      sum = s.high;
      if (s.low != 0) parts_[top++] = s.low;
    }
    parts_[top++] = sum;
    parts_.resize(top);
  }

  boost::container::small_vector<double, 10> parts_;
};

// To within 2^-40 ulp of rounding correctly.
inline double quotient(const TwoDoubles& a, const TwoDoubles& b) {
  const double q = a.high / b.high;
  const TwoDoubles p = two_product(q, b.high);
  return q + (((a.high - p.high) - p.low) + (a.low - q * b.low)) / b.high;
}
inline double quotient(const Expansion& a, const Expansion& b) {
  return a.sign() == 0 ? 0.0 : quotient(a.leading(), b.leading());
}

class Wide {
 public:
  Wide() = default;
  explicit Wide(double x) {
    if (x == 0) return;
    int exponent;
    mantissa_ = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
    exponent_ = exponent - 53;
  }
  static Wide difference(double a, double b) { return Wide(a) - Wide(b); }

  int sign() const { return mantissa_.sign(); }

  friend Wide operator+(const Wide& a, const Wide& b) {
    if (a.mantissa_.is_zero()) return b;
    if (b.mantissa_.is_zero()) return a;
    if (a.exponent_ < b.exponent_) return b + a;
    Wide out;
    out.mantissa_ =
        (a.mantissa_ << static_cast<std::size_t>(a.exponent_ - b.exponent_)) + b.mantissa_;
    out.exponent_ = b.exponent_;
    return out;
  }
  friend Wide operator-(const Wide& a, const Wide& b) {
    Wide minus = b;
    minus.mantissa_.backend().negate();
    return a + minus;
  }
  friend Wide operator*(const Wide& a, const Wide& b) {
    Wide out;
    out.mantissa_ = a.mantissa_ * b.mantissa_;
    out.exponent_ = a.exponent_ + b.exponent_;
    return out;
  }
  // To within 2^-10 ulp of rounding correctly; of a subnormal number, within an ulp. Computed
  // without signs: Boost 1.74 may lose the sign of a negative number of several limbs when the
  // number is shifted down.
  friend double quotient(const Wide& a, const Wide& b) {
    if (a.mantissa_.is_zero()) return 0;
    using boost::multiprecision::cpp_int;
    const cpp_int above = abs(a.mantissa_), below = abs(b.mantissa_);
    const auto bits = [](const cpp_int& m) { return static_cast<std::int64_t>(msb(m)); };
    const std::int64_t shift = std::max<std::int64_t>(0, 66 - bits(above) + bits(below));
    cpp_int q = (above << static_cast<std::size_t>(shift)) / below;
    std::int64_t exponent = a.exponent_ - b.exponent_ - shift;
    if (const std::int64_t more = bits(q) - 62; more > 0) {
      q >>= static_cast<std::size_t>(more);
      exponent += more;
    }
    const double size =
        std::ldexp(static_cast<double>(static_cast<std::int64_t>(q)),
                   static_cast<int>(std::clamp<std::int64_t>(exponent, -4000, 4000)));
    return a.sign() == b.sign() ? size : -size;
  }

 private:
  boost::multiprecision::cpp_int mantissa_;
  std::int64_t exponent_ = 0;
};

// Each operation loses less than 2^-100 of its result (Dekker's sums and products of two doubles
// lose some 2^-104), and nothing if its operands are single doubles. It adds the error bounds of
// its operands. Bounds grow a little at every step to pay for their own rounding.
class Tracked {
 public:
  Tracked() = default;
  explicit Tracked(double x) : value_{x, 0}, error_(0) {}
  static Tracked difference(double a, double b) { return Tracked(two_sum(a, -b), 0); }
  static Tracked unknown() { return Tracked({0, 0}, INFINITY); }

  double error() const { return error_; }
  TwoDoubles leading() const { return value_; }
  int sign() const { return value_.high > 0 ? 1 : value_.high < 0 ? -1 : 0; }
  bool is_sure() const { return std::abs(value_.high) > 2 * error_ || error_ == 0; }  // of the sign

  friend Tracked operator+(const Tracked& a, const Tracked& b) {
    const TwoDoubles s = two_sum(a.value_.high, b.value_.high);
    if (a.value_.low == 0 && b.value_.low == 0) return Tracked(s, more(a.error_ + b.error_));
    const TwoDoubles t = two_sum(a.value_.low, b.value_.low);
    const TwoDoubles first = fast_two_sum(s.high, s.low + t.high);
    return rounded(fast_two_sum(first.high, first.low + t.low), a.error_ + b.error_);
  }
  friend Tracked operator-(const Tracked& a, const Tracked& b) {
    return a + Tracked({-b.value_.high, -b.value_.low}, b.error_);
  }
  friend Tracked operator*(const Tracked& a, const Tracked& b) {
    const TwoDoubles p = two_product(a.value_.high, b.value_.high);
    const double error = std::abs(a.value_.high) * b.error_ + std::abs(b.value_.high) * a.error_ +
                         2 * a.error_ * b.error_;
    if (a.value_.low == 0 && b.value_.low == 0) return Tracked(p, more(error));
    const double low = p.low + (a.value_.high * b.value_.low + a.value_.low * b.value_.high);
    return rounded(fast_two_sum(p.high, low), error);
  }

 private:
  Tracked(const TwoDoubles& value, double error) : value_(value), error_(error) {}
  static Tracked rounded(const TwoDoubles& value, double error) {
    return Tracked(value, more(error) + std::abs(value.high) * 0x1p-99);
  }
  static double more(double error) { return error * (1 + 0x1p-40); }

  TwoDoubles value_{0, 0};
  double error_ = 0;
};

}  // namespace shadowcut
