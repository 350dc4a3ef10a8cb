// The conforming form: no T-junctions inside a face, and one set of numbers for one point.
#pragma once

#include <vector>

#include "fragments/static_fragments.hpp"

namespace shadowcut {

// Makes corners of a face that are one point up to rounding the same numbers, and adds to every
// fragment the corners of other fragments of its face that lie on its edges. Fragments keep their
// order in their blocks; slivers whose corners all fall together are left out.
void make_conforming(const Scene& scene, std::vector<CellOutput>& outputs);

}  // namespace shadowcut
