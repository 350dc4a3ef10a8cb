// Fragments as glTF 2.0, with the data in the file itself: JSON with base64, or binary.
//
// An object becomes a node with a mesh, and a light set a material with a primitive in each mesh.
// glTF holds coordinates as floats, so each node has a translation to the middle of its object and
// the coordinates count from there: a scene far from the origin stays as sharp as one near it.
// Materials are unlit, for the fragments already say where light falls.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "text.hpp"
#include "writers.hpp"

namespace shadowcut::io {

namespace {

using nlohmann::ordered_json;

enum : int {
  array_buffer = 34962,
  element_array_buffer = 34963,
  type_float = 5126,
  type_uint = 5125
};

template <typename T>
void append_little_endian(std::string& bytes, T value) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

std::string base64(std::string_view bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : digits[group >> (18 - 6 * k) & 63];
  }
  return text;
}

double linear_of(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

bool is_straight(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b - a).cross(c - b).norm() <= 1e-12 * (b - a).norm() * (c - b).norm();
}

// Triangles of a convex polygon, as indices into it; index n is its middle. A fan from a corner
// whose neighbours are no straight corners has no flat triangle, and no triangle's side runs past a
// corner; where there is no such corner the fan is from the middle.
void fan(std::span<const Vec3> corners, std::vector<std::uint32_t>& triangles) {
  const auto n = static_cast<std::uint32_t>(corners.size());
  std::vector<bool> straight(n);
  for (std::uint32_t i = 0; i < n; ++i)
    straight[i] = is_straight(corners[(i + n - 1) % n], corners[i], corners[(i + 1) % n]);
  triangles.clear();
  for (std::uint32_t apex = 0; apex < n; ++apex) {
    if (straight[(apex + 1) % n] || straight[(apex + n - 1) % n]) continue;
    for (std::uint32_t i = 1; i + 1 < n; ++i)
      triangles.insert(triangles.end(), {apex, (apex + i) % n, (apex + i + 1) % n});
    return;
  }
  for (std::uint32_t i = 0; i < n; ++i) triangles.insert(triangles.end(), {n, i, (i + 1) % n});
}

class Writer {
 public:
  Writer(const Scene& scene, const Pieces& pieces) : scene_(scene), pieces_(pieces) {}

  void build() {
    add_materials();
    for (std::size_t i = 0; i < pieces_.pieces.size();) i = add_object(i);
    finish();
  }

