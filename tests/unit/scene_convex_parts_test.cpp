// Concave faces and faces with holes are cut into convex facets.
#include <gtest/gtest.h>

#include <cmath>

#include "import_checks.hpp"
#include "scenes.hpp"

namespace shadowcut::testing {
namespace {

TEST(ConvexParts, ConcaveComb) {
  const Mesh mesh = polygon({{0, 0, 1},
                             {5, 0, 1},
                             {5, 3, 1},
                             {4, 3, 1},
                             {4, 1, 1},
                             {3, 1, 1},
                             {3, 3, 1},
                             {2, 3, 1},
                             {2, 1, 1},
                             {1, 1, 1},
                             {1, 3, 1},
                             {0, 3, 1}});
  const Scene scene = second(mesh);
  EXPECT_TRUE(scene.issues().empty());
  EXPECT_GE(scene.faces()[1].facet_count, 3u);
  EXPECT_LE(scene.faces()[1].facet_count, 10u);
  expect_facets_tile(scene, 1, 11);
}

TEST(ConvexParts, HoleEitherWay) {
  for (const bool turned : {false, true}) {
    Mesh mesh = polygon({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}});
    if (turned) add_hole(mesh, {{1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}});
    else add_hole(mesh, {{1, 1, 0}, {3, 1, 0}, {3, 3, 0}, {1, 3, 0}});
    const Scene scene = second(mesh);
    EXPECT_TRUE(scene.issues().empty());
    expect_facets_tile(scene, 1, 12);
    EXPECT_GT(scene.planes()[scene.facets()[scene.faces()[1].first_facet].plane].normal.z(), 0.999);
  }
}

TEST(ConvexParts, ManyHolesInATiltedPlane) {
  Mesh mesh = polygon({{0, 0, 0}, {20, 0, 0}, {20, 20, 0}, {0, 20, 0}});
  for (int x = 1; x < 19; x += 3)
    for (int y = 1; y < 19; y += 3) {
      const double u = x, v = y;
      add_hole(mesh, {{u, v, 0}, {u + 2, v, 0}, {u + 1, v + 2, 0}});
    }
  ObjectSettings settings;
  settings.pose =
      Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized());
  Scene scene;
  scene.add(mesh, settings);
  EXPECT_TRUE(scene.issues().empty());
  expect_facets_tile(scene, 0, 400 - 36 * 2);
}

TEST(ConvexParts, RandomStars) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    scenes::Random random(seed);
    const std::size_t n = 3 + random.below(40);
    Mesh mesh;
    std::vector<std::uint32_t> loop;
    double twice = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
      const double turn = 2 * 3.141592653589793 * i / static_cast<double>(n),
                   r = 0.2 + random.unit();
      mesh.vertices.emplace_back(r * std::cos(turn), r * std::sin(turn), 0);
      loop.push_back(i);
    }
    for (std::size_t i = 0; i < n; ++i)
      twice += mesh.vertices[i].cross(mesh.vertices[(i + 1) % n]).z();
    mesh.add_face(loop);
    const Scene scene = second(mesh);
    EXPECT_TRUE(scene.issues().empty());
    expect_facets_tile(scene, 1, twice / 2);
  }
}

TEST(ConvexParts, StraightCornersAreKept) {
  const Scene scene = second(polygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}));
  ASSERT_EQ(scene.faces()[1].facet_count, 1u);
  EXPECT_EQ(scene.facets()[scene.faces()[1].first_facet].corner_count, 5u);
}

TEST(ConvexParts, LongOutline) {
  Mesh mesh;  // a saw of 300 teeth
  std::vector<std::uint32_t> loop;
  for (std::uint32_t i = 0; i < 600; ++i) mesh.vertices.emplace_back(600 - i, 1 + i % 2, 0);
  mesh.vertices.emplace_back(0, 0, 0);
  mesh.vertices.emplace_back(601, 0, 0);
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) loop.push_back(i);
  mesh.add_face(loop);
  const Scene scene = second(mesh);
  EXPECT_TRUE(scene.issues().empty());
  double twice = 0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    twice += mesh.vertices[i].cross(mesh.vertices[(i + 1) % loop.size()]).z();
  expect_facets_tile(scene, 1, std::abs(twice) / 2);
}

}  // namespace
}  // namespace shadowcut::testing
