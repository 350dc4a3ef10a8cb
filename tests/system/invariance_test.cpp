// What may change without changing the shadows: order, threads, prefix, form, and the distance of a
// far light.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <shadowcut/buffers.hpp>
#include <thread>

#include "check.hpp"
#include "edit_checks.hpp"
#include "random_scenes.hpp"

namespace shadowcut::testing {
namespace {

using scenes::SceneData;

std::vector<SceneData> some_scenes() {
  std::vector<SceneData> out;
  for (const Kind kind : kAllKinds)
    for (std::uint64_t seed = 0; seed < 8; ++seed) out.push_back(random_scene(kind, 400 + seed));
  for (auto& data :
       {scenes::room(1), scenes::room(3), scenes::furnished_room(), scenes::tetrahedron(3),
        scenes::city(10), scenes::spheres(5, 12, 8), scenes::triangles(300), scenes::branch(3)})
    out.push_back(data);
  return out;
}

TEST(Invariance, AnyOrderGivesTheSameAreas) {
  for (const SceneData& data : some_scenes()) {
    SCOPED_TRACE(data.name);
    const Scene scene = scenes::build(data);
    const Shadows first = cast_shadows(scene, data.light);
    for (const auto& [order, seed] : {std::pair(Order::as_given, 0),
                                      {Order::random, 1},
                                      {Order::random, 2},
                                      {Order::random, 3}}) {
      SCOPED_TRACE("order " + std::to_string(static_cast<int>(order)) + ", seed " +
                   std::to_string(seed));
      Options options;
      options.tuning.order = order;
      options.tuning.seed = static_cast<std::uint64_t>(seed);
      EXPECT_EQ(check_same_areas(scene, first, cast_shadows(scene, data.light, options)), "");
    }
  }
}

TEST(Invariance, PrefixGivesTheSameAreas) {
  for (const SceneData& data : some_scenes()) {
    SCOPED_TRACE(data.name);
    const Scene scene = scenes::build(data);
    Options options;
    options.tuning.facets_per_cell = 0;
    const Shadows without = cast_shadows(scene, data.light, options);
    for (const std::uint32_t size : {1u, 4u, 16u, 64u}) {
      SCOPED_TRACE("facets per cell " + std::to_string(size));
      options.tuning.facets_per_cell = size;
      EXPECT_EQ(check_same_areas(scene, without, cast_shadows(scene, data.light, options)), "");
    }
  }
}

TEST(Invariance, AnyNumberOfThreadsGivesTheSameBytes) {
  for (const SceneData& data : some_scenes()) {
    SCOPED_TRACE(data.name);
    const Scene scene = scenes::build(data);
    for (const Form form : {Form::pieces, Form::merged, Form::conforming}) {
      Options options;
      options.form = form;
      options.tuning.facets_per_cell = 8;
      options.threads = 1;
      const Shadows one = cast_shadows(scene, data.light, options);
      for (const unsigned threads : {2u, 3u, 4u}) {
        options.threads = threads;
        EXPECT_EQ(check_identical(one, cast_shadows(scene, data.light, options)), "")
            << threads << " threads";
      }
    }
  }
}

TEST(Invariance, ThreadsOnALargeScene) {
  const SceneData data = scenes::city(40);
  const Scene scene = scenes::build(data);
  Options options;
  options.threads = 1;
  const Shadows one = cast_shadows(scene, data.light, options);
  EXPECT_EQ(check_fragments(scene, data.light, one), "");
  for (int run = 0; run < 3; ++run) {
    options.threads = 4;
    EXPECT_EQ(check_identical(one, cast_shadows(scene, data.light, options)), "");
  }
}

// Callers who share nothing but a scene that none of them changes.
TEST(Invariance, SeveralCallersAtOnce) {
  for (SceneData data : {scenes::furnished_room(), scenes::city(6), scenes::triangles(60)}) {
    Scene scene = scenes::build(data);
    scene.add(data.light);
    for (const Kernel kernel : {Kernel::fast, Kernel::exact}) {
      SCOPED_TRACE(data.name + ", kernel " + std::to_string(static_cast<int>(kernel)));
      Options options;
      options.kernel = kernel, options.threads = 2, options.tuning.facets_per_cell = 8;
      std::vector<Shadows> results(4);
      std::vector<std::thread> callers;
      for (Shadows& shadows : results) {
        callers.emplace_back([&] {
          shadows = cast_shadows(scene, data.light, options);
          Engine engine(scene, options);
          engine.update();
          engine.overlay();
          engine.uncertain_area(0);
        });
      }
      for (std::thread& caller : callers) caller.join();
      for (const Shadows& shadows : results) EXPECT_EQ(check_identical(results[0], shadows), "");
    }
  }
}

// So many that cells are edited on two threads.
TEST(Invariance, ManyMovesOnTwoThreads) {
  const SceneData data = scenes::city(20);
  for (const Kernel kernel : {Kernel::fast, Kernel::exact}) {
    Scene scene = scenes::build(data);
    scene.add(data.light);
    Options options;
    options.kernel = kernel, options.threads = 1;
    Engine one(scene, options);
    options.threads = 2;
    Engine two(scene, options);
    for (int step = 0; step < 4; ++step) {
      SCOPED_TRACE("kernel " + std::to_string(static_cast<int>(kernel)) + ", step " +
                   std::to_string(step));
      EXPECT_EQ(check_identical(one.update(), two.update()), "");
      EXPECT_EQ(check_identical(one.shadows(0), two.shadows(0)), "");
      for (std::size_t o = 1; o < scene.objects().size(); o += 3) {
        ASSERT_EQ(scene.set_pose(scene.object_id(o),
                                 Pose(Eigen::Translation3d(0.01 * step + 0.01, 0.02 * step, 0))),
                  Status::ok);
      }
    }
  }
}

TEST(Invariance, RandomOrderDependsOnItsSeedAlone) {
  const SceneData data = scenes::triangles(200);
  const Scene scene = scenes::build(data);
  Options options;
  options.tuning.order = Order::random;
  options.tuning.seed = 17;
  EXPECT_EQ(check_identical(cast_shadows(scene, data.light, options),
                            cast_shadows(scene, data.light, options)),
            "");
}

TEST(Invariance, EveryTreeIsValid) {
  for (const SceneData& data : some_scenes()) {
    SCOPED_TRACE(data.name);
    Scene scene = scenes::build(data);
    scene.add(Light::directional({0.25, 0.5, -1}));
    for (const std::uint32_t size : {0u, 4u, 64u}) {
      for (const Order order : {Order::solid_angle, Order::as_given, Order::random}) {
        Options options;
        options.tuning.facets_per_cell = size;
        options.tuning.order = order;
        Engine engine(scene, options);
        engine.update();
        EXPECT_EQ(engine.validate(), "")
            << "facets per cell " << size << ", order " << static_cast<int>(order);
      }
    }
  }
}

TEST(Invariance, FormsHaveEqualAreas) {
  for (const SceneData& data : some_scenes()) {
    SCOPED_TRACE(data.name);
    const Scene scene = scenes::build(data);
    Options options;
    options.form = Form::pieces;
    const Shadows pieces = cast_shadows(scene, data.light, options);
    options.form = Form::merged;
    const Shadows merged = cast_shadows(scene, data.light, options);
    options.form = Form::conforming;
    const Shadows conforming = cast_shadows(scene, data.light, options);
    EXPECT_EQ(check_same_areas(scene, pieces, merged), "");
    EXPECT_EQ(check_same_areas(scene, pieces, conforming), "");
    for (const Shadows* shadows : {&pieces, &merged, &conforming})
      EXPECT_EQ(check_fragments(scene, data.light, *shadows), "");
    const auto count = [](const Shadows& s) {
      return s.stats.lit_fragments + s.stats.shadowed_fragments;
    };
    EXPECT_LE(count(merged), count(pieces));
    EXPECT_EQ(count(merged), count(conforming));
  }
}

TEST(Invariance, ConformingHasNoTJunction) {
  for (const SceneData& data : some_scenes()) {
    SCOPED_TRACE(data.name);
    const Scene scene = scenes::build(data);
    for (const std::uint32_t size : {0u, 8u}) {
      Options options;
      options.form = Form::conforming;
      options.tuning.facets_per_cell = size;
      EXPECT_EQ(check_conforming(scene, cast_shadows(scene, data.light, options)), "")
          << "facets per cell " << size;
    }
  }
}

// In the conforming form there are no two corners of a face that differ in their last bits only.
// (In the others there are, where more than two lines happen to meet in one point.)
TEST(Invariance, CornersOnSharedCutsAreBitEqual) {
  for (const Kind kind : kAllKinds) {
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
      const SceneData data = random_scene(kind, 600 + seed);
      SCOPED_TRACE(data.name);
      const Scene scene = scenes::build(data);
      Options options;
      options.form = Form::conforming;
      options.tuning.facets_per_cell = seed % 2 ? 4 : 64;
      EXPECT_EQ(check_shared_corners(scene, cast_shadows(scene, data.light, options)), "");
    }
  }
}

// The lit share of a face under a point light 10^k away differs from that under the sun by a small
// multiple of 10^-k.
TEST(Invariance, FarPointLightIsTheSun) {
  for (const Kind kind : {Kind::soup, Kind::solids, Kind::outlines, Kind::turned_boxes}) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const SceneData data = random_scene(kind, 800 + seed);
      SCOPED_TRACE(data.name);
      const Scene scene = scenes::build(data);
      const Vec3 direction(0.31, -0.23, -1);
      const Shadows sun = cast_shadows(scene, Light::directional(direction));
      for (const double distance : {1e3, 1e6}) {
        const Shadows point = cast_shadows(scene, Light::point(-distance * direction));
        EXPECT_EQ(check_same_areas(scene, sun, point, 200 / distance), "") << "at " << distance;
      }
    }
  }
}

