// A scene as OpenGL draws it: the triangles of all facets, flat-shaded in muted colours, and how a
// light shades them.
//
// Coordinates go to the driver as floats, from the scene's middle. A pixel is lit by a light if the
// eye sees the side that the light sees (of a solid: the outer one), within the light's range and
// cone, unless a technique says that it is in shadow.
#pragma once

#include <array>
#include <shadowcut/scene.hpp>
#include <span>
#include <vector>

#include "camera.hpp"

namespace shadowcut::render {

struct Frame {
  Camera camera;
  int width, height;
  double near;           // distance of the near plane, scene units
  Eigen::Matrix4d clip;  // world (not shifted) to clip space
  Mat4f shifted_clip;    // the same for the model's coordinates
  Vec3f eye;             // in the model's coordinates

  // The near plane's part of the picture, `scale` times as large, in the world; counter-clockwise
  // seen from the eye.
  std::array<Vec3, 4> near_window(double scale) const;
};

using Paint = std::array<std::uint8_t, 4>;  // a colour, and 255 for a solid's face
Paint paint_of(const Object& object);

// What is put into the vertex buffers.
struct Vertex {
  float position[3];
  float normal[3];
  Paint colour;
};

// A wind that bends everything above `foot` in the vertex shader: what is h above it is carried by
// sway h^2. Only what techniques make of vertices on the way to the screen follows
// (Technique::bends).
struct Wind {
  Vec3f sway = Vec3f::Zero();  // one over the scene's unit
  float foot = 0;              // z, scene units
  friend bool operator==(const Wind& a, const Wind& b) {
    return a.sway == b.sway && a.foot == b.foot;
  }
};

// Of all corners of facets; empty where there are none.
Eigen::AlignedBox3d box_of(const Scene& scene);

constexpr float ambient_share = 0.35f;  // of a face's colour; the lights share the rest

class Model {
 public:
  explicit Model(const Scene& scene);

  // Uploads the vertices that an object's motion changed. If the number of facets of any object has
  // changed, uploads everything.
  void scene_changed(const Scene& scene);

  void set_wind(const Wind& wind) { wind_ = wind; }
  const Wind& wind() const { return wind_; }
  // GLSL: vec3 bent(vec3 x), of the model's coordinates; and what it needs, for the program in use.
  static std::string bending_shader();
  void use_wind(const Program& program) const;

  Frame frame(const Camera& camera, int width, int height) const;
  Vec3f shifted(const Vec3& world) const { return (world - origin_).cast<float>(); }
  const Vec3& origin() const { return origin_; }
  double radius() const { return radius_; }
  Vertex vertex(const Scene& scene, std::uint32_t facet, const Vec3& world) const;

  // Clears, and draws everything in ambient light, with its depths.
  void draw_ambient(const Frame& frame) const;
  // Adds a light's share, where depths are equal, to the faces that receive; or to those that do
  // not.
  void add_light(const Frame& frame, const Light& light, std::size_t lights, bool receivers) const;
  // Of what is drawn next, only the first at each pixel is kept, until the stencil test is switched
  // off. Clears the stencil buffer.
  static void once_a_pixel();
  // The program behind that, for other geometry in the model's coordinates. `more` is GLSL put
  // before main(): float reached(vec3 x, vec3 n), the share of the light that comes to a point.
  static std::string lit_vertex_shader();
  static std::string lit_fragment_shader(
      const std::string& reached = "float reached(vec3 x, vec3 n) { return 1.0; }");
  void use_light(const Program& program, const Frame& frame, const Light& light,
                 std::size_t lights) const;
  void draw_triangles(bool receivers) const;
  void draw_casters() const;
  // Where an object's triangles are in the buffer, facet by facet in the scene's order; and drawing
  // ranges of them.
  struct Range {
    GLint first = 0;
    GLsizei count = 0;
  };
  const Range& range_of(std::uint32_t object) const { return ranges_[object]; }
  void draw_object(std::uint32_t object) const;
  void draw_ranges(std::span<const GLint> firsts, std::span<const GLsizei> counts) const;

  // An array object for a buffer of vertices as above.
  static VertexArray array_of(const Buffer& vertices);

 private:
  void upload(const Scene& scene);
  bool upload_in_place(const Scene& scene, std::uint32_t object);

  Vec3 origin_ = Vec3::Zero();
  double radius_ = 1;
  Buffer vertices_;
  VertexArray array_;
  std::vector<Range> ranges_;  // by object
  std::uint64_t known_ = 0;
  Wind wind_;
  // vertices: of faces that receive and cast, only receive, only cast, do neither; first a 0
  std::array<GLsizei, 5> ends_{};
  Program ambient_, lit_;
};

// Muted, and the same for an object as long as its name is.
std::array<std::uint8_t, 3> colour_of(const Object& object);

}  // namespace shadowcut::render
