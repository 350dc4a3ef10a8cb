// A convex cone of rays: a face, or a piece of one, as the light sees it.
//
// Corners in order, so that every edge's line is positive inside; edge i runs from corner i to corner i+1, and corner i is (a positive multiple
// of) line[i-1] x line[i]. Corners are kept as separate x, y, z arrays for testing four at a time.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <vector>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "light_space.hpp"

namespace shadowcut {

// A line as the edge of a cone: which line, which side of it is inside, and whether something above in the tree already bounds the cell there.
struct EdgeRef {
  std::uint32_t bits;

  EdgeRef() = default;
  EdgeRef(std::uint32_t line, bool negative) : bits((line << 2) | (negative ? 2u : 0u)) {}
  std::uint32_t line() const { return bits >> 2; }
  bool negative() const { return bits & 2; }  // inside is where n.r < 0
  bool bounded() const { return bits & 1; }
  void set_bounded() { bits |= 1; }
  EdgeRef without_bounded() const { return EdgeRef(line(), negative()); }
};
static_assert(sizeof(EdgeRef) == 4);

struct Cone {
  std::uint32_t count, capacity;  // capacity: a multiple of 4; the lanes behind `count` repeat corner 0
  float error;                    // absolute, of every corner's ray
  std::uint32_t facet;
  std::uint32_t at;               // free for who holds the cone
  Cone* next_free;
  double *x, *y, *z;
  EdgeRef* edge;
  std::uint32_t* vertex;  // index into Scene::vertices() when the corner is that vertex, else none

  // The cone is full when count == capacity.
  void push(double rx, double ry, double rz, EdgeRef e, std::uint32_t v) {
    x[count] = rx, y[count] = ry, z[count] = rz, edge[count] = e, vertex[count] = v;
    ++count;
  }
  void push_run(const Cone& from, std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t i = begin; i < end; ++i) push(from.x[i], from.y[i], from.z[i], from.edge[i], from.vertex[i]);
  }
  void pad() {
    for (std::uint32_t i = count; i & 3; ++i) x[i] = x[0], y[i] = y[0], z[i] = z[0];
  }
};

// Cones are taken and given back; each size class (8, 16, 32, ... corners) has a list of free ones. Not thread-safe: one pool a thread.
class ConePool {
 public:
  ConePool() = default;
  ConePool(const ConePool&) = delete;
  ConePool& operator=(const ConePool&) = delete;
  ~ConePool() {
    for (void* block : blocks_) ::operator delete(block, std::align_val_t{64});
  }

  Cone* take(std::uint32_t corners) {
    const std::uint32_t capacity = corners <= 8 ? 8 : std::bit_ceil(corners);
    const auto size_class = static_cast<std::size_t>(std::countr_zero(capacity)) - 3;
    if (size_class >= free_.size()) free_.resize(size_class + 1, nullptr);
    Cone* cone = free_[size_class];
    if (cone) {
      free_[size_class] = cone->next_free;
    } else {
      cone = make(capacity);
    }
    cone->count = 0;
    return cone;
  }
  void give_back(Cone* cone) {
    Cone*& head = free_[static_cast<std::size_t>(std::countr_zero(cone->capacity)) - 3];
    cone->next_free = head;
    head = cone;
  }

 private:
  Cone* make(std::uint32_t capacity) {
    const std::size_t head = (sizeof(Cone) + 63) & ~std::size_t{63};
    const std::size_t bytes = head + capacity * (3 * sizeof(double) + sizeof(EdgeRef) + sizeof(std::uint32_t));
    blocks_.reserve(blocks_.size() + 1);
    void* block = ::operator new(bytes, std::align_val_t{64});
    blocks_.push_back(block);
    Cone* cone = new (block) Cone;
    char* data = static_cast<char*>(block) + head;
    cone->capacity = capacity;
    cone->x = reinterpret_cast<double*>(data);
    cone->y = cone->x + capacity;
    cone->z = cone->y + capacity;
    cone->edge = reinterpret_cast<EdgeRef*>(cone->z + capacity);
    cone->vertex = reinterpret_cast<std::uint32_t*>(cone->edge + capacity);
    return cone;
  }

  std::vector<Cone*> free_;
  std::vector<void*> blocks_;
};

// Where the corners of a cone change from one side of a line to the other.
struct Change {
  std::uint32_t corner;  // the last one before the edge that crosses the line, or the corner on the line
  bool on;
};

