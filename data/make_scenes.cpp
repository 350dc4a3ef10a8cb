// Writes generated scenes.
//
//   make_scenes FOLDER           the shipped scenes: an OBJ file each, in world coordinates with
//                                all digits; scenes.json with their lights; room4_edits.jsonl, the
//                                moves of a computer through the fourth room
//   make_scenes FOLDER NAME...   the OBJ files of the named scenes, for example city:100
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
  const Vec3& at = light.position;
  return "point:" + digits(at.x()) + "," + digits(at.y()) + "," + digits(at.z());
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

// A computer of room(4) is lifted over its neighbours, carried across the room below the lamp, and
// put on the floor: 40 updates.
std::string walk() {
  constexpr int steps = 40;
  std::string text;
  for (int k = 1; k <= steps; ++k) {
    const char* by = k == 1 ? "[0,0,0.5]" : k == steps ? "[0,0,-1.23]" : "[0.25,0.15625,0]";
    for (const char* object : {"computer.1", "screen.1"})
      text.append("{\"op\":\"move\",\"object\":\"")
          .append(object)
          .append("\",\"translate\":")
          .append(by)
          .append("}\n");
    text += "{\"op\":\"update\"}\n";
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

// Returns the exit status of the program.
int write_obj(const std::string& folder, const SceneData& data) {
  if (has_holes(data)) {
    std::cerr << data.name << ": OBJ files cannot hold faces with holes\n";
    return 1;
  }
  const std::string path = folder + "/" + data.name + ".obj";
  if (!write(path, obj(data))) {
    std::cerr << "cannot write " << path << "\n";
    return 2;
  }
  std::printf("%-16s %6zu polygons, light %s\n", data.name.c_str(), polygon_count(data),
              spec(data.light).c_str());
  return 0;
}

int write_shipped(const std::string& folder) {
  namespace make = shadowcut::scenes;
  const SceneData all[] = {make::room(1),        make::room(2),        make::room(3),
                           make::room(4),        make::tetrahedron(2), make::tetrahedron(3),
                           make::tetrahedron(4), make::city(8),        make::spheres(5, 12, 8),
                           make::triangles(200), make::branch(3)};
  std::string index;
  for (const SceneData& data : all) {
    if (const int status = write_obj(folder, data); status != 0) return status;
    index += index.empty() ? "{\n" : ",\n";
    index += "  \"" + data.name + ".obj\": {\"light\": \"" + spec(data.light) + "\", ";
    index += "\"polygons\": " + std::to_string(polygon_count(data)) + "}";
  }
  return write(folder + "/scenes.json", index + "\n}\n") &&
                 write(folder + "/room4_edits.jsonl", walk())
             ? 0
             : 2;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: make_scenes FOLDER [NAME...]\n";
    return 2;
  }
  if (argc == 2) return write_shipped(argv[1]);
  for (int i = 2; i < argc; ++i) {
    try {
      if (const int status = write_obj(argv[1], shadowcut::scenes::named(argv[i])); status != 0)
        return status;
    } catch (const shadowcut::Error& error) {
      std::cerr << error.what() << "\n";
      return 2;
    }
  }
}
