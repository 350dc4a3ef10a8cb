// What the fuzzers of scenes share: bytes, the meshes they make, and the end when something does
// not hold.
#pragma once

#include <array>
#include <cstdlib>
#include <iostream>
#include <shadowcut/scene.hpp>

namespace shadowcut::fuzz {

// Bytes, then zeros.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  bool empty() const { return at_ >= size_; }
  std::uint8_t byte() { return at_ < size_ ? data_[at_++] : 0; }

 private:
  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};

inline Mesh box(const Vec3& lo, const Vec3& hi) {
  Mesh mesh;
  for (int k = 0; k < 8; ++k)
    mesh.vertices.emplace_back(k & 1 ? hi.x() : lo.x(), k & 2 ? hi.y() : lo.y(),
                               k & 4 ? hi.z() : lo.z());
  for (const std::array<std::uint32_t, 4>& q : {std::array{0u, 2u, 3u, 1u},
                                                {4u, 5u, 7u, 6u},
                                                {0u, 1u, 5u, 4u},
                                                {2u, 6u, 7u, 3u},
                                                {0u, 4u, 6u, 2u},
                                                {1u, 3u, 7u, 5u}})
    mesh.add_face(q);
  return mesh;
}

// A box, a triangle, a parallelogram, or any four corners: point() gives the next one.
template <class Point>
Mesh some_mesh(std::uint8_t kind, const Point& point) {
  const Vec3 a = point(), b = point();
  if (kind % 4 == 0) return box(a.cwiseMin(b), a.cwiseMax(b));
  Mesh mesh;
  const Vec3 c = point();
  mesh.vertices = {a, b, c};
  if (kind % 4 == 1) mesh.add_face({0, 1, 2});
  if (kind % 4 == 2) mesh.vertices.push_back(a + (c - b));
  if (kind % 4 == 3) mesh.vertices.push_back(point());  // may be concave, crossed or not flat
  if (kind % 4 >= 2) mesh.add_face({0, 1, 2, 3});
  return mesh;
}

inline void require(bool holds, const char* what) {
  if (holds) return;
  std::cerr << what << "\n";
  std::abort();
}

}  // namespace shadowcut::fuzz
