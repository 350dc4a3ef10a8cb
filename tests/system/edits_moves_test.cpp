// Objects that move: named geometry, in every form.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "check.hpp"
#include "follower.hpp"
#include "settings.hpp"

namespace shadowcut::testing {
namespace {

using scenes::Random;
using scenes::SceneData;

struct Theatre {
  Scene scene;
  Options options;
  std::unique_ptr<Engine> engine;
  Mirror mirror;
  bool solids = true;

  ObjectId add(const Mesh& mesh) { return scene.add(mesh, {}); }
  ObjectId ground() { return add(scenes::rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0})); }
  void move(ObjectId id, const Vec3& to) {
    Pose pose = Pose::Identity();
    pose.translation() = to;
    ASSERT_EQ(scene.set_pose(id, pose), Status::ok);
  }
  // Against a rebuild and against the oracle.
  void expect_right() {
    if (!engine) engine = std::make_unique<Engine>(scene, options);
    const Changes& changes = engine->update();
    ASSERT_EQ(engine->validate(), "");
    ASSERT_EQ(check_same_scene(scene, engine->scene()), "");
    ASSERT_EQ(mirror.apply(changes, *engine), "");
    ASSERT_EQ(check_lights(*engine, 0, solids), "");
  }
};

template <class Play>
void in_every_form(const Play& play) {
  for (const Form form : {Form::pieces, Form::merged, Form::conforming}) {
    for (const std::uint32_t threshold : {0u, 16u}) {
      for (const std::uint32_t size : {0u, 4u}) {
        Theatre t;
        t.options.form = form;
        t.options.tuning.join_threshold = threshold;
        t.options.tuning.facets_per_cell = size;
        SCOPED_TRACE(describe(t.options));
        play(t);
        if (::testing::Test::HasFailure()) return;
      }
    }
  }
}

// Edits large enough to be spread over threads: two buildings of five of a city at once. (Of more,
// all would be built again.)
TEST(Moves, ManyAtOnceSameBitsOnAnyNumberOfThreads) {
  for (const Kernel kernel : {Kernel::fast, Kernel::exact}) {
    const SceneData data = scenes::city(12);
    Scene scene = scenes::build(data);
    std::vector<std::unique_ptr<Engine>> engines;
    for (const unsigned threads : {1u, 2u, 3u}) {
      Options options;
      options.kernel = kernel;
      options.threads = threads;
      options.tuning.facets_per_cell = 32;
      engines.push_back(std::make_unique<Engine>(scene, options));
      engines.back()->update();
    }
    for (int k = 1; k <= 6; ++k) {
      SCOPED_TRACE("kernel " + std::to_string(static_cast<int>(kernel)) + ", move " +
                   std::to_string(k));
      for (std::size_t i = 1; i < scene.objects().size(); ++i) {
        if (i % 5 > 1) continue;
        Pose pose = scene.objects()[i].pose;
        pose.pretranslate(Vec3(k % 2 ? 0.05 : -0.05, 0.01 * static_cast<double>(i % 3), 0));
        ASSERT_EQ(scene.set_pose(scene.object_id(i), pose), Status::ok);
      }
      std::vector<const Changes*> changes;
      for (const auto& engine : engines) changes.push_back(&engine->update());
      ASSERT_EQ(changes[0]->lights.size(), 1u);
      EXPECT_FALSE(changes[0]->lights[0].rebuilt);
      for (const std::size_t other : {1u, 2u}) {
        ASSERT_EQ(check_identical(*changes[0], *changes[other]), "");
        ASSERT_EQ(check_identical(engines[0]->shadows(0), engines[other]->shadows(0)), "");
      }
      ASSERT_EQ(engines[1]->validate(), "");
      ASSERT_EQ(check_lights(*engines[1], 1, true), "");
    }
  }
}

