// The two passes that brute force, tiling and the ordered tree have in common (Slater 1992,
// sections 2 and 3): the scene BSP gives the polygons front to back from a light, and each is cut
// by the shadow volumes of those before it.
//
// Several lights: what one light has cut is what the next one cuts (Slater's shadows on shadows);
// casters are always the BSP's polygons.
#pragma once

#include <chrono>

#include "compare.hpp"

namespace shadowcut::compare {

using Clock = std::chrono::steady_clock;
inline double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Any algorithm but unordered. Fills all but what follows from the fragments.
std::vector<Result> cast_front_to_back(const Scene& scene, std::span<const Light> lights,
                                       Algorithm algorithm, const Settings& settings);

}  // namespace shadowcut::compare
