// Fragments as polygons: OBJ with materials, and PLY with properties. Coordinates are written so
// that they read back to the bit.
#include <algorithm>
#include <filesystem>

#include "files.hpp"
#include "text.hpp"
#include "writers.hpp"

namespace shadowcut::io {

namespace {

constexpr std::size_t block_size = 1 << 20;

void append_position(std::string& text, const Vec3& p) {
  for (int i = 0; i < 3; ++i) {
    if (i > 0) text += ' ';
    append(text, p[i]);
  }
  text += '\n';
}

void flush(PendingFile& file, std::string& text, std::size_t limit) {
  if (text.size() < limit) return;
  file.write(text);
  text.clear();
}

struct Indexed {
  VertexPool pool;
  std::vector<std::uint32_t> indices;  // by corner of Pieces
};

Indexed index(const Pieces& pieces) {
  Indexed out;
  out.indices.resize(pieces.corners.size());
  for (const Piece& piece : pieces.pieces)
    for (std::size_t i = piece.first_corner; i < piece.first_corner + piece.corner_count; ++i)
      out.indices[i] = out.pool.add(pieces.corners[i]);
  return out;
}

// Material names are single words in OBJ.
std::string material_name(const LightSet& set) {
  std::string name = set.name;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

std::string materials(const Pieces& pieces) {
  std::string text;
  for (const LightSet& set : pieces.sets) {
    text += "newmtl " + material_name(set) + "\nKd ";
    append_position(text, colour_of(pieces.brightness(set)));
    text += "illum 0\n";
  }
  return text;
}

}  // namespace

void write_obj(const std::string& path, const Scene& scene, const Pieces& pieces) {
  const std::filesystem::path beside = std::filesystem::path(path).replace_extension(".mtl");
  PendingFile material_file(beside.string()), file(path);
  material_file.write(materials(pieces));

  const Indexed indexed = index(pieces);
  std::string text = "mtllib " + beside.filename().string() + "\n";
  for (const Vec3& p : indexed.pool.positions()) {
    text += "v ";
    append_position(text, p);
    flush(file, text, block_size);
  }
  std::uint32_t object = invalid_index, set = invalid_index;
  for (const Piece& piece : pieces.pieces) {
    if (const std::uint32_t mine = scene.faces()[piece.face].object; mine != object) {
      text += "o " + printable(scene.objects()[mine].name) + "\n";
      object = mine;
      set = invalid_index;
    }
    if (piece.set != set) text += "usemtl " + material_name(pieces.sets[set = piece.set]) + "\n";
    text += 'f';
    for (std::size_t i = piece.first_corner; i < piece.first_corner + piece.corner_count; ++i) {
      text += ' ';
      append(text, std::uint64_t{indexed.indices[i]} + 1);
    }
    text += '\n';
    flush(file, text, block_size);
  }
  flush(file, text, 0);
  material_file.commit();
  file.commit();
}

void write_ply(const std::string& path, const Scene& scene, const Pieces& pieces) {
  PendingFile file(path);
  const Indexed indexed = index(pieces);
  std::uint32_t most = 0;
  for (const Piece& piece : pieces.pieces) most = std::max(most, piece.corner_count);

  std::string text = "ply\nformat ascii 1.0\n";
  for (std::size_t i = 0; i < scene.objects().size(); ++i) {
    if (!scene.objects()[i].alive) continue;
    text += "comment object " + std::to_string(i) + " " + printable(scene.objects()[i].name) + "\n";
  }
  for (std::size_t i = 0; i < pieces.sets.size(); ++i)
    text += "comment light_set " + std::to_string(i) + " " + pieces.sets[i].name + "\n";
  text +=
      "comment face is numbered within its object; lit is the number of lights that reach the "
      "fragment\n";
  text += "element vertex " + std::to_string(indexed.pool.positions().size()) +
          "\nproperty double x\nproperty double y\nproperty double z\n";
  text += "element face " + std::to_string(pieces.pieces.size()) + "\nproperty list " +
          (most < 256 ? "uchar" : "uint") +
          " uint vertex_indices\nproperty int object\nproperty int face\nproperty int "
          "lit\nproperty int light_set\nend_header\n";
  for (const Vec3& p : indexed.pool.positions()) {
    append_position(text, p);
    flush(file, text, block_size);
  }
  for (const Piece& piece : pieces.pieces) {
    const Face& face = scene.faces()[piece.face];
    append(text, std::uint64_t{piece.corner_count});
    for (std::uint32_t i = 0; i < piece.corner_count; ++i)
      append(text += ' ', std::uint64_t{indexed.indices[piece.first_corner + i]});
    for (const std::uint64_t value :
         {std::uint64_t{face.object}, std::uint64_t{face.number},
          std::uint64_t{pieces.sets[piece.set].lights.size()}, std::uint64_t{piece.set}})
      append(text += ' ', value);
    text += '\n';
    flush(file, text, block_size);
  }
  flush(file, text, 0);
  file.commit();
}

}  // namespace shadowcut::io
