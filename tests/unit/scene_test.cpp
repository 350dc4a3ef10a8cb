// A scene's objects: welding, closed or open, poses, lights, and meshes that come back.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <shadowcut/shadows.hpp>

#include "import_checks.hpp"
#include "random_scenes.hpp"
#include "scenes.hpp"

namespace shadowcut::testing {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(),
                 kInfinity = std::numeric_limits<double>::infinity();

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

TEST(Lights, DirectionalOnesHaveNoRangeAndNoSpot) {
  Scene scene;
  Light ranged = Light::directional({0, 0, -1}), spot = ranged;
  ranged.range = 5;
  EXPECT_THROW(scene.add(ranged), Error);
  EXPECT_THROW(cast_shadows(scene, ranged), Error);
  spot.spot = Light::Spot{{0, 0, -1}, 1};
  try {
    spot.check("the lamp");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "the lamp: a directional light has no spot");
  }
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
  ASSERT_EQ(scene.set_pose(id, pose), Status::ok);
  std::vector<Vec3> deformed = scenes::box({0, 0, 0}, {1, 2, 3.7}).vertices;
  ASSERT_EQ(scene.set_vertices(id, deformed), Status::ok);
  ASSERT_EQ(scene.set_casts_shadows(id, false), Status::ok);
  const Object before = *scene.find(id);
  const std::vector<Vec3> vertices(
      scene.vertices().begin() + before.first_vertex,
      scene.vertices().begin() + before.first_vertex + before.vertex_count);
  const auto given = scene.source(id);
  ASSERT_TRUE(given);
  EXPECT_EQ(given->second.sides, Sides::automatic);  // as asked for, not as decided
  ASSERT_EQ(scene.remove(id), Status::ok);
  EXPECT_FALSE(scene.source(id));
  const Object& after = *scene.find(scene.add(given->first, given->second));
  EXPECT_EQ(after.name, before.name);
  EXPECT_EQ(after.casts_shadows, false);
  EXPECT_EQ(after.sides, Sides::closed);
  EXPECT_TRUE(
      std::equal(vertices.begin(), vertices.end(), scene.vertices().begin() + after.first_vertex));
}

}  // namespace
}  // namespace shadowcut::testing
