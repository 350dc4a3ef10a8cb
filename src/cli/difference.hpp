// How much two cuttings of one scene's faces differ: not in their fragments, which may be other
// ones, but in what is lit.
#pragma once

#include <shadowcut/shadows.hpp>

namespace shadowcut::cli {

struct Difference {
  double share = 0;           // of the face's area
  std::uint32_t face = invalid_index;  // where it is greatest
};

// The area of the symmetric difference of the lit regions, by face, computed from the fragments'
// corners. Fragments that overlap count as a difference. Cost: about the number of lit fragments,
// where they are spread evenly over their faces.
std::vector<double> lit_differences(const Scene& scene, const Shadows& one, const Shadows& other);

// For each face the greater of two: the difference of the lit areas, as both state them, and the
// above.
Difference greatest_difference(const Scene& scene, const Shadows& one, const Shadows& other);

}  // namespace shadowcut::cli
