// An upper bound, for each face, on the area whose state the floating-point filter left uncertain.
#pragma once

#include <vector>

#include "fragments/light_view.hpp"

namespace shadowcut {

// By face: no less than the area that is lit and was emitted as shadowed, or the reverse, with what
// rounding made of the areas; to first order. For the kernel fast. Cost: about that of emitting all
// fragments.
std::vector<double> error_bound(const LightView& light);

}  // namespace shadowcut
