// Updates emit the fragments that changed, and leave the others alone.
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <set>

#include "check.hpp"
#include "follower.hpp"

namespace shadowcut::testing {
namespace {

using scenes::Random;
using scenes::SceneData;

TEST(Changes, NothingWithoutEdits) {
  Scene scene = scenes::build(scenes::city(4));
  Engine engine(scene);
  const Changes& first = engine.update();
  EXPECT_TRUE(first.complete);
  ASSERT_EQ(first.lights.size(), 1u);
  EXPECT_TRUE(first.lights[0].rebuilt);
  EXPECT_TRUE(first.lights[0].gone.empty());
  for (int k = 0; k < 3; ++k) {
    const Changes& again = engine.update();
    EXPECT_TRUE(again.complete);
    EXPECT_EQ(again.applied, 0u);
    EXPECT_TRUE(again.lights.empty());
  }
  const Scene copy = engine.scene();
  EXPECT_EQ(check_same_scene(scene, copy), "");
}

TEST(Changes, OfOneBuildingAreFew) {
  for (const std::uint32_t size : {0u, 128u}) {
    Options options;
    options.tuning.facets_per_cell = size;
    const SceneData data = scenes::city(12);
    Scene scene = scenes::build(data);
    Engine engine(scene, options);
    engine.update();
    const ObjectId house = scene.object_id(70);
    const Pose home = scene.find(house)->pose;
    for (int k = 1; k <= 8; ++k) {
      Pose pose = home;
      pose.pretranslate(Vec3(k % 2 ? 0.05 : 0, 0, 0));
      ASSERT_EQ(scene.set_pose(house, pose), Status::ok);
      const Changes& changes = engine.update();
      EXPECT_EQ(changes.applied, 1u);
      ASSERT_EQ(changes.lights.size(), 1u);
      const LightChanges& c = changes.lights[0];
      const Stats& stats = engine.shadows(0).stats;
      EXPECT_FALSE(c.rebuilt) << "facets_per_cell " << size << ", move " << k;
      // The house, its neighbours and its piece of ground, out of 144.
      EXPECT_LT(c.added.size() * 8, stats.lit_fragments + stats.shadowed_fragments)
          << "facets_per_cell " << size << ", move " << k;
      EXPECT_LT(c.gone.size() * 8, stats.lit_fragments + stats.shadowed_fragments)
          << "facets_per_cell " << size << ", move " << k;
      EXPECT_LT(c.areas.size(), 60u) << "facets_per_cell " << size << ", move " << k;
    }
  }
}

TEST(Changes, OfOneLightAreItsOwn) {
  Scene scene = scenes::build(scenes::city(5));
  const LightId sun = scene.add(Light::directional({0.25, 0.5, -1}));
  Engine engine(scene);
  engine.update();
  const Shadows lamp = engine.shadows(0);
  ASSERT_EQ(scene.set_light(sun, Light::directional({0.25, 0.25, -1})), Status::ok);
  const Changes& moved = engine.update();
  EXPECT_EQ(moved.applied, 1u);
  ASSERT_EQ(moved.lights.size(), 1u);
  EXPECT_EQ(moved.lights[0].light, 1u);
  EXPECT_TRUE(moved.lights[0].rebuilt);
  ASSERT_EQ(scene.remove(sun), Status::ok);
  const Changes& removed = engine.update();
  ASSERT_EQ(removed.lights.size(), 1u);
  EXPECT_EQ(removed.lights[0].light, 1u);
  EXPECT_TRUE(removed.lights[0].removed);
  EXPECT_EQ(check_identical(lamp, engine.shadows(0)), "");
  EXPECT_THROW(engine.shadows(1), Error);
  EXPECT_THROW(engine.shadows(2), Error);
}

// An engine may begin with nothing, and be left with nothing.
TEST(Changes, FromNothingToNothing) {
  for (const bool edits : {true, false}) {
    Options options;
    options.tuning.incremental = edits;
    options.tuning.facets_per_cell = 4;
    Scene scene;
    Engine engine(scene, options);
    Mirror mirror;
    const auto update = [&] {
      const Changes& changes = engine.update();
      std::string what = engine.validate() + check_same_scene(scene, engine.scene());
      if (what.empty()) what = mirror.apply(changes, engine);
      if (what.empty()) what = mirror.check_find(engine);
      return what.empty() ? check_lights(engine, 1, true) : what;
    };
    ASSERT_EQ(update(), "");
    const LightId first = scene.add(Light::point({0.5, 0.25, 3}));
    ASSERT_EQ(update(), "");
    std::vector<ObjectId> boxes;
    for (int k = 0; k < 6; ++k) {
      boxes.push_back(scene.add(scenes::box({k - 3.0, -1, 0.5 * (k % 3)}, {k - 2.5, 1, 1}), {}));
      ASSERT_EQ(update(), "") << "box " << k;
    }
    const LightId second = scene.add(Light::directional({1, 0, -1}));
    ASSERT_EQ(update(), "");
    ASSERT_EQ(scene.remove(first), Status::ok);
    ASSERT_EQ(update(), "");
    for (const ObjectId box : boxes) {
      ASSERT_EQ(scene.remove(box), Status::ok);
      ASSERT_EQ(update(), "");
    }
    ASSERT_EQ(scene.remove(second), Status::ok);
    ASSERT_EQ(update(), "");
    ASSERT_EQ(scene.add(Light::point({0, 0, 1})).index, second.index);
    scene.add(scenes::box({0, 0, 0}, {1, 1, 0.5}), {});
    ASSERT_EQ(update(), "");
  }
}

// Added and removed, or moved and moved back, between two updates.
TEST(Changes, WhatCameAndWentInBetween) {
  Scene scene = scenes::build(scenes::city(3));
  Options options;
  Engine engine(scene, options);
  Mirror mirror;
  ASSERT_EQ(mirror.apply(engine.update(), engine), "");
  ASSERT_EQ(scene.remove(scene.add(scenes::box({0, 0, 3}, {1, 1, 4}), {})), Status::ok);
  ASSERT_EQ(scene.remove(scene.add(Light::point({1, 1, 9}))), Status::ok);
  const Changes& changes = engine.update();
  EXPECT_EQ(mirror.apply(changes, engine), "");
  EXPECT_EQ(check_same_scene(scene, engine.scene()), "");
  EXPECT_EQ(check_lights(engine, 1, true), "");
}

// In this history a corner that is cut goes from 0 to -0, in the conforming form: equal, and other
// bits.
TEST(Changes, MinusZeroIsAnotherNumber) {
  EXPECT_TRUE(run_history(setting_named("grid_soup"), 310000000351, 130));
}

// Several engines follow one scene, each at its own pace.
TEST(Changes, EnginesAtTheirOwnPace) {
  for (std::uint64_t seed = 1; seed < 6; ++seed) {
    EditScript script(setting_named("resting"), seed);
    struct Pace {
      std::unique_ptr<Engine> engine;
      Mirror mirror;
      int every;
    };
    std::vector<Pace> paces;
    for (const int every : {1, 3, 7}) {
      const Options options = some_options(seed + static_cast<std::uint64_t>(every));
      paces.push_back({std::make_unique<Engine>(script.scene(), options), {}, every});
    }
    for (int step = 0; step <= 42; ++step) {
      for (Pace& p : paces) {
        if (step % p.every != 0) continue;
        SCOPED_TRACE("seed " + std::to_string(seed) + ", step " + std::to_string(step) +
                     ", every " + std::to_string(p.every));
        const Changes& changes = p.engine->update();
        ASSERT_EQ(p.engine->validate(), "");
        ASSERT_EQ(check_same_scene(script.scene(), p.engine->scene()), "");
        ASSERT_EQ(p.mirror.apply(changes, *p.engine), "");
        ASSERT_EQ(check_lights(*p.engine, 1, true), "");
      }
      script.step();
    }
  }
}

}  // namespace
}  // namespace shadowcut::testing
