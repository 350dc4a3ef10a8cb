// From the tree to fragments in world space.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tree.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {

// A block with what later stages need of each corner and fragment.
struct CellOutput {
  Block block;
  // By corner, in the block's order: the line of the edge that leaves it; lines of a cell's own are
  // told apart by the cell. Only filled for the conforming form.
  std::vector<std::uint64_t> edge_lines;
};

// What turning a cone into corners needs.
struct EmitTarget {
  const Scene& scene;
  const LightSpace& space;
  const LightTables& tables;
  bool keep_lines, constructions;
};

// States of a branch in front of a PP-node: lit, shadowed by a face, or more than one.
inline constexpr std::uint32_t lit_state = none;
inline constexpr std::uint32_t mixed_state = none - 1;

// Whether fragments in these states may be handed out as one: both lit, or both shadowed by faces
// of one object.
inline bool alike_states(const Scene& scene, std::uint32_t a, std::uint32_t b) {
  if (a == b) return true;
  if (a >= mixed_state || b >= mixed_state) return false;
  return scene.faces()[a].object == scene.faces()[b].object;
}

// Of what lies to both sides of a node.
inline std::uint32_t joint_state(const Scene& scene, std::uint32_t a, std::uint32_t b) {
  return alike_states(scene, a, b) ? a : mixed_state;
}

inline std::uint32_t owner_face(const CellTree& tree, std::uint32_t pp) {
  return tree.tables().facets[tree.pieces()[tree.nodes()[pp].id].facet].face;
}

// Of a branch, with those of the SP-nodes; without any, SP-nodes count as mixed.
inline std::uint32_t state_of(const CellTree& tree, std::span<const std::uint32_t> of_nodes,
                              Child c) {
  return c.is_out()         ? lit_state
         : c.is_pp()        ? owner_face(tree, c.node())
         : of_nodes.empty() ? mixed_state
                            : of_nodes[c.node()];
}
// By SP-node.
std::vector<std::uint32_t> find_states(const CellTree& tree, const Scene& scene);

// Whether a piece gives fragments.
inline bool hands_out(const EmitTarget& target, const Piece& piece) {
  return piece.kind != Piece::Kind::free && !target.tables.blocks_only[piece.facet] &&
         target.scene.objects()[target.tables.object_of(piece.facet)].receives;
}

// The area of a polygon handed over corner by corner, as its part along the plane's normal: linear
// in the corners, so the areas of parts add up.
class AreaSum {
 public:
  explicit AreaSum(const Vec3& first) : origin_(first) {}
  void add(const Vec3& x) {
    const Vec3 spoke = x - origin_;
    doubled_ += last_.cross(spoke);
    last_ = spoke;
  }
  double area(const Vec3& normal) const { return std::abs(doubled_.dot(normal)) / 2; }

 private:
  Vec3 origin_, last_ = Vec3::Zero(), doubled_ = Vec3::Zero();
};

// Whether a facet's area can be taken from its corners.
bool corners_will_do(const EmitTarget& target, std::uint32_t facet);

// A polygon of a facet into world space: counter-clockwise seen from the light, as many corners as
// the cone has. Returns its area.
double place_polygon(const EmitTarget& target, const Lines& lines, std::uint32_t facet,
                     std::span<const ConeCorner> cone, PointCache& points, Vec3* out);

// What its corners are, from corner `first` of the block on.
void note_constructions(const EmitTarget& target, const Lines& lines,
                        std::span<const ConeCorner> cone, std::size_t first, Block& block);

// The area of a facet's region: in_light, its plane cut by its cone of light (for facets that
// entered); otherwise what its corners enclose.
double area_of_facet(const EmitTarget& target, std::uint32_t facet, bool in_light);

// All fragments of one cell. `merge`: siblings that are both lit, or shadowed by one object, are
// handed out as one.
void emit_cell(const CellTree& tree, std::uint32_t cell, bool merge, const EmitTarget& target,
               Workspace& w, CellOutput& out);

}  // namespace shadowcut::SHADOWCUT_NUMBERS
