// STL, text and binary. A text file's solids become objects. Equal corners are welded by
// Scene::add, and degenerate facets reported by it. (OpenMesh's reader rounds a text file's numbers
// to float and leaves degenerate facets out without a word.)
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>

#include "readers.hpp"
#include "text.hpp"

namespace shadowcut::io {

namespace {

constexpr std::size_t header_size = 80, facet_size = 50;

struct Solid {
  std::string name;
  Mesh mesh;
};

template <typename T>
T little_endian(std::string_view bytes) {
  std::array<char, sizeof(T)> raw{};
  std::copy_n(bytes.begin(), raw.size(), raw.begin());
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

// A binary file may begin with "solid" too; its length tells.
bool is_binary(std::string_view bytes) {
  if (bytes.size() < header_size + 4) return false;
  const std::uint64_t facets = little_endian<std::uint32_t>(bytes.substr(header_size));
  if (bytes.size() == header_size + 4 + facets * facet_size) return true;
  return !trimmed(bytes.substr(0, header_size)).starts_with("solid");
}

Solid read_binary(std::string_view bytes, const std::string& name) {
  const std::uint64_t facets = little_endian<std::uint32_t>(bytes.substr(header_size));
  bytes.remove_prefix(header_size + 4);
  if (bytes.size() / facet_size < facets) throw Error(name + ": the file ends too early");
  Solid solid{stem_of(name), {}};
  for (std::uint64_t i = 0; i < facets; ++i) {
    std::array<std::uint32_t, 3> loop;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      Vec3 p;
      for (std::size_t axis = 0; axis < 3; ++axis)  // past the normal
        p[static_cast<Eigen::Index>(axis)] =
            little_endian<float>(bytes.substr(i * facet_size + 12 + corner * 12 + axis * 4, 4));
      loop[corner] = static_cast<std::uint32_t>(solid.mesh.vertices.size());
      solid.mesh.vertices.push_back(p);
    }
    solid.mesh.add_face(loop);
  }
  return solid;
}

std::string lower(std::string_view word) {
  std::string text(word);
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::vector<Solid> read_text(std::string_view text, const std::string& name) {
  std::vector<Solid> solids;
  std::vector<std::uint32_t> loop;
  while (!text.empty()) {
    std::string_view line = take_line(text);
    const std::string keyword = lower(take_word(line));
    if (keyword == "solid") {
      const std::string_view given = trimmed(line);
      solids.push_back({given.empty() ? stem_of(name) : std::string(given), {}});
      continue;
    }
    if (keyword.empty()) continue;
    if (solids.empty()) throw Error(name + ": not an STL file");
    Mesh& mesh = solids.back().mesh;
    if (keyword == "outer") loop.clear();
    if (keyword == "vertex") {
      Vec3 p;
      for (int i = 0; i < 3; ++i) p[i] = number_of(take_word(line));
      loop.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
      mesh.vertices.push_back(p);
    }
    if (keyword == "endloop") mesh.add_face(loop);
  }
  return solids;
}

}  // namespace

Scene read_stl(std::string_view bytes, const std::string& name, const ReadOptions& options) {
  std::vector<Solid> solids;
  if (is_binary(bytes)) solids.push_back(read_binary(bytes, name));
  else solids = read_text(bytes, name);
  Scene scene = empty_scene(options);
  for (const Solid& solid : solids) {
    ObjectSettings settings;
    settings.name = solid.name;
    settings.sides = options.sides;
    if (solid.mesh.face_count() > 0) scene.add(solid.mesh, settings);
  }
  return scene;
}

}  // namespace shadowcut::io
