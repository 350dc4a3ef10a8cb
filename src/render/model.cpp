// See model.hpp.
#include "model.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "polygon.hpp"
#include "scene/scene_access.hpp"

namespace shadowcut::render {
namespace {

// Every program that draws surfaces has this, so that depths of one vertex are one number. A normal
// is bent by the inverse of the transposed derivative of the motion: that says which way the facet
// faces; the drawn triangle's own normal is found where it is needed.
const char* const common_vertex_shader = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 colour;
uniform mat4 clip;
// what is the same all over a facet is not interpolated: across a sliver that runs away
out vec3 x;
flat out vec3 n;
flat out vec4 paint;
invariant gl_Position;
void main() {
  x = bent(position);
  vec3 turn = 2.0 * sway * max(position.z - foot, 0.0);
  n = normal - vec3(0.0, 0.0, dot(turn, normal) / (1.0 + turn.z));
  paint = colour;
  gl_Position = clip * vec4(x, 1.0);
}
)";

const char* const ambient_fragment_shader = R"(
in vec3 x;
flat in vec3 n;
flat in vec4 paint;
uniform float share;
out vec4 pixel;
void main() { pixel = vec4(paint.rgb * share, 1.0); }
)";

// A light is (at, 1) or (its direction, 0). axis.w: the cosine of the cone's half angle,
// or -2 for none.
const char* const lit_main = R"(
in vec3 x;
flat in vec3 n;
flat in vec4 paint;
uniform vec3 eye;
uniform vec4 light;
uniform vec4 axis;
uniform float range;
uniform float share;
uniform vec3 sway;
out vec4 pixel;
vec3 facet_normal() {
  if (sway == vec3(0.0)) return n;
  vec3 drawn = normalize(cross(dFdx(x), dFdy(x)));
  return dot(drawn, n) < 0.0 ? -drawn : drawn;
}
void main() {
  vec3 normal = facet_normal();
  vec3 to_light = light.w > 0.5 ? light.xyz - x : -light.xyz;
  float facing = dot(normal, to_light);
  bool seen = facing * dot(normal, eye - x) > 0.0 && (paint.a < 0.5 || facing > 0.0);
  bool within = length(to_light) <= range &&
      (axis.w < -1.5 || dot(axis.xyz, -normalize(to_light)) >= axis.w);
  // and leaves the pixel to the face beside it, where each may draw once
  if (!seen || !within) discard;
  float slant = abs(facing) / length(to_light);
  pixel = vec4(paint.rgb * share * (0.4 + 0.6 * slant) * reached(x, normal), 1.0);
}
)";

void append_triangles(const Model& model, const Scene& scene, std::uint32_t facet,
                      std::vector<Vertex>& vertices) {
  const auto corners = scene.corners_of(scene.facets()[facet]);
  for (std::size_t i = 2; i < corners.size(); ++i)
    for (const std::size_t k : {std::size_t{0}, i - 1, i})
      vertices.push_back(model.vertex(scene, facet, scene.vertices()[corners[k].vertex]));
}

}  // namespace

std::array<std::uint8_t, 3> colour_of(const Object& object) {
  std::uint32_t hash = 2166136261u;  // FNV-1a
  for (const char c : object.name) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  const double turn = 6.283185307179586 * (hash % 360) / 360;
  const auto channel = [&](double phase) {
    return static_cast<std::uint8_t>(205 + 42 * std::cos(turn + phase));
  };
  return {channel(0), channel(-2.0943951), channel(2.0943951)};
}

Eigen::AlignedBox3d box_of(const Scene& scene) { return compare::box_of(scene); }

Paint paint_of(const Object& object) {
  const auto colour = colour_of(object);
  return {colour[0], colour[1], colour[2],
          static_cast<std::uint8_t>(object.sides == Sides::closed ? 255 : 0)};
}

Model::Model(const Scene& scene)
    : vertices_(make_buffer()),
      array_(array_of(vertices_)),
      ambient_(lit_vertex_shader(), ambient_fragment_shader),
      lit_(lit_vertex_shader(), lit_fragment_shader()) {
  const Eigen::AlignedBox3d box = box_of(scene);
  if (!box.isEmpty())
    origin_ = box.center(),
    radius_ = std::max(box.diagonal().norm() / 2, std::numeric_limits<double>::min());
  upload(scene);
}

