// A convex cone of rays: a face, or a piece of one, as the light sees it.
//
// Corners in order, so that every edge's line is positive inside; edge i runs from corner i to corner i+1, and corner i is (a positive multiple
// of) line[i-1] x line[i]. Corners are kept as separate x, y, z arrays for testing four at a time.
#pragma once

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

// On which sides of a covector a cone's corners lie. "On" means: the sign is not certain.
struct Sides3 {
  bool positive, negative, on;
};

// The signs of the corners of the cone at hand, +1, -1 or 0 (on). Kept between calls for its memory.
using Signs = std::vector<std::int8_t>;

// Tests all corners against n. bound: |n.r| up to which a sign is not certain.
inline Sides3 classify(const Cone& c, const double n[3], double bound) {
#if defined(__SSE2__)
  const __m128d nx = _mm_set1_pd(n[0]), ny = _mm_set1_pd(n[1]), nz = _mm_set1_pd(n[2]), hi = _mm_set1_pd(bound), lo = _mm_set1_pd(-bound);
  int positive = 0, negative = 0, certain = 3;
  for (std::uint32_t i = 0; i < c.count; i += 2) {
    const __m128d s = _mm_add_pd(_mm_add_pd(_mm_mul_pd(nx, _mm_load_pd(c.x + i)), _mm_mul_pd(ny, _mm_load_pd(c.y + i))),
                                 _mm_mul_pd(nz, _mm_load_pd(c.z + i)));
    const int p = _mm_movemask_pd(_mm_cmpgt_pd(s, hi)), m = _mm_movemask_pd(_mm_cmplt_pd(s, lo));
    positive |= p, negative |= m, certain &= p | m;
  }
  return {positive != 0, negative != 0, certain != 3};
#else
  Sides3 out{false, false, false};
  for (std::uint32_t i = 0; i < c.count; ++i) {
    const double s = n[0] * c.x[i] + n[1] * c.y[i] + n[2] * c.z[i];
    const bool p = s > bound, m = s < -bound;
    out.positive |= p, out.negative |= m, out.on |= !(p | m);
  }
  return out;
#endif
}

inline void signs_of(const Cone& c, const double n[3], double bound, Signs& signs) {
  signs.resize(c.count);
  for (std::uint32_t i = 0; i < c.count; ++i) {
    const double s = n[0] * c.x[i] + n[1] * c.y[i] + n[2] * c.z[i];
    signs[i] = static_cast<std::int8_t>(s > bound ? 1 : s < -bound ? -1 : 0);
  }
}

// Marks the edges both of whose ends are on the line of a node: the cell ends there, so they need no node of their own.
inline void mark_on_edges(Cone& c, const Signs& signs) {
  for (std::uint32_t i = 0; i < c.count; ++i) {
    if (signs[i] == 0 && signs[i + 1 == c.count ? 0 : i + 1] == 0) c.edge[i].set_bounded();
  }
}

// Cuts a cone that has corners on both sides of a line. The corners between which the sign changes for certain get a new corner; a corner that is on the
// line serves as it is. `cut` is the line's id; `lines(id)` gives the line of an edge.
// `bounded`: whether a node of the tree stands on the cut.
template <class Lines>
void split(const Cone& c, const Signs& signs, const Line& line, std::uint32_t cut, bool bounded, const Lines& lines, ConePool& pool, Cone*& positive,
           Cone*& negative) {
  const std::uint32_t n = c.count;
  const auto next = [n](std::uint32_t i) { return i + 1 == n ? 0 : i + 1; };
  // The two changes of sign, each as (corner before it, corner after it); with corners on the line between, the first of those is the cut.
  struct Change {
    std::uint32_t corner;  // the last one certainly on the old side, or the corner on the line
    bool on;
  } down{}, up{};
  for (std::uint32_t i = 0; i < n; ++i) {
    if (signs[i] == 0) continue;
    const std::uint32_t j = next(i);
    std::uint32_t k = j;
    while (signs[k] == 0) k = next(k);
    if (signs[k] == signs[i]) continue;
    (signs[i] > 0 ? down : up) = signs[j] == 0 ? Change{j, true} : Change{i, false};
  }

  struct Point {
    double x, y, z;
    float error;
    std::uint32_t vertex;
  };
  // Where the edge leaving corner i meets the line; the edge is followed by the cut on its positive side when it goes down, and follows it
  // when it comes up. The product changes sign, and nothing else, with the order: both sides of a cut get the same numbers.
  const auto meet = [&](std::uint32_t i, bool downward) -> Point {
    const EdgeRef e = c.edge[i];
    const Line& l = lines(e.line());
    const double s = e.negative() == downward ? -1.0 : 1.0;
    return {s * (l.n[1] * line.n[2] - l.n[2] * line.n[1]), s * (l.n[2] * line.n[0] - l.n[0] * line.n[2]), s * (l.n[0] * line.n[1] - l.n[1] * line.n[0]),
            l.error + line.error + static_cast<float>(corner_slack), none};
  };
  const auto at = [&](const Change& change, bool downward) -> Point {
    if (!change.on) return meet(change.corner, downward);
    const std::uint32_t i = change.corner;
    return {c.x[i], c.y[i], c.z[i], c.error, c.vertex[i]};
  };
  const Point p_down = at(down, true), p_up = at(up, false);

  const auto build = [&](const Change& from, const Point& p_from, const Change& to, const Point& p_to, EdgeRef closing) {
    Cone* out = pool.take(n + 2);
    out->facet = c.facet, out->at = c.at;
    out->push(p_from.x, p_from.y, p_from.z, c.edge[from.corner], p_from.vertex);
    const std::uint32_t last = to.on ? to.corner : next(to.corner);
    for (std::uint32_t i = next(from.corner); i != last; i = next(i)) out->push(c.x[i], c.y[i], c.z[i], c.edge[i], c.vertex[i]);
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

}  // namespace shadowcut
