// The command render: draws a scene, with shadows by one of the techniques of src/render.
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

std::string json_text(const RenderArguments& a, const std::vector<NamedLight>& lights,
                      const render::Figures& figures, double draw_ms) {
  ordered_json document{{"scene", a.scene},   {"technique", a.technique},
                        {"width", a.width},   {"height", a.height},
                        {"draw_ms", draw_ms}, {"lights", ordered_json::array()}};
  for (const NamedLight& light : lights) document["lights"].push_back(light.spec);
  for (const auto& [name, value] : figures) document["figures"][name] = value;
  return document.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

render::MapSettings map_settings(const RenderArguments& a) {
  render::MapSettings map;
  const bool texture = a.technique == "shadow-texture";
  if (a.map_side) {
    if (!texture && a.technique != "shadow-map")
      throw Error("--map-size: the technique " + a.technique + " uses no map");
    map.side = *a.map_side;
  }
  if (!a.bias.empty()) {
    if (a.technique != "shadow-map")
      throw Error("--bias: only the technique shadow-map has a bias");
    const std::vector<double> bias = parse_numbers_of("--bias", a.bias, "SLOPE,UNITS,TEXELS");
    map.slope_bias = static_cast<float>(bias[0]), map.unit_bias = static_cast<float>(bias[1]),
    map.texel_bias = static_cast<float>(bias[2]);
  }
  return map;
}

// The wind bends everything above the lowest point of the scene.
render::Wind wind_of(const std::string& text, const Scene& scene) {
  render::Wind wind;
  if (text.empty()) return wind;
  const std::vector<double> sway = parse_numbers_of("--wind", text, "X,Y");
  const Eigen::AlignedBox3d box = render::box_of(scene);
  wind.sway = Vec3(sway[0], sway[1], 0).cast<float>();
  wind.foot = box.isEmpty() ? 0 : static_cast<float>(box.min().z());
  return wind;
}

}  // namespace

void render_picture(const RenderArguments& a) {
  render::check_technique(a.technique);
  const render::MapSettings map = map_settings(a);
  check_folder(a.output);
  if (!a.json.empty() && a.json != "-") check_folder(a.json);
  if (io::extension_of(a.output) != ".png")
    throw Error("-o: '" + a.output + "' does not end in .png");
  const io::View view = parse_camera(a.camera);
  const render::Camera camera{view.eye, view.target, view.fov, view.up};
  const std::vector<NamedLight> given = parse_lights(a.lights);
  Scene scene = read({a.scene, a.reading, false, a.quiet});
  const std::vector<NamedLight> lights = set_lights(scene, given, a.scene);

  const render::OffscreenContext context;
  const render::Target target(a.width, a.height);
  render::Model model(scene);
  model.set_wind(wind_of(a.wind, scene));
  const auto technique = render::make_technique(a.technique, scene, model, map);
  target.bind();
  const Clock::time_point start = Clock::now();
  render::draw(model.frame(camera, a.width, a.height), scene, model, *technique);
  glFinish();
  const double draw_ms = milliseconds_since(start);
  const render::Picture picture = target.read();

  Outputs outputs;
  outputs.write(a.output, [&] { render::write_png(a.output, picture); });
  if (!a.json.empty())
    outputs.write(a.json, [&] {
      io::write_text(a.json, json_text(a, lights, technique->figures(), draw_ms));
    });
  if (!a.quiet && a.json != "-")
    outputs.write("-", [&] {
      io::write_text("-", a.output + ": " + a.technique + ", " + tenths(draw_ms) + " ms\n");
    });
}

}  // namespace shadowcut::cli
