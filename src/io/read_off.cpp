// OFF as text: OFF, COFF, NOFF, STOFF and their combinations. Every vertex and every face has a
// line of its own; what follows a vertex's three coordinates or a face's corners (normals, colours,
// texture coordinates) is stepped over. (OpenMesh's reader passes coordinates through a float.)
#include "readers.hpp"
#include "text.hpp"

namespace shadowcut::io {

namespace {

class Reader {
 public:
  Reader(std::string_view text, const std::string& name) : rest_(text), name_(name) {}

  Mesh read() {
    std::string_view line = read_header();
    if (trimmed(line).empty()) line = next_line();
    const std::uint64_t vertices = read_count(line), faces = read_count(line);
    for (std::uint64_t i = 0; i < vertices; ++i) read_vertex();
    for (std::uint64_t i = 0; i < faces; ++i) read_face();
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw Error(name_ + ": " + what); }

  // What is left of the line of the keyword: the counts may stand on it.
  std::string_view read_header() {
    std::string_view line = next_line();
    const std::string_view whole = line, keyword = take_word(line);
    if (integer_of(keyword)) return whole;  // the keyword may be missing
    if (!keyword.ends_with("OFF")) fail("not an OFF file");
    if (keyword.find_first_of("4n") != std::string_view::npos)
      fail("only OFF files with three dimensions are supported");
    if (trimmed(line).starts_with("BINARY")) fail("binary OFF files are not supported");
    return line;
  }

  std::string_view next_line() {
    while (!rest_.empty()) {
      std::string_view line = take_line(rest_);
      line = trimmed(line.substr(0, line.find('#')));
      if (!line.empty()) return line;
    }
    fail("the file ends too early");
  }

  std::uint64_t read_count(std::string_view& line) const {
    const std::optional<std::int64_t> count = integer_of(take_word(line));
    if (!count || *count < 0) fail("the OFF header has no counts of vertices and faces");
    return static_cast<std::uint64_t>(*count);
  }

  void read_vertex() {
    std::string_view line = next_line();
    Vec3 position;
    for (int i = 0; i < 3; ++i) position[i] = number_of(take_word(line));
    mesh_.vertices.push_back(position);
  }

  void read_face() {
    std::string_view line = next_line();
    const std::uint64_t count = read_count(line);
    loop_.clear();
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::string_view word = take_word(line);
      if (word.empty())
        fail("face " + std::to_string(mesh_.face_count()) +
             " has fewer corners than its count says");
      const std::optional<std::int64_t> index = integer_of(word);
      loop_.push_back(index && *index >= 0 && *index < invalid_index
                          ? static_cast<std::uint32_t>(*index)
                          : bad_index);
    }
    mesh_.add_face(loop_);
  }

  std::string_view rest_;
  const std::string& name_;
  Mesh mesh_;
  std::vector<std::uint32_t> loop_;
};

}  // namespace

Scene read_off(std::string_view text, const std::string& name, const ReadOptions& options) {
  ObjectSettings settings;
  settings.name = stem_of(name);
  settings.sides = options.sides;
  const Mesh mesh = Reader(text, name).read();
  Scene scene = empty_scene(options);
  if (mesh.face_count() > 0) scene.add(mesh, settings);
  return scene;
}

}  // namespace shadowcut::io