void Model::scene_changed(const Scene& scene) {
  for (const std::uint32_t object : SceneAccess::changed_since(scene, known_))
    if (object >= ranges_.size() || !upload_in_place(scene, object)) return upload(scene);
  known_ = SceneAccess::revision(scene);
}

// False when the object needs another place: it has another number of triangles, or receives or
// casts otherwise.
bool Model::upload_in_place(const Scene& scene, std::uint32_t index) {
  const Object& object = scene.objects()[index];
  const Range& range = ranges_[index];
  const std::size_t part = (object.receives_shadows ? 0 : 2) + (object.casts_shadows ? 0 : 1);
  if (range.first < ends_[part] || range.first + range.count > ends_[part + 1]) return false;
  std::vector<Vertex> vertices;
  for (std::uint32_t f = object.first_facet; f < object.first_facet + object.facet_count; ++f)
    append_triangles(*this, scene, f, vertices);
  if (vertices.size() != static_cast<std::size_t>(range.count)) return false;
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.get());
  glBufferSubData(GL_ARRAY_BUFFER,
                  static_cast<GLintptr>(static_cast<std::size_t>(range.first) * sizeof(Vertex)),
                  static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)), vertices.data());
  return true;
}

void Model::upload(const Scene& scene) {
  known_ = SceneAccess::revision(scene);
  ranges_.assign(scene.objects().size(), {});
  std::vector<Vertex> vertices;
  std::size_t part = 0;
  for (const auto& [receives, casts] :
       {std::pair(true, true), {true, false}, {false, true}, {false, false}}) {
    for (std::uint32_t f = 0; f < scene.facets().size(); ++f) {
      if (scene.facets()[f].corner_count == 0) continue;
      const std::uint32_t index = scene.faces()[scene.facets()[f].face].object;
      const Object& object = scene.objects()[index];
      if (object.receives_shadows != receives || object.casts_shadows != casts) continue;
      Range& range = ranges_[index];
      if (range.count == 0) range.first = static_cast<GLint>(vertices.size());
      append_triangles(*this, scene, f, vertices);
      range.count = static_cast<GLsizei>(vertices.size()) - range.first;
    }
    ends_[++part] = static_cast<GLsizei>(vertices.size());
  }
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.get());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)),
               vertices.data(), GL_DYNAMIC_DRAW);
  require_no_error("uploading the scene");
}

Vertex Model::vertex(const Scene& scene, std::uint32_t f, const Vec3& world) const {
  const Facet& facet = scene.facets()[f];
  const Object& object = scene.objects()[scene.faces()[facet.face].object];
  const Vec3f p = shifted(world), n = scene.planes()[facet.plane].normal.cast<float>();
  return {{p.x(), p.y(), p.z()}, {n.x(), n.y(), n.z()}, paint_of(object)};
}

Frame Model::frame(const Camera& camera, int width, int height) const {
  check(camera);
  // 24 bits of depth then tell 1e-4 of the radius apart at its distance
  const double near = radius_ / 512;
  const double aspect = static_cast<double>(width) / height;
  Frame frame{camera,
              width,
              height,
              near,
              camera.projection(aspect, near) * camera.view().matrix(),
              {},
              shifted(camera.eye)};
  Eigen::Matrix4d shift = Eigen::Matrix4d::Identity();
  shift.topRightCorner<3, 1>() = origin_;
  frame.shifted_clip = (frame.clip * shift).cast<float>();
  return frame;
}

std::array<Vec3, 4> Frame::near_window(double scale) const {
  const double high = scale * near * std::tan(camera.fov / 2), wide = high * width / height;
  const Pose world = camera.view().inverse(Eigen::Isometry);
  return {world * Vec3(-wide, -high, -near), world * Vec3(wide, -high, -near),
          world * Vec3(wide, high, -near), world * Vec3(-wide, high, -near)};
}

