// See camera.hpp.
#include "camera.hpp"

#include <cmath>
#include <numbers>

namespace shadowcut::render {

Pose Camera::view() const {
  const Vec3 back = (eye - target).stableNormalized();
  Vec3 right = up.cross(back);
  if (right.norm() < 1e-6 * up.norm()) right = back.unitOrthogonal();
  right.normalize();
  Pose pose = Pose::Identity();
  pose.linear().row(0) = right, pose.linear().row(1) = back.cross(right),
  pose.linear().row(2) = back;
  pose.translation() = -(pose.linear() * eye);
  return pose;
}

Eigen::Matrix4d Camera::projection(double aspect, double near) const {
  const double f = 1 / std::tan(fov / 2);
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m(0, 0) = f / aspect, m(1, 1) = f, m(2, 2) = -1, m(2, 3) = -2 * near, m(3, 2) = -1;
  return m;
}

void check(const Camera& camera) {
  if (!camera.eye.allFinite() || !camera.target.allFinite())
    throw Error("camera: its coordinates must be finite");
  if ((camera.eye - camera.target).stableNorm() == 0)
    throw Error("camera: eye and target are the same point");
  if (!(camera.fov > 0 && camera.fov < std::numbers::pi))
    throw Error("camera: the field of view must be between 0 and 180 degrees");
}

}  // namespace shadowcut::render
