// See technique.hpp.
#include "technique.hpp"

namespace shadowcut::render {

const std::vector<std::string>& technique_names() {
  static const std::vector<std::string> names{
      "fragments",     "stencil-standard", "stencil-zfail", "stencil-hybrid",
      "stencil-kolic", "shadow-texture",   "shadow-map"};
  return names;
}

void check_technique(const std::string& name) {
  std::string all;
  for (const std::string& known : technique_names()) {
    if (known == name) return;
    all += (all.empty() ? "" : ", ") + known;
  }
  throw Error("'" + name + "' is no technique: " + all);
}

namespace {

void check_side(int side) {
  GLint largest = 0;
  glGetIntegerv(GL_MAX_CUBE_MAP_TEXTURE_SIZE, &largest);
  if (side >= 1 && side <= largest) return;
  throw Error("a shadow map of " + std::to_string(side) +
              " pixels a side: this driver has them from 1 to " + std::to_string(largest));
}

}  // namespace

std::unique_ptr<Technique> make_technique(const std::string& name, const Scene& scene,
                                          const Model& model, const MapSettings& map) {
  check_technique(name);
  check_side(map.side);
  if (name == "fragments") return make_fragments(scene, model);
  if (name == "stencil-standard") return make_stencil_volumes(scene, model, false);
  if (name == "stencil-zfail") return make_stencil_volumes(scene, model, true);
  if (name == "stencil-hybrid") return make_stencil_hybrid(scene, model);
  if (name == "stencil-kolic") return make_stencil_kolic(scene, model);
  if (name == "shadow-texture") return make_shadow_texture(scene, model, map.side);
  return make_shadow_map(scene, model, map);
}

void draw(const Frame& frame, const Scene& scene, const Model& model, Technique& technique) {
  if (!model.wind().sway.isZero() && !technique.bends())
    throw Error("wind: this technique's shadows do not follow what the vertex shader bends");
  technique.update();
  model.draw_ambient(frame);
  for (std::size_t k = 0; k < scene.lights().size(); ++k) {
    if (scene.light_id(k).index == invalid_index) continue;
    technique.add_light(frame, k);
    glDisable(GL_STENCIL_TEST);
    model.add_light(frame, scene.lights()[k], scene.lights().size(), false);
  }
  require_no_error("drawing");
}

}  // namespace shadowcut::render
