// Writes the shipped scenes: make_scenes FOLDER. An OBJ each, in world coordinates with all their digits, and scenes.json with their
// lights.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <iostream>

#include "scenes.hpp"

namespace {

using shadowcut::Vec3;
using shadowcut::scenes::SceneData;

// The shortest digits that read back as the same double.
std::string digits(double x) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, x).ptr};
}

std::string spec(const shadowcut::Light& light) {
  return "point:" + digits(light.at.x()) + "," + digits(light.at.y()) + "," + digits(light.at.z());
}

std::string obj(const SceneData& data) {
  std::string text = "# " + data.name + ", made by make_scenes; light " + spec(data.light) + "\n";
  std::size_t base = 1;
  for (const auto& [mesh, settings] : data.objects) {
    text += "o " + settings.name + "\n";
    for (const Vec3& local : mesh.vertices) {
      const Vec3 v = settings.pose * local;
      text += "v " + digits(v.x()) + " " + digits(v.y()) + " " + digits(v.z()) + "\n";
    }
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
      text += "f";
      for (const std::uint32_t v : mesh.loop(f, 0)) text += " " + std::to_string(base + v);
      text += "\n";
    }
    base += mesh.vertices.size();
  }
  return text;
}

bool has_holes(const SceneData& data) {
  return std::any_of(data.objects.begin(), data.objects.end(), [](const auto& object) {
    for (std::size_t f = 0; f < object.first.face_count(); ++f)
      if (object.first.loop_count(f) > 1) return true;
    return false;
  });
}

bool write(const std::string& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  return static_cast<bool>(out.flush());
}

}  // namespace

int main(int argc, char** argv) {
  namespace make = shadowcut::scenes;
  if (argc != 2) {
    std::cerr << "usage: make_scenes FOLDER\n";
    return 2;
  }
  const std::string folder = argv[1];
  const SceneData all[] = {make::room(1),           make::room(2),        make::room(3),        make::room(4),
                           make::tetrahedron(2),    make::tetrahedron(3), make::tetrahedron(4), make::city(8),
                           make::spheres(5, 12, 8), make::triangles(200), make::branch(3)};
  std::string index;
  for (const SceneData& data : all) {
    if (has_holes(data)) {
      std::cerr << data.name << ": OBJ has no holes\n";
      return 1;
    }
    const std::string file = data.name + ".obj";
    if (!write(folder + "/" + file, obj(data))) {
      std::cerr << "cannot write " << folder << "/" << file << "\n";
      return 2;
    }
    index += index.empty() ? "{\n" : ",\n";
    index += "  \"" + file + "\": {\"light\": \"" + spec(data.light) + "\", \"polygons\": " + std::to_string(polygon_count(data)) + "}";
    std::printf("%-16s %6zu polygons\n", data.name.c_str(), polygon_count(data));
  }
  return write(folder + "/scenes.json", index + "\n}\n") ? 0 : 2;
}
