// The door: every reason to refuse or repair a face, with the object and face it names; welding,
// convex parts, closed or open.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <shadowcut/shadows.hpp>

#include "random_scenes.hpp"
#include "scenes.hpp"

namespace shadowcut::testing {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(),
                 kInfinity = std::numeric_limits<double>::infinity();

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

// A scene whose second object is `mesh`, so that an issue must count objects.
Scene second(const Mesh& mesh, Sides sides = Sides::automatic) {
  Scene scene;
  scene.add(scenes::rectangle({0, 0, -9}, {1, 0, 0}, {0, 1, 0}), {});
  ObjectSettings settings;
  settings.name = "it";
  settings.sides = sides;
  scene.add(mesh, settings);
  return scene;
}

// The mesh's face `bad` has this one issue; the other faces are kept.
void expect_issue(const Mesh& mesh, std::uint32_t bad, Reason reason) {
  const Scene scene = second(mesh);
  ASSERT_EQ(scene.issues().size(), 1u);
  EXPECT_EQ(scene.issues()[0].object, 1u);
  EXPECT_EQ(scene.issues()[0].face, bad);
  EXPECT_EQ(scene.issues()[0].reason, reason) << describe(scene.issues()[0].reason);
  const Object& object = scene.objects()[1];
  ASSERT_EQ(object.face_count, mesh.face_count());
  for (std::uint32_t k = 0; k < object.face_count; ++k) {
    const Face& face = scene.faces()[object.first_face + k];
    EXPECT_EQ(face.number, k);
    EXPECT_EQ(face.facet_count == 0, k == bad && refuses(reason)) << "face " << k;
    EXPECT_EQ(face.area == 0, k == bad && refuses(reason)) << "face " << k;
  }
}

// A good face, then `loop` in the same vertices, then a good face.
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

TEST(Door, GoodFacesHaveNoIssue) {
  const Scene scene = second(scenes::box({0, 0, 0}, {1, 2, 3}));
  EXPECT_TRUE(scene.issues().empty());
  EXPECT_EQ(scene.objects()[1].name, "it");
  for (std::uint32_t f = 1; f < 7; ++f) EXPECT_EQ(scene.faces()[f].facet_count, 1u);
  EXPECT_EQ(scene.objects()[1].vertex_count, 8u);
}

TEST(Door, NonFinite) {
  for (const double bad : {kNaN, kInfinity, -kInfinity})
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 v(1, 1, 0);
      v[axis] = bad;
      expect_issue(between_good({{0, 0, 0}, {1, 0, 0}, v}), 1, Reason::non_finite);
    }
}

TEST(Door, UnusedNonFiniteVertexHarmsNothing) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.vertices.emplace_back(kNaN, 0, 0);
  EXPECT_TRUE(second(mesh).issues().empty());
}

TEST(Door, IndexOutOfRange) {
  for (const std::uint32_t bad : {4u, 1000u, 0xFFFFFFFFu}) {
    Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    mesh.add_face({0, 1, bad});
    mesh.add_face({2, 1, 0});
    expect_issue(mesh, 1, Reason::index_out_of_range);
  }
}

TEST(Door, IndexOutOfRangeInAHole) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.add_face({3, 2, 1, 0});
  constexpr std::array<std::uint32_t, 3> hole{0, 1, 77};
  mesh.add_hole(hole);
  expect_issue(mesh, 1, Reason::index_out_of_range);
}

TEST(Door, TooFewCorners) {
  expect_issue(between_good({}), 1, Reason::too_few_corners);
  expect_issue(between_good({{0, 0, 0}}), 1, Reason::too_few_corners);
  expect_issue(between_good({{0, 0, 0}, {1, 0, 0}}), 1, Reason::too_few_corners);
  expect_issue(between_good({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}}), 1, Reason::too_few_corners);
  expect_issue(between_good({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}), 1,
               Reason::too_few_corners);
}

