// The command render: a picture of a scene, its shadows by one of the techniques of src/render.
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "inputs.hpp"
#include "io/files.hpp"
#include "offscreen.hpp"
#include "outputs.hpp"
#include "report.hpp"
#include "specs.hpp"
#include "technique.hpp"

namespace shadowcut::cli {

namespace {

using nlohmann::ordered_json;

std::string json_text(const RenderArguments& a, const std::vector<NamedLight>& lights, const render::Figures& figures, double draw_ms) {
  ordered_json document{{"scene", a.scene},   {"technique", a.technique}, {"width", a.width},
                        {"height", a.height}, {"draw_ms", draw_ms},       {"lights", ordered_json::array()}};
  for (const NamedLight& light : lights) document["lights"].push_back(light.spec);
  for (const auto& [name, value] : figures) document["figures"][name] = value;
  return document.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace

void render_picture(const RenderArguments& a) {
  check_folder(a.output);
  if (!a.json.empty() && a.json != "-") check_folder(a.json);
  if (io::extension_of(a.output) != ".png") throw Error("-o: '" + a.output + "' does not end in .png");
  const io::View view = parse_camera(a.camera);
  const render::Camera camera{view.eye, view.target, view.fov, view.up};
  const std::vector<NamedLight> given = parse_lights(a.lights);
  Scene scene = read({a.scene, a.reading, false, a.quiet});
  const std::vector<NamedLight> lights = set_lights(scene, given, a.scene);

  const render::OffscreenContext context;
  const render::Target target(a.width, a.height);
  const render::Model model(scene);
  const auto technique = render::make_technique(a.technique, scene, model);
  target.bind();
  const Clock::time_point start = Clock::now();
  render::draw(model.frame(camera, a.width, a.height), scene, model, *technique);
  glFinish();
  const double draw_ms = milliseconds_since(start);
  const render::Picture picture = target.read();

  Outputs outputs;
  outputs.write(a.output, [&] { render::write_png(a.output, picture); });
  if (!a.json.empty()) outputs.write(a.json, [&] { io::write_text(a.json, json_text(a, lights, technique->figures(), draw_ms)); });
  if (!a.quiet && a.json != "-")
    outputs.write("-", [&] { io::write_text("-", a.output + ": " + a.technique + ", " + tenths(draw_ms) + " ms\n"); });
}

}  // namespace shadowcut::cli