TEST(Invariance, LengthOfADirectionDoesNotMatter) {
  const SceneData data = scenes::city(6);
  const Scene scene = scenes::build(data);
  const Shadows one = cast_shadows(scene, Light::directional({0.5, 0.25, -1}));
  const Shadows other = cast_shadows(scene, Light::directional({0.5e-7, 0.25e-7, -1e-7}));
  EXPECT_EQ(check_same_areas(scene, one, other), "");
}

TEST(Invariance, EngineRemembersWhatOneOffCallsGive) {
  for (const SceneData& data : some_scenes()) {
    SCOPED_TRACE(data.name);
    Scene scene = scenes::build(data);
    scene.add(Light::directional({0.25, 0.5, -1}));
    Options options;
    options.tuning.incremental = false;
    Engine engine(scene, options);
    engine.update();
    ASSERT_EQ(engine.light_count(), 2u);
    EXPECT_EQ(check_identical(engine.shadows(0), cast_shadows(scene, data.light)), "");
    EXPECT_EQ(check_identical(engine.shadows(1),
                              cast_shadows(scene, Light::directional({0.25, 0.5, -1}))),
              "");
    const Engine moved = std::move(engine);
    EXPECT_EQ(moved.light_count(), 2u);
  }
}

// Each light's region in the common partition is its own region, and so is every point.
TEST(Invariance, CombinedLightsKeepTheirRegions) {
  for (const Kind kind : kAllKinds) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const SceneData data = random_scene(kind, 200 + seed);
      SCOPED_TRACE(data.name);
      Scene scene = scenes::build(data);
      scenes::Random random(seed);
      std::vector<Light> lights{data.light, random_light(kind, random), random_light(kind, random)};
      scene.replace_lights(lights);
      Engine engine(scene);
      engine.update();
      const LightPartition sets = engine.overlay();
      std::vector<double> whole(scene.faces().size());
      for (const auto& f : sets.fragments) whole[f.face] += polygon_area(sets.corners_of(f));
      for (std::size_t k = 0; k < lights.size(); ++k) {
        const std::vector<double> lit = lit_areas(scene, sets, k);
        for (std::size_t face = 0; face < lit.size(); ++face) {
          const FaceArea& alone = engine.shadows(k).areas[face];
          EXPECT_NEAR(lit[face], alone.lit, kAreaTolerance * alone.area)
              << "light " << k << ", face " << face;
          EXPECT_NEAR(whole[face], alone.area, kAreaTolerance * alone.area)
              << "light " << k << ", face " << face;
        }
        EXPECT_EQ(check_points(scene, sets, k, CgalOracle(scene, lights[k]), seed, 40), "")
            << "light " << k;
      }
    }
  }
}

