// PLY, ascii and binary in both byte orders, with the types of the file: a double stays a double.
// (OpenMesh's reader was the first choice, but it passes every coordinate through a float, whatever
// its importer asks for.) Elements and properties other than the vertices' x y z and the faces'
// vertex_indices are stepped over.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "readers.hpp"
#include "text.hpp"

namespace shadowcut::io {

namespace {

enum class Type : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

struct Property {
  std::string name;
  Type type;
  std::optional<Type> count_type;  // of a list
};

struct Element {
  std::string name;
  std::uint64_t count;
  std::vector<Property> properties;
};

struct Header {
  enum class Format { ascii, little, big } format;
  std::vector<Element> elements;
};

std::optional<Type> type_of(std::string_view word) {
  struct Entry {
    std::string_view name, alias;
    Type type;
  };
  static constexpr std::array<Entry, 8> entries{{{"char", "int8", Type::i8},
                                                 {"uchar", "uint8", Type::u8},
                                                 {"short", "int16", Type::i16},
                                                 {"ushort", "uint16", Type::u16},
                                                 {"int", "int32", Type::i32},
                                                 {"uint", "uint32", Type::u32},
                                                 {"float", "float32", Type::f32},
                                                 {"double", "float64", Type::f64}}};
  for (const Entry& entry : entries)
    if (word == entry.name || word == entry.alias) return entry.type;
  return std::nullopt;
}

std::size_t size_of(Type type) {
  switch (type) {
    case Type::i8:
    case Type::u8:
      return 1;
    case Type::i16:
    case Type::u16:
      return 2;
    case Type::i32:
    case Type::u32:
    case Type::f32:
      return 4;
    case Type::f64:
      return 8;
  }
  return 0;
}

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& name) : rest_(bytes), name_(name) {}

  Mesh read() {
    const Header header = read_header();
    format_ = header.format;
    for (const Element& element : header.elements) {
      if (element.name == "vertex") read_vertices(element);
      else read_others(element);
    }
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw Error(name_ + ": " + what); }

  Header read_header() {
    if (trimmed(take_line(rest_)) != "ply") fail("not a PLY file");
    Header header{Header::Format::ascii, {}};
    bool has_format = false;
    while (true) {
      if (rest_.empty()) fail("the PLY header has no end_header");
      std::string_view line = take_line(rest_);
      const std::string_view keyword = take_word(line);
      if (keyword == "end_header") break;
      if (keyword == "format") {
        header.format = read_format(take_word(line));
        has_format = true;
      } else if (keyword == "element") {
        header.elements.push_back(read_element(line));
      } else if (keyword == "property") {
        if (header.elements.empty()) fail("the PLY header has a property before its first element");
        header.elements.back().properties.push_back(read_property(line));
      }
    }
    if (!has_format) fail("the PLY header has no format");
    return header;
  }

  Header::Format read_format(std::string_view word) const {
    if (word == "ascii") return Header::Format::ascii;
    if (word == "binary_little_endian") return Header::Format::little;
    if (word == "binary_big_endian") return Header::Format::big;
    fail("unknown PLY format '" + printable(word) + "'");
  }

  Element read_element(std::string_view line) const {
    const std::string_view name = take_word(line);
    const std::optional<std::int64_t> count = integer_of(take_word(line));
    if (!count || *count < 0) fail("the PLY element '" + printable(name) + "' has no count");
    return {std::string(name), static_cast<std::uint64_t>(*count), {}};
  }

  Property read_property(std::string_view line) const {
    std::string_view word = take_word(line);
    std::optional<Type> count_type;
    if (word == "list") {
      count_type = type_of(take_word(line));
      word = take_word(line);
      if (!count_type) fail("a PLY list has no type for its length");
    }
    const std::optional<Type> type = type_of(word);
    if (!type) fail("unknown PLY type '" + printable(word) + "'");
    return {std::string(take_word(line)), *type, count_type};
  }

