// The command cast: scene and lights in, fragments and figures out.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "commands.hpp"
#include "report.hpp"
#include "specs.hpp"

namespace shadowcut::cli {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t most_issues = 20;

struct NamedLight {
  Light light;
  std::string spec;  // as given
};

std::string extension_of(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return extension;
}

void check_folder(const std::string& path) {
  const fs::path folder = fs::absolute(path).parent_path();
  std::error_code error;
  if (path.empty() || !fs::is_directory(folder, error)) throw Error(path + ": cannot be written: there is no folder " + folder.string());
}

// What can be known to fail before the work is done shall fail before the work is done.
void check_outputs(const CastArguments& a) {
  std::size_t drawings = 0;
  for (const std::string& path : a.outputs) {
    const std::string extension = extension_of(path);
    if (extension == ".svg") ++drawings;
    else if (extension != ".obj" && extension != ".ply" && extension != ".gltf" && extension != ".glb")
      throw Error("-o: '" + path + "' ends in none of .obj .ply .gltf .glb .svg");
    check_folder(path);
  }
  if (!a.areas.empty()) check_folder(a.areas);
  if (!a.json.empty() && a.json != "-") check_folder(a.json);
  if (!a.drawings.empty() && drawings == 0) throw Error("--svg: no output ends in .svg");
  if (a.drawings.size() > 1 && a.drawings.size() != drawings) throw Error("--svg: give one for all drawings, or one for each");
}

std::vector<NamedLight> given_lights(const CastArguments& a) {
  std::vector<NamedLight> lights;
  for (const std::string& spec : a.lights) lights.push_back({parse_light(spec), spec});
  return lights;
}

std::vector<NamedLight> lights_of(const Scene& scene, const CastArguments& a) {
  std::vector<NamedLight> lights;
  for (const Light& light : scene.lights()) lights.push_back({light, light_spec(light)});
  if (lights.empty()) throw Error(a.scene + ": the scene has no light of its own, and there is no --light");
  return lights;
}

Scene read(const CastArguments& a) {
  io::ReadOptions options;
  options.sides = a.sides;
  Scene scene = io::read_scene(a.scene, options);
  if (a.strict && !scene.issues().empty()) {
    list_issues(scene, a.scene, most_issues);
    throw Error(a.scene + ": " + std::to_string(scene.issues().size()) + " faces refused or repaired, and --strict allows none");
  }
  if (!a.quiet) list_issues(scene, a.scene, most_issues);
  if (scene.facets().empty()) throw Error(a.scene + ": no usable face: see inspect");
  return scene;
}

Engine build(const Scene& scene, const CastArguments& a, ProgressBar& bar) {
  Options options = a.options;
  options.edits = false;
  options.progress = [&](double share) { bar.show(share); };
  Engine engine(scene, options);
  engine.update();
  return engine;
}

ordered_json summary_of(const Engine& engine, std::size_t k, const NamedLight& light) {
  const Stats& s = engine.shadows(k).stats;
  ordered_json entry{{"light", light.spec},
                     {"faces", s.faces},
                     {"facing_faces", s.facing_faces},
                     {"facing_area", s.facing_area},
                     {"lit_area", s.lit_area},
                     {"shadowed_area", s.shadowed_area},
                     {"lit_fragments", s.lit_fragments},
                     {"shadowed_fragments", s.shadowed_fragments},
                     {"tree_nodes", s.nodes},
                     {"tree_depth", s.depth},
                     {"build_ms", s.build_ms},
                     {"emit_ms", s.emit_ms}};
  if (!light.light.name.empty()) entry["name"] = light.light.name;
  entry["stats"] = {{"facets", s.facets},         {"cells", s.cells},   {"sp_nodes", s.sp_nodes},
                    {"pp_nodes", s.pp_nodes},     {"pieces", s.pieces}, {"crossing_lines", s.crossing_lines},
                    {"predicates", s.predicates}, {"on", s.on},         {"bytes", s.bytes}};
  return entry;
}

std::string summary(const Engine& engine, const std::vector<NamedLight>& lights, const CastArguments& a, double load_ms) {
  ordered_json document{
      {"scene", a.scene}, {"kernel", "fast"}, {"threads", a.options.threads}, {"load_ms", load_ms}, {"lights", ordered_json::array()}};
  for (std::size_t k = 0; k < lights.size(); ++k) document["lights"].push_back(summary_of(engine, k, lights[k]));
  return document.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string table(const Scene& scene, const Engine& engine, const std::vector<NamedLight>& lights, const CastArguments& a, double load_ms) {
  Table table({"light", "facing area", "lit area", "shadowed area", "lit", "shadowed", "nodes", "depth", "build ms", "emit ms"});
  for (std::size_t k = 0; k < lights.size(); ++k) {
    const Stats& s = engine.shadows(k).stats;
    table.add({lights[k].spec, significant(s.facing_area), significant(s.lit_area), significant(s.shadowed_area),
               std::to_string(s.lit_fragments), std::to_string(s.shadowed_fragments), std::to_string(s.nodes), std::to_string(s.depth),
               tenths(s.build_ms), tenths(s.emit_ms)});
  }
  return a.scene + ": " + std::to_string(scene.objects().size()) + " objects, " + std::to_string(scene.faces().size()) + " faces, " +
         std::to_string(scene.facets().size()) + " facets, read in " + tenths(load_ms) + " ms; " + std::to_string(a.options.threads) +
         (a.options.threads == 1 ? " thread\n" : " threads\n") + table.text();
}

// The drawing for each output; those that are no drawings take none.
std::vector<io::View> views_of(const Scene& scene, const std::vector<NamedLight>& lights, const CastArguments& a) {
  std::vector<io::View> views;
  std::size_t drawing = 0;
  for (const std::string& path : a.outputs) {
    io::View view;
    if (extension_of(path) == ".svg" && !a.drawings.empty()) {
      view = parse_view(a.drawings.size() == 1 ? a.drawings.front() : a.drawings[drawing], scene);
      ++drawing;
    }
    view.up = parse_axis(a.up);
    view.threads = a.options.threads;
    for (const NamedLight& light : lights) view.lights.push_back(light.light);
    views.push_back(std::move(view));
  }
  return views;
}

// Writes one after the other; when one fails, those before it go too.
class Outputs {
 public:
  template <typename Write>
  void write(const std::string& path, const Write& write) {
    try {
      write();
    } catch (...) {
      for (const std::string& written : written_) remove(written);
      throw;
    }
    written_.push_back(path);
    if (extension_of(path) == ".obj") written_.push_back(fs::path(path).replace_extension(".mtl").string());
  }

 private:
  static void remove(const std::string& path) {
    std::error_code error;
    if (fs::is_regular_file(path, error)) fs::remove(path, error);
  }
  std::vector<std::string> written_;
};

}  // namespace

void cast(const CastArguments& arguments) {
  CastArguments a = arguments;
  if (a.options.threads == 0) a.options.threads = std::max(1u, std::thread::hardware_concurrency());
  check_outputs(a);
  std::vector<NamedLight> lights = given_lights(a);

  const Clock::time_point start = Clock::now();
  Scene scene = read(a);
  const double load_ms = milliseconds_since(start);
  if (lights.empty()) lights = lights_of(scene, a);
  const std::vector<io::View> views = views_of(scene, lights, a);
  std::vector<Light> plain;
  for (const NamedLight& light : lights) plain.push_back(light.light);
  scene.replace_lights(plain);
  ProgressBar bar(!a.quiet);
  const Engine engine = build(scene, a, bar);

  Outputs outputs;
  for (std::size_t i = 0; i < a.outputs.size(); ++i)
    outputs.write(a.outputs[i], [&] { io::write_fragments(a.outputs[i], scene, engine, views[i]); });
  if (!a.areas.empty()) outputs.write(a.areas, [&] { io::write_areas(a.areas, scene, engine); });
  if (!a.json.empty()) outputs.write(a.json, [&] { io::write_text(a.json, summary(engine, lights, a, load_ms)); });
  if (!a.quiet && a.json != "-") outputs.write("-", [&] { io::write_text("-", table(scene, engine, lights, a, load_ms)); });
}

}  // namespace shadowcut::cli
