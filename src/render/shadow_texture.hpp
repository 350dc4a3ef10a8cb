// The technique shadow-texture: K.-S. Oh, B.-S. Shin, "An efficient method for dynamic shadow
// texture generation", IEICE Trans. Inf. & Syst. E88-D(3), 2005. Its own header, for the choices
// that its authors compare.
#pragma once

#include "sz_buffer.hpp"
#include "technique.hpp"

namespace shadowcut::render {

class ShadowTexture : public Technique {
 public:
  enum class Method : std::uint8_t {
    sz_buffer,  // theirs: one depth buffer for all receivers (section 2)
    quadratic,  // the one before: for each receiver, all objects that its rays may meet are drawn
  };
  struct Choices {
    Method method = Method::sz_buffer;
    // section 3; without it every buffer and texture is made again in every frame
    bool coherence = true;
    int side = 2048;  // pixels of a light's view
  };

  ShadowTexture(const Scene& scene, const Model& model, const Choices& choices);

  void update() override;
  void add_light(const Frame& frame, std::size_t light) override;
  // receivers: of all lights; textures: that they have; textures_made: in the frame; ss, sd, ds,
  // dd: objects, of all lights.
  Figures figures() const override { return figures_; }

  // The textures as they are, for tests.
  struct Texels {
    std::uint32_t object;
    std::size_t receiver, view;
    Rectangle extent;
    std::vector<std::uint8_t> values;  // 255: lit
    friend bool operator==(const Texels&, const Texels&) = default;
  };
  std::vector<Texels> texels(std::size_t light) const;
  const LightViews& views(std::size_t light) const { return lights_[light]->views; }
  const SzBuffer& sz_buffer(std::size_t light) const { return lights_[light]->buffer; }

 private:
  struct Image {
    std::size_t view;
    Rectangle extent;
    Texture texture;
  };
  struct Receiver {
    std::vector<GLint> firsts;  // of its triangles, from the object's first on
    std::vector<GLsizei> counts;
    std::vector<Image> images;
  };
  struct Lit {
    Lit(const Scene& scene, const Model& model, std::size_t light, int side)
        : views(scene, model, light, side), buffer(model, views) {}
    LightViews views;
    SzBuffer buffer;
    std::vector<std::vector<Receiver>> receivers;  // by object
  };

  void update_light(std::size_t light);
  void update_textures(Lit& lit, const Light& light);
  std::vector<Receiver> find_receivers(const Lit& lit, const Light& light,
                                       std::uint32_t object) const;
  void make_texture_of(const Lit& lit, std::uint32_t object, const Receiver& receiver,
                       const Image& image);
  void draw_receiver(std::uint32_t object, const Receiver& receiver) const;
  void draw_biased(std::uint32_t object, const Receiver& receiver) const;
  void draw_nearer_casters(const LightViews& views, const Image& image);
  void count(const Lit& lit);

  const Scene& scene_;
  const Model& model_;
  const Choices choices_;
  Program paint_, lit_;
  Framebuffer framebuffer_;
  Texture canvas_, depths_;  // a view's size; depths_: of the quadratic method
  std::vector<std::unique_ptr<Lit>> lights_;
  Figures figures_;
  std::array<std::size_t, 4> mobilities_{};
  std::size_t receivers_ = 0, textures_ = 0, made_ = 0, drawn_ = 0;
  double texels_ = 0, buffer_ms_ = 0, textures_ms_ = 0;
};

}  // namespace shadowcut::render
