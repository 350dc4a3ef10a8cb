// From the tree to fragments in world space.
#pragma once

#include <cstdint>
#include <vector>

#include "tree.hpp"

namespace shadowcut {

// A block with what later stages need of each corner and fragment.
struct CellOutput {
  Block block;
  // By corner, in the block's order: the line of the edge that leaves it; lines of a cell's own are told apart by the cell. Only filled for
  // the conforming form.
  std::vector<std::uint64_t> edge_lines;
};

// What turning a cone into corners needs.
struct EmitTarget {
  const Scene& scene;
  const LightSpace& space;
  const LightTables& tables;
  bool keep_lines;
};

// The area of a facet's region: in_light, its plane cut by its cone of light (for facets that entered); otherwise what its corners enclose.
double area_of_facet(const EmitTarget& target, std::uint32_t facet, bool in_light);

// All fragments of one cell. `merge`: siblings that are both lit, or shadowed by one object, are handed out as one.
void emit_cell(const CellTree& tree, std::uint32_t cell, bool merge, const EmitTarget& target, Workspace& w, CellOutput& out);

}  // namespace shadowcut
