// The published algorithms beside the engine, on the same scenes and behind one call.
//
//   brute, tiling, ordered   M. Slater, "A comparison of three shadow volume algorithms", The
//                            Visual Computer 9(1), 1992: two passes. A scene BSP orders the
//                            polygons front to back from the light; then each polygon is cut by
//                            the shadows of the polygons before it
//   unordered                the engine (CS95), on the scene's own faces or on the polygons of the
//                            scene BSP
//
// Areas, facing, ranges and spot cones are defined as in shadows.hpp. The published algorithms
// compute in plain doubles with a fixed tolerance (lighting.hpp): lit areas are good to 1e-9 of a
// face if the face is flat, is larger than a millionth of the scene, and is not seen within 1e-3
// radians of its plane. Faces that cross are cut along their crossing by the scene BSP, and
// are no special case.
#pragma once

#include <shadowcut/shadows.hpp>

#include "polygon.hpp"

namespace shadowcut::compare {

enum class Algorithm : std::uint8_t { brute, ordered, tiling, unordered };

struct Settings {
  std::uint32_t candidates = 8;  // for each root of the scene BSP
  std::uint32_t tiles = 128;     // tiling: along a side of each face of the cube around the light
  // ordered, unordered: fragments of one state meet again across the cuts that parted them
  // (Slater's figure 6)
  bool reunite = true;
  // unordered: cuts the scene BSP's polygons in place of the faces (CS95, table 1)
  bool after_bsp = false;
  // brute, tiling: fill Result::shadow_polygons, at the cost of time
  bool count_shadow_polygons = false;
  Kernel kernel = Kernel::fast;  // unordered
};

struct Fragment {
  Polygon polygon;
  bool lit;
};

// What one light makes of the scene. Every light's input is the fragments of the light before
// (Slater 1992, section 3); unordered casts each light by itself.
struct Result {
  // by index into Scene::faces(); away and out_of_reach: shadowed whole, without a fragment
  std::vector<FaceArea> areas;
  std::vector<Fragment> fragments;  // of faces turned to the light
  // usable faces; and polygons that the algorithm was given
  std::uint64_t faces_in = 0, faces_after_bsp = 0;
  std::uint64_t lit_fragments = 0, shadowed_fragments = 0;
  // Shadows as Slater counts them: one for each pair of a polygon and the shadow volume of one
  // before it that meet. They overlap.
  std::uint64_t shadow_polygons = 0;
  double lit_area = 0, shadowed_area = 0;
  // scene BSP and traversal, steady clock; the tree is built for the first light
  double order_ms = 0;
  double shadow_ms = 0;            // the rest
  std::uint64_t memory_bytes = 0;  // held at the end: tree, shadow volumes, tiles and fragments
};

// One result a light. Single-threaded. Throws Error as cast_shadows does.
std::vector<Result> cast(const Scene& scene, std::span<const Light> lights, Algorithm algorithm,
                         const Settings& settings = {});

const char* name_of(Algorithm algorithm);

}  // namespace shadowcut::compare
