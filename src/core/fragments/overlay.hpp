// The overlay of several lights: one partition for all of them.
#pragma once

#include <vector>

#include "fragments/light_view.hpp"

namespace shadowcut {

// Cuts the first light's fragments by the second light's trees, and so on (CS95, section 4). A null
// stands for a light that has been removed. `faces`, where it is given, chooses whose fragments.
LightPartition overlay(const std::vector<const LightView*>& lights, const std::vector<bool>* faces);

}  // namespace shadowcut
