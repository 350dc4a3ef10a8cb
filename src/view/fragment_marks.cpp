// See fragment_marks.hpp.
#include "fragment_marks.hpp"

#include <cmath>

namespace shadowcut::view {
namespace {

// Drawn `nearer` to the eye, as a share of the distance: at the same pixels, in front of the faces
// they lie on.
const char* const vertex_shader = R"(
layout(location = 0) in vec3 position;
layout(location = 2) in vec4 colour;
uniform mat4 clip;
uniform vec3 eye;
uniform float nearer;
flat out vec3 paint;
void main() {
  paint = colour.rgb;
  gl_Position = clip * vec4(position + nearer * (eye - position), 1.0);
}
)";

const char* const fragment_shader = R"(
flat in vec3 paint;
uniform float opacity;
out vec4 pixel;
void main() { pixel = vec4(paint, opacity); }
)";

using Colour = std::array<std::uint8_t, 3>;

// Neighbours in number are far apart in hue.
Colour colour_of_cell(std::uint32_t cell) {
  const double turn = 2.399963229728653 * cell;  // the golden angle
  const auto channel = [&](double phase) {
    return static_cast<std::uint8_t>(140 + 110 * std::cos(turn + phase));
  };
  return {channel(0), channel(-2.0943951), channel(2.0943951)};
}

render::Vertex vertex(const render::Model& model, const Vec3& at, const Colour& colour) {
  const render::Vec3f p = model.shifted(at);
  return {{p.x(), p.y(), p.z()}, {}, {colour[0], colour[1], colour[2], 255}};
}

}  // namespace

FragmentMarks::FragmentMarks() : program_(vertex_shader, fragment_shader) {}

void FragmentMarks::Shape::upload(const std::vector<render::Vertex>& vertices) {
  count = static_cast<GLsizei>(vertices.size());
  glBindBuffer(GL_ARRAY_BUFFER, buffer.get());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(render::Vertex)),
               vertices.data(), GL_DYNAMIC_DRAW);
}

void FragmentMarks::set(const Engine& engine, std::size_t light, const render::Model& model) {
  constexpr Colour lit{176, 84, 0}, shadowed{20, 40, 150};
  std::vector<render::Vertex> lines, triangles;
  for (const Block& block : engine.shadows(light).blocks) {
    for (const Fragment& fragment : block.fragments) {
      const auto corners = block.corners_of(fragment);
      const Colour cell = colour_of_cell(fragment.id.cell);
      for (std::size_t i = 0; i < corners.size(); ++i)
        for (const std::size_t k : {i, (i + 1) % corners.size()})
          lines.push_back(vertex(model, corners[k], fragment.lit ? lit : shadowed));
      for (std::size_t i = 2; i < corners.size(); ++i)
        for (const std::size_t k : {std::size_t{0}, i - 1, i})
          triangles.push_back(vertex(model, corners[k], cell));
    }
  }
  outlines_.upload(lines);
  cells_.upload(triangles);
}

void FragmentMarks::use(const render::Frame& frame, float opacity, float nearer) const {
  program_.use();
  program_.set("clip", frame.shifted_clip);
  program_.set("eye", frame.eye);
  program_.set("opacity", opacity);
  program_.set("nearer", nearer);
  glDisable(GL_STENCIL_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_LEQUAL);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
}

void FragmentMarks::draw_outlines(const render::Frame& frame) const {
  use(frame, 0.8f, 0.003f);
  glBindVertexArray(outlines_.array.get());
  glDrawArrays(GL_LINES, 0, outlines_.count);
  glDisable(GL_BLEND);
}

void FragmentMarks::draw_cells(const render::Frame& frame) const {
  // As the fragments themselves are drawn.
  use(frame, 0.5f, 0);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(-0.25f, -4);
  render::Model::once_a_pixel();
  glBindVertexArray(cells_.array.get());
  glDrawArrays(GL_TRIANGLES, 0, cells_.count);
  glDisable(GL_STENCIL_TEST);
  glDisable(GL_POLYGON_OFFSET_FILL);
  glDisable(GL_BLEND);
}

}  // namespace shadowcut::view
