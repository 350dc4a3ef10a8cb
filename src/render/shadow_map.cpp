// The depth map that everyone knows: L. Williams, "Casting curved shadows on curved surfaces",
// SIGGRAPH 1978. For a point light a cube of six images, for a directional one an image as large as
// the scene. Against self-shadowing, what is drawn is moved away from the light (glPolygonOffset),
// and what is looked up off its face.
#include "light_projection.hpp"
#include "scene/scene_access.hpp"
#include "technique.hpp"

namespace shadowcut::render {
namespace {

const char* const depth_vertex_shader = R"(
layout(location = 0) in vec3 position;
uniform mat4 clip;
void main() { gl_Position = clip * vec4(bent(position), 1.0); }
)";

// The cube map is asked along the ray, with the depth that the ray's face gives: `nearest` / the
// largest component, as the projection makes it.
const char* const cube_lookup = R"(
uniform samplerCubeShadow map;
uniform vec4 place;
uniform float nearest;
uniform float texel;
uniform float off_face;
float reached(vec3 x, vec3 n) {
  vec3 off = x - place.xyz;
  float far = max(abs(off.x), max(abs(off.y), abs(off.z)));
  vec3 ray = off - n * sign(dot(n, off)) * (off_face * texel * far);
  far = max(abs(ray.x), max(abs(ray.y), abs(ray.z)));
  return texture(map, vec4(ray, 1.0 - nearest / far));
}
)";

const char* const flat_lookup = R"(
uniform sampler2DShadow map;
uniform mat4 map_clip;
uniform vec3 direction;
uniform float texel;
uniform float off_face;
float reached(vec3 x, vec3 n) {
  vec4 p = map_clip * vec4(x - n * sign(dot(n, direction)) * (off_face * texel), 1.0);
  return texture(map, p.xyz * 0.5 + 0.5);
}
)";

class ShadowMap : public Technique {
 public:
  ShadowMap(const Scene& scene, const Model& model, const MapSettings& settings)
      : scene_(scene),
        model_(model),
        settings_(settings),
        depth_(Model::bending_shader() + depth_vertex_shader, "void main() {}"),
        cube_lit_(Model::lit_vertex_shader(), Model::lit_fragment_shader(cube_lookup)),
        flat_lit_(Model::lit_vertex_shader(), Model::lit_fragment_shader(flat_lookup)),
        framebuffer_(make_framebuffer()) {}

  void update() override {
    if (known_ == SceneAccess::revision(scene_) && wind_ == model_.wind()) return;
    known_ = SceneAccess::revision(scene_);
    wind_ = model_.wind();
    GLint before = 0, viewport[4];
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &before);
    glGetIntegerv(GL_VIEWPORT, viewport);
    maps_.clear();
    for (const Light& light : scene_.lights()) maps_.push_back(map_of(light));
    glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(before));
    glViewport(viewport[0], viewport[1], viewport[2], viewport[3]);
    require_no_error("drawing a shadow map");
  }

  void add_light(const Frame& frame, std::size_t k) override {
    const Light& light = scene_.lights()[k];
    const bool point = light.kind == Light::Kind::point;
    const Program& program = point ? cube_lit_ : flat_lit_;
    model_.use_light(program, frame, light, scene_.lights().size());
    program.set("map", 0);
    program.set("texel", maps_[k].texel);
    program.set("off_face", settings_.texel_bias);
    if (point) {
      const Vec3f at = model_.shifted(light.position);
      program.set("place", Eigen::Vector4f(at.x(), at.y(), at.z(), 1));
      program.set("nearest", maps_[k].nearest);
    } else {
      program.set("map_clip", maps_[k].clip);
      program.set("direction", light.direction.stableNormalized().cast<float>().eval());
    }
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(point ? GL_TEXTURE_CUBE_MAP : GL_TEXTURE_2D, maps_[k].texture.get());
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_EQUAL);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    Model::once_a_pixel();
    model_.draw_triangles(true);
    glDisable(GL_STENCIL_TEST);
    glDisable(GL_BLEND);
  }

  Figures figures() const override { return {{"map_side", settings_.side}}; }
  bool bends() const override { return true; }

 private:
  struct Map {
    Texture texture;
    Mat4f clip = Mat4f::Identity();
    float nearest = 0, texel = 0;  // texel: its size, at distance one of a point light
  };

  Map map_of(const Light& light) {
    const bool point = light.kind == Light::Kind::point;
    const int side = settings_.side;
    const GLenum kind = point ? GL_TEXTURE_CUBE_MAP : GL_TEXTURE_2D;
    Map map{make_texture(), Mat4f::Identity(), static_cast<float>(model_.radius() / 512),
            2.f / static_cast<float>(side)};
    glBindTexture(kind, map.texture.get());
    for (int face = 0; face < (point ? 6 : 1); ++face)
      glTexImage2D(point ? GL_TEXTURE_CUBE_MAP_POSITIVE_X + static_cast<GLenum>(face) : kind, 0,
                   GL_DEPTH_COMPONENT32F, side, side, 0, GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
    glTexParameteri(kind, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(kind, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
      glTexParameteri(kind, axis, GL_CLAMP_TO_EDGE);
    glTexParameteri(kind, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(kind, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    if (point) draw_cube(light, map);
    else draw_sheet(light, map);
    return map;
  }

  void draw_cube(const Light& light, const Map& map) {
    GLenum face = GL_TEXTURE_CUBE_MAP_POSITIVE_X;
    for (const CubeAxes& axes : cube_axes())
      draw_depths(face++, map, cube_face(model_.shifted(light.position), axes, map.nearest));
  }

  void draw_sheet(const Light& light, Map& map) {
    const Vec3f d = light.direction.stableNormalized().cast<float>(), u = d.unitOrthogonal(),
                v = d.cross(u);
    const float size = static_cast<float>(model_.radius()) * 1.001f;
    map.clip.row(0).head<3>() = u / size, map.clip.row(1).head<3>() = v / size,
    map.clip.row(2).head<3>() = d / size;
    map.texel = 2 * size / static_cast<float>(settings_.side);
    draw_depths(GL_TEXTURE_2D, map, map.clip);
  }

  void draw_depths(GLenum image, const Map& map, const Mat4f& clip) {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, image, map.texture.get(), 0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    glViewport(0, 0, settings_.side, settings_.side);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_LESS);
    glClear(GL_DEPTH_BUFFER_BIT);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(settings_.slope_bias, settings_.unit_bias);
    depth_.use();
    depth_.set("clip", clip);
    model_.use_wind(depth_);
    model_.draw_casters();
    glDisable(GL_POLYGON_OFFSET_FILL);
  }

  const Scene& scene_;
  const Model& model_;
  const MapSettings settings_;
  Program depth_, cube_lit_, flat_lit_;
  Framebuffer framebuffer_;
  std::vector<Map> maps_;               // by light
  std::optional<std::uint64_t> known_;  // revision of the scene that this is of, and its wind
  Wind wind_;
};

}  // namespace

std::unique_ptr<Technique> make_shadow_map(const Scene& scene, const Model& model,
                                           const MapSettings& settings) {
  return std::make_unique<ShadowMap>(scene, model, settings);
}

}  // namespace shadowcut::render
