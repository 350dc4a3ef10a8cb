// See walk.hpp.
#include "walk.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pick.hpp"

namespace shadowcut::view {
namespace {

constexpr double turning_speed = 1.2;  // radians a second, by keys
constexpr double running = 4;          // times as fast
constexpr double steepest = 89 * std::numbers::pi / 180;

}  // namespace

render::Camera first_camera(const Scene& scene) {
  const Eigen::AlignedBox3d box = box_of(scene);
  const auto at = [&](double x, double y, double z) -> Vec3 {
    return box.min() + Vec3(x, y, z).cwiseProduct(box.sizes());
  };
  if (is_room(scene)) return {at(0.03, 0.04, 0.85), at(0.5, 0.6, 0.1), 75 * std::numbers::pi / 180};
  const double away = std::max(box.diagonal().norm(), std::numeric_limits<double>::min());
  return {box.center() + away * Vec3(-0.55, -0.66, 0.42), box.center()};
}

Walker::Walker(const render::Camera& camera, double pace) : camera_(camera), pace_(pace) {
  const Vec3 ahead = (camera.target - camera.eye).stableNormalized();
  heading_ = std::atan2(ahead.y(), ahead.x());
  pitch_ = std::asin(std::clamp(ahead.z(), -1.0, 1.0));
}

void Walker::walk(const Steps& steps, double seconds) {
  // Half of the turn before the way and half after it; the way is the chord of the arc walked.
  const double half = turning_speed * seconds / 2;
  turn(half * steps.turn_right, half * steps.turn_up);
  Vec3 way(steps.forward * std::cos(heading_) + steps.right * std::sin(heading_),
           steps.forward * std::sin(heading_) - steps.right * std::cos(heading_), steps.up);
  if (way.norm() > 1) way.normalize();  // no faster at a slant
  const double bend = half * steps.turn_right;
  if (bend != 0) way.head<2>() *= std::sin(bend) / bend;
  way *= pace_ * (steps.run ? running : 1) * seconds;
  camera_.eye += way, camera_.target += way;
  turn(half * steps.turn_right, half * steps.turn_up);
}

void Walker::turn(double right, double up) {
  if (right == 0 && up == 0) return;
  heading_ = std::remainder(heading_ - right, 2 * std::numbers::pi);
  pitch_ = std::clamp(pitch_ + up, -steepest, steepest);
  const double distance = (camera_.target - camera_.eye).norm();
  camera_.target =
      camera_.eye + distance * Vec3(std::cos(pitch_) * std::cos(heading_),
                                    std::cos(pitch_) * std::sin(heading_), std::sin(pitch_));
}

}  // namespace shadowcut::view
