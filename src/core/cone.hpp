// A convex cone of rays: a face, or a piece of one, as the light sees it.
//
// Corners in order, so that every edge's line is positive inside; edge i runs from corner i to
// corner i+1, and corner i is (a positive multiple of) line[i-1] x line[i].
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <new>
#include <span>
#include <vector>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "tree_numbers.hpp"
#include "two_doubles.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {

// A line as the edge of a cone: which line, which side of it is inside, and whether something above
// in the tree already bounds the cell there.
class EdgeRef {
 public:
  EdgeRef() = default;
  EdgeRef(std::uint32_t line, bool negative) : bits_((line << 2) | (negative ? 2u : 0u)) {}
  std::uint32_t line() const { return bits_ >> 2; }
  bool negative() const { return bits_ & 2; }  // inside is where n.r < 0
  bool bounded() const { return bits_ & 1; }
  void set_bounded(bool bounded = true) { bits_ = (bits_ & ~1u) | (bounded ? 1u : 0u); }

 private:
  std::uint32_t bits_;
};
static_assert(sizeof(EdgeRef) == 4);

struct ConeCorner {
  Real r[3];
  EdgeRef edge;          // that leaves this corner
  std::uint32_t vertex;  // index into Scene::vertices() when the corner is that vertex, else none
};
static_assert(sizeof(ConeCorner) == 3 * sizeof(Real) + 8);

// The edge that comes to corner i.
inline EdgeRef incoming(std::span<const ConeCorner> cone, std::size_t i) {
  return cone[i == 0 ? cone.size() - 1 : i - 1].edge;
}

struct Cone {
  std::uint32_t count, capacity;  // capacity: even, so that corners can be tested two at a time
  float error;                    // absolute, of every corner's ray
  std::uint32_t facet;
  std::uint32_t at;     // free for who holds the cone
  std::uint32_t entry;  // of the facet in the cell where the cone is (see CellTree)
  Cone* next_free;

  ConeCorner* corners() {
    return reinterpret_cast<ConeCorner*>(reinterpret_cast<char*>(this) + 64);
  }
  const ConeCorner* corners() const {
    return reinterpret_cast<const ConeCorner*>(reinterpret_cast<const char*>(this) + 64);
  }
  std::span<const ConeCorner> span() const { return {corners(), count}; }
  void assign(std::span<const ConeCorner> from) {  // from.size() <= capacity
    count = static_cast<std::uint32_t>(from.size());
    std::memcpy(static_cast<void*>(corners()), from.data(), from.size_bytes());
  }
};
static_assert(sizeof(Cone) <= 64);

// Cones are taken and given back; each size class (8, 16, 32, ... corners) has a list of free ones.
// Not thread-safe: one pool a thread.
class ConePool {
 public:
  ConePool() = default;
  ConePool(const ConePool&) = delete;
  ConePool& operator=(const ConePool&) = delete;
  ~ConePool() {
    for (void* block : blocks_) ::operator delete (block, std::align_val_t{64});
  }

  Cone* take(std::uint32_t corners) {
    if (corners <= 8 && free_[0]) [[likely]] {
      Cone* cone = free_[0];
      free_[0] = cone->next_free;
      return cone;
    }
    const std::uint32_t capacity = corners <= 8 ? 8 : std::bit_ceil(corners);
    Cone*& head = free_[size_class(capacity)];
    if (!head) return make(capacity);
    Cone* cone = head;
    head = cone->next_free;
    return cone;
  }
  void give_back(Cone* cone) {
    Cone*& head = free_[cone->capacity == 8 ? 0 : size_class(cone->capacity)];
    cone->next_free = head;
    head = cone;
  }

 private:
  static std::size_t size_class(std::uint32_t capacity) {
    return static_cast<std::size_t>(std::countr_zero(capacity)) - 3;
  }

  Cone* make(std::uint32_t capacity) {
    blocks_.push_back(nullptr);
    void* block = blocks_.back() =
        ::operator new (64 + capacity * sizeof(ConeCorner), std::align_val_t{64});
    Cone* cone = new (block) Cone;
    cone->capacity = capacity;
    return cone;
  }

  Cone* free_[32] = {};  // by size class: capacities to 2^34
  std::vector<void*> blocks_;
};

// Of signs asked for.
struct SignCounts {
  std::uint64_t on = 0;  // that came out as zero
  // exact kernel: that the numbers left open, and how they were found
  std::uint64_t by_identity = 0, by_exact = 0;
};

