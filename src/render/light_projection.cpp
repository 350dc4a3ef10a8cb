// See light_projection.hpp.
#include "light_projection.hpp"

namespace shadowcut::render {

std::array<CubeAxes, 6> cube_axes() {
  const Vec3f x = Vec3f::UnitX(), y = Vec3f::UnitY(), z = Vec3f::UnitZ();
  return {{{-z, -y, x}, {z, -y, -x}, {x, z, y}, {x, -z, -y}, {x, -y, z}, {-x, -y, -z}}};
}

Mat4f cube_face(const Vec3f& at, const CubeAxes& axes, float nearest) {
  const auto& [right, up, forward] = axes;
  Mat4f view = Mat4f::Identity();
  view.row(0).head<3>() = right, view.row(1).head<3>() = up, view.row(2).head<3>() = -forward;
  view.topRightCorner<3, 1>() = -(view.topLeftCorner<3, 3>() * at);
  Mat4f projection = Mat4f::Zero();
  projection(0, 0) = projection(1, 1) = 1, projection(2, 2) = -1, projection(2, 3) = -2 * nearest,
                projection(3, 2) = -1;
  return projection * view;
}

}  // namespace shadowcut::render
