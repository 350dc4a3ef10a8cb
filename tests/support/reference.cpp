// See reference.hpp.
#include "reference.hpp"

#include <array>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace shadowcut::testing {
namespace {

Light parse_point(const std::string& spec) {
  Vec3 at;
  const char* text = spec.c_str() + std::string("point:").size();
  for (int k = 0; k < 3; ++k) {
    char* end = nullptr;
    at[k] = std::strtod(text, &end);
    text = end + 1;
  }
  return Light::point(at);
}

}  // namespace

void PrintTo(const ReferenceScene& scene, std::ostream* out) { *out << scene.name; }

std::vector<ReferenceScene> reference_scenes(const std::string& data_folder) {
  std::ifstream in(data_folder + "/scenes.json");
  std::vector<ReferenceScene> out;
  const nlohmann::json index = nlohmann::json::parse(in);
  for (const auto& [file, entry] : index.items())
    out.push_back({file.substr(0, file.rfind('.')), data_folder + "/" + file,
                   parse_point(entry.at("light").get<std::string>())});
  return out;
}

std::string areas_path(const std::string& data_folder, const std::string& name) {
  return data_folder + "/" + name + ".areas.csv";
}

std::vector<ReferenceArea> read_areas(const std::string& path) {
  std::ifstream in(path);
  std::vector<ReferenceArea> out;
  std::string line;
  std::getline(in, line);
  if (line != "light,object,face,area,lit_area")
    throw Error(path + ": not a table of reference areas");
  while (std::getline(in, line)) {
    std::array<std::string, 5> cells;
    std::istringstream row(line);
    for (std::string& cell : cells) std::getline(row, cell, ',');
    out.push_back({cells[0], cells[1], static_cast<std::uint32_t>(std::stoul(cells[2])),
                   std::strtod(cells[3].c_str(), nullptr), std::strtod(cells[4].c_str(), nullptr)});
  }
  return out;
}

}  // namespace shadowcut::testing
