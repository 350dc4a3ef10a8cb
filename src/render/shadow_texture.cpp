// See shadow_texture.hpp. A texture for each receiver says, for every ray from the light through
// it, whether the receiver is what the ray meets first: the light's view is filled with the shadow
// colour, and the receiver drawn in the light colour with the SZ-buffer for depth (section 2).
// After a frame only textures of objects that have moved, and of those that overlap where they were
// or are, are made again (section 3.2).
//
// Departures. Receivers are parts of objects that cannot shadow themselves (receivers.hpp). The
// SZ-buffer itself is the depth buffer, not written to, in place of a copy. A texture has the
// receiver's rectangle of the view, pixel for pixel. The edges of its triangles are drawn too:
// pixels that the receiver covers but not in their middle would be in shadow.
//
// The texture's pixels are the SZ-buffer's, so that a receiver never shadows itself, whatever its
// slope. The bias (glPolygonOffset, to the light) is for others that touch it: slope x 0.1 + 4
// units; for edges, which are drawn up to half a pixel off, slope x 0.5 + 4 units.
//
// The quadratic method: the receiver in the light colour with a depth buffer of its own, then in
// the shadow colour whatever is nearer. Its textures are the same to the bit, because both ask of
// each pixel whether the receiver, moved by its bias, is nearer than the nearest caster.
#include "shadow_texture.hpp"

#include <algorithm>
#include <chrono>

#include "receivers.hpp"

namespace shadowcut::render {
namespace {

constexpr float slope_bias = 0.1f, rim_slope_bias = 0.5f, unit_bias = 4;

using Clock = std::chrono::steady_clock;

double lap(Clock::time_point& since) {
  glFinish();
  const Clock::time_point now = Clock::now();
  const double ms = std::chrono::duration<double, std::milli>(now - since).count();
  since = now;
  return ms;
}

const char* const paint_fragment_shader = R"(
uniform float paint;
out vec4 pixel;
void main() { pixel = vec4(paint); }
)";

// face: of a cube, or -1. A point on two faces belongs to the first of them.
const char* const lookup = R"(
uniform sampler2D shadow;
uniform mat4 view_clip;
uniform vec3 place;
uniform int face;
uniform float side;
uniform vec4 extent;
int face_of(vec3 v) {
  vec3 a = abs(v);
  if (a.x >= a.y && a.x >= a.z) return v.x > 0.0 ? 0 : 1;
  if (a.y >= a.z) return v.y > 0.0 ? 2 : 3;
  return v.z > 0.0 ? 4 : 5;
}
float reached(vec3 x, vec3 n) {
  if (face >= 0 && face_of(x - place) != face) discard;
  vec4 p = view_clip * vec4(x, 1.0);
  vec2 texel = floor((p.xy / p.w * 0.5 + 0.5) * side) - extent.xy;
  return texelFetch(shadow, ivec2(clamp(texel, vec2(0.0), extent.zw - 1.0)), 0).r;
}
)";

Texture make_canvas(int side) {
  Texture texture = make_texture();
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R8, side, side, 0, GL_RED, GL_UNSIGNED_BYTE, nullptr);
  return texture;
}

Texture make_image() {
  Texture texture = make_texture();
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

}  // namespace

ShadowTexture::ShadowTexture(const Scene& scene, const Model& model, const Choices& choices)
    : scene_(scene),
      model_(model),
      choices_(choices),
      paint_(light_view_vertex_shader, paint_fragment_shader),
      lit_(Model::lit_vertex_shader(), Model::lit_fragment_shader(lookup)),
      framebuffer_(make_framebuffer()),
      canvas_(make_canvas(choices.side)) {
  if (choices.method == Method::quadratic) depths_ = make_depths(choices.side);
  require_no_error("making the pictures that shadow textures are drawn in");
}

void ShadowTexture::update() {
  const KeptBinding kept;
  lights_.resize(scene_.lights().size());
  mobilities_ = {}, receivers_ = textures_ = made_ = drawn_ = 0,
  texels_ = buffer_ms_ = textures_ms_ = 0;
  for (std::size_t k = 0; k < lights_.size(); ++k) {
    if (scene_.light_id(k).index == invalid_index) lights_[k].reset();
    else update_light(k);
  }
  const auto number = [](std::size_t n) { return static_cast<double>(n); };
  figures_ = {{"receivers", number(receivers_)}, {"textures", number(textures_)},
              {"textures_made", number(made_)},  {"texels", texels_},
              {"ss", number(mobilities_[0])},    {"sd", number(mobilities_[1])},
              {"ds", number(mobilities_[2])},    {"dd", number(mobilities_[3])},
              {"objects_drawn", number(drawn_)}, {"buffer_ms", buffer_ms_},
              {"textures_ms", textures_ms_}};
}

