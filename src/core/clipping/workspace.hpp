// The memory of one thread that works on cones.
#pragma once

#include <cstdint>
#include <vector>

#include "predicates/cell_predicates.hpp"
#include "predicates/cone.hpp"

namespace shadowcut {

// Memory that one thread reuses for cell after cell.
struct Workspace {
  // A cone on its way down a tree; see svbsp/descend.hpp.
  struct Pending {
    Cone* cone;
    std::uint32_t place;  // a Place of a cell's tree, or a branch of the k-d tree
    std::uint32_t tag;    // the visitor's own
  };

  ConePool pool;
  std::vector<std::int8_t> spill;  // see CornerSides
  std::vector<Pending> pending;
  PointCache points;
};

}  // namespace shadowcut
