// Chooses the reader for a file, and words for its issues.
#include <filesystem>

#include "files.hpp"
#include "readers.hpp"

namespace shadowcut::io {

namespace {

Scene read_by_extension(const std::string& path, const ReadOptions& options) {
  const std::string extension = extension_of(path);
  if (extension == ".obj") return read_obj(read_bytes(path), path, options);
  if (extension == ".ply") return read_ply(read_bytes(path), path, options);
  if (extension == ".off") return read_off(read_bytes(path), path, options);
  if (extension == ".stl") return read_stl(read_bytes(path), path, options);
  return read_with_assimp(path, options);
}

}  // namespace

std::string stem_of(const std::string& path) {
  const std::string stem = std::filesystem::path(path).stem().string();
  return stem.empty() ? "default" : stem;
}

Scene empty_scene(const ReadOptions& options) {
  Scene scene;
  scene.coplanarity_tolerance = options.coplanarity_tolerance;
  return scene;
}

Scene read_scene(const std::string& path, const ReadOptions& options) {
  Scene scene = read_by_extension(path, options);
  if (scene.faces().empty()) throw Error(path + ": the file has no faces");
  return scene;
}

std::string describe(const Scene& scene, const Issue& issue, const std::string& file) {
  std::string line = file + ": object '" + scene.objects()[issue.object].name + "': face " +
                     std::to_string(issue.face) +
                     (issue.is_refusal() ? " refused: " : " repaired: ") + issue.text();
  if (!issue.detail.empty()) line += " (" + issue.detail + ")";
  return line;
}

}  // namespace shadowcut::io
