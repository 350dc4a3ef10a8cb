// Everything that can be asked of one light's shadows, at once.
#pragma once

#include <gtest/gtest.h>

#include "check.hpp"

namespace shadowcut::testing {

inline void expect_right(const Scene& scene, const Light& light, const Options& options = {},
                         bool only_facing = false) {
  const Shadows shadows = cast_shadows(scene, light, options);
  const CgalOracle oracle(scene, light, only_facing);
  EXPECT_EQ(check_areas(scene, shadows, oracle), "");
  EXPECT_EQ(check_fragments(scene, light, shadows), "");
  EXPECT_EQ(check_points(scene, shadows, oracle, 1, 50), "");
}

}  // namespace shadowcut::testing
