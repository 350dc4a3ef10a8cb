// Several lights: one partition for all of them.
#pragma once

#include <vector>

#include "light_tree.hpp"

namespace shadowcut {

// Cuts the first light's fragments by the second light's tree, and so on (CS95, section 4). A null stands for a light that there is not.
LightSets combine(const std::vector<const LightTree*>& lights);

}  // namespace shadowcut
