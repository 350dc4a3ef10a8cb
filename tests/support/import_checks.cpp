// See import_checks.hpp.
#include "import_checks.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes.hpp"

namespace shadowcut::testing {

Mesh polygon(std::initializer_list<Vec3> points) {
  Mesh mesh;
  mesh.vertices = points;
  std::vector<std::uint32_t> loop(points.size());
  for (std::uint32_t i = 0; i < loop.size(); ++i) loop[i] = i;
  mesh.add_face(loop);
  return mesh;
}

void add_hole(Mesh& mesh, std::initializer_list<Vec3> points) {
  std::vector<std::uint32_t> loop;
  for (const Vec3& p : points) {
    loop.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    mesh.vertices.push_back(p);
  }
  mesh.add_hole(loop);
}

Scene second(const Mesh& mesh, Sides sides) {
  Scene scene;
  scene.add(scenes::rectangle({0, 0, -9}, {1, 0, 0}, {0, 1, 0}), {});
  ObjectSettings settings;
  settings.name = "it";
  settings.sides = sides;
  scene.add(mesh, settings);
  return scene;
}

void expect_issue(const Mesh& mesh, std::uint32_t bad, Reason reason) {
  const Scene scene = second(mesh);
  ASSERT_EQ(scene.issues().size(), 1u);
  EXPECT_EQ(scene.issues()[0].object, 1u);
  EXPECT_EQ(scene.issues()[0].face, bad);
  EXPECT_EQ(scene.issues()[0].reason, reason) << scene.issues()[0].text();
  const Object& object = scene.objects()[1];
  ASSERT_EQ(object.face_count, mesh.face_count());
  for (std::uint32_t k = 0; k < object.face_count; ++k) {
    const Face& face = scene.faces()[object.first_face + k];
    EXPECT_EQ(face.number, k);
    EXPECT_EQ(face.facet_count == 0, k == bad && is_refusal(reason)) << "face " << k;
    EXPECT_EQ(face.area == 0, k == bad && is_refusal(reason)) << "face " << k;
  }
}

Mesh between_good(const std::vector<Vec3>& points) {
  Mesh mesh = scenes::rectangle({10, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), points.begin(), points.end());
  std::vector<std::uint32_t> loop;
  for (std::uint32_t i = 0; i < points.size(); ++i) loop.push_back(base + i);
  mesh.add_face(loop);
  scenes::append(mesh, scenes::rectangle({20, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  return mesh;
}

void expect_facets_tile(const Scene& scene, std::uint32_t face_index, double area) {
  const Face& face = scene.faces()[face_index];
  EXPECT_NEAR(face.area, area, 1e-12 * area);
  double sum = 0;
  for (std::uint32_t k = 0; k < face.facet_count; ++k) {
    const Facet& facet = scene.facets()[face.first_facet + k];
    EXPECT_EQ(facet.face, face_index);
    ASSERT_GE(facet.corner_count, 3u);
    const Plane& plane = scene.planes()[facet.plane];
    EXPECT_NEAR(plane.normal.norm(), 1, 1e-15);
    const auto corners = scene.corners_of(facet);
    const auto at = [&](std::size_t i) -> const Vec3& {
      return scene.vertices()[corners[i % corners.size()].vertex];
    };
    Vec3 twice = Vec3::Zero();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      EXPECT_LE(std::abs(plane.normal.dot(at(i) - plane.point)),
                plane.flatness * (1 + 1e-9) + 1e-15);
      EXPECT_GE((at(i + 1) - at(i)).cross(at(i + 2) - at(i + 1)).dot(plane.normal), -1e-12 * area)
          << "not convex";
      twice += (at(i) - at(0)).cross(at(i + 1) - at(0));
      const Edge& edge = scene.edges()[corners[i].edge >> 1];
      EXPECT_LT(edge.a, edge.b);
      const bool turned = corners[i].edge & 1;
      EXPECT_EQ(turned ? edge.b : edge.a, corners[i].vertex);
      EXPECT_EQ(turned ? edge.a : edge.b, corners[(i + 1) % corners.size()].vertex);
    }
    EXPECT_GT(twice.dot(plane.normal), 0);
    sum += twice.norm() / 2;
  }
  EXPECT_NEAR(sum, area, 1e-12 * area);
}

}  // namespace shadowcut::testing
