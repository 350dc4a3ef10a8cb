// Where a picture is taken from. Perspective without a far plane: shadow volumes reach to infinity.
#pragma once

#include <shadowcut/scene.hpp>

#include "gl.hpp"

namespace shadowcut::render {

struct Camera {
  Vec3 eye = Vec3::Zero(), target = Vec3::UnitX();
  double fov = 1.0471975511965976;  // vertical, radians
  Vec3 up = Vec3::UnitZ();

  // World to camera: x to the right, y up, looking along -z. Where it looks along `up`, another
  // axis serves.
  Pose view() const;
  // From camera space to clip space, near plane at `near`, nothing beyond is too far.
  Eigen::Matrix4d projection(double aspect, double near) const;
};

// Throws Error when it looks nowhere or its field of view is not between 0 and pi.
void check(const Camera& camera);

}  // namespace shadowcut::render