void ShadowTexture::update_light(std::size_t k) {
  if (!lights_[k]) lights_[k] = std::make_unique<Lit>(scene_, model_, k, choices_.side);
  Lit& lit = *lights_[k];
  Clock::time_point since = Clock::now();
  lit.views.advance();
  if (choices_.method == Method::sz_buffer) {
    if (choices_.coherence) lit.buffer.update();
    else lit.buffer.make_rendering();
    drawn_ += lit.buffer.drawn();
  }
  buffer_ms_ += lap(since);
  update_textures(lit, scene_.lights()[k]);
  textures_ms_ += lap(since);
  count(lit);
  require_no_error("making shadow textures");
}

void ShadowTexture::update_textures(Lit& lit, const Light& light) {
  const LightViews& views = lit.views;
  const bool all = views.afresh() || !choices_.coherence;
  lit.receivers.resize(views.object_count());
  for (std::uint32_t object = 0; object < views.object_count(); ++object) {
    const bool again = views.afresh() || views.moves(object);
    if (again) lit.receivers[object] = find_receivers(lit, light, object);
    for (const Receiver& receiver : lit.receivers[object])
      for (const Image& image : receiver.images)
        if (all || again || views.disturbed(image.view, image.extent))
          make_texture_of(lit, object, receiver, image);
  }
}

std::vector<ShadowTexture::Receiver> ShadowTexture::find_receivers(const Lit& lit,
                                                                   const Light& light,
                                                                   std::uint32_t index) const {
  const Object& object = scene_.objects()[index];
  if (!object.alive || !object.receives_shadows) return {};
  std::vector<GLint> firsts;  // by facet of the object
  GLint end = 0;
  for (std::uint32_t f = object.first_facet; f < object.first_facet + object.facet_count; ++f) {
    firsts.push_back(end);
    end += 3 * std::max(static_cast<GLint>(scene_.facets()[f].corner_count) - 2, 0);
  }
  firsts.push_back(end);
  std::vector<Receiver> receivers;
  for (const auto& facets : receivers_of(scene_, index, light, model_.radius() * 1e-6)) {
    Receiver& receiver = receivers.emplace_back();
    for (const std::uint32_t f : facets) {
      const std::size_t k = f - object.first_facet;
      const bool follows =
          !receiver.firsts.empty() && receiver.firsts.back() + receiver.counts.back() == firsts[k];
      if (!follows) receiver.firsts.push_back(firsts[k]), receiver.counts.push_back(0);
      receiver.counts.back() += firsts[k + 1] - firsts[k];
    }
    for (std::size_t view = 0; view < lit.views.size(); ++view) {
      if (lit.views.extent(view, index).empty()) continue;
      const Rectangle extent = lit.views.extent(view, index, facets);
      if (!extent.empty()) receiver.images.push_back({view, extent, make_image()});
    }
  }
  return receivers;
}

void ShadowTexture::make_texture_of(const Lit& lit, std::uint32_t object, const Receiver& receiver,
                                    const Image& image) {
  const bool quadratic = choices_.method == Method::quadratic;
  const GLuint depths = quadratic ? depths_.get() : lit.buffer.depths(image.view);
  const Rectangle& r = image.extent;
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, canvas_.get(), 0);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depths, 0);
  glViewport(0, 0, choices_.side, choices_.side);
  for (const GLenum off : {GL_BLEND, GL_STENCIL_TEST, GL_CULL_FACE}) glDisable(off);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(quadratic ? GL_TRUE : GL_FALSE);
  glDepthFunc(quadratic ? GL_LESS : GL_LEQUAL);
  glEnable(GL_SCISSOR_TEST);
  glScissor(r.x0, r.y0, r.width(), r.height());
  glClearColor(0, 0, 0, 0);
  glClearDepth(1);
  glClear(GL_COLOR_BUFFER_BIT | (quadratic ? GL_DEPTH_BUFFER_BIT : 0u));
  paint_.use();
  paint_.set("clip", lit.views.clip(image.view));
  paint_.set("paint", 1.f);
  draw_biased(object, receiver);
  if (quadratic) draw_nearer_casters(lit.views, image);
  glDisable(GL_SCISSOR_TEST);
  glDepthMask(GL_TRUE);
  glBindTexture(GL_TEXTURE_2D, image.texture.get());
  glCopyTexImage2D(GL_TEXTURE_2D, 0, GL_R8, r.x0, r.y0, r.width(), r.height(), 0);
  ++made_;
}

