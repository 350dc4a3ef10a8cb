// Small random scenes of every kind that has a way of going wrong. A seed gives the same scene
// everywhere.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>

#include "scenes.hpp"

namespace shadowcut::testing {

enum class Kind {
  soup,  // open triangles and quadrilaterals in general position, many of them crossing
  // the same on a small integer grid, the light too: planes and edges that meet the light, each
  // other, and themselves
  grid_soup,
  solids,  // closed tetrahedra in general position that overlap
  // closed boxes on an integer grid: contact, shared walls, the light in planes, on faces, inside
  grid_boxes,
  turned_boxes,  // stacked boxes turned by a pose that rounds: contact up to the last bits
  outlines,      // concave outlines and holes, flat on tilted planes
  tiles,         // coplanar tiles and posters on tilted planes, exactly flat
  room,          // an inside-out room, furnished with boxes, the light inside
};
inline constexpr Kind kAllKinds[] = {Kind::soup,       Kind::grid_soup,    Kind::solids,
                                     Kind::grid_boxes, Kind::turned_boxes, Kind::outlines,
                                     Kind::tiles,      Kind::room};
const char* name_of(Kind kind);
void PrintTo(Kind kind, std::ostream* out);  // for GoogleTest

// With its light, a point or a direction. No object casts or receives otherwise than by default.
scenes::SceneData random_scene(Kind kind, std::uint64_t seed);

// A second light for the scene, of the kind's own sort.
Light random_light(Kind kind, scenes::Random& random);

// The same scene, all lengths times `factor` and then shifted.
scenes::SceneData scaled(const scenes::SceneData& data, double factor,
                         const Vec3& shift = Vec3::Zero());

}  // namespace shadowcut::testing
