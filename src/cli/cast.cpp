// The command cast: reads a scene, casts its shadows, writes fragments, areas and statistics.
#include <nlohmann/json.hpp>
#include <numeric>

#include "commands.hpp"
#include "inputs.hpp"
#include "io/files.hpp"
#include "outputs.hpp"
#include "report.hpp"
#include "specs.hpp"

namespace shadowcut::cli {

namespace {

using nlohmann::ordered_json;

void check_outputs(const CastArguments& a) {
  std::size_t drawings = 0;
  for (const std::string& path : a.outputs) {
    const std::string extension = io::extension_of(path);
    if (extension == ".svg") ++drawings;
    else if (extension != ".obj" && extension != ".ply" && extension != ".gltf" &&
             extension != ".glb")
      throw Error("-o: '" + path + "': the extension is not one of .obj .ply .gltf .glb .svg");
    check_folder(path);
  }
  if (!a.areas.empty()) check_folder(a.areas);
  if (!a.json.empty() && a.json != "-") check_folder(a.json);
  if (!a.drawings.empty() && drawings == 0)
    throw Error("--svg: there is no output with the extension .svg");
  if (a.drawings.size() > 1 && a.drawings.size() != drawings)
    throw Error("--svg: give one view for all drawings, or one view for each drawing");
}

Engine build(const Scene& scene, const CastArguments& a, ProgressBar& bar) {
  Options options = a.options;
  options.tuning.incremental = false;
  options.progress = [&](double share) { bar.show(share); };
  Engine engine(scene, options);
  engine.update();
  return engine;
}

ordered_json summary_of(const Engine& engine, std::size_t k, const NamedLight& light) {
  const Stats& s = engine.shadows(k).stats;
  const std::vector<double> uncertain = engine.uncertain_area(k);
  ordered_json entry{{"light", light.spec},
                     {"faces", s.faces},
                     {"facing_faces", s.facing_faces},
                     {"facing_area", s.facing_area},
                     {"lit_area", s.lit_area},
                     {"shadowed_area", s.shadowed_area},
                     {"dropped_area", s.dropped_area},
                     {"undecided_area", std::accumulate(uncertain.begin(), uncertain.end(), 0.0)},
                     {"lit_fragments", s.lit_fragments},
                     {"shadowed_fragments", s.shadowed_fragments},
                     {"tree_nodes", s.nodes},
                     {"tree_depth", s.depth},
                     {"build_ms", s.build_ms},
                     {"emit_ms", s.emit_ms},
                     {"predicates", s.predicates},
                     {"by_identity", s.by_identity},
                     {"by_filter", s.by_filter},
                     {"by_exact", s.by_exact}};
  if (!light.light.name.empty()) entry["name"] = light.light.name;
  entry["stats"] = {
      {"facets", s.facets},         {"cells", s.cells},   {"sp_nodes", s.sp_nodes},
      {"pp_nodes", s.pp_nodes},     {"pieces", s.pieces}, {"crossing_lines", s.crossing_lines},
      {"predicates", s.predicates}, {"on", s.on},         {"bytes", s.bytes}};
  return entry;
}

std::string summary(const Engine& engine, const std::vector<NamedLight>& lights,
                    const CastArguments& a, double load_ms) {
  ordered_json document{{"scene", a.scene},
                        {"kernel", kernel_name(a.options.kernel)},
                        {"threads", a.options.threads},
                        {"load_ms", load_ms},
                        {"aligned", alignment_of(engine.scene()).facets},
                        {"lights", ordered_json::array()}};
  for (std::size_t k = 0; k < lights.size(); ++k)
    document["lights"].push_back(summary_of(engine, k, lights[k]));
  return document.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string table(const Scene& scene, const Engine& engine, const std::vector<NamedLight>& lights,
                  const CastArguments& a, double load_ms) {
  Table table({"light", "facing area", "lit area", "shadowed area", "lit", "shadowed", "nodes",
               "depth", "build ms", "emit ms"});
  for (std::size_t k = 0; k < lights.size(); ++k) {
    const Stats& s = engine.shadows(k).stats;
    table.add({lights[k].spec, significant(s.facing_area), significant(s.lit_area),
               significant(s.shadowed_area), std::to_string(s.lit_fragments),
               std::to_string(s.shadowed_fragments), std::to_string(s.nodes),
               std::to_string(s.depth), tenths(s.build_ms), tenths(s.emit_ms)});
  }
  return a.scene + ": " + std::to_string(scene.objects().size()) + " objects, " +
         std::to_string(scene.faces().size()) + " faces, " + std::to_string(scene.facets().size()) +
         " facets, read in " + tenths(load_ms) + " ms; " + std::to_string(a.options.threads) +
         (a.options.threads == 1 ? " thread\n" : " threads\n") + sentence(alignment_of(scene)) +
         table.text();
}

// The view of each output. Only drawings use their view.
std::vector<io::View> views_of(const Scene& scene, const std::vector<NamedLight>& lights,
                               const CastArguments& a) {
  std::vector<io::View> views;
  std::size_t drawing = 0;
  for (const std::string& path : a.outputs) {
    io::View view;
    if (io::extension_of(path) == ".svg" && !a.drawings.empty()) {
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

}  // namespace

void cast(const CastArguments& arguments) {
  CastArguments a = arguments;
  a.options.threads = threads_of(a.options.threads);
  check_outputs(a);
  const std::vector<NamedLight> given = parse_lights(a.lights);

  const Clock::time_point start = Clock::now();
  Scene scene = read({a.scene, a.reading, a.strict, a.quiet});
  const double load_ms = milliseconds_since(start);
  const std::vector<NamedLight> lights = set_lights(scene, given, a.scene);
  const std::vector<io::View> views = views_of(scene, lights, a);
  ProgressBar bar(!a.quiet);
  const Engine engine = build(scene, a, bar);

  Outputs outputs;
  for (std::size_t i = 0; i < a.outputs.size(); ++i)
    outputs.write(a.outputs[i],
                  [&] { io::write_fragments(a.outputs[i], scene, engine, views[i]); });
  if (!a.areas.empty()) outputs.write(a.areas, [&] { io::write_areas(a.areas, scene, engine); });
  if (!a.json.empty())
    outputs.write(a.json, [&] { io::write_text(a.json, summary(engine, lights, a, load_ms)); });
  if (!a.quiet && a.json != "-")
    outputs.write("-", [&] { io::write_text("-", table(scene, engine, lights, a, load_ms)); });
}

}  // namespace shadowcut::cli