void ShadowTexture::draw_receiver(std::uint32_t object, const Receiver& receiver) const {
  std::vector<GLint> firsts = receiver.firsts;
  for (GLint& first : firsts) first += model_.range_of(object).first;
  model_.draw_ranges(firsts, receiver.counts);
}

void ShadowTexture::draw_biased(std::uint32_t object, const Receiver& receiver) const {
  glPolygonOffset(-slope_bias, -unit_bias);
  glEnable(GL_POLYGON_OFFSET_FILL);
  draw_receiver(object, receiver);
  glDisable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(-rim_slope_bias, -unit_bias);
  glEnable(GL_POLYGON_OFFSET_LINE);
  glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
  draw_receiver(object, receiver);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glDisable(GL_POLYGON_OFFSET_LINE);
}

void ShadowTexture::draw_nearer_casters(const LightViews& views, const Image& image) {
  glDepthMask(GL_FALSE);
  paint_.set("paint", 0.f);
  for (std::uint32_t object = 0; object < views.object_count(); ++object) {
    if (!views.casts(object) || !views.extent(image.view, object).overlaps(image.extent)) continue;
    model_.draw_object(object);
    ++drawn_;
  }
}

void ShadowTexture::count(const Lit& lit) {
  for (std::uint32_t object = 0; object < lit.views.object_count(); ++object) {
    if (scene_.objects()[object].alive)
      ++mobilities_[static_cast<std::size_t>(lit.views.mobility(object))];
    receivers_ += lit.receivers[object].size();
    for (const Receiver& receiver : lit.receivers[object]) {
      textures_ += receiver.images.size();
      for (const Image& image : receiver.images)
        texels_ += static_cast<double>(image.extent.width()) * image.extent.height();
    }
  }
}

void ShadowTexture::add_light(const Frame& frame, std::size_t k) {
  const Light& light = scene_.lights()[k];
  const Lit& lit = *lights_[k];
  const bool point = light.kind == Light::Kind::point;
  model_.use_light(lit_, frame, light, scene_.lights().size());
  lit_.set("shadow", 0);
  lit_.set("side", static_cast<float>(choices_.side));
  if (point) lit_.set("place", model_.shifted(light.position));
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_EQUAL);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  Model::once_a_pixel();
  glActiveTexture(GL_TEXTURE0);
  for (std::uint32_t object = 0; object < lit.receivers.size(); ++object)
    for (const Receiver& receiver : lit.receivers[object])
      for (const Image& image : receiver.images) {
        const Rectangle& r = image.extent;
        lit_.set("view_clip", lit.views.clip(image.view));
        lit_.set("face", point ? static_cast<int>(image.view) : -1);
        lit_.set("extent",
                 Eigen::Vector4f(static_cast<float>(r.x0), static_cast<float>(r.y0),
                                 static_cast<float>(r.width()), static_cast<float>(r.height())));
        glBindTexture(GL_TEXTURE_2D, image.texture.get());
        draw_receiver(object, receiver);
      }
  glDisable(GL_STENCIL_TEST);
  glDisable(GL_BLEND);
}

std::vector<ShadowTexture::Texels> ShadowTexture::texels(std::size_t light) const {
  const Lit& lit = *lights_[light];
  std::vector<Texels> all;
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  for (std::uint32_t object = 0; object < lit.receivers.size(); ++object)
    for (std::size_t k = 0; k < lit.receivers[object].size(); ++k)
      for (const Image& image : lit.receivers[object][k].images) {
        Texels& texels = all.emplace_back(Texels{object, k, image.view, image.extent, {}});
        texels.values.resize(static_cast<std::size_t>(image.extent.width()) *
                             static_cast<std::size_t>(image.extent.height()));
        glBindTexture(GL_TEXTURE_2D, image.texture.get());
        glGetTexImage(GL_TEXTURE_2D, 0, GL_RED, GL_UNSIGNED_BYTE, texels.values.data());
      }
  require_no_error("reading shadow textures");
  return all;
}

std::unique_ptr<Technique> make_shadow_texture(const Scene& scene, const Model& model, int side) {
  ShadowTexture::Choices choices;
  choices.side = side;
  return std::make_unique<ShadowTexture>(scene, model, choices);
}

}  // namespace shadowcut::render
