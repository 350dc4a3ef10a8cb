// Chooses the writer for a file; and the table of areas.
#include "files.hpp"
#include "text.hpp"
#include "writers.hpp"

namespace shadowcut::io {

namespace {

std::string quoted(std::string_view name) {
  std::string text = "\"";
  for (const char c : printable(name)) text.append(c == '"' ? 2 : 1, c);
  return text + '"';
}

// Names are quoted only where a reader of comma separated values needs it.
std::string csv_name(std::string_view name) {
  return name.find_first_of(",\"\r\n") != std::string_view::npos ? quoted(name) : printable(name);
}

}  // namespace

Vec3 colour_of(double brightness) {
  return Vec3(0.40, 0.44, 0.52) + brightness * (Vec3(1.0, 0.95, 0.82) - Vec3(0.40, 0.44, 0.52));
}

void write_fragments(const std::string& path, const Scene& scene, const Engine& engine,
                     const View& view) {
  const std::string extension = extension_of(path);
  if (lights_of(engine).empty()) throw Error(path + ": cannot be drawn: the scene has no light");
  if (extension == ".obj") write_obj(path, scene, pieces_of(scene, engine));
  else if (extension == ".ply") write_ply(path, scene, pieces_of(scene, engine));
  else if (extension == ".gltf" || extension == ".glb")
    write_gltf(path, scene, pieces_of(scene, engine), extension == ".glb");
  else if (extension == ".svg") write_svg(path, scene, engine, view);
  else
    throw Error(path +
                ": cannot be written: the extension is not one of .obj .ply .gltf .glb .svg");
}

void write_areas(const std::string& path, const Scene& scene, const Engine& engine) {
  std::string text = "light,object,face,facing,area,lit_area,shadowed_area\n";
  for (const std::uint32_t k : lights_of(engine)) {
    const Shadows& shadows = engine.shadows(k);
    for (std::size_t f = 0; f < scene.faces().size(); ++f) {
      const Face& face = scene.faces()[f];
      if (face.object == invalid_index) continue;
      const FaceArea& area = shadows.areas[f];
      append(text, std::uint64_t{k});
      text.append(",").append(csv_name(scene.objects()[face.object].name)).append(",");
      append(text, std::uint64_t{face.number});
      text += area.facing == Facing::toward ? ",1" : ",0";
      for (const double value : {area.area, area.lit, area.shadowed}) {
        text += ',';
        append(text, value);
      }
      text += '\n';
    }
  }
  write_text(path, text);
}

}  // namespace shadowcut::io
