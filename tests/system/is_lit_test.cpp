// Engine::is_lit: one descent of the tree answers for a point.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>

#include "check.hpp"
#include "follower.hpp"
#include "random_scenes.hpp"

namespace shadowcut::testing {
namespace {

class IsLit : public ::testing::TestWithParam<Kernel> {};
INSTANTIATE_TEST_SUITE_P(Kernels, IsLit, ::testing::Values(Kernel::fast, Kernel::exact),
                         [](const auto& kernel) {
                           return kernel.param == Kernel::exact ? "exact" : "fast";
                         });

// Squares of side 2 at the heights 0 and 1 below a lamp at height 2; the upper one shadows a square
// of side 4 around the middle of the floor.
struct Table {
  Scene scene;
  ObjectId floor, top;
  Table() {
    Mesh big, small;
    big.vertices = {{-4, -4, 0}, {4, -4, 0}, {4, 4, 0}, {-4, 4, 0}};
    small.vertices = {{-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}};
    big.add_face({0, 1, 2, 3}), small.add_face({0, 1, 2, 3});
    floor = scene.add(big), top = scene.add(small);
    scene.add(Light::point({0, 0, 2}));
  }
};

TEST_P(IsLit, SeesTheTableAndItsShadow) {
  Table t;
  Options options;
  options.kernel = GetParam();
  Engine engine(t.scene, options);
  engine.update();
  EXPECT_FALSE(engine.is_lit(0, 0, {0, 0, 0}));
  EXPECT_FALSE(engine.is_lit(0, 0, {1.75, -1.75, 0}));
  EXPECT_TRUE(engine.is_lit(0, 0, {2.25, 0, 0}));
  EXPECT_TRUE(engine.is_lit(0, 1, {0, 0, 1}));  // contact is not occlusion
  // A point off the plane stands for the point where its ray meets the plane.
  EXPECT_FALSE(engine.is_lit(0, 0, {0.9, 0, 0.5}));
  EXPECT_TRUE(engine.is_lit(0, 0, {1.8, 0, 0.5}));
  ASSERT_EQ(t.scene.remove(t.top), Status::ok);
  engine.update();
  EXPECT_TRUE(engine.is_lit(0, 0, {0, 0, 0}));
}

TEST_P(IsLit, FacesThatCannotBeLitAreNotLit) {
  Table t;
  Options options;
  options.kernel = GetParam();
  Mesh bad;  // a face without area
  bad.vertices = {{0, 0, 0.5}, {1, 0, 0.5}, {2, 0, 0.5}};
  bad.add_face({0, 1, 2});
  t.scene.add(bad);
  t.scene.add(Light::point({0, 0, -2}));
  ASSERT_EQ(t.scene.set_receives_shadows(t.top, false), Status::ok);
  Engine engine(t.scene, options);
  engine.update();
  EXPECT_FALSE(engine.is_lit(0, 2, {1, 0, 0.5}));
  EXPECT_FALSE(engine.is_lit(0, 1, {0, 0, 1}));
  EXPECT_TRUE(engine.is_lit(1, 0, {3.5, 3.5, 0}));
  Light lamp = Light::point({0, 0, 2});
  lamp.range = 1.5;
  ASSERT_EQ(t.scene.set_light(t.scene.light_id(0), lamp), Status::ok);
  engine.update();
  EXPECT_FALSE(engine.is_lit(0, 0, {3.5, 3.5, 0}));
}

TEST_P(IsLit, MisuseIsAnError) {
  Table t;
  Options options;
  options.kernel = GetParam();
  Engine engine(t.scene, options);
  EXPECT_THROW(engine.is_lit(0, 0, {0, 0, 0}), Error);  // no update yet
  engine.update();
  EXPECT_THROW(engine.is_lit(1, 0, {0, 0, 0}), Error);
  EXPECT_THROW(engine.is_lit(0, 2, {0, 0, 0}), Error);
  EXPECT_THROW(engine.is_lit(0, 0, {0, std::numeric_limits<double>::quiet_NaN(), 0}), Error);
}

TEST_P(IsLit, AgreesWithFragmentsAndTheOracle) {
  for (std::uint64_t seed = first_seed(); seed < first_seed() + 40; ++seed) {
    for (const Setting& setting : all_settings()) {
      SCOPED_TRACE(std::string(setting.name) + ", seed " + std::to_string(seed));
      const scenes::SceneData data = setting.scene(seed);
      Scene scene = scenes::build(data);
      Options options;
      options.kernel = GetParam();
      options.tuning.incremental = seed % 2 == 0;
      options.tuning.facets_per_cell = seed % 3 == 0 ? 4 : 128;
      scene.replace_lights({&data.light, 1});
      Engine engine(scene, options);
      engine.update();
      std::optional<CgalOracle> oracle;
      if (scene.facets().size() < 400) oracle.emplace(engine.scene(), data.light);
      ASSERT_EQ(check_point_queries(engine, 0, oracle ? &*oracle : nullptr, seed, 60), "");
    }
  }
}

TEST_P(IsLit, AgreesAfterRandomEdits) {
  for (const Setting& setting : all_settings()) {
    for (std::uint64_t seed = first_seed(); seed < first_seed() + 3; ++seed) {
      Options options;
      options.kernel = GetParam();
      options.tuning.facets_per_cell = seed % 2 == 0 ? 4 : 128;
      EditScript script(setting, seed);
      Engine engine(script.scene(), options);
      std::string edits = "the first update";
      for (std::uint64_t step = 0; step < 40; ++step) {
        engine.update();
        const Scene& scene = engine.scene();
        for (std::size_t k = 0; k < engine.light_count(); ++k) {
          if (scene.light_id(k).index == invalid_index) continue;
          const Light& light = scene.lights()[k];
          // Far sides of closed solids cast in the oracle: they must not be in range alone, nor
          // those of a deformed object.
          std::optional<CgalOracle> oracle;
          if (step % 8 == 0 && scene.facets().size() < 400 && !script.deformed() && !light.spot &&
              std::isinf(light.range))
            oracle.emplace(scene, light);
          ASSERT_EQ(check_point_queries(engine, k, oracle ? &*oracle : nullptr, step, 40), "")
              << setting.name << ", seed " << seed << ", light " << k << ", step " << step << ": "
              << edits;
        }
        edits = script.step();
      }
    }
  }
}

}  // namespace
}  // namespace shadowcut::testing
