// See volume_buffer.hpp.
#include "volume_buffer.hpp"

#include <algorithm>

#include "casters.hpp"

namespace shadowcut::render {
namespace {

const char* const volume_vertex_shader = R"(
layout(location = 0) in vec4 position;
uniform mat4 clip;
invariant gl_Position;
void main() { gl_Position = clip * position; }
)";

}  // namespace

VolumeBuffer::VolumeBuffer(const Model& model)
    : model_(model),
      program_(volume_vertex_shader, "void main() {}"),
      buffer_(make_buffer()),
      array_(make_vertex_array()) {
  glBindVertexArray(array_.get());
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, sizeof(Point), nullptr);
}

void VolumeBuffer::clear() { volumes_.clear(), caps_.clear(); }

VolumeBuffer::Point VolumeBuffer::point(const Vec3& x) const {
  const Vec3f p = model_.shifted(x);
  return {p.x(), p.y(), p.z(), 1};
}

VolumeBuffer::Point VolumeBuffer::direction(const Light& light, const Vec3& x) {
  const Vec3f d = away_from(light, x).stableNormalized().cast<float>();
  return {d.x(), d.y(), d.z(), 0};
}

// The four points are floats, and in no plane. So that where two polygons meet in an edge their
// sides take each other away in every pixel, they are the same two triangles, one pair turned
// round.
void VolumeBuffer::add_side(const Light& light, const Vec3& from, const Vec3& to) {
  const bool turned = std::lexicographical_compare(to.begin(), to.end(), from.begin(), from.end());
  const Vec3 &a = turned ? to : from, &b = turned ? from : to;
  const auto add = [&](const Point& p, const Point& q, const Point& r) {
    volumes_.push_back(turned ? q : p);
    volumes_.push_back(turned ? p : q);
    volumes_.push_back(r);
  };
  const Point near_b = point(b), far_a = direction(light, a);
  add(point(a), far_a, near_b);
  // else the far ends are one
  if (light.kind == Light::Kind::point) add(near_b, far_a, direction(light, b));
}

void VolumeBuffer::add_ends(const Light& light, std::span<const Vec3> polygon) {
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const Vec3 &a = polygon[0], &b = polygon[i - 1], &c = polygon[i];
    volumes_.insert(volumes_.end(), {point(a), point(b), point(c)});
    if (light.kind == Light::Kind::point)
      volumes_.insert(volumes_.end(),
                      {direction(light, a), direction(light, c), direction(light, b)});
  }
}

void VolumeBuffer::add_cap(std::span<const Vec3> polygon) {
  for (std::size_t i = 2; i < polygon.size(); ++i)
    caps_.insert(caps_.end(), {point(polygon[0]), point(polygon[i - 1]), point(polygon[i])});
}

void VolumeBuffer::upload() {
  const auto bytes = [](const std::vector<Point>& points) {
    return static_cast<GLsizeiptr>(points.size() * sizeof(Point));
  };
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
  glBufferData(GL_ARRAY_BUFFER, bytes(volumes_) + bytes(caps_), nullptr, GL_DYNAMIC_DRAW);
  glBufferSubData(GL_ARRAY_BUFFER, 0, bytes(volumes_), volumes_.data());
  glBufferSubData(GL_ARRAY_BUFFER, bytes(volumes_), bytes(caps_), caps_.data());
  require_no_error("uploading shadow volumes");
}

void VolumeBuffer::begin(const Frame& frame) const {
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_LESS);  // the end at a polygon lies exactly on it, and it is not in its own shadow
  glEnable(GL_STENCIL_TEST);
  glStencilMask(0xFF);
  glClear(GL_STENCIL_BUFFER_BIT);
  glStencilFunc(GL_ALWAYS, 0, 0xFF);
  program_.use();
  program_.set("clip", frame.shifted_clip);
  glBindVertexArray(array_.get());
}

void VolumeBuffer::end() const {
  glDisable(GL_DEPTH_CLAMP);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glStencilFunc(GL_EQUAL, 0, 0xFF);
  glStencilOp(GL_KEEP, GL_KEEP, GL_INCR);  // lit once, however many faces are at one place
}

void VolumeBuffer::count_passes(const Frame& frame) const {
  begin(frame);
  glStencilOpSeparate(GL_FRONT, GL_KEEP, GL_KEEP, GL_INCR_WRAP);
  glStencilOpSeparate(GL_BACK, GL_KEEP, GL_KEEP, GL_DECR_WRAP);
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(volumes_.size()));
  // a cap lies on the near plane, and may not be clipped away by rounding
  glEnable(GL_DEPTH_CLAMP);
  glDrawArrays(GL_TRIANGLES, static_cast<GLint>(volumes_.size()),
               static_cast<GLsizei>(caps_.size()));
  end();
}

void VolumeBuffer::count_failures(const Frame& frame) const {
  begin(frame);
  glEnable(GL_DEPTH_CLAMP);  // infinity is in view, whatever rounding says
  glStencilOpSeparate(GL_BACK, GL_KEEP, GL_INCR_WRAP, GL_KEEP);
  glStencilOpSeparate(GL_FRONT, GL_KEEP, GL_DECR_WRAP, GL_KEEP);
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(volumes_.size()));
  end();
}

}  // namespace shadowcut::render
