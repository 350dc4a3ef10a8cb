// Ids of objects and lights, and the room that objects take in the scene's arrays.
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <set>

#include "follower.hpp"
#include "scene/scene_access.hpp"

namespace shadowcut::testing {
namespace {

TEST(Ids, StaleOnesChangeNothing) {
  Scene scene = scenes::build(scenes::city(2));
  Engine engine(scene);
  engine.update();
  const ObjectId gone = scene.object_id(2);
  ASSERT_EQ(scene.remove(gone), Status::ok);
  const LightId lamp = scene.add(Light::point({9, 9, 9}));
  ASSERT_EQ(scene.remove(lamp), Status::ok);
  const Scene before = scene;
  const std::uint64_t revision = SceneAccess::revision(scene);
  const std::vector<Vec3> vertices(8, Vec3::Zero());
  const auto expect_refused = [&](ObjectId object, LightId light, Status as) {
    EXPECT_EQ(scene.remove(object), as);
    EXPECT_EQ(scene.set_pose(object, Pose::Identity()), as);
    EXPECT_EQ(scene.set_vertices(object, vertices), as);
    EXPECT_EQ(scene.set_casts_shadows(object, false), as);
    EXPECT_EQ(scene.set_receives_shadows(object, false), as);
    EXPECT_EQ(scene.remove(light), as);
    EXPECT_EQ(scene.set_light(light, Light::point({1, 2, 3})), as);
    EXPECT_EQ(scene.find(object), nullptr);
    EXPECT_EQ(scene.find(light), nullptr);
    EXPECT_EQ(check_same_scene(before, scene), "");
    EXPECT_EQ(SceneAccess::revision(scene), revision);
  };
  expect_refused(gone, lamp, Status::stale);
  expect_refused({}, {}, Status::foreign);
  Scene other = scenes::build(scenes::city(2));
  expect_refused(other.object_id(1), other.light_id(0), Status::foreign);
  ObjectId beyond = scene.object_id(1);
  beyond.index = 100;
  LightId light_beyond = scene.light_id(0);
  light_beyond.index = 100;
  expect_refused(beyond, light_beyond, Status::foreign);
  EXPECT_EQ(scene.object_id(2), ObjectId{});
  EXPECT_EQ(scene.object_id(100), ObjectId{});
  EXPECT_EQ(scene.light_id(1), LightId{});
  // An index used again does not bring an old id back.
  const ObjectId again = scene.add(scenes::box({0, 0, 0}, {1, 1, 1}), {});
  EXPECT_EQ(again.index, gone.index);
  EXPECT_NE(again.generation, gone.generation);
  EXPECT_EQ(scene.remove(gone), Status::stale);
  EXPECT_NE(scene.find(again), nullptr);
}

TEST(Ids, BadArgumentsChangeNothing) {
  Scene scene = scenes::build(scenes::city(2));
  const ObjectId house = scene.object_id(1);
  const Scene before = scene;
  const std::uint64_t revision = SceneAccess::revision(scene);
  Pose singular = Pose::Identity();
  singular.linear().setZero();
  EXPECT_THROW(static_cast<void>(scene.set_pose(house, singular)), Error);
  singular.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(static_cast<void>(scene.set_pose(house, singular)), Error);
  EXPECT_THROW(static_cast<void>(scene.set_vertices(house, std::vector<Vec3>(7, Vec3::Zero()))),
               Error);
  EXPECT_THROW(
      static_cast<void>(scene.set_light(scene.light_id(0), Light::directional(Vec3::Zero()))),
      Error);
  EXPECT_THROW(scene.add(Light::directional(Vec3::Zero())), Error);
  const std::array lights{Light::point({1, 1, 1}), Light::directional(Vec3::Zero())};
  EXPECT_THROW(scene.replace_lights(lights), Error);
  ObjectSettings settings;
  settings.pose = singular;
  EXPECT_THROW(scene.add(scenes::box({0, 0, 0}, {1, 1, 1}), settings), Error);
  EXPECT_EQ(check_same_scene(before, scene), "");
  EXPECT_EQ(SceneAccess::revision(scene), revision);
}

TEST(Ids, CopyOfASceneKnowsThem) {
  Scene scene = scenes::build(scenes::city(2));
  const ObjectId house = scene.object_id(1);
  Scene copy = scene;
  ASSERT_EQ(copy.remove(house), Status::ok);
  EXPECT_NE(scene.find(house), nullptr);
  EXPECT_EQ(scene.set_casts_shadows(house, false), Status::ok);
  EXPECT_EQ(check_arrays(copy), "");
  EXPECT_EQ(check_arrays(scene), "");
}

TEST(Ids, ReplacedLightsAreStale) {
  Scene scene = scenes::build(scenes::city(2));
  scene.add(Light::point({1, 1, 8}));
  const LightId first = scene.light_id(0), second = scene.light_id(1);
  Engine engine(scene);
  Mirror mirror;
  ASSERT_EQ(mirror.apply(engine.update(), engine), "");
  const std::array lights{Light::directional({0, 0.25, -1})};
  scene.replace_lights(lights);
  EXPECT_EQ(scene.remove(first), Status::stale);
  EXPECT_EQ(scene.remove(second), Status::stale);
  EXPECT_EQ(scene.light_id(0).index, 0u);
  EXPECT_EQ(scene.light_id(1), LightId{});
  ASSERT_EQ(mirror.apply(engine.update(), engine), "");
  EXPECT_EQ(check_lights(engine, 1, true), "");
  const std::vector<Light> three(3, Light::point({1, 2, 8}));
  scene.replace_lights(three);
  for (std::uint32_t k = 0; k < 3; ++k) EXPECT_EQ(scene.light_id(k).index, k);
  ASSERT_EQ(mirror.apply(engine.update(), engine), "");
  EXPECT_EQ(check_lights(engine, 1, true), "");
  scene.replace_lights(scene.lights());  // its own
  ASSERT_EQ(mirror.apply(engine.update(), engine), "");
  EXPECT_EQ(check_lights(engine, 1, true), "");
}

TEST(Ids, AThousandRoundsUseTheSameRoom) {
  Scene scene = scenes::build(scenes::city(3));
  const auto sizes = [&] {
    return std::array{scene.objects().size(), scene.lights().size(),  scene.faces().size(),
                      scene.facets().size(),  scene.corners().size(), scene.vertices().size(),
                      scene.edges().size(),   scene.planes().size()};
  };
  const Mesh box = scenes::box({0, 0, 3}, {1, 1, 4}),
             sheet = scenes::rectangle({0, 0, 2}, {1, 0, 0}, {0, 1, 0});
  std::set<std::uint32_t> generations;
  const auto round = [&] {
    const ObjectId a = scene.add(box, {}), b = scene.add(sheet, {});
    const LightId l = scene.add(Light::point({1, 2, 3}));
    generations.insert(a.generation);
    ASSERT_EQ(scene.remove(a), Status::ok);
    ASSERT_EQ(scene.remove(l), Status::ok);
    ASSERT_EQ(scene.remove(b), Status::ok);
  };
  round();
  round();
  const auto after_two = sizes();
  for (int k = 2; k < 1000; ++k) round();
  EXPECT_EQ(sizes(), after_two);
  EXPECT_GE(generations.size(), 500u);
  EXPECT_EQ(check_arrays(scene), "");
}

// An object that keeps changing its number of facets moves between two rooms, not on and on.
TEST(Ids, FoldingAndUnfoldingUsesTheSameRooms) {
  Scene scene = scenes::build(scenes::city(2));
  const Mesh box = scenes::box({0, 0, 3}, {1, 1, 4});
  const ObjectId id = scene.add(box, {});
  std::vector<Vec3> folded = box.vertices;
  folded[7].z() += 0.5;
  std::size_t after_some = 0;
  for (int k = 0; k < 1000; ++k) {
    ASSERT_EQ(scene.set_vertices(id, k % 2 ? box.vertices : folded), Status::ok);
    if (k == 5) after_some = scene.corners().size();
  }
  EXPECT_EQ(scene.corners().size(), after_some);
  EXPECT_EQ(check_arrays(scene), "");
}

// A rigid motion that makes corners equal by rounding, and one that parts them again.
TEST(Ids, WeldingIsDecidedAgainAfterAMove) {
  Mesh mesh = scenes::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  scenes::append(mesh, scenes::rectangle({1e-14, 0, 0}, {0, 0, 1}, {0, 1, 0}));
  Scene scene, fresh;
  const ObjectId id = scene.add(mesh, {});
  ObjectSettings far;
  far.pose.translation() = Vec3(1024, 0, 0);
  ASSERT_EQ(scene.set_pose(id, far.pose), Status::ok);
  fresh.add(mesh, far);
  EXPECT_EQ(scene.find(id)->vertex_count, fresh.objects()[0].vertex_count);
  EXPECT_EQ(scene.find(id)->edge_count, fresh.objects()[0].edge_count);
  ASSERT_EQ(scene.set_pose(id, Pose::Identity()), Status::ok);
  EXPECT_EQ(scene.find(id)->vertex_count, 8u);
}

}  // namespace
}  // namespace shadowcut::testing
