// Shadows without a tree: every face that the light reaches is clipped by every possible caster,
// and a polygon clipping library unites the shadows (Angus Johnson's Clipper, Debian package
// polyclipping).
//
// Pairs are rejected by discs around both faces, as the light sees them. A caster is clipped to the
// shadow planes of the receiver and to the space in front of the plane of the receiver, as convex
// polygons (src/compare/polygon.hpp). The shadows are united in the plane of the receiver, in
// integers of Clipper with 2^30 units per size of the receiver.
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
