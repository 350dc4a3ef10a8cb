// See sz_buffer.hpp.
#include "sz_buffer.hpp"

#include <algorithm>
#include <cmath>

#include "light_projection.hpp"
#include "scene/scene_access.hpp"

namespace shadowcut::render {
namespace {

using Point = Eigen::Vector4d;  // in clip space
// pixels around an extent: for the driver's rounding, and lines drawn along rims
constexpr int margin = 2;

// A point is in the view where all of these are not negative.
std::array<double, 5> heights(const Point& p) {
  return {p.w() + p.z(), p.w() + p.x(), p.w() - p.x(), p.w() + p.y(), p.w() - p.y()};
}

unsigned outside(const Point& p) {
  const auto h = heights(p);
  unsigned code = 0;
  for (std::size_t k = 0; k < h.size(); ++k) code |= (h[k] < 0 ? 1u : 0u) << k;
  return code;
}

std::vector<Point> clipped(std::vector<Point> polygon) {
  for (std::size_t plane = 0; plane < 5; ++plane) {
    std::vector<Point> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Point &a = polygon[i], &b = polygon[i + 1 == polygon.size() ? 0 : i + 1];
      const double ha = heights(a)[plane], hb = heights(b)[plane];
      if (ha >= 0) kept.push_back(a);
      if ((ha < 0) != (hb < 0)) kept.push_back(a + (b - a) * (ha / (ha - hb)));
    }
    polygon = std::move(kept);
  }
  return polygon;
}

// Grows to hold points that are in the view.
struct Bounds {
  Eigen::AlignedBox2d box;
  void add(const Point& p) { box.extend(Eigen::Vector2d(p.head<2>() / p.w())); }
  Rectangle pixels(int side) const {
    if (box.isEmpty()) return {};
    const auto low = [side](double x) {
      return std::clamp(static_cast<int>(std::floor((x + 1) / 2 * side)) - margin, 0, side);
    };
    const auto high = [side](double x) {
      return std::clamp(static_cast<int>(std::ceil((x + 1) / 2 * side)) + margin, 0, side);
    };
    return {low(box.min().x()), low(box.min().y()), high(box.max().x()), high(box.max().y())};
  }
};

// Rows: to the right, up, and along the light. Seen along the light it is no mirror image.
Eigen::Matrix3f sheet_axes(const Light& light) {
  Eigen::Matrix3f axes;
  const Vec3f along = light.direction.stableNormalized().cast<float>(),
              right = along.unitOrthogonal();
  axes.row(0) = right, axes.row(1) = right.cross(along), axes.row(2) = along;
  return axes;
}

template <class Use>
void for_each_corner(const Scene& scene, std::uint32_t object, const Use& use) {
  const Object& o = scene.objects()[object];
  for (std::uint32_t f = o.first_facet; f < o.first_facet + o.facet_count; ++f)
    for (const Corner& corner : scene.corners_of(scene.facets()[f])) use(corner.vertex);
}

void scissor(const Rectangle& r) { glScissor(r.x0, r.y0, r.width(), r.height()); }

void attach_depths(const Framebuffer& framebuffer, const Texture& depths) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depths.get(), 0);
}

// Leaves the rendering buffer's framebuffer bound if it was: drawing goes on where it did.
void copy_depths(const Framebuffer& from, const Framebuffer& to, const Rectangle& r) {
  GLint before = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &before);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, from.get());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to.get());
  glBlitFramebuffer(r.x0, r.y0, r.x1, r.y1, r.x0, r.y0, r.x1, r.y1, GL_DEPTH_BUFFER_BIT,
                    GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(before));
}

}  // namespace

const char* const light_view_vertex_shader = R"(
layout(location = 0) in vec3 position;
uniform mat4 clip;
invariant gl_Position;
void main() { gl_Position = clip * vec4(position, 1.0); }
)";

Rectangle united(const Rectangle& a, const Rectangle& b) {
  if (a.empty() || b.empty()) return a.empty() ? b : a;
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

Texture make_depths(int side) {
  Texture texture = make_texture();
  glBindTexture(GL_TEXTURE_2D, texture.get());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, side, side, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
               nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

KeptBinding::KeptBinding() {
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer_);
  glGetIntegerv(GL_VIEWPORT, viewport_.data());
}

KeptBinding::~KeptBinding() {
  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(framebuffer_));
  glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
}

// ---- LightViews

