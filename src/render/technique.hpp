// The ways of drawing shadows, behind one small face.
//
//   fragments         the engine's lit fragments, brought up to date by what Engine::update() hands
//                     out
//   stencil-standard  Heidmann's shadow volumes, counted where they pass the depth test
//   stencil-zfail     the same, counted where they fail it: no near plane can cut them
//   stencil-hybrid    Batagelo & Costa 1999: hidden casters left out by an SVBSP tree, silhouettes,
//                     caps at the near plane
//   stencil-kolic     Kolic et al. 2004: no silhouettes, volumes made in the vertex shader
//   shadow-texture    Oh & Shin 2005: a texture for each receiver, made with one depth buffer that
//                     is kept from frame to frame
//   shadow-map        a depth map for each light, with the usual bias
#pragma once

#include <memory>
#include <optional>
#include <shadowcut/shadows.hpp>
#include <string>
#include <vector>

#include "model.hpp"

namespace shadowcut::render {

// Figures of a frame, by name: milliseconds of phases (glFinish between them), and numbers of what
// was drawn.
using Figures = std::vector<std::pair<std::string, double>>;

class Technique {
 public:
  virtual ~Technique() = default;
  // Before a frame: brings the technique up to date with the scene.
  virtual void update() = 0;
  // Adds one light's share. The frame holds the ambient picture and all depths; stencil and
  // blending may be left in any state.
  virtual void add_light(const Frame& frame, std::size_t light) = 0;
  // Of the frame drawn last.
  virtual Figures figures() const { return {}; }
  // Whether its shadows follow a model that the wind bends in the vertex shader.
  virtual bool bends() const { return false; }
  // The engine behind it; null where there is none.
  virtual const Engine* engine() const { return nullptr; }
};

// Of a shadow map. What is drawn into it is moved away from the light by slope x its slope + units
// x the smallest step of depth; what is looked up is moved off its face by `texels`.
struct MapSettings {
  int side = 2048;  // pixels; of shadow textures too: of a light's view
  float slope_bias = 1.1f, unit_bias = 4, texel_bias = 0.5f;
};

// The scene, and the model of it, must outlive the technique. Throws Error when there is no
// technique of the name, or the driver has no maps as large.
std::unique_ptr<Technique> make_technique(const std::string& name, const Scene& scene,
                                          const Model& model, const MapSettings& map = {});
const std::vector<std::string>& technique_names();
void check_technique(const std::string& name);  // throws the same, without a driver

std::unique_ptr<Technique> make_fragments(const Scene& scene, const Model& model);
std::unique_ptr<Technique> make_stencil_volumes(const Scene& scene, const Model& model, bool zfail);
std::unique_ptr<Technique> make_stencil_hybrid(const Scene& scene, const Model& model);
std::unique_ptr<Technique> make_stencil_kolic(const Scene& scene, const Model& model);
std::unique_ptr<Technique> make_shadow_texture(const Scene& scene, const Model& model, int side);
std::unique_ptr<Technique> make_shadow_map(const Scene& scene, const Model& model,
                                           const MapSettings& settings);

// A whole picture: ambient light, then one light after another. Throws Error when the wind bends
// the model, but not the technique's shadows.
void draw(const Frame& frame, const Scene& scene, const Model& model, Technique& technique);

}  // namespace shadowcut::render
