// Scenes and lights; see inputs.hpp.
#include "inputs.hpp"

#include <algorithm>
#include <thread>

#include "report.hpp"
#include "specs.hpp"

namespace shadowcut::cli {

namespace {

constexpr std::size_t most_issues = 20;

std::vector<NamedLight> lights_of(const Scene& scene, const std::string& file) {
  std::vector<NamedLight> lights;
  for (const Light& light : scene.lights()) lights.push_back({light, light_spec(light)});
  if (lights.empty()) throw Error(file + ": the scene has no light; give one with --light");
  return lights;
}

}  // namespace

std::vector<NamedLight> parse_lights(const std::vector<std::string>& specs) {
  std::vector<NamedLight> lights;
  for (const std::string& spec : specs) lights.push_back({parse_light(spec), spec});
  return lights;
}

std::vector<NamedLight> set_lights(Scene& scene, const std::vector<NamedLight>& given,
                                   const std::string& file) {
  std::vector<NamedLight> lights = given.empty() ? lights_of(scene, file) : given;
  std::vector<Light> plain;
  for (const NamedLight& l : lights) plain.push_back(l.light);
  scene.replace_lights(plain);
  return lights;
}

Scene read(const Reading& reading) {
  Scene scene = io::read_scene(reading.file, reading.options);
  if (reading.strict && !scene.issues().empty()) {
    list_issues(scene, reading.file, most_issues);
    throw Error(reading.file + ": --strict: " + std::to_string(scene.issues().size()) +
                " faces were refused or repaired");
  }
  if (!reading.quiet) list_issues(scene, reading.file, most_issues);
  if (scene.facets().empty())
    throw Error(reading.file + ": no usable face; 'shadowcut inspect' lists the reasons");
  return scene;
}

unsigned threads_of(unsigned wanted) {
  return wanted != 0 ? wanted : std::max(1u, std::thread::hardware_concurrency());
}

}  // namespace shadowcut::cli
