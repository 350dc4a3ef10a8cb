// The conforming form: no T-junctions inside a face, and one set of numbers for one point.
#pragma once

#include <vector>

#include "emit.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {

// Makes corners of a face that are one point up to rounding the same numbers, and adds to every
// fragment the corners of other fragments of its face that lie on its edges. Fragments keep their
// order in their blocks; slivers whose corners all fall together are left out.
void make_conforming(const Scene& scene, std::vector<CellOutput>& outputs);

}  // namespace shadowcut::SHADOWCUT_NUMBERS
