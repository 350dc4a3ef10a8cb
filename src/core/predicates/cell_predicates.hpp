// A cell's view of lines and signs: lines by their ids, and the signs that the floating-point
// filter leaves open, decided exactly (exact kernel).
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "predicates/cone.hpp"
#include "predicates/light_tables.hpp"

namespace shadowcut {

// How signs were found.
struct SignCounts {
  std::uint64_t on = 0;           // signs that came out as zero
  std::uint64_t by_identity = 0;  // exact kernel, of the signs that the filter left open
  std::uint64_t by_exact = 0;     // likewise
};

struct LocalLine {  // of a cell
  Line line;
  std::uint32_t uses;  // by nodes and by stored pieces' edges; none: free
  LightLine exact;     // exact kernel
};

// Corners of fragments in world space, which are needed several times: from both sides of a cut,
// and where cuts meet. Exact kernel.
class PointCache {
 public:
  void clear() { ++generation_; }
  // The point of corner (in, out) in a plane; make() computes it if it is not in the cache.
  template <class Make>
  Vec3 get(std::uint32_t plane, std::uint32_t in, std::uint32_t out, const Make& make) {
    if (in > out) std::swap(in, out);
    SHADOWCUT_ASSERT(in != invalid_index && out != invalid_index);
    if (slots_.empty()) slots_.resize(std::size_t{1} << bits);
    Slot& slot =
        slots_[(in * 0x9E3779B1u ^ out * 0x85EBCA77u ^ plane * 0xC2B2AE3Du) >> (32 - bits)];
    if (slot.generation != generation_ || slot.plane != plane || slot.in != in || slot.out != out)
      slot = {make(), generation_, plane, in, out};
    return slot.point;
  }

 private:
  static constexpr int bits = 9;
  struct Slot {
    Vec3 point;
    std::uint64_t generation = 0;
    std::uint32_t plane = invalid_index, in = invalid_index, out = invalid_index;
  };
  std::vector<Slot> slots_;  // empty until the first get()
  std::uint64_t generation_ = 1;
};

class CellPredicates {
 public:
  CellPredicates(const LightTables& tables, std::span<const LocalLine> local)
      : CellPredicates(tables, local, tables.exact.get()) {}
  // `exact`: null for the filter alone, whatever the light's kernel.
  CellPredicates(const LightTables& tables, std::span<const LocalLine> local,
                 const ExactPredicates* exact)
      : tables_(tables), local_(local), exact_(exact) {}

  const Line& line(LineId id) const {
    SHADOWCUT_ASSERT(!is_local(id) || id.value() - first_local_line < local_.size());
    return is_local(id) ? local_[id.value() - first_local_line].line : tables_.lines[id];
  }
  std::span<const VertexRay> rays() const { return tables_.rays; }
  bool is_exact() const { return exact_ != nullptr; }

  // Everything below is for the exact kernel.

  LightLine exact(LineId id) const;
  // The sign of a line at corner i of a facet's cone; and of the facet's plane against another
  // plane (1: the facet is nearer to the light). Signs that hold by construction cost no
  // arithmetic: at the end of an edge, and where the line itself has cut the cone.
  int side(std::span<const ConeCorner> cone, std::uint32_t i, FacetId facet, LineId line,
           SignCounts& counts) const;
  int nearer(std::span<const ConeCorner> cone, std::uint32_t i, FacetId facet,
             std::uint32_t other_plane, SignCounts& counts) const;
  // Whether the ray of a vertex meets the facet's plane (1), or its continuation behind the light
  // does (-1).
  int ahead(FacetId facet, std::uint32_t vertex) const;
  // The ray in which the incoming edge meets the outgoing edge.
  VertexRay ray(EdgeRef in, EdgeRef out) const;
  // Corner i in the plane of the facet. Since its last clear() the cache must have been used with
  // lines of this cell only, as they are now.
  Vec3 point(std::span<const ConeCorner> cone, std::uint32_t i, FacetId facet,
             PointCache& cache) const;
  // The vertex in whose ray two edges meet; none if they have no vertex in common.
  std::uint32_t shared_vertex(EdgeRef a, EdgeRef b) const;
  Construction construction(std::span<const ConeCorner> cone, std::uint32_t i) const;

 private:
  struct HeldCorner {  // an exact corner, and the lines that it points to
    LightLine in, out;
    ExactCorner corner;
  };
  void hold(std::span<const ConeCorner> cone, std::uint32_t i, FacetId facet,
            HeldCorner& held) const;

  const LightTables& tables_;
  std::span<const LocalLine> local_;
  const ExactPredicates* exact_;
};

}  // namespace shadowcut
