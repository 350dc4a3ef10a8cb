// A cube in bricks, turned: faces that were meant to lie in one plane.
#pragma once

#include <algorithm>
#include <vector>

#include "scenes.hpp"

namespace shadowcut::testing {

inline Eigen::Quaterniond random_turn(scenes::Random& random) {
  Eigen::Quaterniond q(random.in(-1, 1), random.in(-1, 1), random.in(-1, 1), random.in(-1, 1));
  return q.norm() > 0.1 ? q.normalized() : Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5);
}

// As a file holds a model that was turned before it was written: every coordinate rounded by
// itself.
inline Mesh turned(Mesh mesh, const Eigen::Quaterniond& q, const Vec3& shift = Vec3::Zero()) {
  for (Vec3& v : mesh.vertices) v = q * v + shift;
  return mesh;
}

// A rectangle laid in bricks, n rows of n, every other row but the last shifted by half a brick:
// corners in the middle of edges.
inline Mesh bricks(const Vec3& corner, const Vec3& u, const Vec3& v, unsigned n) {
  Mesh mesh;
  for (unsigned row = 0; row < n; ++row) {
    double from = 0;
    for (unsigned k = 0; from < n; ++k) {
      const double to =
          std::min<double>(n, from + (k == 0 && row % 2 == 1 && row + 1 < n ? 0.5 : 1));
      scenes::append(mesh,
                     scenes::rectangle(corner + u * (from / n) + v * (row / static_cast<double>(n)),
                                       u * ((to - from) / n), v / n));
      from = to;
    }
  }
  return mesh;
}

// The cube's sides: from a corner, along two edges, the front outward.
struct Side {
  Vec3 corner, u, v;
};
inline const std::vector<Side> kCubeSides = {
    {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}}, {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}},
    {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}, {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}},
    {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

// A cube, each side n x n bricks (n a power of two: then bricks of two sides have the same corners
// on their common edge), and a poster over their middle, which overlaps them. Faces of a side come
// together.
inline Mesh brick_cube(unsigned n) {
  Mesh mesh;
  for (const Side& s : kCubeSides) {
    scenes::append(mesh, bricks(s.corner, s.u, s.v, n));
    scenes::append(mesh,
                   scenes::rectangle(s.corner + 0.23 * s.u + 0.31 * s.v, 0.41 * s.u, 0.37 * s.v));
  }
  return mesh;
}
inline Mesh plain_cube() {
  Mesh mesh;
  for (const Side& s : kCubeSides) scenes::append(mesh, scenes::rectangle(s.corner, s.u, s.v));
  return mesh;
}

inline Scene scene_of(const Mesh& mesh, double tolerance = default_coplanarity,
                      const Pose& pose = Pose::Identity(), Sides sides = Sides::automatic) {
  Scene scene;
  scene.coplanarity_tolerance = tolerance;
  ObjectSettings settings;
  settings.pose = pose;
  settings.sides = sides;
  scene.add(mesh, settings);
  return scene;
}

}  // namespace shadowcut::testing
