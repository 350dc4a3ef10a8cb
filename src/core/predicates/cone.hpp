// A convex cone of rays: a facet, or a piece of a facet, as the light sees it.
//
// Corners are in order, so that every edge's line is positive inside. Edge i runs from corner i to
// corner i+1, and corner i is (a positive multiple of) line[i-1] x line[i].
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <new>
#include <span>
#include <vector>

#include "light_space/light_space.hpp"
#include "support/assert.hpp"
#include "support/index.hpp"

namespace shadowcut {

inline constexpr double sign_slack = 4 * unit_roundoff;    // of a dot product of unit vectors
inline constexpr double corner_slack = 3 * unit_roundoff;  // of a cross product of unit vectors

// Line ids: edges of the scene and planes of the k-d tree are below, a cell's own lines from here.
inline constexpr std::uint32_t first_local_line = 1u << 29;
inline bool is_local(LineId line) { return line.value() >= first_local_line; }

// A line as the edge of a cone: the line's id, which side of the line is inside, and whether a node
// above in the tree already bounds the cell there.
class EdgeRef {
 public:
  EdgeRef() = default;
  EdgeRef(LineId line, bool negative) : bits_((line.value() << 2) | (negative ? 2u : 0u)) {
    SHADOWCUT_ASSERT(line.value() < 1u << 30);
  }
  LineId line() const { return LineId(bits_ >> 2); }
  bool negative() const { return bits_ & 2; }  // inside is where n.r < 0
  bool bounded() const { return bits_ & 1; }
  void set_bounded(bool bounded = true) { bits_ = (bits_ & ~1u) | (bounded ? 1u : 0u); }

 private:
  std::uint32_t bits_;
};
static_assert(sizeof(EdgeRef) == 4);

struct ConeCorner {
  double r[3];
  EdgeRef edge;          // that leaves this corner
  std::uint32_t vertex;  // index into Scene::vertices() when the corner is that vertex, else none
};
static_assert(sizeof(ConeCorner) == 32);

// The edge that comes to corner i.
inline EdgeRef incoming(std::span<const ConeCorner> cone, std::size_t i) {
  SHADOWCUT_ASSERT(i < cone.size());
  return cone[i == 0 ? cone.size() - 1 : i - 1].edge;
}

inline double dot(const double n[3], const double r[3]) {
  return n[0] * r[0] + n[1] * r[1] + n[2] * r[2];
}

// The header of a cone; its corners follow in memory.
struct Cone {
  std::uint32_t count, capacity;  // capacity: even, so that corners can be tested two at a time
  float error;                    // absolute, of every corner's ray
  FacetId facet;
  EntryId entry;  // of the facet in the cell where the cone is (see SvbspTree)
  Cone* next_free;

  ConeCorner* corners() {
    return reinterpret_cast<ConeCorner*>(reinterpret_cast<char*>(this) + 64);
  }
  const ConeCorner* corners() const {
    return reinterpret_cast<const ConeCorner*>(reinterpret_cast<const char*>(this) + 64);
  }
  std::span<const ConeCorner> span() const { return {corners(), count}; }
  std::span<ConeCorner> span() { return {corners(), count}; }
  void assign(std::span<const ConeCorner> from) {
    SHADOWCUT_ASSERT(from.size() <= capacity);
    count = static_cast<std::uint32_t>(from.size());
    std::memcpy(static_cast<void*>(corners()), from.data(), from.size_bytes());
  }
};
static_assert(sizeof(Cone) <= 64);

// Memory for cones, reused by size class (8, 16, 32, ... corners). Not thread-safe: each thread has
// a pool of its own.
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
    SHADOWCUT_ASSERT(cone && cone->capacity >= 8);
    Cone*& head = free_[cone->capacity == 8 ? 0 : size_class(cone->capacity)];
    cone->next_free = head;
    head = cone;
  }
  Cone* copy(const Cone& from) {
    Cone* cone = take(from.count + 1);
    cone->facet = from.facet, cone->error = from.error, cone->entry = from.entry;
    cone->assign(from.span());
    return cone;
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
    SHADOWCUT_ASSERT(capacity % 2 == 0);
    return cone;
  }

  Cone* free_[32] = {};  // by size class: capacities to 2^34
  std::vector<void*> blocks_;
};

}  // namespace shadowcut
