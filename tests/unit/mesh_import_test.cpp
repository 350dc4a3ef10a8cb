// Mesh import: every reason to refuse or repair a face, with the object and face that it names.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <shadowcut/shadows.hpp>

#include "import_checks.hpp"
#include "scenes.hpp"

namespace shadowcut::testing {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(),
                 kInfinity = std::numeric_limits<double>::infinity();

TEST(MeshImport, GoodFacesHaveNoIssue) {
  const Scene scene = second(scenes::box({0, 0, 0}, {1, 2, 3}));
  EXPECT_TRUE(scene.issues().empty());
  EXPECT_EQ(scene.objects()[1].name, "it");
  for (std::uint32_t f = 1; f < 7; ++f) EXPECT_EQ(scene.faces()[f].facet_count, 1u);
  EXPECT_EQ(scene.objects()[1].vertex_count, 8u);
}

TEST(MeshImport, NonFinite) {
  for (const double bad : {kNaN, kInfinity, -kInfinity})
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 v(1, 1, 0);
      v[axis] = bad;
      expect_issue(between_good({{0, 0, 0}, {1, 0, 0}, v}), 1, Reason::non_finite);
    }
}

TEST(MeshImport, UnusedNonFiniteVertexHarmsNothing) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.vertices.emplace_back(kNaN, 0, 0);
  EXPECT_TRUE(second(mesh).issues().empty());
}

TEST(MeshImport, IndexOutOfRange) {
  for (const std::uint32_t bad : {4u, 1000u, 0xFFFFFFFFu}) {
    Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    mesh.add_face({0, 1, bad});
    mesh.add_face({2, 1, 0});
    expect_issue(mesh, 1, Reason::index_out_of_range);
  }
}

TEST(MeshImport, IndexOutOfRangeInAHole) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.add_face({3, 2, 1, 0});
  constexpr std::array<std::uint32_t, 3> hole{0, 1, 77};
  mesh.add_hole(hole);
  expect_issue(mesh, 1, Reason::index_out_of_range);
}

TEST(MeshImport, TooFewCorners) {
  expect_issue(between_good({}), 1, Reason::too_few_corners);
  expect_issue(between_good({{0, 0, 0}}), 1, Reason::too_few_corners);
  expect_issue(between_good({{0, 0, 0}, {1, 0, 0}}), 1, Reason::too_few_corners);
  expect_issue(between_good({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}}), 1, Reason::too_few_corners);
  expect_issue(between_good({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}), 1,
               Reason::too_few_corners);
}

TEST(MeshImport, ZeroArea) {
  expect_issue(between_good({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}), 1, Reason::zero_area);
  expect_issue(between_good({{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {2, 0, 0}}), 1, Reason::zero_area);
}

TEST(MeshImport, ThinButNotZero) {
  const Scene scene = second(polygon({{0, 0, 0}, {1, 0, 0}, {0, 1e-9, 0}}));
  EXPECT_TRUE(scene.issues().empty());
  EXPECT_NEAR(scene.faces()[1].area, 0.5e-9, 1e-18);
}

TEST(MeshImport, BowTie) {
  expect_issue(between_good({{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 1, 0}}), 1,
               Reason::self_intersecting);
}

// Touching is not crossing: such outlines come out of bridges to holes. They are cut as what they
// enclose.
TEST(MeshImport, OutlineTouchesItself) {
  // corner on edge
  const Scene edge = second(between_good({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 0, 0}, {0, 4, 0}}));
  EXPECT_TRUE(edge.issues().empty());
  EXPECT_DOUBLE_EQ(edge.faces()[edge.objects()[1].first_face + 1].area, 8);
  const Scene corner =
      // corner on corner
      second(between_good({{0, 0, 0},
                           {2, 0, 0},
                           {2, 2, 0},
                           {4, 2, 0},
                           {4, 4, 0},
                           {2, 4, 0},
                           {2, 2, 0},
                           {0, 2, 0}}));
  EXPECT_TRUE(corner.issues().empty());
  EXPECT_DOUBLE_EQ(corner.faces()[corner.objects()[1].first_face + 1].area, 8);
}

// Passing through a corner or along an edge of its own, an outline can run round a place twice.
TEST(MeshImport, OutlineRunsRoundTwice) {
  expect_issue(
      between_good({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0}, {2, 1, 0}, {1, 2, 0}}),
      1, Reason::self_intersecting);
  expect_issue(
      between_good({{4, 2, 0}, {3, 2, 0}, {1, 4, 0}, {3, 3, 0}, {2, 3, 0}, {0, 4, 0}, {3, 4, 0}}),
      1, Reason::self_intersecting);
}

TEST(MeshImport, OutlineTurnsBackOnItself) {
  expect_issue(between_good({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {2, 4, 0}, {2, 2, 0.0}, {0, 2, 0}}),
               1, Reason::self_intersecting);
}

TEST(MeshImport, HoleLeavesTheOutline) {
  Mesh crossing = polygon({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}});
  add_hole(crossing, {{3, 1, 0}, {5, 1, 0}, {5, 2, 0}, {3, 2, 0}});
  expect_issue(crossing, 0, Reason::self_intersecting);
  Mesh outside = polygon({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}});
  add_hole(outside, {{5, 1, 0}, {6, 1, 0}, {6, 2, 0}});
  expect_issue(outside, 0, Reason::self_intersecting);
}