TEST(Door, ZeroArea) {
  expect_issue(between_good({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}), 1, Reason::zero_area);
  expect_issue(between_good({{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {2, 0, 0}}), 1, Reason::zero_area);
}

TEST(Door, ThinButNotZero) {
  const Scene scene = second(polygon({{0, 0, 0}, {1, 0, 0}, {0, 1e-9, 0}}));
  EXPECT_TRUE(scene.issues().empty());
  EXPECT_NEAR(scene.faces()[1].area, 0.5e-9, 1e-18);
}

TEST(Door, BowTie) {
  expect_issue(between_good({{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 1, 0}}), 1,
               Reason::self_intersecting);
}

// Touching is not crossing: such outlines come out of bridges to holes. They are cut as what they
// enclose.
TEST(Door, OutlineTouchesItself) {
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
TEST(Door, OutlineRunsRoundTwice) {
  expect_issue(
      between_good({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0}, {2, 1, 0}, {1, 2, 0}}),
      1, Reason::self_intersecting);
  expect_issue(
      between_good({{4, 2, 0}, {3, 2, 0}, {1, 4, 0}, {3, 3, 0}, {2, 3, 0}, {0, 4, 0}, {3, 4, 0}}),
      1, Reason::self_intersecting);
}

TEST(Door, OutlineTurnsBackOnItself) {
  expect_issue(between_good({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {2, 4, 0}, {2, 2, 0.0}, {0, 2, 0}}),
               1, Reason::self_intersecting);
}

TEST(Door, HoleLeavesTheOutline) {
  Mesh crossing = polygon({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}});
  add_hole(crossing, {{3, 1, 0}, {5, 1, 0}, {5, 2, 0}, {3, 2, 0}});
  expect_issue(crossing, 0, Reason::self_intersecting);
  Mesh outside = polygon({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}});
  add_hole(outside, {{5, 1, 0}, {6, 1, 0}, {6, 2, 0}});
  expect_issue(outside, 0, Reason::self_intersecting);
}

TEST(Door, HolesCrossOrNest) {
  Mesh crossing = polygon({{0, 0, 0}, {9, 0, 0}, {9, 9, 0}, {0, 9, 0}});
  add_hole(crossing, {{1, 1, 0}, {5, 1, 0}, {5, 5, 0}, {1, 5, 0}});
  add_hole(crossing, {{3, 3, 0}, {7, 3, 0}, {7, 7, 0}, {3, 7, 0}});
  expect_issue(crossing, 0, Reason::self_intersecting);
  Mesh nested = polygon({{0, 0, 0}, {9, 0, 0}, {9, 9, 0}, {0, 9, 0}});
  add_hole(nested, {{1, 1, 0}, {8, 1, 0}, {8, 8, 0}, {1, 8, 0}});
  add_hole(nested, {{3, 3, 0}, {5, 3, 0}, {5, 5, 0}, {3, 5, 0}});
  expect_issue(nested, 0, Reason::self_intersecting);
}

TEST(Door, Duplicate) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.add_face({0, 1, 2, 3});
  expect_issue(mesh, 1, Reason::duplicate);
  Mesh rotated = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  rotated.add_face({2, 3, 0, 1});  // the same order, begun elsewhere
  expect_issue(rotated, 1, Reason::duplicate);
}

TEST(Door, DuplicateByPositionNotByIndex) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  scenes::append(mesh, scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  expect_issue(mesh, 1, Reason::duplicate);
}

TEST(Door, OppositeFaceIsNoDuplicate) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.add_face({3, 2, 1, 0});
  EXPECT_TRUE(second(mesh).issues().empty());
}

TEST(Door, RepeatedCornerIsRepaired) {
  const Mesh mesh = between_good({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}});
  expect_issue(mesh, 1, Reason::repeated_corner);
  const Scene scene = second(mesh);
  EXPECT_EQ(scene.facets()[scene.faces()[2].first_facet].corner_count, 3u);
  expect_facets_tile(scene, 2, 0.5);
}