// False when the views are what they were.
bool LightViews::aim() {
  const Light& light = scene_.lights()[light_];
  if (!clips_.empty() && light_known_ == SceneAccess::light_revision(scene_, light_) &&
      std::all_of(moving_.begin(), moving_.end(),
                  [this](std::uint32_t object) { return covers(object); }))
    return false;
  light_known_ = SceneAccess::light_revision(scene_, light_);
  clips_.clear();
  if (light.kind == Light::Kind::point) {
    for (const auto& axes : cube_axes())
      clips_.push_back(cube_face(model_.shifted(light.position), axes,
                                 static_cast<float>(model_.radius() / 512)));
    return true;
  }
  const Eigen::Matrix3f axes = sheet_axes(light);
  double farthest = model_.radius();
  for (std::uint32_t object = 0; object < scene_.objects().size(); ++object)
    for_each_corner(scene_, object, [&](std::uint32_t v) {
      farthest = std::max(
          farthest,
          static_cast<double>((axes * model_.shifted(scene_.vertices()[v])).cwiseAbs().maxCoeff()));
    });
  // Room to move in, once the scene has left the sphere in which it began.
  reach_ = farthest * (farthest > model_.radius() ? 1.25 : 1.001);
  clips_.emplace_back(Mat4f::Identity()).topLeftCorner<3, 3>() = axes / static_cast<float>(reach_);
  return true;
}

// Whether an object is wholly within a directional light's view.
bool LightViews::covers(std::uint32_t object) const {
  if (clips_.size() != 1) return true;
  bool within = true;
  for_each_corner(scene_, object, [&](std::uint32_t v) {
    const Vec3f p = clips_[0].topLeftCorner<3, 3>() * model_.shifted(scene_.vertices()[v]);
    within = within && p.cwiseAbs().maxCoeff() < 1;
  });
  return within;
}

void LightViews::advance() {
  moving_ = SceneAccess::changed_since(scene_, known_);
  known_ = SceneAccess::revision(scene_);
  before_.clear();
  afresh_ = aim();
  if (afresh_) return start();
  now_.resize(scene_.objects().size());
  mobility_.resize(scene_.objects().size(), Mobility::ss);
  for (Mobility& m : mobility_)
    m = m == Mobility::sd || m == Mobility::dd ? Mobility::ds : Mobility::ss;
  for (const std::uint32_t object : moving_) {
    Mobility& m = mobility_[object];
    m = m == Mobility::ds ? Mobility::dd : Mobility::sd;
    if (now_[object].casts) before_[object] = now_[object];
    else before_[object] = {};
    now_[object] = look_at(object);
  }
}

void LightViews::start() {
  moving_.clear();
  mobility_.assign(scene_.objects().size(), Mobility::ss);
  now_.clear();
  for (std::uint32_t object = 0; object < scene_.objects().size(); ++object)
    now_.push_back(look_at(object));
}

bool LightViews::disturbed(std::size_t view, const Rectangle& pixels) const {
  return std::any_of(moving_.begin(), moving_.end(), [&](std::uint32_t object) {
    return extent_before(view, object).overlaps(pixels) ||
           (casts(object) && extent(view, object).overlaps(pixels));
  });
}

LightViews::Seen LightViews::look_at(std::uint32_t index) const {
  const Object& object = scene_.objects()[index];
  Seen seen{object.alive && object.casts_shadows, {}};
  std::vector<std::uint32_t> facets(object.facet_count);
  for (std::uint32_t k = 0; k < object.facet_count; ++k) facets[k] = object.first_facet + k;
  for (std::size_t view = 0; view < clips_.size(); ++view)
    seen.extents[view] = extent(view, index, facets);
  return seen;
}

Rectangle LightViews::extent(std::size_t view, std::uint32_t index,
                             std::span<const std::uint32_t> facets) const {
  const Object& object = scene_.objects()[index];
  const Eigen::Matrix4d clip = clips_[view].cast<double>();
  std::vector<Point> points(object.vertex_count);
  std::vector<unsigned> codes(object.vertex_count);
  for (std::uint32_t k = 0; k < object.vertex_count; ++k) {
    points[k] =
        clip *
        model_.shifted(scene_.vertices()[object.first_vertex + k]).cast<double>().homogeneous();
    codes[k] = outside(points[k]);
  }
  Bounds bounds;
  for (const std::uint32_t f : facets) {
    unsigned all = ~0u, any = 0;
    std::vector<Point> polygon;
    for (const Corner& corner : scene_.corners_of(scene_.facets()[f])) {
      const std::uint32_t k = corner.vertex - object.first_vertex;
      all &= codes[k], any |= codes[k];
      polygon.push_back(points[k]);
    }
    if (all != 0) continue;
    if (any != 0) polygon = clipped(std::move(polygon));
    for (const Point& p : polygon) bounds.add(p);
  }
  return bounds.pixels(side_);
}

// ---- SzBuffer

SzBuffer::SzBuffer(const Model& model, const LightViews& views)
    : model_(model),
      views_(views),
      depth_(light_view_vertex_shader, "void main() {}"),
      rendering_(make_framebuffer()),
      standing_(make_framebuffer()) {
  const KeptBinding kept;
  for (const Framebuffer* framebuffer : {&rendering_, &standing_}) {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer->get());
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
  }
}

void SzBuffer::make_layers() {
  if (layers_.size() == views_.size()) return;
  layers_.clear();
  for (std::size_t view = 0; view < views_.size(); ++view)
    layers_.push_back({make_depths(views_.side()), make_depths(views_.side())});
  require_no_error("making a light's depth buffers");
}