// On which sides of a covector a cone's corners lie: certainly positive, certainly negative, or "on", which means that the sign is not certain.
class Signs {
 public:
  // Tests all corners against n. bound: |n.r| up to which a sign is not certain.
  void test(const Cone& c, const double n[3], double bound) {
    count_ = c.count;
    if (count_ > 64) return test_large(c, n, bound);
    positive_ = negative_ = 0;
#if defined(__SSE2__)
    const __m128d nx = _mm_set1_pd(n[0]), ny = _mm_set1_pd(n[1]), nz = _mm_set1_pd(n[2]), hi = _mm_set1_pd(bound), lo = _mm_set1_pd(-bound);
    const auto four = [&](std::uint32_t i) {
      const __m128d s = _mm_add_pd(_mm_add_pd(_mm_mul_pd(nx, _mm_load_pd(c.x + i)), _mm_mul_pd(ny, _mm_load_pd(c.y + i))), _mm_mul_pd(nz, _mm_load_pd(c.z + i)));
      const __m128d t =
          _mm_add_pd(_mm_add_pd(_mm_mul_pd(nx, _mm_load_pd(c.x + i + 2)), _mm_mul_pd(ny, _mm_load_pd(c.y + i + 2))), _mm_mul_pd(nz, _mm_load_pd(c.z + i + 2)));
      const auto p = static_cast<unsigned>(_mm_movemask_pd(_mm_cmpgt_pd(s, hi)) | _mm_movemask_pd(_mm_cmpgt_pd(t, hi)) << 2);
      const auto m = static_cast<unsigned>(_mm_movemask_pd(_mm_cmplt_pd(s, lo)) | _mm_movemask_pd(_mm_cmplt_pd(t, lo)) << 2);
      positive_ |= std::uint64_t{p} << i, negative_ |= std::uint64_t{m} << i;
    };
    for (std::uint32_t i = 0; i < count_; i += 4) four(i);
    const std::uint64_t real = ~std::uint64_t{0} >> (64 - count_);  // not the lanes that repeat corner 0
    positive_ &= real, negative_ &= real;
#else
    for (std::uint32_t i = 0; i < count_; ++i) {
      const double s = n[0] * c.x[i] + n[1] * c.y[i] + n[2] * c.z[i];
      positive_ |= std::uint64_t{s > bound} << i, negative_ |= std::uint64_t{s < -bound} << i;
    }
#endif
  }

  bool positive() const { return positive_ != 0; }
  bool negative() const { return negative_ != 0; }
  std::uint32_t on() const {  // how many are
    if (count_ > 64) return static_cast<std::uint32_t>(std::count(large_.begin(), large_.end(), 0));
    std::uint64_t rest = (positive_ | negative_) ^ (~std::uint64_t{0} >> (64 - count_));
    std::uint32_t n = 0;
    for (; rest != 0; rest &= rest - 1) ++n;  // mostly none
    return n;
  }
  int operator[](std::uint32_t i) const {
    if (count_ > 64) return large_[i];
    return static_cast<int>(positive_ >> i & 1) - static_cast<int>(negative_ >> i & 1);
  }
  // With corners on both sides: where the sign goes down, and where it goes up again.
  void changes(Change& down, Change& up) const {
    const std::uint64_t all = ~std::uint64_t{0} >> ((64 - count_) & 63);
    if (count_ <= 64 && (positive_ | negative_) == all) {
      const auto behind = [&](std::uint64_t m) { return (m >> 1 | m << (count_ - 1)) & all; };  // bit i: corner i+1's
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
      if ((*this)[k] != here) (here > 0 ? down : up) = (*this)[j] == 0 ? Change{j, true} : Change{i, false};
    }
  }

 private:
  void test_large(const Cone& c, const double n[3], double bound) {
    large_.resize(c.count);
    positive_ = negative_ = 0;
    for (std::uint32_t i = 0; i < c.count; ++i) {
      const double s = n[0] * c.x[i] + n[1] * c.y[i] + n[2] * c.z[i];
      large_[i] = static_cast<std::int8_t>(s > bound ? 1 : s < -bound ? -1 : 0);
      positive_ |= s > bound, negative_ |= s < -bound;
    }
  }

  std::uint32_t count_ = 0;
  std::uint64_t positive_ = 0, negative_ = 0;  // up to 64 corners: a bit each; beyond: whether any
  std::vector<std::int8_t> large_;
};

