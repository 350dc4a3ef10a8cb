// Changes as JSON lines; see changes.hpp. The text is appended directly, without a JSON document,
// because the first line holds every fragment of the scene.
#include "changes.hpp"

#include <nlohmann/json.hpp>

#include "io/text.hpp"

namespace shadowcut::cli {

namespace {

void append(std::string& text, std::uint32_t value) { io::append(text, std::uint64_t{value}); }

void append(std::string& text, const FragmentId& id) {
  append(text += '[', id.cell);
  append(text += ',', id.piece);
  append(text += ',', id.place);
  text += ']';
}

// Calls `write` for each element, with commas between.
template <typename List, typename Write>
void append_list(std::string& text, const List& list, const Write& write) {
  text += '[';
  bool first = true;
  for (const auto& element : list) {
    if (!first) text += ',';
    first = false;
    write(element);
  }
  text += ']';
}

void append_key(std::string& text, const char* key) {
  text.append(",\"").append(key).append("\":");
}

}  // namespace

void ChangesFile::write(std::size_t update, const Engine& engine, const Changes& changes) {
  for (const LightChanges& light : changes.lights) {
    append_line(update, engine, light);
    file_.write(text_);
    text_.clear();
  }
}

void ChangesFile::append_line(std::size_t update, const Engine& engine,
                              const LightChanges& changes) {
  io::append(text_ += "{\"update\":", std::uint64_t{update});
  append_key(text_, "light"), append(text_, changes.light);
  append_key(text_, "rebuilt"), text_ += changes.rebuilt ? "true" : "false";
  append_key(text_, "removed"), text_ += changes.removed ? "true" : "false";
  append_key(text_, "gone");
  append_list(text_, changes.gone, [this](const FragmentId& id) { append(text_, id); });
  append_key(text_, "added");
  append_added(engine, changes);
  append_key(text_, "areas");
  append_list(text_, changes.areas, [this](const LightChanges::Area& a) {
    append(text_ += "{\"face\":", a.face);
    append_key(text_, "lit"), io::append(text_, a.area.lit);
    append_key(text_, "shadowed"), io::append(text_, a.area.shadowed);
    append_key(text_, "area"), io::append(text_, a.area.area);
    text_ += '}';
  });
  text_ += "}\n";
}

void ChangesFile::append_added(const Engine& engine, const LightChanges& changes) {
  const Scene& scene = engine.scene();
  append_list(text_, changes.added, [&](const LightChanges::Added& added) {
    const Block& block = engine.shadows(changes.light).blocks[added.id.cell];
    const Fragment& fragment = block.fragments[added.index];
    const Face& face = scene.faces()[fragment.face];
    append(text_ += "{\"id\":", added.id);
    append_key(text_, "face"), append(text_, fragment.face);
    append_key(text_, "object"),
        text_ += nlohmann::json(io::printable(scene.objects()[face.object].name)).dump();
    append_key(text_, "number"), append(text_, face.number);
    append_key(text_, "lit"), text_ += fragment.lit ? "true" : "false";
    append_key(text_, "caster");
    if (fragment.caster == invalid_index) text_ += "null";
    else append(text_, fragment.caster);
    append_key(text_, "corners");
    append_list(text_, block.corners_of(fragment), [this](const Vec3& corner) {
      append_list(text_, corner, [this](double x) { io::append(text_, x); });
    });
    text_ += '}';
  });
}

}  // namespace shadowcut::cli
