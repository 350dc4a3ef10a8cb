// The engine against the CGAL oracle, face by face and point by point: random and made scenes.
#include <gtest/gtest.h>

#include <cmath>

#include "random_scenes.hpp"
#include "shadow_checks.hpp"

namespace shadowcut::testing {
namespace {

using scenes::SceneData;

TEST(Shadows, RangeAndConeOnRandomScenes) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const SceneData data = random_scene(seed % 2 ? Kind::soup : Kind::outlines, 5000 + seed);
    SCOPED_TRACE(data.name);
    scenes::Random random(seed);
    Light light = Light::point(random.in_cube(-2, 2) + Vec3(0, 0, 3));
    if (seed % 3 != 0) light.range = random.in(0.5, 4);
    if (seed % 3 != 1)
      light.spot = Light::Spot{random.in_ball(1) - Vec3(0, 0, 0.5), random.in(0.05, 3.1)};
    expect_right(scenes::build(data), light, {}, true);
  }
}

TEST(Shadows, TinyAndHugeScenes) {
  for (const double factor : {1e-9, 1e-4, 3e3, 1e9}) {
    for (const Kind kind : kAllKinds) {
      for (std::uint64_t seed = 0; seed < 3; ++seed) {
        const SceneData data = scaled(random_scene(kind, 7000 + seed), factor);
        SCOPED_TRACE(data.name + ", times " + std::to_string(factor));
        expect_right(scenes::build(data), data.light);
      }
    }
  }
}

TEST(Shadows, FarFromTheOrigin) {
  for (const Kind kind : {Kind::solids, Kind::grid_boxes, Kind::room}) {
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
      const SceneData data = scaled(random_scene(kind, 7100 + seed), 1, {4096, -8192, 1024});
      SCOPED_TRACE(data.name);
      expect_right(scenes::build(data), data.light);
    }
  }
}

// Random scenes of every kind, several lights each.
class RandomScenes : public ::testing::TestWithParam<Kind> {};

TEST_P(RandomScenes, MatchTheOracle) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const SceneData data = random_scene(GetParam(), seed);
    SCOPED_TRACE(data.name);
    Options options;
    options.tuning.facets_per_cell = seed % 3 == 0 ? 4 : seed % 3 == 1 ? 64 : 0;
    options.form = static_cast<Form>(seed % 3);
    const Scene scene = scenes::build(data);
    scenes::Random random(seed);
    expect_right(scene, data.light, options);
    expect_right(scene, random_light(GetParam(), random), options);
    if (HasFailure()) break;
  }
}

TEST_P(RandomScenes, MatchTheOracleAsOpenSheetsThatCastOrNot) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SceneData data = random_scene(GetParam(), 3000 + seed);
    SCOPED_TRACE(data.name);
    scenes::Random random(seed);
    for (auto& object : data.objects) {
      if (random.below(2) == 0) object.second.sides = Sides::open;
      object.second.casts_shadows = random.below(4) != 0;
      object.second.receives_shadows = random.below(4) != 0;
      object.second.dynamic = random.below(4) == 0;
    }
    expect_right(scenes::build(data), data.light);
    if (HasFailure()) break;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, RandomScenes, ::testing::ValuesIn(kAllKinds),
                         [](const auto& info) { return std::string(name_of(info.param)); });

// The generated scenes as they stand in memory (those with files are in reference_test.cpp, against
// shipped areas).
TEST(GeneratedScenes, FurnishedRoom) {
  const SceneData data = scenes::furnished_room();
  const Scene scene = scenes::build(data);
  EXPECT_EQ(cast_shadows(scene, data.light).stats.facing_faces, 344u);
  expect_right(scene, data.light);
}

TEST(GeneratedScenes, Rooms) {
  for (int level = 1; level <= 2; ++level) {
    const SceneData data = scenes::room(level);
    SCOPED_TRACE(data.name);
    expect_right(scenes::build(data), data.light);
    expect_right(scenes::build(data), Light::directional({0.4, 0.3, -1}));
    // at the height of the desk tops
    expect_right(scenes::build(data), Light::point({3, 2.5, 0.73}));
  }
}

TEST(GeneratedScenes, Tetrahedra) {
  for (int depth = 2; depth <= 3; ++depth) {
    const SceneData data = scenes::tetrahedron(depth);
    SCOPED_TRACE(data.name);
    expect_right(scenes::build(data), data.light);
    // on the axis of symmetry: shadows meet in edges and corners
    expect_right(scenes::build(data), Light::point({0, 0, 3}));
    expect_right(scenes::build(data), Light::directional({0, 0, -1}));
  }
}

TEST(GeneratedScenes, CityUnderTheSunAlongItsStreets) {
  const SceneData data = scenes::city(6);
  for (const Vec3& direction : {Vec3(1, 0, -1), Vec3(0, -1, -0.5), Vec3(0, 0, -1), Vec3(1, 1, -1)})
    expect_right(scenes::build(data), Light::directional(direction));
}

TEST(GeneratedScenes, TrianglesAndBranch) {
  for (const SceneData& data : {scenes::triangles(120), scenes::branch(2)}) {
    SCOPED_TRACE(data.name);
    expect_right(scenes::build(data), data.light);
  }
}

}  // namespace
}  // namespace shadowcut::testing