// Where the corners of a cone change from one side of a line to the other.
struct Change {
  // the last one before the edge that crosses the line, or the corner on the line
  std::uint32_t corner;
  bool on;
};

// On which sides of a covector a cone's corners lie: certainly positive, certainly negative, or
// "on", which means that the sign is not certain; or, once settle() has been called, that it is
// zero.
class Signs {
 public:
  // Tests all corners of c against n. bound: |n.r| up to which a sign is not certain. `spill` holds
  // the signs of more than 64 corners, and must outlive this.
  Signs(Cone& c, const Real n[3], double bound, std::vector<std::int8_t>& spill) : count_(c.count) {
    if (count_ > 64) {
      test_large(c, n, bound, spill);
      return;
    }
    ConeCorner* k = c.corners();
#if defined(__SSE2__) && !defined(SHADOWCUT_SINGLE)
    k[count_] = k[0];  // an odd one out is tested with this; capacity is even
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
      const Real s = n[0] * k[i].r[0] + n[1] * k[i].r[1] + n[2] * k[i].r[2];
      positive_ |= std::uint64_t{s > bound} << i, negative_ |= std::uint64_t{s < -bound} << i;
    }
#endif
  }

  bool positive() const { return positive_ != 0; }
  bool negative() const { return negative_ != 0; }
  bool any_on() const { return large_ ? on() != 0 : (positive_ | negative_) != all(); }
  std::uint32_t on() const {  // how many are
    if (large_) return static_cast<std::uint32_t>(std::count(large_, large_ + count_, 0));
    std::uint32_t n = 0;
    // mostly none
    for (std::uint64_t rest = (positive_ | negative_) ^ all(); rest != 0; rest &= rest - 1) ++n;
    return n;
  }
  int operator[](std::uint32_t i) const {
    if (large_) return large_[i];
    return static_cast<int>(positive_ >> i & 1) - static_cast<int>(negative_ >> i & 1);
  }

  // Asks sign(i) for every corner i that is on.
  template <class Sign>
  void settle(const Sign& sign) {
    for (std::uint32_t i = 0; i < count_; ++i) {
      if ((*this)[i] != 0) continue;
      const int s = sign(i);
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

  // With corners on both sides: where the sign goes down, and where it goes up again.
  void changes(Change& down, Change& up) const {
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
        (here > 0 ? down : up) = (*this)[j] == 0 ? Change{j, true} : Change{i, false};
    }
  }

 private:
  std::uint64_t all() const { return ~std::uint64_t{0} >> (64 - count_); }

  void test_large(const Cone& c, const Real n[3], double bound, std::vector<std::int8_t>& spill) {
    spill.resize(count_);
    large_ = spill.data();
    for (std::uint32_t i = 0; i < count_; ++i) {
      const Real* r = c.corners()[i].r;
      const Real s = n[0] * r[0] + n[1] * r[1] + n[2] * r[2];
      spill[i] = static_cast<std::int8_t>(s > bound ? 1 : s < -bound ? -1 : 0);
      positive_ |= s > bound, negative_ |= s < -bound;
    }
  }

  std::uint32_t count_;
  std::uint64_t positive_ = 0, negative_ = 0;  // up to 64 corners: a bit each; beyond: whether any
  std::int8_t* large_ = nullptr;               // beyond: each
};

// a*b - c*d with an error of about one rounding of the result: Dekker's products (1971) give what
// the plain ones drop. Swapping the products changes the sign and nothing else.
inline double difference_of_products(double a, double b, double c, double d) {
  const TwoDoubles p = two_product(a, b), q = two_product(c, d);
  return (p.high - q.high) + (p.low - q.low);
}

// The cross product of two unit lines. Where they are nearly parallel the plain product loses the
// digits that say where along them they meet; the corner would then lie beside both, and the areas
// on the two sides of a T-junction would no longer add up.
inline void cross(const Real a[3], const Real b[3], Real out[3]) {
#if defined(SHADOWCUT_SINGLE)
  // products of floats are exact in double
  const auto minor = [](float p, float q, float r, float s) {
    return static_cast<float>(static_cast<double>(p) * static_cast<double>(q) -
                              static_cast<double>(r) * static_cast<double>(s));
  };
  out[0] = minor(a[1], b[2], a[2], b[1]), out[1] = minor(a[2], b[0], a[0], b[2]),
  out[2] = minor(a[0], b[1], a[1], b[0]);
#else
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
  if (out[0] * out[0] + out[1] * out[1] + out[2] * out[2] >= 0x1p-6) return;
  out[0] = difference_of_products(a[1], b[2], a[2], b[1]);
  out[1] = difference_of_products(a[2], b[0], a[0], b[2]);
  out[2] = difference_of_products(a[0], b[1], a[1], b[0]);
#endif
}

