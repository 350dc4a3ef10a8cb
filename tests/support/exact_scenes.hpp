// Small scenes made to break an exact kernel: on a grid, where almost everything is degenerate, and
// beside it by some ulps; thin, stacked, huge, tiny and far away; with lights in planes, on lines
// and at corners. A seed gives the same scene everywhere. Unlike those of random_scenes.hpp they
// are plain lists of faces, so that a scene that fails can be made smaller and printed.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace shadowcut::testing {

enum class ExactKind {
  soup,           // triangles and flat quadrilaterals in general position
  grid,           // sheets on a grid of 4 x 4 x 4, the light on it, half-way, or off it
  grid_solids,    // closed tetrahedra and boxes there, of both windings, among sheets
  folded,         // quadrilaterals there that are not flat, and concave outlines
  coplanar,       // sheets in few planes there: overlapping, equal, touching
  fan,            // all sheets have a vertex in common
  pencil,         // many corners and edges on few rays from the light
  nudged,         // one of the above on the grid, some coordinates one to three ulps off
  needles,        // widths of 1e-12 of the length, among others
  stack,          // parallel sheets one ulp apart
  scaled,         // any of the above times 1e-30, 1e-9, 1e9 or 1e30
  mixed_scales,   // every object times one of those
  far_away,       // 1e6 to 1e12 from the origin
  special_light,  // on a face's plane, an edge's line or a vertex, and one ulp off
  far_light,      // a point light at 1e12
  near_light,     // 1e-9 from a face
  grazing         // a directional light 1e-3 to 1e-12 off a face's plane
};
inline constexpr ExactKind kAllExactKinds[] = {
    ExactKind::soup,     ExactKind::grid,          ExactKind::grid_solids, ExactKind::folded,
    ExactKind::coplanar, ExactKind::fan,           ExactKind::pencil,      ExactKind::nudged,
    ExactKind::needles,  ExactKind::stack,         ExactKind::scaled,      ExactKind::mixed_scales,
    ExactKind::far_away, ExactKind::special_light, ExactKind::far_light,   ExactKind::near_light,
    ExactKind::grazing};
const char* name_of(ExactKind kind);
void PrintTo(ExactKind kind, std::ostream* out);  // for GoogleTest

struct ExactObject {
  std::vector<Vec3> vertices;
  std::vector<std::vector<std::uint32_t>> faces;
  // by decree: a solid with faces left out, or inside out, has one-sided faces like any other
  bool closed = false;
  bool casts_shadows = true, receives_shadows = true;
};

struct ExactScene {
  std::vector<ExactObject> objects;
  Light light;
};

ExactScene exact_scene(ExactKind kind, std::uint64_t seed);

// Parts of such scenes, for scripts of edits on the grid.
ExactObject grid_object(scenes::Random& random);
Light grid_light(scenes::Random& random);

Mesh mesh_of(const ExactObject& object);
ObjectSettings settings_of(const ExactObject& object);
Scene build(const ExactScene& scene);

// Leaves out faces one at a time for as long as the scene still fails.
ExactScene reduced_scene(ExactScene scene, const std::function<bool(const ExactScene&)>& fails);

// Every number with %.17g.
std::string describe(const ExactScene& scene);
std::string describe(const ExactObject& object);
std::string describe(const Light& light);

}  // namespace shadowcut::testing