TEST(Door, NegativeZeroIsZero) {
  Mesh mesh = polygon({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  mesh.vertices.emplace_back(-0.0, 0, -0.0);
  mesh.add_face({3, 2, 1});
  const Scene scene = second(mesh);
  EXPECT_EQ(scene.objects()[1].vertex_count, 3u);
}

TEST(Door, NotFlatIsTriangulated) {
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

TEST(Door, FlatnessToleranceIsAShareOfTheDiameter) {
  const Mesh flat_enough = polygon({{0, 0, 0}, {1000, 0, 2e-4}, {1000, 1000, 0}, {0, 1000, 2e-4}});
  EXPECT_TRUE(second(flat_enough).issues().empty());
  expect_issue(polygon({{0, 0, 0}, {1, 0, 2e-4}, {1, 1, 0}, {0, 1, 2e-4}}), 0, Reason::not_flat);
  Scene lenient;
  lenient.flatness_tolerance = 1e-3;
  lenient.add(polygon({{0, 0, 0}, {1, 0, 2e-4}, {1, 1, 0}, {0, 1, 2e-4}}), {});
  EXPECT_TRUE(lenient.issues().empty());
}

TEST(Door, SeveralIssuesAreAllListed) {
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
    EXPECT_TRUE(refuses(scene.issues()[k].reason));
    EXPECT_GT(std::string(describe(scene.issues()[k].reason)).size(), 3u);
  }
}

TEST(Door, RefusedFacesStayShadowless) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.add_face({0, 1});
  const Scene scene = second(mesh);
  const Shadows shadows = cast_shadows(scene, Light::point({0, 0, 5}));
  EXPECT_EQ(shadows.areas[2].facing, Facing::refused);
  EXPECT_EQ(shadows.areas[2].area, 0);
}

TEST(Door, OnlyFlatAndRepeatedAreRepairs) {
  EXPECT_FALSE(refuses(Reason::not_flat));
  EXPECT_FALSE(refuses(Reason::repeated_corner));
  for (const Reason r : {Reason::non_finite, Reason::index_out_of_range, Reason::too_few_corners,
                         Reason::zero_area, Reason::self_intersecting, Reason::duplicate})
    EXPECT_TRUE(refuses(r));
}

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

TEST(Welding, EqualPositionsBecomeOneVertex) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  scenes::append(mesh, scenes::rectangle({1, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  const Scene scene = second(mesh);
  EXPECT_EQ(scene.objects()[1].vertex_count, 6u);
  std::set<std::uint32_t> edges;
  for (std::uint32_t f = 1; f < 3; ++f)
    for (const Corner& c : scene.corners_of(scene.facets()[scene.faces()[f].first_facet]))
      edges.insert(c.edge >> 1);
  EXPECT_EQ(edges.size(), 7u);  // the one between them is shared
}

TEST(Welding, NearlyEqualPositionsStayApart) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  scenes::append(mesh, scenes::rectangle({std::nextafter(1.0, 2.0), 0, 0}, {1, 0, 0}, {0, 1, 0}));
  EXPECT_EQ(second(mesh).objects()[1].vertex_count, 8u);
}

TEST(SidesDecision, BoxIsClosed) {
  const Scene scene = second(scenes::box({0, 0, 0}, {1, 2, 3}));
  EXPECT_EQ(scene.objects()[1].sides, Sides::closed);
  EXPECT_DOUBLE_EQ(scene.objects()[1].signed_volume, 6);
}

TEST(SidesDecision, BoxOfSeparateQuadsIsClosedAfterWelding) {
  const Mesh box = scenes::box({0, 0, 0}, {1, 2, 3});
  Mesh loose;
  for (std::size_t f = 0; f < 6; ++f) {
    std::vector<std::uint32_t> loop;
    for (const std::uint32_t v : box.loop(f, 0)) {
      loop.push_back(static_cast<std::uint32_t>(loose.vertices.size()));
      loose.vertices.push_back(box.vertices[v]);
    }
    loose.add_face(loop);
  }
  EXPECT_EQ(second(loose).objects()[1].sides, Sides::closed);
}

TEST(SidesDecision, MissingFaceIsOpen) {
  const Mesh box = scenes::box({0, 0, 0}, {1, 1, 1});
  Mesh mesh;
  mesh.vertices = box.vertices;
  for (std::size_t f = 0; f < 5; ++f) mesh.add_face(box.loop(f, 0));
  EXPECT_EQ(second(mesh).objects()[1].sides, Sides::open);
}

TEST(SidesDecision, OneFaceTurnedIsOpen) {
  const Mesh box = scenes::box({0, 0, 0}, {1, 1, 1});
  Mesh mesh;
  mesh.vertices = box.vertices;
  for (std::size_t f = 0; f < 6; ++f) {
    std::vector<std::uint32_t> loop(box.loop(f, 0).begin(), box.loop(f, 0).end());
    if (f == 3) std::reverse(loop.begin(), loop.end());
    mesh.add_face(loop);
  }
  EXPECT_EQ(second(mesh).objects()[1].sides, Sides::open);
}

TEST(SidesDecision, InsideOutIsOpen) {
  const Mesh box = scenes::box({0, 0, 0}, {1, 1, 1});
  Mesh mesh;
  mesh.vertices = box.vertices;
  for (std::size_t f = 0; f < 6; ++f) {
    std::vector<std::uint32_t> loop(box.loop(f, 0).rbegin(), box.loop(f, 0).rend());
    mesh.add_face(loop);
  }
  const Scene scene = second(mesh);
  EXPECT_EQ(scene.objects()[1].sides, Sides::open);
  EXPECT_DOUBLE_EQ(scene.objects()[1].signed_volume, -1);
}

TEST(SidesDecision, OnePartInsideOutIsOpen) {
  Mesh mesh = scenes::box({0, 0, 0}, {9, 9, 9});
  const Mesh small = scenes::box({20, 0, 0}, {21, 1, 1});
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), small.vertices.begin(), small.vertices.end());
  for (std::size_t f = 0; f < 6; ++f) {
    std::vector<std::uint32_t> loop;
    for (const std::uint32_t v : small.loop(f, 0)) loop.insert(loop.begin(), base + v);
    mesh.add_face(loop);
  }
  EXPECT_EQ(second(mesh).objects()[1].sides, Sides::open);
}