// Cuts a cone that has corners on both sides of a line. The corners between which the sign changes
// for certain get a new corner; a corner that is on the line serves as it is. m is the line,
// m_error its error, `cut` its id; `lines(id)` gives the line of an edge. Two lines of edges that
// share a vertex meet in that vertex's ray, and get its numbers: every such corner is the same to
// the bit, whichever of the vertex's edges cut it out. `bounded`: whether a node of the tree stands
// on the cut.
template <class Lines>
void split(const Cone& c, const Signs& signs, const Real m[3], float m_error, std::uint32_t cut,
           bool bounded, const Lines& lines, ConePool& pool, Cone*& positive, Cone*& negative) {
  const std::uint32_t n = c.count;
  const ConeCorner* const k = c.corners();
  const auto next = [n](std::uint32_t i) { return i + 1 == n ? 0 : i + 1; };
  // The two changes of sign, downward and upward, each by the last corner certainly on the old
  // side; or, with corners on the line between, by the first of those.
  Change down{}, up{};
  signs.changes(down, up);

  float error = c.error;
  const std::span<const VertexRay> rays = lines.rays();
  const Line& mine = lines(cut);
  // Below which square of its length a cross product is too short against its own error.
  const double too_short = lines.is_exact()                ? 0x1p-24
                           : sizeof(Real) == sizeof(float) ? 0x1p-16
                                                           : 0x1p-40;
  // Where the edge leaving the corner meets the line, with that edge for its own; the edge is
  // followed by the cut on its positive side when it goes down, and follows it when it comes up.
  // The product changes sign, and nothing else, with the order: both sides of a cut get the same
  // numbers.
  const auto point = [&](const Change& change, bool downward) -> ConeCorner {
    ConeCorner p = k[change.corner];
    if (change.on) return p;
    const Line& l = lines(p.edge.line());
    p.vertex = none;
    if (const std::uint32_t shared = shared_vertex(l, mine); shared != none) {
      // The planes meet in that ray and in its opposite; the crossing lies between the edge's ends.
      const Real *r = rays[shared].r, *from = k[change.corner].r, *to = k[next(change.corner)].r;
      const auto dot = [](const Real* a, const Real* b) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
      };
      const bool opposite =
          lines.is_exact()
              ? lines.ahead(c.facet, shared) < 0
              : dot(r, from) * std::abs(dot(m, to)) + dot(r, to) * std::abs(dot(m, from)) < 0;
      const Real s = opposite ? -1 : 1;
      for (int i = 0; i < 3; ++i) p.r[i] = s * r[i];
      error = std::max(error, rays[shared].error);
      return p;
    }
    const Real s = p.edge.negative() == downward ? -1 : 1;
    cross(l.n, m, p.r);
    if (!(p.r[0] * p.r[0] + p.r[1] * p.r[1] + p.r[2] * p.r[2] >= too_short)) {
      if (lines.is_exact()) {
        const EdgeRef inside(cut, false);
        const VertexRay ray = downward ? lines.ray(p.edge, inside) : lines.ray(inside, p.edge);
        std::copy(ray.r, ray.r + 3, p.r);
        error = std::max(error, ray.error);
        return p;
      }
      // Nearly one line: the product is hardly longer than its own error, and says little. The
      // point between the edge's ends where the line's test vanishes is as good a crossing as there
      // is, lies on both, and is as certain as those ends.
      const Real *from = k[change.corner].r, *to = k[next(change.corner)].r;
      const Real at_from = std::abs(m[0] * from[0] + m[1] * from[1] + m[2] * from[2]),
                 at_to = std::abs(m[0] * to[0] + m[1] * to[1] + m[2] * to[2]);
      for (int i = 0; i < 3; ++i) p.r[i] = (from[i] * at_to + to[i] * at_from) / (at_from + at_to);
      error =
          std::max(error, (c.error + m_error + static_cast<float>(corner_slack)) * (1 + 0x1p-22f));
      return p;
    }
    for (Real& c : p.r) c *= s;
    error =
        std::max(error, (l.error + m_error + static_cast<float>(corner_slack)) * (1 + 0x1p-22f));
    return p;
  };
  const ConeCorner p_down = point(down, true), p_up = point(up, false);

  // From one change to the other; the corners between lie in one run, or in two where it passes
  // corner 0.
  const auto build = [&](const Change& from, const ConeCorner& p_from, const Change& to,
                         const ConeCorner& p_to, EdgeRef closing) {
    Cone* out = pool.take(n + 2);  // at most n + 1 corners, and one more to test in pairs
    ConeCorner* o = out->corners();
    *o++ = p_from;
    const std::uint32_t first = next(from.corner), last = to.on ? to.corner : next(to.corner);
    for (std::uint32_t i = first; i != last; i = next(i)) *o++ = k[i];
    *o = p_to;
    o->edge = closing;
    out->count = static_cast<std::uint32_t>(o + 1 - out->corners());
    out->facet = c.facet;
    out->entry = c.entry;
    out->error = error;
    return out;
  };
  EdgeRef inside(cut, false), outside(cut, true);
  if (bounded) inside.set_bounded(), outside.set_bounded();
  positive = build(up, p_up, down, p_down, inside);
  negative = build(down, p_down, up, p_up, outside);
}

