// The command view: a window in which to walk through a scene.
#include <filesystem>
#include <numbers>

#include "commands.hpp"
#include "inputs.hpp"
#include "scenes.hpp"
#include "specs.hpp"
#include "technique.hpp"
#include "walk.hpp"
#include "walkthrough.hpp"

namespace shadowcut::cli {

namespace {

// A generated scene, so that the command needs no file: a lamp inside, and a lamp outside the door.
// A depth buffer cannot order two faces in one plane, so faces that lie in the plane of another
// face are moved three millimetres out of it.
Scene furnished_room() {
  scenes::SceneData data = scenes::furnished_room();
  for (auto& [mesh, settings] : data.objects) {
    if (settings.name == "poster") settings.pose.translate(Vec3(0.003, 0, 0));
    if (settings.name.starts_with("screen")) settings.pose.translate(Vec3(0, 0.003, 0));
  }
  Scene scene = scenes::build(data);
  scene.add(scenes::light_at_the_door());
  return scene;
}

const render::Camera before_the_door{
    {0.5, 5.9, 1.75}, {5.4, 2.2, 0.55}, 75 * std::numbers::pi / 180};

}  // namespace

void view_scene(const ViewArguments& a) {
  render::check_technique(a.technique);
  const std::vector<NamedLight> given = parse_lights(a.lights);
  view::Settings settings;
  settings.technique = a.technique;
  settings.width = a.width, settings.height = a.height;
  if (!a.camera.empty()) {
    const io::View view = parse_camera(a.camera);
    settings.camera = {view.eye, view.target, view.fov, view.up};
    render::check(settings.camera);
  }
  Scene scene = a.scene.empty() ? furnished_room() : read({a.scene, a.reading, false, a.quiet});
  settings.scene_name =
      a.scene.empty() ? "furnished room" : std::filesystem::path(a.scene).filename().string();
  if (given.empty() && scene.lights().empty()) {
    scene.add(view::light_for(scene));
    settings.note = "the scene has no light: a lamp was added above its centre";
  }
  if (!given.empty()) set_lights(scene, given, a.scene);
  if (a.camera.empty())
    settings.camera = a.scene.empty() ? before_the_door : view::first_camera(scene);
  view::walk_through(std::move(scene), settings);
}

}  // namespace shadowcut::cli
