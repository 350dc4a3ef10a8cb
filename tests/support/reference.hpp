// The shipped scenes and their reference areas (data/).
#pragma once

#include <iosfwd>
#include <shadowcut/scene.hpp>
#include <string>
#include <vector>

namespace shadowcut::testing {

struct ReferenceScene {
  std::string name;  // "room1"
  std::string path;  // of its OBJ
  Light light;
};
void PrintTo(const ReferenceScene& scene, std::ostream* out);  // for GoogleTest
// those of scenes.json
std::vector<ReferenceScene> reference_scenes(const std::string& data_folder);

struct ReferenceArea {
  std::string light, object;
  std::uint32_t face;
  double area, lit;
};
std::string areas_path(const std::string& data_folder, const std::string& name);
std::vector<ReferenceArea> read_areas(const std::string& path);

}  // namespace shadowcut::testing
