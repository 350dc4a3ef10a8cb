// The conforming form: no T-junctions inside a face.
#pragma once

#include <vector>

#include "emit.hpp"

namespace shadowcut {

// Adds to every fragment the corners of other fragments of its face that lie on its edges. Fragments stay where they are in their blocks.
void make_conforming(const Scene& scene, std::vector<CellOutput>& outputs);

}  // namespace shadowcut
