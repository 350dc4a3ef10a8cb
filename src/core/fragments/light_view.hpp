// Read access to one light that is up to date.
#pragma once

#include "fragments/emission_context.hpp"
#include "svbsp/cell_grid.hpp"

namespace shadowcut {

struct LightView {
  const CellGrid& grid;
  const EmissionContext& context;
  const Shadows& shadows;
};

}  // namespace shadowcut