  double read_value(Type type) {
    if (format_ == Header::Format::ascii) {
      const std::string_view word = take_word(rest_);
      if (word.empty()) fail("the file ends too early");
      return number_of(word);
    }
    return read_binary(type);
  }

  double read_binary(Type type) {
    const std::size_t size = size_of(type);
    if (rest_.size() < size) fail("the file ends too early");
    std::array<char, 8> raw{};
    std::copy_n(rest_.begin(), size, raw.begin());
    rest_.remove_prefix(size);
    const bool swap = (format_ == Header::Format::big) != (std::endian::native == std::endian::big);
    if (swap) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
    switch (type) {
      case Type::i8:
        return as<std::int8_t>(raw);
      case Type::u8:
        return as<std::uint8_t>(raw);
      case Type::i16:
        return as<std::int16_t>(raw);
      case Type::u16:
        return as<std::uint16_t>(raw);
      case Type::i32:
        return as<std::int32_t>(raw);
      case Type::u32:
        return as<std::uint32_t>(raw);
      case Type::f32:
        return as<float>(raw);
      case Type::f64:
        return as<double>(raw);
    }
    return 0;
  }

  template <typename T>
  static double as(const std::array<char, 8>& raw) {
    T value;
    std::memcpy(&value, raw.data(), sizeof value);
    return static_cast<double>(value);
  }

  std::uint64_t read_length(Type type) {
    const double length = read_value(type);
    if (!(length >= 0) || length != std::floor(length) || length > 4294967295.0)
      fail("a PLY list has an invalid length");
    return static_cast<std::uint64_t>(length);
  }

  void skip(const Property& property) {
    const std::uint64_t count = property.count_type ? read_length(*property.count_type) : 1;
    for (std::uint64_t i = 0; i < count; ++i) read_value(property.type);
  }

  void read_vertices(const Element& element) {
    const std::array<std::string_view, 3> axes{"x", "y", "z"};
    for (const std::string_view axis : axes)
      if (std::none_of(element.properties.begin(), element.properties.end(),
                       [&](const Property& p) { return p.name == axis; }))
        fail("the PLY vertices have no " + std::string(axis));
    for (std::uint64_t i = 0; i < element.count; ++i) {
      Vec3 position;
      for (const Property& property : element.properties) {
        const auto axis = std::find(axes.begin(), axes.end(), property.name) - axes.begin();
        if (axis < 3 && !property.count_type) position[axis] = read_value(property.type);
        else skip(property);
      }
      mesh_.vertices.push_back(position);
    }
  }

  void read_others(const Element& element) {
    if (element.properties.empty()) return;
    for (std::uint64_t i = 0; i < element.count; ++i) {
      for (const Property& property : element.properties) {
        const bool corners = property.count_type &&
                             (property.name == "vertex_indices" || property.name == "vertex_index");
        if (element.name == "face" && corners) read_loop(property);
        else skip(property);
      }
    }
  }

  void read_loop(const Property& property) {
    loop_.clear();
    const std::uint64_t count = read_length(*property.count_type);
    for (std::uint64_t i = 0; i < count; ++i) {
      const double index = read_value(property.type);
      const bool proper = index >= 0 && index < invalid_index && index == std::floor(index);
      loop_.push_back(proper ? static_cast<std::uint32_t>(index) : bad_index);
    }
    mesh_.add_face(loop_);
  }

  std::string_view rest_;
  const std::string& name_;
  Header::Format format_ = Header::Format::ascii;
  Mesh mesh_;
  std::vector<std::uint32_t> loop_;
};

}  // namespace

Scene read_ply(std::string_view bytes, const std::string& name, const ReadOptions& options) {
  ObjectSettings settings;
  settings.name = stem_of(name);
  settings.sides = options.sides;
  const Mesh mesh = Reader(bytes, name).read();
  Scene scene = empty_scene(options);
  if (mesh.face_count() > 0) scene.add(mesh, settings);
  return scene;
}

}  // namespace shadowcut::io
