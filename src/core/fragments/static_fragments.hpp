// The fragments of a cell whose tree is finished: for one-off casts, and for the conforming form.
//
// Unlike CellFragments it keeps nothing for updates, and merges fragments across all cuts whose
// sides came to the same state. docs/decisions.md has the figures of that difference.
#pragma once

#include <cstdint>
#include <vector>

#include "fragments/polygon.hpp"
#include "svbsp/svbsp_tree.hpp"

namespace shadowcut {

// A block, with what later stages need of each corner.
struct CellOutput {
  Block block;
  // By corner, in the block's order: a name of the line of the edge that leaves it. The same for
  // the same line in every cell; a cell's own lines differ from those of other cells. Filled for
  // the conforming form only.
  std::vector<std::uint64_t> edge_lines;
};

void emit_cell(const SvbspTree& tree, CellId cell, const EmissionContext& context, Workspace& w,
               CellOutput& out);

}  // namespace shadowcut
