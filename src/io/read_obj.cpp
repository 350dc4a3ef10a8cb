// OBJ by tinyobjloader's callbacks, with two precautions.
//
// Its number parser is not used: it adds up digits times powers of a tenth and scales by powers of
// five, both rounded, and of 3000 decimals of 12 to 25 digits it got more than half wrong by an ulp
// or more. Its indices go through atoi, which turns an index of many digits into a small, valid
// one. So the text is gone over once before: coordinates are read here and replaced by zeros,
// indices are checked and replaced by 0, which is no vertex, where they are not integers. What is
// left for tinyobjloader is the grammar: faces, objects, groups, relative indices.
//
// An object of the scene is a pair of an OBJ's object and group. Both are kept in its name, as
// "object/group". An `o` line ends the group before it.
#include <tiny_obj_loader.h>

#include <limits>
#include <map>
#include <streambuf>

#include "readers.hpp"
#include "text.hpp"

namespace shadowcut::io {

namespace {

// Reads a string in place; std::istringstream would copy it.
struct TextBuffer : std::streambuf {
  explicit TextBuffer(std::string& text) {
    setg(text.data(), text.data(), text.data() + text.size());
  }
};

// The text without what is not needed, and the vertices' coordinates.
struct Prepared {
  std::string text;
  std::vector<Vec3> positions;
};

void append_corner(std::string_view word, std::string& out) {
  const std::string_view index = word.substr(0, word.find('/'));
  const std::optional<std::int64_t> value = integer_of(index);
  const bool fits = value && *value > -1'000'000'000 && *value < 1'000'000'000;
  out.append(" ").append(fits ? index : std::string_view("0"));
}

void prepare_line(std::string_view line, Prepared& out) {
  const std::string_view keyword = take_word(line);
  if (keyword == "v") {
    Vec3 p;
    for (int i = 0; i < 3; ++i) p[i] = number_of(take_word(line));
    out.positions.push_back(p);
    out.text += "v 0 0 0\n";
  } else if (keyword == "f") {
    out.text += 'f';
    std::string_view word = take_word(line);
    // tinyobjloader would skip a face without corners; this way it is refused, and counted
    if (word.empty()) out.text += " 1";
    for (; !word.empty(); word = take_word(line)) append_corner(word, out.text);
    out.text += '\n';
  } else if (keyword == "o" || keyword == "g") {
    out.text.append(keyword).append(" ").append(trimmed(line)).append("\n");
  }
}

Prepared prepare(std::string_view text) {
  Prepared out;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  std::string joined;  // of lines that end in a backslash
  while (!text.empty()) {
    const std::string_view line = take_line(text);
    if (line.ends_with('\\')) {
      joined.append(line.substr(0, line.size() - 1)).append(" ");
    } else if (joined.empty()) {
      prepare_line(line, out);
    } else {
      prepare_line(joined.append(line), out);
      joined.clear();
    }
  }
  prepare_line(joined, out);
  return out;
}

class Collector {
 public:
  explicit Collector(std::vector<Vec3> positions)
      : positions_(std::move(positions)), slots_(positions_.size()) {}

  static tinyobj::callback_t callbacks() {
    tinyobj::callback_t call;
    static_assert(sizeof(tinyobj::real_t) == sizeof(double));
    call.vertex_cb = [](void* p, tinyobj::real_t, tinyobj::real_t, tinyobj::real_t,
                        tinyobj::real_t) { ++static_cast<Collector*>(p)->seen_; };
    call.object_cb = [](void* p, const char* name) {
      static_cast<Collector*>(p)->start_object(name);
    };
    call.group_cb = [](void* p, const char** names, int count) {
      static_cast<Collector*>(p)->start_group(names, count);
    };
    call.index_cb = [](void* p, tinyobj::index_t* indices, int count) {
      static_cast<Collector*>(p)->add_face(indices, count);
    };
    return call;
  }

  Scene scene(const ReadOptions& options) const {
    Scene scene = empty_scene(options);
    for (const Part& part : parts_) {
      ObjectSettings settings;
      settings.name = part.name;
      settings.sides = options.sides;
      scene.add(part.mesh, settings);
    }
    return scene;
  }

 private:
  struct Part {
    std::string name;
    Mesh mesh;
  };
  struct Slot {  // where a vertex stands in the mesh of the part that used it last
    std::uint32_t part = invalid_index, index = 0;
  };

  void start_object(const char* name) {
    object_ = trimmed(name);
    group_.clear();
    current_ = invalid_index;
  }

  void start_group(const char** names, int count) {
    group_.clear();
    for (int i = 0; i < count; ++i) group_.append(i == 0 ? "" : " ").append(names[i]);
    current_ = invalid_index;
  }

  std::uint32_t part() {
    if (current_ != invalid_index) return current_;
    const auto [place, is_new] =
        by_name_.try_emplace({object_, group_}, static_cast<std::uint32_t>(parts_.size()));
    if (is_new) {
      const std::string name = object_ + (object_.empty() || group_.empty() ? "" : "/") + group_;
      parts_.push_back({name.empty() ? "default" : name, {}});
    }
    return current_ = place->second;
  }

  void add_face(const tinyobj::index_t* indices, int count) {
    const std::uint32_t p = part();
    loop_.clear();
    for (int i = 0; i < count; ++i) loop_.push_back(local_index(p, indices[i].vertex_index));
    parts_[p].mesh.add_face(loop_);
  }

  std::uint32_t local_index(std::uint32_t p, std::int64_t index) {
    const std::int64_t global = index > 0 ? index - 1 : index < 0 ? seen_ + index : -1;
    if (global < 0 || global >= static_cast<std::int64_t>(slots_.size())) return bad_index;
    Slot& slot = slots_[static_cast<std::size_t>(global)];
    if (slot.part != p) {
      slot = {p, static_cast<std::uint32_t>(parts_[p].mesh.vertices.size())};
      parts_[p].mesh.vertices.push_back(positions_[static_cast<std::size_t>(global)]);
    }
    return slot.index;
  }

  std::vector<Vec3> positions_;
  std::vector<Slot> slots_;
  std::int64_t seen_ = 0;  // vertices so far: relative indices count from here
  std::string object_, group_;
  std::map<std::pair<std::string, std::string>, std::uint32_t> by_name_;
  std::vector<Part> parts_;
  std::uint32_t current_ = invalid_index;
  std::vector<std::uint32_t> loop_;
};

}  // namespace

Scene read_obj(std::string_view text, const std::string& name, const ReadOptions& options) {
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
    throw Error(name + ": the file is UTF-16; OBJ files must be ASCII or UTF-8");
  Prepared prepared = prepare(text);
  if (prepared.positions.size() >= invalid_index) throw Error(name + ": too many vertices");
  Collector collector(std::move(prepared.positions));
  TextBuffer buffer(prepared.text);
  std::istream in(&buffer);
  std::string warnings, errors;
  if (!tinyobj::LoadObjWithCallback(in, Collector::callbacks(), &collector, nullptr, &warnings,
                                    &errors))
    throw Error(name + ": " + std::string(trimmed(errors)));
  return collector.scene(options);
}

}  // namespace shadowcut::io
