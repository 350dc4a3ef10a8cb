// A person who walks and looks around: the camera, from what keys and mouse ask for. Knows no
// window.
#pragma once

#include "model.hpp"

namespace shadowcut::view {

using render::box_of;

// Where to stand first: in a corner of a room and looking across it, or outside of what is no room.
render::Camera first_camera(const Scene& scene);

// What is asked for, each from -1 to 1.
struct Steps {
  // forward and right along the floor, wherever the eye looks
  double forward = 0, right = 0, up = 0;
  double turn_right = 0, turn_up = 0;
  bool run = false;
};

class Walker {
 public:
  // `pace`: scene units a second.
  Walker(const render::Camera& camera, double pace);

  // Where it gets to depends on the time alone, not on into how many calls it is divided.
  void walk(const Steps& steps, double seconds);
  // Radians. The eye looks almost straight up or down at most.
  void turn(double right, double up);
  const render::Camera& camera() const { return camera_; }

 private:
  render::Camera camera_;
  double pace_, heading_, pitch_;
};

}  // namespace shadowcut::view