  std::string json_with_data() {
    document_["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64(data());
    return dump();
  }

  std::string binary() {
    std::string json = dump(), bytes = data(), out;
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::uint64_t size = 12 + 8 + json.size() + 8 + bytes.size();
    if (size > std::numeric_limits<std::uint32_t>::max())
      throw Error("more than 4 GiB of data, which a .glb file cannot hold");
    append_little_endian(out, std::uint32_t{0x46546C67});  // "glTF"
    append_little_endian(out, std::uint32_t{2});
    append_little_endian(out, static_cast<std::uint32_t>(size));
    append_little_endian(out, static_cast<std::uint32_t>(json.size()));
    append_little_endian(out, std::uint32_t{0x4E4F534A});  // "JSON"
    out += json;
    append_little_endian(out, static_cast<std::uint32_t>(bytes.size()));
    append_little_endian(out, std::uint32_t{0x004E4942});  // "BIN"
    return out += bytes;
  }

 private:
  std::string data() const { return positions_ + indices_; }
  std::string dump() const {
    return document_.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  }

  void add_materials() {
    for (const LightSet& set : pieces_.sets) {
      const Vec3 colour =
          colour_of(pieces_.brightness(set)).unaryExpr([](double c) { return linear_of(c); });
      document_["materials"].push_back(
          {{"name", set.name},
           {"doubleSided", true},
           {"extensions", {{"KHR_materials_unlit", ordered_json::object()}}},
           {"pbrMetallicRoughness",
            {{"baseColorFactor", {colour.x(), colour.y(), colour.z(), 1.0}},
             {"metallicFactor", 0.0},
             {"roughnessFactor", 1.0}}}});
    }
  }

  // The pieces of one object, which begin at `first`; returns where the next object's begin.
  std::size_t add_object(std::size_t first) {
    const std::uint32_t object = scene_.faces()[pieces_.pieces[first].face].object;
    std::size_t end = first;
    pool_.clear();
    std::vector<std::vector<std::uint32_t>> triangles(pieces_.sets.size());
    for (; end < pieces_.pieces.size() && scene_.faces()[pieces_.pieces[end].face].object == object;
         ++end)
      add_triangles(pieces_.pieces[end], triangles[pieces_.pieces[end].set]);

    const Vec3 middle = middle_of(pool_.positions());
    const std::size_t positions = add_positions(middle);
    ordered_json primitives = ordered_json::array();
    for (std::size_t set = 0; set < triangles.size(); ++set) {
      if (triangles[set].empty()) continue;
      primitives.push_back({{"attributes", {{"POSITION", positions}}},
                            {"indices", add_indices(triangles[set])},
                            {"material", set}});
    }
    const std::string name = printable(scene_.objects()[object].name);
    document_["nodes"].push_back({{"name", name},
                                  {"mesh", document_["meshes"].size()},
                                  {"translation", {middle.x(), middle.y(), middle.z()}}});
    document_["meshes"].push_back({{"name", name}, {"primitives", std::move(primitives)}});
    return end;
  }

  void add_triangles(const Piece& piece, std::vector<std::uint32_t>& out) {
    const std::span<const Vec3> corners = pieces_.corners_of(piece);
    fan(corners, fan_);
    for (const std::uint32_t i : fan_)
      out.push_back(pool_.add(i < corners.size() ? corners[i] : middle_of(corners)));
  }

  // Rounded to float, so that viewers, which compute in floats, move by exactly as much as was
  // taken off.
  static Vec3 middle_of(std::span<const Vec3> points) {
    Eigen::AlignedBox3d box;
    for (const Vec3& p : points) box.extend(p);
    const Vec3 middle = box.center().cast<float>().cast<double>();
    if (!middle.allFinite())
      throw Error("coordinates exceed the range of glTF, which stores float");
    return middle;
  }

  std::size_t add_positions(const Vec3& middle) {
    const std::size_t offset = positions_.size();
    Eigen::AlignedBox3f box;
    for (const Vec3& p : pool_.positions()) {
      const Eigen::Vector3f local = (p - middle).cast<float>();
      box.extend(local);
      for (const float c : local) append_little_endian(positions_, c);
    }
    document_["accessors"].push_back({{"bufferView", 0},
                                      {"byteOffset", offset},
                                      {"componentType", type_float},
                                      {"count", pool_.positions().size()},
                                      {"type", "VEC3"},
                                      {"min", {box.min().x(), box.min().y(), box.min().z()}},
                                      {"max", {box.max().x(), box.max().y(), box.max().z()}}});
    return document_["accessors"].size() - 1;
  }

  std::size_t add_indices(const std::vector<std::uint32_t>& triangles) {
    const std::size_t offset = indices_.size();
    for (const std::uint32_t i : triangles) append_little_endian(indices_, i);
    document_["accessors"].push_back({{"bufferView", 1},
                                      {"byteOffset", offset},
                                      {"componentType", type_uint},
                                      {"count", triangles.size()},
                                      {"type", "SCALAR"}});
    return document_["accessors"].size() - 1;
  }

  void finish() {
    std::vector<std::size_t> roots(document_["nodes"].size());
    for (std::size_t i = 0; i < roots.size(); ++i) roots[i] = i;
    document_["asset"] = {{"version", "2.0"}, {"generator", "shadowcut"}};
    document_["extensionsUsed"] = {"KHR_materials_unlit"};
    document_["scene"] = 0;
    document_["scenes"] = ordered_json::array({{{"nodes", roots}}});
    document_["bufferViews"] = {{{"buffer", 0},
                                 {"byteOffset", 0},
                                 {"byteLength", positions_.size()},
                                 {"byteStride", 12},
                                 {"target", array_buffer}},  // several share it
                                {{"buffer", 0},
                                 {"byteOffset", positions_.size()},
                                 {"byteLength", indices_.size()},
                                 {"target", element_array_buffer}}};
    document_["buffers"] =
        ordered_json::array({{{"byteLength", positions_.size() + indices_.size()}}});
  }

  const Scene& scene_;
  const Pieces& pieces_;
  ordered_json document_;
  std::string positions_, indices_;  // the two halves of the buffer
  VertexPool pool_;                  // of the present object
  std::vector<std::uint32_t> fan_;
};

}  // namespace

void write_gltf(const std::string& path, const Scene& scene, const Pieces& pieces, bool binary) {
  if (pieces.pieces.empty()) throw Error(path + ": there are no fragments to write");
  Writer writer(scene, pieces);
  std::string bytes;
  try {
    writer.build();
    bytes = binary ? writer.binary() : writer.json_with_data();
  } catch (const Error& error) {
    throw Error(path + ": " + error.what());
  }
  write_text(path, bytes);
}

}  // namespace shadowcut::io
