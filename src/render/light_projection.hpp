// How a point light is looked out of: six square views, the faces of a cube.
#pragma once

#include <array>

#include "gl.hpp"

namespace shadowcut::render {

// Right, up, forward.
using CubeAxes = std::array<Vec3f, 3>;

// The directions in which OpenGL has a cube's faces, in its order.
std::array<CubeAxes, 6> cube_axes();

// World to clip space for one of them, a quarter turn across. Depth is 1 - nearest / distance:
// nothing is too far.
Mat4f cube_face(const Vec3f& at, const CubeAxes& axes, float nearest);

}  // namespace shadowcut::render