// The plane of one face against another's: d.r > 0 for rays along which `own` is nearer to the
// light. Not for one plane and itself.
struct PlaneDifference {
  Real d[3];
  double size, error;  // |d|, about; absolute, of d

  PlaneDifference(const PlaneRay& own, const Real q[3], float q_error)
      : d{own.q[0] - q[0], own.q[1] - q[1], own.q[2] - q[2]} {
    size = std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2]);
    error = static_cast<double>(own.error) + static_cast<double>(q_error) + 2 * roundoff * size;
  }
  // Up to which |d.r| a sign is not certain.
  double bound(const Cone& cone) const {
    return error + size * (static_cast<double>(cone.error) + sign_slack);
  }
  // d.r = 0 as a line: where the two planes cross.
  Line line() const {
    const Real length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    return {{d[0] / length, d[1] / length, d[2] / length},
            std::nextafter(static_cast<float>(error / length + 2 * roundoff), INFINITY),
            none,
            none};
  }
};

// Whether the inside of an edge and one side of a node's line (0 positive, 1 negative) are the same
// half of light space, up to the errors of both. Two ends on the line do not make it so: those of a
// sliver lie on every line that passes near. Nor do errors so large that the two may part visibly
// elsewhere.
inline bool same_half(EdgeRef edge, const Line& own, const Real m[3], float m_error,
                      std::uint32_t side) {
  constexpr float largest_error = static_cast<float>(512 * roundoff);
  const Real s = edge.negative() == (side == 1) ? 1 : -1;
  const double apart =
      std::abs(own.n[0] - s * m[0]) + std::abs(own.n[1] - s * m[1]) + std::abs(own.n[2] - s * m[2]);
  return own.error <= largest_error &&
         apart <= 4 * (static_cast<double>(own.error) + static_cast<double>(m_error) + sign_slack);
}

// Sends a cone to its side of a node's line: 0 positive, 1 negative. A cone on both sides is cut:
// it becomes its positive part and goes to 0, and cut_off is its negative part, otherwise null. A
// cone that lies on the line altogether (a sliver that rounding made) goes to the positive side.
// bounds(edge): whether the node serves an edge that lies on it as the cell's end there; such an
// edge needs no node of its own.
template <class Lines, class Bounds>
std::uint32_t sift(Cone*& cone, const Real m[3], float m_error, std::uint32_t line,
                   const Lines& lines, const Bounds& bounds, ConePool& pool,
                   std::vector<std::int8_t>& spill, Cone*& cut_off, SignCounts& counts) {
  cut_off = nullptr;
  Signs signs(*cone, m,
              static_cast<double>(m_error) + static_cast<double>(cone->error) + sign_slack, spill);
  if (signs.any_on()) {
    if (lines.is_exact())
      signs.settle(
          [&](std::uint32_t i) { return lines.side(cone->span(), i, cone->facet, line, counts); });
    counts.on += signs.on();
  }
  if (signs.positive() && signs.negative()) {
    Cone* positive;
    split(*cone, signs, m, m_error, line, true, lines, pool, positive, cut_off);
    pool.give_back(cone);
    cone = positive;
    return 0;
  }
  const std::uint32_t side = signs.negative() ? 1 : 0;
  if (signs.any_on()) {
    signs.for_each_on_edge([&](std::uint32_t i) {
      EdgeRef& edge = cone->corners()[i].edge;
      if ((lines.is_exact() || same_half(edge, lines(edge.line()), m, m_error, side)) &&
          bounds(edge))
        edge.set_bounded();
    });
  }
  return side;
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