// Marks the edges both of whose ends are on the line of a node: the cell ends there, so they need no node of their own.
inline void mark_on_edges(Cone& c, const Signs& signs) {
  for (std::uint32_t i = 0; i < c.count; ++i) {
    if (signs[i] == 0 && signs[i + 1 == c.count ? 0 : i + 1] == 0) c.edge[i].set_bounded();
  }
}

// Cuts a cone that has corners on both sides of a line. The corners between which the sign changes for certain get a new corner; a corner that is on the
// line serves as it is. m is the line, m_error its error, `cut` its id; `lines(id)` gives the line
// of an edge.
// `bounded`: whether a node of the tree stands on the cut.
template <class Lines>
void split(const Cone& c, const Signs& signs, const double m[3], float m_error, std::uint32_t cut, bool bounded, const Lines& lines, ConePool& pool,
           Cone*& positive, Cone*& negative) {
  const std::uint32_t n = c.count;
  const auto next = [n](std::uint32_t i) { return i + 1 == n ? 0 : i + 1; };
  // The two changes of sign, downward and upward, each by the last corner certainly on the old side; or, with corners on the line
  // between, by the first of those.
  Change down{}, up{};
  signs.changes(down, up);

  struct Point {
    double x, y, z;
    float error;
    std::uint32_t vertex;
  };
  // Where the edge leaving corner i meets the line; the edge is followed by the cut on its positive side when it goes down, and follows it
  // when it comes up. The product changes sign, and nothing else, with the order: both sides of a cut get the same numbers.
  const auto point = [&](const Change& change, bool downward) -> Point {
    const std::uint32_t i = change.corner;
    if (change.on) return {c.x[i], c.y[i], c.z[i], c.error, c.vertex[i]};
    const EdgeRef e = c.edge[i];
    const Line& l = lines(e.line());
    const double s = e.negative() == downward ? -1.0 : 1.0;
    return {s * (l.n[1] * m[2] - l.n[2] * m[1]), s * (l.n[2] * m[0] - l.n[0] * m[2]), s * (l.n[0] * m[1] - l.n[1] * m[0]),
            l.error + m_error + static_cast<float>(corner_slack), none};
  };
  const Point p_down = point(down, true), p_up = point(up, false);

  // From one change to the other; the corners between lie in one run, or in two where it passes corner 0.
  const auto build = [&](const Change& from, const Point& p_from, const Change& to, const Point& p_to, EdgeRef closing) {
    Cone* out = pool.take(n + 2);
    out->facet = c.facet;
    out->push(p_from.x, p_from.y, p_from.z, c.edge[from.corner], p_from.vertex);
    const std::uint32_t first = next(from.corner), last = to.on ? to.corner : next(to.corner);
    if (last < first) {
      out->push_run(c, first, n);
      out->push_run(c, 0, last);
    } else {
      out->push_run(c, first, last);
    }
    out->push(p_to.x, p_to.y, p_to.z, closing, p_to.vertex);
    out->error = std::max(c.error, std::max(p_from.error, p_to.error));
    out->pad();
    return out;
  };
  EdgeRef inside(cut, false), outside(cut, true);
  if (bounded) inside.set_bounded(), outside.set_bounded();
  positive = build(up, p_up, down, p_down, inside);
  negative = build(down, p_down, up, p_up, outside);
}

// Sends a cone to its side of a node's line: 0 positive, 1 negative. A cone on both sides is cut: it becomes its positive part and goes to 0, and
// cut_off is its negative part, otherwise null. A cone that lies on the line altogether (a sliver that rounding made) goes to the positive side.
template <class Lines>
std::uint32_t sift(Cone*& cone, const double m[3], float m_error, std::uint32_t line, const Lines& lines, ConePool& pool, Signs& signs, Cone*& cut_off) {
  cut_off = nullptr;
  signs.test(*cone, m, static_cast<double>(m_error) + static_cast<double>(cone->error) + sign_slack);
  if (signs.positive() && signs.negative()) {
    Cone* positive;
    split(*cone, signs, m, m_error, line, true, lines, pool, positive, cut_off);
    pool.give_back(cone);
    cone = positive;
    return 0;
  }
  if (signs.on() > 1) mark_on_edges(*cone, signs);
  return signs.negative() ? 1 : 0;
}

}  // namespace shadowcut
