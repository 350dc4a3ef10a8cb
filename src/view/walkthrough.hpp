// A walk through a scene: its picture by one of the techniques of src/render in a window, where
// objects and lights are picked and dragged.
#pragma once

#include <shadowcut/scene.hpp>
#include <string>

#include "camera.hpp"

namespace shadowcut::view {

struct Settings {
  std::string scene_name, technique;
  render::Camera camera;
  int width = 1024, height = 768;
  std::string note;  // said in the overlay from first to last; may be empty
};

// Puts a light into a scene that has none: near the ceiling of a room's middle, or above the middle
// of what is no room.
Light light_for(const Scene& scene);

// Returns when the window is closed. Throws Error where there is no display, or no driver that
// serves.
void walk_through(Scene scene, const Settings& settings);

}  // namespace shadowcut::view