TEST(Invariance, CombinedTakesMoreLightsThanAWordHasBits) {
  Scene scene;
  scene.add(scenes::rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}), {});
  scene.add(scenes::rectangle({-0.1, -0.1, 1}, {0.2, 0, 0}, {0, 0.2, 0}), {});
  for (int k = 0; k < 70; ++k) scene.add(Light::point({-2 + 0.06 * k, 0.01 * k, 2 + 0.003 * k}));
  Engine engine(scene);
  engine.update();
  const LightPartition sets = engine.overlay();
  EXPECT_EQ(sets.words, 2u);
  for (std::size_t k = 0; k < 70; ++k) {
    const std::vector<double> lit = lit_areas(scene, sets, k);
    EXPECT_NEAR(lit[0], engine.shadows(k).areas[0].lit, 64e-9);
  }

  BufferLayout layout;
  layout.doubles = layout.masks = true;
  FragmentBuffers buffers(FragmentBuffers::all_lights, layout);
  buffers.fill(engine);
  ASSERT_EQ(buffers.mask_words(), 3u);
  std::vector<double> lit(70);
  for (std::size_t v = 0; v < buffers.vertex_count(); v += 3) {
    if (buffers.faces()[v] != 0) continue;
    std::array<Vec3, 3> triangle;
    for (std::size_t i = 0; i < 3; ++i)
      triangle[i] = Vec3(buffers.double_positions().data() + 3 * (v + i));
    for (std::size_t k = 0; k < 70; ++k)
      if (buffers.masks()[3 * v + k / 32] >> (k % 32) & 1) lit[k] += polygon_area(triangle);
  }
  for (std::size_t k = 0; k < 70; ++k)
    EXPECT_NEAR(lit[k], engine.shadows(k).areas[0].lit, 64e-9) << "light " << k;
}

