// The difference of two shadows of one scene: not of their fragments, which may differ, but of
// their lit regions.
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

// By face: the larger of the difference of the two lit areas and the area above, as a share of the
// area of the face.
std::vector<double> difference_shares(const Scene& scene, const Shadows& one, const Shadows& other);

// The face with the largest share.
Difference greatest_difference(const Scene& scene, const Shadows& one, const Shadows& other);

// The largest share at which an update still equals a rebuild. The exact kernel cuts both along the
// same lines, so 1e-12 covers the rounding of areas. Corners of the input are added to that: a
// corner that is off its plane by the plane's flatness moves along its ray to the plane by the
// flatness divided by the sine of the angle between ray and plane, and the two trees may use the
// corner itself at different places of the outline. The fast kernel, and faces that are nearly
// edge-on, have 1e-9.
double tolerance_of(const Scene& scene, const Light& light, std::uint32_t face, Kernel kernel);

}  // namespace shadowcut::cli
