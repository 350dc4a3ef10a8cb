// Several lights: one partition for all of them.
#pragma once

#include <memory>
#include <vector>

#include "light_tree.hpp"

namespace shadowcut {

// Cuts the first light's fragments by the second light's tree, and so on (CS95, section 4).
LightSets combine(const std::vector<std::unique_ptr<LightTree>>& lights);

}  // namespace shadowcut
