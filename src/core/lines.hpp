// What all cells of one light share, and a cell's view of it: lines by their ids, and the signs
// that their numbers leave open.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "cone.hpp"
#include "exact.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {

// Line ids: edges of the scene and planes of the prefix lie below, a cell's own lines from here on.
inline constexpr std::uint32_t first_local_line = 1u << 29;

// Read-only while cells are built or edited.
struct LightTables {
  std::vector<Line> lines;                  // by line id, below first_local_line
  std::vector<std::pair<Vec3, Vec3>> ends;  // exact kernel: likewise, what they go through
  // by Scene::vertices(); only those of facets that enter are filled in
  std::vector<VertexRay> rays;
  std::vector<PlaneRay> planes;  // by Scene::planes(); likewise
  std::uint32_t first_prefix_line = 0, prefix_lines = 0;
  std::span<const Facet> facets;
  std::span<const Object> objects;
  std::span<const Face> faces;
  std::span<const Vec3> vertices;
  std::span<const Plane> scene_planes;
  // by facet, exact kernel: seen so nearly edge-on that its corners say little about its region
  std::vector<std::uint8_t> grazed;
  // by facet: the far wall of a solid the light is in; it casts, its own side is dark
  std::vector<std::uint8_t> blocks_only;
  // by object: what to add to an edge's index for its line's id
  std::vector<std::uint32_t> line_shift;
  bool edits = false;  // whether objects will come and go
  std::uint32_t join_threshold = 0;
  MinFeature least = {};  // see smallest_feature.hpp
  const LightSpace* space = nullptr;
  Vec3 light_at = Vec3::Zero();       // of a point light
  std::unique_ptr<ExactLight> exact;  // exact kernel
  std::uint32_t object_of(std::uint32_t facet) const { return faces[facets[facet].face].object; }
  bool casts(std::uint32_t facet) const { return objects[object_of(facet)].casts; }
  bool is_prefix_line(std::uint32_t id) const { return id - first_prefix_line < prefix_lines; }
};

struct LocalLine {  // of a cell
  Line line;
  std::uint32_t uses;  // by nodes and by stored pieces' edges
  LightLine exact;     // exact kernel
};

// Corners of fragments, which come several times each: from both sides of a cut, and where cuts
// meet.
class PointCache {
 public:
  void clear() { ++generation_; }
  // The point of corner (in, out) in a plane; make() if it is not known.
  template <class Make>
  Vec3 get(std::uint32_t plane, std::uint32_t in, std::uint32_t out, const Make& make) {
    if (in > out) std::swap(in, out);
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
    std::uint32_t plane = none, in = none, out = none;
  };
  std::vector<Slot> slots_;  // empty until asked
  std::uint64_t generation_ = 1;
};

class Lines {
 public:
  Lines(const LightTables& tables, std::span<const LocalLine> local)
      : Lines(tables, local, tables.exact.get()) {}
  Lines(const LightTables& tables, std::span<const LocalLine> local, const ExactLight* exact)
      : tables_(tables), local_(local), exact_(exact) {}

  const Line& operator()(std::uint32_t id) const {
    return id < first_local_line ? tables_.lines[id] : local_[id - first_local_line].line;
  }
  std::span<const VertexRay> rays() const { return tables_.rays; }

  bool is_exact() const { return exact_ != nullptr; }
  LightLine exact(std::uint32_t id) const;
  // Everything below is for the exact kernel. Signs at corner i of a cone of a facet: of a line,
  // and of its plane against another. Those that hold by construction cost no arithmetic: at the
  // end of an edge, and where the line itself has cut.
  int side(std::span<const ConeCorner> cone, std::uint32_t i, std::uint32_t facet,
           std::uint32_t line, SignCounts& counts) const;
  int nearer(std::span<const ConeCorner> cone, std::uint32_t i, std::uint32_t facet,
             std::uint32_t other_plane, SignCounts& counts) const;
  // Whether the ray of a vertex meets the facet's plane (1), or its continuation behind the light
  // does (-1).
  int ahead(std::uint32_t facet, std::uint32_t vertex) const;
  // Where the edge that comes in meets the one that leaves.
  VertexRay ray(EdgeRef in, EdgeRef out) const;
  // Corner i in the plane of the facet. The cache must have seen lines of this cell only, as they
  // are, since it was cleared.
  Vec3 point(std::span<const ConeCorner> cone, std::uint32_t i, std::uint32_t facet,
             PointCache& cache) const;
  // The vertex in whose ray two edges meet; none if they have none in common.
  std::uint32_t shared_vertex(EdgeRef a, EdgeRef b) const;
  Construction construction(std::span<const ConeCorner> cone, std::uint32_t i) const;

 private:
  struct Held {  // an exact corner, and what it points to
    LightLine in, out;
    ExactCorner corner;
  };
  void hold(std::span<const ConeCorner> cone, std::uint32_t i, std::uint32_t facet,
            Held& held) const;

  const LightTables& tables_;
  std::span<const LocalLine> local_;
  const ExactLight* exact_;
};

}  // namespace shadowcut::SHADOWCUT_NUMBERS