VertexArray Model::array_of(const Buffer& vertices) {
  VertexArray array = make_vertex_array();
  glBindVertexArray(array.get());
  glBindBuffer(GL_ARRAY_BUFFER, vertices.get());
  const auto attribute = [](GLuint index, GLint count, GLenum type, GLboolean normalised,
                            std::size_t offset) {
    glEnableVertexAttribArray(index);
    glVertexAttribPointer(index, count, type, normalised, sizeof(Vertex),
                          reinterpret_cast<const void*>(offset));
  };
  attribute(0, 3, GL_FLOAT, GL_FALSE, offsetof(Vertex, position));
  attribute(1, 3, GL_FLOAT, GL_FALSE, offsetof(Vertex, normal));
  attribute(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Vertex, colour));
  return array;
}

std::string Model::bending_shader() {
  return R"(
uniform vec3 sway;
uniform float foot;
vec3 bent(vec3 x) {
  float high = max(x.z - foot, 0.0);
  return x + sway * (high * high);
}
)";
}

void Model::use_wind(const Program& program) const {
  program.set("sway", wind_.sway);
  program.set("foot", wind_.foot - static_cast<float>(origin_.z()));
}

std::string Model::lit_vertex_shader() { return bending_shader() + common_vertex_shader; }
std::string Model::lit_fragment_shader(const std::string& reached) { return reached + lit_main; }

void Model::draw_triangles(bool receivers) const {
  glBindVertexArray(array_.get());
  const std::size_t first = receivers ? 0 : 2;
  glDrawArrays(GL_TRIANGLES, ends_[first], ends_[first + 2] - ends_[first]);
}

void Model::draw_casters() const {
  glBindVertexArray(array_.get());
  for (const std::size_t part : {0, 2})
    glDrawArrays(GL_TRIANGLES, ends_[part], ends_[part + 1] - ends_[part]);
}

void Model::draw_object(std::uint32_t object) const {
  glBindVertexArray(array_.get());
  glDrawArrays(GL_TRIANGLES, ranges_[object].first, ranges_[object].count);
}

void Model::draw_ranges(std::span<const GLint> firsts, std::span<const GLsizei> counts) const {
  glBindVertexArray(array_.get());
  glMultiDrawArrays(GL_TRIANGLES, firsts.data(), counts.data(),
                    static_cast<GLsizei>(firsts.size()));
}

void Model::draw_ambient(const Frame& frame) const {
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glStencilMask(0xFF);
  glDisable(GL_BLEND);
  glDisable(GL_STENCIL_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_POLYGON_OFFSET_FILL);
  glClearColor(1, 1, 1, 1);
  glClearStencil(0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  ambient_.use();
  ambient_.set("clip", frame.shifted_clip);
  ambient_.set("share", ambient_share);
  use_wind(ambient_);
  draw_triangles(true);
  draw_triangles(false);
}

void Model::use_light(const Program& program, const Frame& frame, const Light& light,
                      std::size_t lights) const {
  const bool point = light.kind == Light::Kind::point;
  const Vec3f at =
      point ? shifted(light.position) : light.direction.stableNormalized().cast<float>().eval();
  program.use();
  program.set("clip", frame.shifted_clip);
  use_wind(program);
  program.set("eye", frame.eye);
  program.set("light", Eigen::Vector4f(at.x(), at.y(), at.z(), point ? 1.f : 0.f));
  program.set("range", point && std::isfinite(light.range) ? static_cast<float>(light.range)
                                                           : std::numeric_limits<float>::max());
  Eigen::Vector4f axis(0, 0, 0, -2);
  if (point && light.spot) {
    axis.head<3>() = light.spot->axis.stableNormalized().cast<float>();
    axis[3] = static_cast<float>(std::cos(light.spot->half_angle));
  }
  program.set("axis", axis);
  program.set("share", (1 - ambient_share) / static_cast<float>(lights));
}

void Model::once_a_pixel() {
  glEnable(GL_STENCIL_TEST);
  glStencilMask(0xFF);
  glClear(GL_STENCIL_BUFFER_BIT);
  glStencilFunc(GL_EQUAL, 0, 0xFF);
  glStencilOp(GL_KEEP, GL_KEEP, GL_INCR);
}

void Model::add_light(const Frame& frame, const Light& light, std::size_t lights,
                      bool receivers) const {
  use_light(lit_, frame, light, lights);
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_EQUAL);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  draw_triangles(receivers);
  glDisable(GL_BLEND);
}

}  // namespace shadowcut::render