// A desk's top, which comes last, cuts all of its cell. That is so again after the next step,
// however often the cell is built again.
TEST(Moves, DraggedDeskSeldomHasItsCellBuiltAgain) {
  Scene scene = scenes::build(scenes::furnished_room());
  const auto desk = std::find_if(scene.objects().begin(), scene.objects().end(),
                                 [](const Object& o) { return o.name == "desk.5"; });
  ASSERT_NE(desk, scene.objects().end());
  const ObjectId id = scene.object_id(static_cast<std::size_t>(desk - scene.objects().begin()));
  const Pose home = desk->pose;
  Options options;
  options.threads = 1;
  Engine engine(scene, options);
  engine.update();
  for (int k = 1; k <= 600; ++k) {
    SCOPED_TRACE("move " + std::to_string(k));
    ASSERT_EQ(scene.set_pose(
                  id, Eigen::Translation3d(k % 2 ? 0.05 : 0, 0.03 * std::sin(0.1 * k), 0) * home),
              Status::ok);
    engine.update();
    if (k % 100 != 0) continue;
    ASSERT_EQ(engine.validate(), "");
    ASSERT_EQ(check_lights(engine, 1, true), "");
    EXPECT_LE(static_cast<double>(engine.shadows(0).stats.nodes),
              kRot * static_cast<double>(nodes_of_new(scene, options)));
  }
  EXPECT_LE(engine.shadows(0).stats.cells_rebuilt, 20u);
}

// Of several that take turns each is cut by the others, and cuts them, a little more at every step.
TEST(Moves, DesksTakingTurnsDoNotRot) {
  Scene scene = scenes::build(scenes::furnished_room());
  std::vector<ObjectId> desks;
  std::vector<Pose> homes;
  for (std::size_t i = 0; i < scene.objects().size() && desks.size() < 3; ++i) {
    if (scene.objects()[i].name.rfind("desk", 0) != 0) continue;
    desks.push_back(scene.object_id(i));
    homes.push_back(scene.objects()[i].pose);
  }
  ASSERT_EQ(desks.size(), 3u);
  Options options;
  options.threads = 1;
  Engine engine(scene, options);
  engine.update();
  Random random(3);
  Vec3 by = Vec3::Zero();
  const auto step = [&](double at) {
    return std::clamp(at + 0.06 * random.unit() - 0.03, -0.5, 0.5);
  };
  for (int k = 1; k <= 3000; ++k) {
    SCOPED_TRACE("move " + std::to_string(k));
    const std::size_t d = random.below(3);
    by = {step(by[0]), step(by[1]), 0};
    ASSERT_EQ(scene.set_pose(desks[d], Eigen::Translation3d(by) * homes[d]), Status::ok);
    engine.update();
    if (k % 150 != 0) continue;
    ASSERT_EQ(engine.validate(), "");
    EXPECT_LE(static_cast<double>(engine.shadows(0).stats.nodes),
              kRot * static_cast<double>(nodes_of_new(scene, options)));
  }
  ASSERT_EQ(check_lights(engine, 1, true), "");
}

TEST(Moves, CubeSlidesThroughTheLight) {
  in_every_form([](Theatre& t) {
    t.ground();
    const ObjectId cube = t.add(scenes::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}));
    t.scene.add(Light::point({0, 0, 2}));
    for (int k = -8; k <= 8; ++k) {
      SCOPED_TRACE("at " + std::to_string(k));
      t.move(cube, {0.25 * k, 0, 2});
      t.expect_right();
    }
  });
}

TEST(Moves, CubeSlidesThroughAWall) {
  in_every_form([](Theatre& t) {
    t.ground();
    t.add(scenes::rectangle({0, -2, 0}, {0, 4, 0}, {0, 0, 3}));
    const ObjectId cube = t.add(scenes::box({-0.5, -0.5, 0}, {0.5, 0.5, 1}));
    t.scene.add(Light::point({3, 0.25, 4}));
    for (int k = -6; k <= 6; ++k) {
      SCOPED_TRACE("at " + std::to_string(k));
      t.move(cube, {0.25 * k, 0, 0.5});
      t.expect_right();
    }
  });
}

TEST(Moves, PosterSlidesInItsWall) {
  in_every_form([](Theatre& t) {
    t.ground();
    t.add(scenes::rectangle({-3, 2, 0}, {6, 0, 0}, {0, 0, 3}));
    t.add(scenes::box({-0.25, 0.5, 0.5}, {0.25, 0.75, 2}));
    const ObjectId poster = t.add(scenes::rectangle({-0.5, 2, 1}, {1, 0, 0}, {0, 0, 1}));
    t.scene.add(Light::point({0.25, -3, 1.75}));
    for (int k = -6; k <= 6; ++k) {
      SCOPED_TRACE("at " + std::to_string(k));
      t.move(poster, {0.5 * k, 0, k % 3 == 0 ? 0 : 0.25});  // in the wall
      t.expect_right();
      t.move(poster, {0.5 * k, -0.25, 0});  // before it
      t.expect_right();
      t.move(poster, {0.5 * k, 0.25, 0});  // behind it
      t.expect_right();
    }
  });
}

