// Writes the reference areas of the shipped scenes: reference_areas DATA_FOLDER. A row for each
// face, from the exact oracle; takes a minute.
#include <charconv>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <shadowcut/io.hpp>

#include "cgal_oracle.hpp"
#include "reference.hpp"

namespace {

std::string digits(double x) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, x).ptr};
}

std::string table(const shadowcut::Scene& scene, const shadowcut::Light& light) {
  const shadowcut::testing::CgalOracle oracle(scene, light);
  std::string text = "light,object,face,area,lit_area\n";
  for (std::uint32_t i = 0; i < scene.faces().size(); ++i) {
    const auto area = oracle.area(i);
    if (area.unsure) std::cerr << "face " << i << ": the light is within 1e-9 of its plane\n";
    const shadowcut::Face& face = scene.faces()[i];
    text += "0," + scene.objects()[face.object].name + "," + std::to_string(face.number) + "," +
            digits(area.area) + "," + digits(area.lit) + "\n";
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: reference_areas DATA_FOLDER\n";
    return 2;
  }
  try {
    for (const auto& reference : shadowcut::testing::reference_scenes(argv[1])) {
      const std::string text = table(shadowcut::io::read_scene(reference.path), reference.light);
      shadowcut::io::write_text(shadowcut::testing::areas_path(argv[1], reference.name), text);
      std::printf("%s\n", reference.name.c_str());
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
  return 0;
}
