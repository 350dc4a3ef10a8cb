// The engine's fragments made visible over the picture: their outlines, or the cells of the
// balanced prefix that they lie in.
#pragma once

#include <shadowcut/shadows.hpp>

#include "model.hpp"

namespace shadowcut::view {

class FragmentMarks {
 public:
  FragmentMarks();
  // What to show: the fragments of one light, as they are now. Shadowed ones are outlined in blue,
  // lit ones in orange.
  void set(const Engine& engine, std::size_t light, const render::Model& model);
  // Over a picture that has its depths. Outlines are drawn a little in front.
  void draw_outlines(const render::Frame& frame) const;
  void draw_cells(const render::Frame& frame) const;

 private:
  struct Shape {
    render::Buffer buffer = render::make_buffer();
    render::VertexArray array = render::Model::array_of(buffer);
    GLsizei count = 0;
    void upload(const std::vector<render::Vertex>& vertices);
  };
  void use(const render::Frame& frame, float opacity, float nearer) const;

  render::Program program_;
  Shape outlines_, cells_;
};

}  // namespace shadowcut::view