TEST(Moves, PileIsTakenDownAndBuiltAgain) {
  in_every_form([](Theatre& t) {
    t.ground();
    std::vector<ObjectId> pile;
    const auto box = [](int k) {
      return scenes::box({-0.5, -0.5, 0.5 * k}, {0.5, 0.5, 0.5 * (k + 1)});
    };
    for (int k = 0; k < 4; ++k) pile.push_back(t.add(box(k)));
    t.scene.add(Light::point({1.5, 1, 4}));
    t.scene.add(Light::directional({1, 0, -1}));
    t.expect_right();
    for (int k = 0; k < 4; ++k) {  // from below: the others hang in the air
      ASSERT_EQ(t.scene.remove(pile[static_cast<std::size_t>(k)]), Status::ok);
      t.expect_right();
    }
    for (int k = 3; k >= 0; --k) {
      t.add(box(k));
      t.expect_right();
    }
  });
}

// The face whose plane divides everything goes: what was behind it and what was in front of it
// become neighbours.
TEST(Moves, RootFaceIsRemoved) {
  in_every_form([](Theatre& t) {
    t.ground();
    const ObjectId screen = t.add(scenes::rectangle({-3, -3, 2}, {6, 0, 0}, {0, 6, 0}));
    for (int k = 0; k < 9; ++k) {
      const double x = k % 3 - 1.25, y = k / 3 - 1.25;
      t.add(scenes::rectangle({x, y, k % 2 ? 1.0 : 3.0}, {0.5, 0, 0}, {0, 0.5, 0.25}));
    }
    t.scene.add(Light::point({0.125, 0.25, 5}));
    t.expect_right();
    for (int k = 0; k < 3; ++k) {
      t.move(screen, {0, 0, 1.5});  // above some of the lower ones, crossing the upper ones
      t.expect_right();
      ASSERT_EQ(t.scene.set_casts_shadows(screen, false), Status::ok);
      t.expect_right();
      ASSERT_EQ(t.scene.set_receives_shadows(screen, false), Status::ok);
      t.expect_right();
      ASSERT_EQ(t.scene.set_casts_shadows(screen, true), Status::ok);
      t.expect_right();
      ASSERT_EQ(t.scene.set_receives_shadows(screen, true), Status::ok);
      t.move(screen, Vec3::Zero());
      t.expect_right();
    }
    ASSERT_EQ(t.scene.remove(screen), Status::ok);
    t.expect_right();
  });
}

TEST(Moves, OutOfRangeAndBack) {
  in_every_form([](Theatre& t) {
    t.ground();
    const ObjectId cube = t.add(scenes::box({-0.5, -0.5, 1}, {0.5, 0.5, 2}));
    const ObjectId other = t.add(scenes::box({1, -0.5, 0}, {2, 0.5, 1}));
    Light lamp = Light::point({0.25, 0.125, 3});
    lamp.range = 4;
    t.scene.add(lamp);
    t.scene.add(Light::directional({0.25, 0, -1}));
    for (const double x : {0.0, 3.0, 4.5, 5.0, 1000.0, 1e6, 4.0, 0.0}) {
      SCOPED_TRACE("at " + std::to_string(x));
      t.move(cube, {x, 0, 0});
      t.expect_right();
      t.move(other, {0, x, 0});
      t.expect_right();
    }
  });
}

TEST(Moves, LidOfAClosedBoxDeforms) {
  in_every_form([](Theatre& t) {
    t.ground();
    const Mesh box = scenes::box({-1, -1, 1}, {1, 1, 2});
    const ObjectId id = t.add(box);
    t.scene.add(Light::point({0.25, 0.5, 4}));
    t.expect_right();
    t.solids = false;
    // not flat, refused, through the light's height, as it was
    for (const double lift : {0.5, -1.0, 1.0, 0.0, -0.5, 0.0}) {
      std::vector<Vec3> vertices = box.vertices;
      vertices[7].z() += lift;
      vertices[4].x() += lift;
      ASSERT_EQ(t.scene.set_vertices(id, vertices), Status::ok);
      t.expect_right();
    }
  });
}

}  // namespace
}  // namespace shadowcut::testing