TEST(SidesDecision, TwoPartsTouchingInAVertexAreClosed) {
  Mesh mesh = scenes::box({0, 0, 0}, {1, 1, 1});
  scenes::append(mesh, scenes::box({1, 1, 1}, {2, 2, 2}));
  EXPECT_EQ(second(mesh).objects()[1].sides, Sides::closed);
}

TEST(SidesDecision, TwoPartsSharingAnEdgeAreOpen) {
  Mesh mesh = scenes::box({0, 0, 0}, {1, 1, 1});
  scenes::append(mesh, scenes::box({1, 1, 0}, {2, 2, 1}));
  EXPECT_EQ(second(mesh).objects()[1].sides, Sides::open);
}

TEST(SidesDecision, RefusedFaceOpensASolid) {
  const Mesh box = scenes::box({0, 0, 0}, {1, 1, 1});
  Mesh mesh;
  mesh.vertices = box.vertices;
  mesh.vertices.emplace_back(kNaN, 0, 0);
  for (std::size_t f = 0; f < 5; ++f) mesh.add_face(box.loop(f, 0));
  mesh.add_face({1, 3, 8, 5});
  EXPECT_EQ(second(mesh).objects()[1].sides, Sides::open);
}

TEST(SidesDecision, CanBeOverridden) {
  EXPECT_EQ(second(scenes::box({0, 0, 0}, {1, 1, 1}), Sides::open).objects()[1].sides, Sides::open);
  EXPECT_EQ(
      second(scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), Sides::closed).objects()[1].sides,
      Sides::closed);
}

TEST(SidesDecision, FarFromTheOrigin) {
  const Scene scene = second(scenes::box({1e6, -1e6, 1e6}, {1e6 + 1, -1e6 + 1, 1e6 + 1}));
  EXPECT_EQ(scene.objects()[1].sides, Sides::closed);
  EXPECT_NEAR(scene.objects()[1].signed_volume, 1, 1e-6);
}

TEST(Pose, MirrorKeepsOutsideOutside) {
  ObjectSettings settings;
  settings.pose = Pose(Eigen::Scaling(-1.0, 1.0, 1.0));
  Scene scene;
  scene.add(scenes::box({0, 0, 0}, {1, 2, 3}), settings);
  EXPECT_EQ(scene.objects()[0].sides, Sides::closed);
  EXPECT_DOUBLE_EQ(scene.objects()[0].signed_volume, 6);
  for (const Facet& facet : scene.facets()) {
    const Plane& plane = scene.planes()[facet.plane];
    EXPECT_GT(plane.normal.dot(plane.point - Vec3(-0.5, 1, 1.5)), 0);
  }
}

TEST(Pose, MovesVertices) {
  ObjectSettings settings;
  settings.pose = Eigen::Translation3d(10, 0, 0) * Eigen::Scaling(2.0);
  Scene scene;
  scene.add(scenes::rectangle({1, 1, 1}, {1, 0, 0}, {0, 1, 0}), settings);
  EXPECT_EQ(scene.vertices()[0], Vec3(12, 2, 2));
  EXPECT_EQ(scene.faces()[0].area, 4);
}

TEST(Pose, SingularOrNonFiniteIsRefused) {
  const Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  Scene scene;
  ObjectSettings settings;
  settings.pose = Pose(Eigen::Scaling(1.0, 1.0, 0.0));
  EXPECT_THROW(scene.add(mesh, settings), Error);
  settings.pose = Pose::Identity();
  settings.pose.translation().x() = kNaN;
  EXPECT_THROW(scene.add(mesh, settings), Error);
  EXPECT_TRUE(scene.objects().empty());
  EXPECT_TRUE(scene.vertices().empty());
}