template <class Draw>
void SzBuffer::draw_views(const Draw& draw_view) {
  const KeptBinding kept;
  make_layers();
  drawn_ = 0;
  for (std::size_t view = 0; view < views_.size(); ++view) {
    begin(view);
    draw_view(view);
  }
  require_no_error("drawing a light's depth buffer");
}

void SzBuffer::update() {
  if (views_.afresh() || layers_.size() != views_.size()) return make_all();
  draw_views([this](std::size_t view) {
    erase(view);
    draw_uncovered(view);
    keep_static(view);
    draw_moving(view);
  });
}

void SzBuffer::make_all() {
  draw_views([this](std::size_t view) {
    glClear(GL_DEPTH_BUFFER_BIT);
    for (std::uint32_t object = 0; object < views_.object_count(); ++object)
      if (!views_.moves(object)) draw(view, object);
    copy_depths(rendering_, standing_, {0, 0, views_.side(), views_.side()});
    draw_moving(view);
  });
}

void SzBuffer::make_rendering() {
  draw_views([this](std::size_t view) {
    glClear(GL_DEPTH_BUFFER_BIT);
    for (std::uint32_t object = 0; object < views_.object_count(); ++object) draw(view, object);
  });
}

void SzBuffer::begin(std::size_t view) const {
  attach_depths(rendering_, layers_[view].rendering);
  attach_depths(standing_, layers_[view].standing);
  glBindFramebuffer(GL_FRAMEBUFFER, rendering_.get());
  glViewport(0, 0, views_.side(), views_.side());
  for (const GLenum off :
       {GL_BLEND, GL_STENCIL_TEST, GL_CULL_FACE, GL_POLYGON_OFFSET_FILL, GL_SCISSOR_TEST})
    glDisable(off);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  glClearDepth(1);
  depth_.use();
  depth_.set("clip", views_.clip(view));
}

// Substeps (1-1) and (1-2): what moves is erased where it was. The static buffer has what stood
// behind those that already moved, but it has those that begin to move too, and what was behind
// these nobody knows.
void SzBuffer::erase(std::size_t view) const {
  for (const std::uint32_t object : views_.moving())
    if (const Rectangle& r = views_.extent_before(view, object);
        views_.mobility(object) == Mobility::dd && !r.empty())
      copy_depths(standing_, rendering_, r);
  glEnable(GL_SCISSOR_TEST);
  for (const std::uint32_t object : views_.moving()) {
    const Rectangle& r = views_.extent_before(view, object);
    if (views_.mobility(object) != Mobility::sd || r.empty()) continue;
    scissor(r);
    glClear(GL_DEPTH_BUFFER_BIT);
  }
  glDisable(GL_SCISSOR_TEST);
}

// Substeps (1-3) and (1-4): what stands still is drawn again where it was erased. Objects that have
// come to rest are not in the static buffer yet, so that copying it erased them too.
void SzBuffer::draw_uncovered(std::size_t view) {
  glEnable(GL_SCISSOR_TEST);
  for (std::uint32_t object = 0; object < views_.object_count(); ++object) {
    const Mobility mobility = views_.mobility(object);
    if (views_.moves(object)) continue;
    Rectangle erased;
    for (const std::uint32_t other : views_.moving()) {
      if (mobility == Mobility::ss && views_.mobility(other) == Mobility::dd) continue;
      const Rectangle& r = views_.extent_before(view, other);
      if (r.overlaps(views_.extent(view, object))) erased = united(erased, r);
    }
    if (erased.empty()) continue;
    scissor(erased);
    draw(view, object);
  }
  glDisable(GL_SCISSOR_TEST);
}

// Stage (2): the rendering buffer has just what stands still.
void SzBuffer::keep_static(std::size_t view) const {
  for (const std::uint32_t object : views_.moving())
    if (const Rectangle& r = views_.extent_before(view, object);
        views_.mobility(object) == Mobility::sd && !r.empty())
      copy_depths(rendering_, standing_, r);
  for (std::uint32_t object = 0; object < views_.object_count(); ++object)
    if (const Rectangle& r = views_.extent(view, object);
        views_.mobility(object) == Mobility::ds && views_.casts(object) && !r.empty())
      copy_depths(rendering_, standing_, r);
}

// Stage (3).
void SzBuffer::draw_moving(std::size_t view) {
  for (const std::uint32_t object : views_.moving()) draw(view, object);
}

void SzBuffer::draw(std::size_t view, std::uint32_t object) {
  if (!views_.casts(object) || views_.extent(view, object).empty()) return;
  model_.draw_object(object);
  ++drawn_;
}

std::vector<float> SzBuffer::read(std::size_t view) const {
  const KeptBinding kept;
  const std::size_t side = static_cast<std::size_t>(views_.side());
  std::vector<float> depths(side * side);
  attach_depths(rendering_, layers_[view].rendering);
  glBindFramebuffer(GL_FRAMEBUFFER, rendering_.get());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, views_.side(), views_.side(), GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
  require_no_error("reading a light's depth buffer");
  return depths;
}

}  // namespace shadowcut::render