TEST(MeshImport, HolesCrossOrNest) {
  Mesh crossing = polygon({{0, 0, 0}, {9, 0, 0}, {9, 9, 0}, {0, 9, 0}});
  add_hole(crossing, {{1, 1, 0}, {5, 1, 0}, {5, 5, 0}, {1, 5, 0}});
  add_hole(crossing, {{3, 3, 0}, {7, 3, 0}, {7, 7, 0}, {3, 7, 0}});
  expect_issue(crossing, 0, Reason::self_intersecting);
  Mesh nested = polygon({{0, 0, 0}, {9, 0, 0}, {9, 9, 0}, {0, 9, 0}});
  add_hole(nested, {{1, 1, 0}, {8, 1, 0}, {8, 8, 0}, {1, 8, 0}});
  add_hole(nested, {{3, 3, 0}, {5, 3, 0}, {5, 5, 0}, {3, 5, 0}});
  expect_issue(nested, 0, Reason::self_intersecting);
}

TEST(MeshImport, Duplicate) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.add_face({0, 1, 2, 3});
  expect_issue(mesh, 1, Reason::duplicate);
  Mesh rotated = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  rotated.add_face({2, 3, 0, 1});  // the same order, begun elsewhere
  expect_issue(rotated, 1, Reason::duplicate);
}

TEST(MeshImport, DuplicateByPositionNotByIndex) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  scenes::append(mesh, scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  expect_issue(mesh, 1, Reason::duplicate);
}

TEST(MeshImport, OppositeFaceIsNoDuplicate) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.add_face({3, 2, 1, 0});
  EXPECT_TRUE(second(mesh).issues().empty());
}

TEST(MeshImport, RepeatedCornerIsRepaired) {
  const Mesh mesh = between_good({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}});
  expect_issue(mesh, 1, Reason::repeated_corner);
  const Scene scene = second(mesh);
  EXPECT_EQ(scene.facets()[scene.faces()[2].first_facet].corner_count, 3u);
  expect_facets_tile(scene, 2, 0.5);
}

TEST(MeshImport, NegativeZeroIsZero) {
  Mesh mesh = polygon({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  mesh.vertices.emplace_back(-0.0, 0, -0.0);
  mesh.add_face({3, 2, 1});
  const Scene scene = second(mesh);
  EXPECT_EQ(scene.objects()[1].vertex_count, 3u);
}

TEST(MeshImport, NotFlatIsTriangulated) {
  const Mesh mesh = between_good({{0, 0, 0}, {1, 0, 0.1}, {1, 1, 0}, {0, 1, 0.1}});
  expect_issue(mesh, 1, Reason::not_flat);
  const Scene scene = second(mesh);
  const Face& face = scene.faces()[2];
  ASSERT_EQ(face.facet_count, 2u);
  EXPECT_NE(scene.facets()[face.first_facet].plane, scene.facets()[face.first_facet + 1].plane);
  double area = 0;
  for (std::uint32_t k = 0; k < 2; ++k) {
    const auto c = scene.corners_of(scene.facets()[face.first_facet + k]);
    ASSERT_EQ(c.size(), 3u);
    const auto& v = scene.vertices();
    area += 0.5 * (v[c[1].vertex] - v[c[0].vertex]).cross(v[c[2].vertex] - v[c[0].vertex]).norm();
  }
  EXPECT_NEAR(face.area, area, 1e-15);
}

TEST(MeshImport, FlatnessToleranceIsAShareOfTheDiameter) {
  const Mesh flat_enough = polygon({{0, 0, 0}, {1000, 0, 2e-4}, {1000, 1000, 0}, {0, 1000, 2e-4}});
  EXPECT_TRUE(second(flat_enough).issues().empty());
  expect_issue(polygon({{0, 0, 0}, {1, 0, 2e-4}, {1, 1, 0}, {0, 1, 2e-4}}), 0, Reason::not_flat);
  Scene lenient;
  lenient.flatness_tolerance = 1e-3;
  lenient.add(polygon({{0, 0, 0}, {1, 0, 2e-4}, {1, 1, 0}, {0, 1, 2e-4}}), {});
  EXPECT_TRUE(lenient.issues().empty());
}

TEST(MeshImport, SeveralIssuesAreAllListed) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.add_face({0, 1});
  mesh.add_face({0, 1, 99});
  mesh.add_face({0, 1, 2, 3});
  Scene scene;
  scene.add(mesh, {});
  scene.add(mesh, {});
  ASSERT_EQ(scene.issues().size(), 6u);
  for (std::uint32_t k = 0; k < 6; ++k) {
    EXPECT_EQ(scene.issues()[k].object, k / 3);
    EXPECT_EQ(scene.issues()[k].face, 1 + k % 3);
    EXPECT_TRUE(scene.issues()[k].is_refusal());
    EXPECT_GT(std::string(scene.issues()[k].text()).size(), 3u);
  }
}

TEST(MeshImport, RefusedFacesStayShadowless) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.add_face({0, 1});
  const Scene scene = second(mesh);
  const Shadows shadows = cast_shadows(scene, Light::point({0, 0, 5}));
  EXPECT_EQ(shadows.areas[2].facing, Facing::refused);
  EXPECT_EQ(shadows.areas[2].area, 0);
}

TEST(MeshImport, OnlyFlatAndRepeatedAreRepairs) {
  EXPECT_FALSE(is_refusal(Reason::not_flat));
  EXPECT_FALSE(is_refusal(Reason::repeated_corner));
  for (const Reason r : {Reason::non_finite, Reason::index_out_of_range, Reason::too_few_corners,
                         Reason::zero_area, Reason::self_intersecting, Reason::duplicate})
    EXPECT_TRUE(is_refusal(r));
}

}  // namespace
}  // namespace shadowcut::testing