// On chosen faces, it is that part of the whole, to the bit.
TEST(Invariance, CombinedOnChosenFaces) {
  for (const Kernel kernel : {Kernel::fast, Kernel::exact}) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      const SceneData data = random_scene(kAllKinds[seed % std::size(kAllKinds)], 300 + seed);
      Scene scene = scenes::build(data);
      scenes::Random random(seed);
      scene.add(random_light(kAllKinds[seed % std::size(kAllKinds)], random));
      Options options;
      options.kernel = kernel;
      Engine engine(scene, options);
      engine.update();
      std::vector<std::uint32_t> faces{invalid_index};  // it is passed over
      std::vector<bool> chosen;
      for (std::uint32_t f = 0; f < scene.faces().size(); ++f) {
        chosen.push_back(random.below(3) == 0);
        if (chosen.back()) faces.push_back(f);
      }
      const LightPartition all = engine.overlay(), part = engine.overlay(faces);
      std::size_t at = 0;
      for (std::size_t i = 0; i < all.fragments.size(); ++i) {
        if (!chosen[all.fragments[i].face]) continue;
        ASSERT_LT(at, part.fragments.size());
        EXPECT_EQ(part.fragments[at].facet, all.fragments[i].facet);
        const auto got = part.corners_of(part.fragments[at]),
                   wanted = all.corners_of(all.fragments[i]);
        EXPECT_TRUE(std::equal(got.begin(), got.end(), wanted.begin(), wanted.end()));
        EXPECT_EQ(part.lights[at], all.lights[i]);
        ++at;
      }
      EXPECT_EQ(at, part.fragments.size());
    }
  }
}

TEST(Invariance, ProgressRisesToOne) {
  const SceneData data = scenes::city(20);
  const Scene scene = scenes::build(data);
  std::vector<double> seen;
  Options options;
  options.threads = 2;
  options.progress = [&](double share) { seen.push_back(share); };
  cast_shadows(scene, data.light, options);
  ASSERT_FALSE(seen.empty());
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_GE(seen.front(), 0);
  EXPECT_LE(seen.back(), 1);
}

}  // namespace
}  // namespace shadowcut::testing