TEST(Lights, BadOnesAreRefused) {
  Scene scene;
  EXPECT_THROW(scene.add(Light::point({kNaN, 0, 0})), Error);
  EXPECT_THROW(scene.add(Light::directional({0, kInfinity, 0})), Error);
  EXPECT_THROW(scene.add(Light::directional({0, 0, 0})), Error);
  Light light = Light::point({0, 0, 0});
  for (const double range : {0.0, -1.0, kNaN}) {
    light.range = range;
    EXPECT_THROW(scene.add(light), Error) << range;
  }
  light.range = 5;
  for (const double angle : {0.0, -1.0, 3.2, kNaN}) {
    light.spot = Light::Spot{{0, 0, 1}, angle};
    EXPECT_THROW(scene.add(light), Error) << angle;
  }
  light.spot = Light::Spot{{0, 0, 0}, 1};
  EXPECT_THROW(scene.add(light), Error);
  light.spot = Light::Spot{{0, 0, kNaN}, 1};
  EXPECT_THROW(scene.add(light), Error);
  EXPECT_TRUE(scene.lights().empty());
}

TEST(Lights, GoodOnesAreKept) {
  Scene scene;
  Light light = Light::point({1, 2, 3});
  light.name = "lamp";
  light.range = 4;
  light.spot = Light::Spot{{0, 0, -2}, 3.141592653589793};
  EXPECT_EQ(scene.add(light).index, 0u);
  EXPECT_EQ(scene.add(Light::directional({0, 0, -1e-300})).index, 1u);
  ASSERT_EQ(scene.lights().size(), 2u);
  EXPECT_EQ(scene.lights()[0].name, "lamp");
}

TEST(Meshes, LoopsComeBack) {
  Mesh mesh = polygon({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}});
  add_hole(mesh, {{1, 1, 0}, {2, 1, 0}, {1, 2, 0}});
  mesh.add_face({3, 2, 1});
  ASSERT_EQ(mesh.face_count(), 2u);
  EXPECT_EQ(mesh.loop_count(0), 2u);
  EXPECT_EQ(mesh.loop_count(1), 1u);
  EXPECT_EQ(std::vector<std::uint32_t>(mesh.loop(0, 1).begin(), mesh.loop(0, 1).end()),
            (std::vector<std::uint32_t>{4, 5, 6}));
  EXPECT_EQ(mesh.loop(1, 0)[0], 3u);
}

TEST(GeneratedSizes, AreThoseOfThePaper) {
  constexpr std::array<std::size_t, 4> polygons{133, 211, 313, 745};
  for (int level = 1; level <= 4; ++level)
    EXPECT_EQ(scenes::polygon_count(scenes::room(level)),
              polygons[static_cast<std::size_t>(level - 1)]);
  for (const auto& [depth, count] : {std::pair(2, 65u), {3, 257u}, {4, 1025u}})
    EXPECT_EQ(scenes::polygon_count(scenes::tetrahedron(depth)), count);
}

TEST(GeneratedSizes, FurnitureIsClosed) {
  for (int level = 1; level <= 4; ++level) {
    const Scene scene = scenes::build(scenes::room(level));
    EXPECT_TRUE(scene.issues().empty());
    for (const Object& object : scene.objects()) {
      const std::string what = object.name.substr(0, object.name.find('.'));
      EXPECT_EQ(object.sides == Sides::open, what == "room" || what == "poster" || what == "screen")
          << object.name;
    }
  }
}

TEST(Given, MakesTheObjectAgain) {
  Scene scene = second(scenes::box({0, 0, 0}, {1, 2, 3}));
  const ObjectId id = scene.object_id(1);
  Pose pose = Pose::Identity();
  pose.translate(Vec3(0.1, 0.2, 0.3));
  ASSERT_EQ(scene.set_pose(id, pose), Edit::done);
  std::vector<Vec3> deformed = scenes::box({0, 0, 0}, {1, 2, 3.7}).vertices;
  ASSERT_EQ(scene.set_vertices(id, deformed), Edit::done);
  ASSERT_EQ(scene.set_casts(id, false), Edit::done);
  const Object before = *scene.find(id);
  const std::vector<Vec3> vertices(
      scene.vertices().begin() + before.first_vertex,
      scene.vertices().begin() + before.first_vertex + before.vertex_count);
  const auto given = scene.given(id);
  ASSERT_TRUE(given);
  EXPECT_EQ(given->second.sides, Sides::automatic);  // as asked for, not as decided
  ASSERT_EQ(scene.remove(id), Edit::done);
  EXPECT_FALSE(scene.given(id));
  const Object& after = *scene.find(scene.add(given->first, given->second));
  EXPECT_EQ(after.name, before.name);
  EXPECT_EQ(after.casts, false);
  EXPECT_EQ(after.sides, Sides::closed);
  EXPECT_TRUE(
      std::equal(vertices.begin(), vertices.end(), scene.vertices().begin() + after.first_vertex));
}

}  // namespace
}  // namespace shadowcut::testing
