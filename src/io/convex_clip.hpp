// Clipping of convex polygons for drawings. Not for the engine, which cuts in light space.
#pragma once

#include <cstddef>
#include <shadowcut/scene.hpp>
#include <vector>

namespace shadowcut::io {

// Keeps the part of `polygon` (or, with two corners, of a segment) where `height`, an affine
// function of the point, is not negative.
template <typename Height>
void clip(std::vector<Vec3>& polygon, std::vector<Vec3>& scratch, const Height& height) {
  scratch.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double ha = height(a), hb = height(b);
    if (ha >= 0) scratch.push_back(a);
    if ((ha >= 0) != (hb >= 0)) scratch.push_back(a + (b - a) * (ha / (ha - hb)));
  }
  polygon.swap(scratch);
}

}  // namespace shadowcut::io
