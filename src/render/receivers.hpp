// What of an object can have one shadow texture: a texture holds one bit for each ray of light, so
// no ray may meet it twice.
//
// A receiver is a connected set of facets, turned to the light, that lie on the surface of a convex
// body seen from outside or on that of a convex room seen from inside: each facet's corners are
// behind the planes of all others, or before all of them, and a ray that comes through one plane
// cannot come to another's front. A convex solid is one receiver. (Oh & Shin say "object", and do
// not speak of objects that shadow themselves.)
#pragma once

#include <shadowcut/scene.hpp>
#include <vector>

namespace shadowcut::render {

// Facets of each receiver, ascending. Of solids the facets that are turned to the light, of sheets
// all; none that the light sees edge-on. `tolerance` is how far corners may be on the wrong side of
// a plane. Cost: in proportion to the facets of convex solids; otherwise to the sum of the squares
// of the receivers' sizes.
std::vector<std::vector<std::uint32_t>> receivers_of(const Scene& scene, std::uint32_t object,
                                                     const Light& light, double tolerance);

}  // namespace shadowcut::render
