// What one would write without a tree: every face that the light reaches against every face that
// may stand in its way, and a polygon clipping library to unite the shadows (Angus Johnson's
// Clipper, Debian's polyclipping).
//
// Pairs are dismissed by the discs, as the light sees them, around both faces. A caster is cut to
// the receiver's planes of light, and to what is nearer than the receiver's plane, as convex
// polygons (src/compare/polygon.hpp); the shadows are then united in the receiver's plane, on
// Clipper's integers, 2^30 to the receiver's size. No cap on anything.
#pragma once

#include <shadowcut/shadows.hpp>

namespace shadowcut::bench {

struct Clipped {
  std::vector<double> lit;  // by index into Scene::faces(); 0 for those not turned to the light
  double lit_area = 0;
};

// Cost: the square of the number of facets in dismissals. Throws Error as cast_shadows does.
Clipped clip_every_face(const Scene& scene, const Light& light);

}  // namespace shadowcut::bench
