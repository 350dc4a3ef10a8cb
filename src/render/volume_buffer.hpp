// Shadow volumes as triangles, their outsides counter-clockwise, and how they are counted in the
// stencil buffer. Sides end at infinity.
#pragma once

#include <span>
#include <vector>

#include "model.hpp"

namespace shadowcut::render {

class VolumeBuffer {
 public:
  explicit VolumeBuffer(const Model& model);

  void clear();
  // The side below the edge a -> b of a polygon that is counter-clockwise seen from the light.
  void add_side(const Light& light, const Vec3& from, const Vec3& to);
  // Closes a volume at its polygon and at infinity.
  void add_ends(const Light& light, std::span<const Vec3> polygon);
  // A polygon on the near plane, counter-clockwise seen from the camera.
  void add_cap(std::span<const Vec3> polygon);
  void upload();

  // Clears the stencil buffer, counts volumes where they pass the depth test (caps too), or fail
  // it, and leaves the stencil test set to draw where none is left: in the light.
  void count_passes(const Frame& frame) const;
  void count_failures(const Frame& frame) const;

 private:
  using Point = Eigen::Vector4f;  // w = 0: a direction
  Point point(const Vec3& x) const;
  static Point direction(const Light& light, const Vec3& x);
  void begin(const Frame& frame) const;
  void end() const;

  const Model& model_;
  Program program_;
  Buffer buffer_;
  VertexArray array_;
  std::vector<Point> volumes_, caps_;
};

}  // namespace shadowcut::render
