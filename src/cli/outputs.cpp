// Output files; see outputs.hpp.
#include "outputs.hpp"

#include <filesystem>
#include <shadowcut/scene.hpp>

#include "io/files.hpp"

namespace shadowcut::cli {

namespace fs = std::filesystem;

namespace {

void remove(const std::string& path) {
  std::error_code error;
  if (fs::is_regular_file(path, error)) fs::remove(path, error);
}

}  // namespace

void check_folder(const std::string& path) {
  const fs::path folder = fs::absolute(path).parent_path();
  std::error_code error;
  if (path.empty() || !fs::is_directory(folder, error))
    throw Error(path + ": cannot be written: the folder " + folder.string() + " does not exist");
}

void Outputs::write(const std::string& path, const std::function<void()>& write) {
  try {
    write();
  } catch (...) {
    for (const std::string& written : written_) remove(written);
    throw;
  }
  written_.push_back(path);
  if (io::extension_of(path) == ".obj")
    written_.push_back(fs::path(path).replace_extension(".mtl").string());
}

}  // namespace shadowcut::cli
