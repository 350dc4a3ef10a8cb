// When memory runs out: operator new fails at the n-th allocation from now, for every n in turn. An
// edit then leaves the scene as it was, and an engine either is right or says that it must be
// built again.
#include <gtest/gtest.h>

#include <functional>
#include <new>
#include <optional>

#include "check.hpp"
#include "edit_checks.hpp"
#include "edit_scripts.hpp"
#include "failing_new.hpp"
#include "scene/scene_access.hpp"

namespace shadowcut::testing {
namespace {

enum class Outcome { done, out_of_memory, done_in_spite };

// Runs a step in which the n-th allocation fails.
template <class Step>
Outcome with_failure_at(std::int64_t n, const Step& step) {
  allocations_left = n;
  bool failed = false;
  try {
    step();
  } catch (const std::bad_alloc&) {
    failed = true;
  }
  const bool reached = allocations_left < 0;
  allocations_left = never;
  return failed ? Outcome::out_of_memory : reached ? Outcome::done_in_spite : Outcome::done;
}

// All of the first ones, then fewer and fewer.
std::int64_t next(std::int64_t n) { return n < 300 ? n + 1 : n + n / 100; }

std::string check_right(const Scene& scene, const Engine& engine) {
  std::string what = engine.validate() + check_same_scene(scene, engine.scene());
  for (std::size_t k = 0; k < scene.lights().size() && what.empty(); ++k) {
    if (scene.light_id(k).index == invalid_index) continue;
    Options once;
    once.threads = 1;
    what = check_same_areas(scene, cast_shadows(scene, scene.lights()[k], once), engine.shadows(k));
    if (what.empty()) what = check_fragments(scene, scene.lights()[k], engine.shadows(k));
  }
  return what;
}

void expect_answers_nothing(Engine& engine) {
  EXPECT_THROW(engine.update(), Error);
  EXPECT_THROW(engine.update(std::chrono::nanoseconds(0)), Error);
  EXPECT_THROW(engine.scene(), Error);
  EXPECT_THROW(engine.light_count(), Error);
  EXPECT_THROW(engine.shadows(0), Error);
  EXPECT_THROW(engine.find(0, {0, 0, 0}), Error);
  EXPECT_THROW(engine.overlay(), Error);
  EXPECT_THROW(engine.overlay({}), Error);
  EXPECT_THROW(engine.validate(), Error);
}

struct Case {
  Form form;
  std::uint32_t facets_per_cell, join_threshold;
  bool edits = true;
};
constexpr Case kCases[] = {{Form::merged, 128, 16},
                           {Form::pieces, 4, 0},
                           {Form::conforming, 0, 1000000},
                           {Form::merged, 128, 16, false}};

Options options_of(const Case& c) {
  Options o;
  o.form = c.form;
  o.tuning.facets_per_cell = c.facets_per_cell;
  o.tuning.join_threshold = c.join_threshold;
  o.tuning.incremental = c.edits;
  o.threads = 1;
  return o;
}

// What happens to a scene between the update that built the engine and the one that runs out of
// memory.
struct Play {
  const char* name;
  std::function<void(EditScript&)> edits;
};
std::vector<Play> plays() {
  std::vector<Play> all;
  all.push_back({"an object moves", [](EditScript& s) { s.move(s.size() / 2); }});
  all.push_back({"an object is removed", [](EditScript& s) { s.remove(1); }});
  all.push_back({"an object comes", [](EditScript& s) {
                   s.scene().add(scenes::box({-0.5, -0.5, 2}, {0.5, 0.5, 2.25}), {});
                 }});
  all.push_back({"an object is removed, and another comes in its room", [](EditScript& s) {
                   s.remove(s.size() - 1);
                   s.scene().add(s.item(s.size() - 1).mesh, {});
                 }});
  all.push_back({"a light moves", [](EditScript& s) {
                   static_cast<void>(
                       s.scene().set_light(s.scene().light_id(0), Light::point({0.5, 0.25, 4})));
                 }});
  all.push_back({"a light comes", [](EditScript& s) {
                   s.scene().add(Light::directional({0.25, 0.5, -1}));
                 }});
  all.push_back({"a light goes, objects move", [](EditScript& s) {
                   s.scene().add(Light::point({1, 1, 5}));
                   static_cast<void>(s.scene().remove(s.scene().light_id(0)));
                   s.move(0);
                   s.move(1);
                 }});
  return all;
}

// Whatever allocation of an update fails: bad_alloc comes out, nothing is answered until compact(),
// and then everything is right.
void expect_safe(EditScript& script, Engine& engine, const std::function<void()>& step,
                 std::int64_t n, Outcome& outcome) {
  outcome = with_failure_at(n, step);
  if (outcome == Outcome::out_of_memory) {
    expect_answers_nothing(engine);
    // It may fail again, and is still safe.
    if (with_failure_at(n / 2, [&] { engine.compact(); }) == Outcome::out_of_memory) {
      expect_answers_nothing(engine);
      engine.compact();
    }
  }
  ASSERT_EQ(check_right(script.scene(), engine), "");
}

class OutOfMemory : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Plays, OutOfMemory, ::testing::Range(0, static_cast<int>(plays().size())));

TEST_P(OutOfMemory, DuringAnUpdate) {
  const Play play = plays()[static_cast<std::size_t>(GetParam())];
  for (const Case& c : kCases) {
    Outcome outcome = Outcome::out_of_memory;
    for (std::int64_t n = 0; outcome != Outcome::done; n = next(n)) {
      SCOPED_TRACE(std::string(play.name) + ", case " + std::to_string(&c - kCases) +
                   ", allocation " + std::to_string(n));
      EditScript script(setting_named("resting"), 2);
      Engine engine(script.scene(), options_of(c));
      engine.update();
      script.move(0);  // so that the next update is not the first
      engine.update();
      play.edits(script);
      ASSERT_NO_FATAL_FAILURE(expect_safe(
          script, engine, [&] { engine.update(); }, n, outcome));
      // It goes on from there.
      script.move(0);
      engine.update();
      ASSERT_EQ(check_right(script.scene(), engine), "");
      if (HasFailure()) return;
    }
  }
}

TEST(OutOfMemory, DuringTheFirstUpdate) {
  for (const Case& c : kCases) {
    Outcome outcome = Outcome::out_of_memory;
    for (std::int64_t n = 0; outcome != Outcome::done; n = next(n)) {
      SCOPED_TRACE("case " + std::to_string(&c - kCases) + ", allocation " + std::to_string(n));
      EditScript script(setting_named("resting"), 2);
      Engine engine(script.scene(), options_of(c));
      ASSERT_NO_FATAL_FAILURE(expect_safe(
          script, engine, [&] { engine.update(); }, n, outcome));
      if (HasFailure()) return;
    }
  }
}

TEST(OutOfMemory, DuringCompact) {
  for (const Case& c : kCases) {
    Outcome outcome = Outcome::out_of_memory;
    for (std::int64_t n = 0; outcome != Outcome::done; n = next(n)) {
      SCOPED_TRACE("case " + std::to_string(&c - kCases) + ", allocation " + std::to_string(n));
      EditScript script(setting_named("resting"), 2);
      Engine engine(script.scene(), options_of(c));
      engine.update();
      script.move(1);
      engine.update();
      ASSERT_NO_FATAL_FAILURE(expect_safe(
          script, engine, [&] { engine.compact(); }, n, outcome));
      if (HasFailure()) return;
    }
  }
}

// Within the budget's calls too.
TEST(OutOfMemory, DuringABudgetedUpdate) {
  const Options options = options_of(kCases[0]);
  Outcome outcome = Outcome::out_of_memory;
  for (std::int64_t n = 0; outcome != Outcome::done; n = next(n)) {
    SCOPED_TRACE("allocation " + std::to_string(n));
    EditScript script(setting_named("resting"), 2);
    Engine engine(script.scene(), options);
    engine.update();
    for (std::size_t k = 0; k < script.size(); ++k) script.move(k);
    engine.update(std::chrono::nanoseconds(0));
    ASSERT_NO_FATAL_FAILURE(expect_safe(
        script, engine,
        [&] {
          while (!engine.update(std::chrono::nanoseconds(0)).complete) continue;
        },
        n, outcome));
    if (HasFailure()) return;
  }
}

// An edit that throws leaves the scene as it was.
TEST(OutOfMemory, DuringAnEdit) {
  ObjectSettings settings;
  settings.name = "a name that is too long to be kept in place";
  Light named = Light::point({1, 2, 3});
  named.name = settings.name;
  Pose far = Pose::Identity(), wide = Pose::Identity();
  far.translation() = Vec3(3, 2, 1);
  wide.linear() *= 2;
  const Mesh box = scenes::box({0, 0, 0}, {1, 1, 1});
  std::vector<Vec3> folded = box.vertices;
  folded[7].z() += 0.5;
  struct Edited {
    const char* name;
    std::function<void(Scene&, ObjectId)> edit;
  };
  const Edited edits[] = {
      {"add", [&](Scene& s, ObjectId) { s.add(box, settings); }},
      {"remove", [&](Scene& s, ObjectId id) { static_cast<void>(s.remove(id)); }},
      {"set_pose, rigid", [&](Scene& s, ObjectId id) { static_cast<void>(s.set_pose(id, far)); }},
      {"set_pose, not rigid",
       [&](Scene& s, ObjectId id) { static_cast<void>(s.set_pose(id, wide)); }},
      {"set_vertices",
       [&](Scene& s, ObjectId id) { static_cast<void>(s.set_vertices(id, folded)); }},
      {"set_casts",
       [&](Scene& s, ObjectId id) { static_cast<void>(s.set_casts_shadows(id, false)); }},
      {"add light", [&](Scene& s, ObjectId) { s.add(named); }},
      {"remove light", [&](Scene& s, ObjectId) { static_cast<void>(s.remove(s.light_id(0))); }},
      {"set_light",
       [&](Scene& s, ObjectId) { static_cast<void>(s.set_light(s.light_id(0), named)); }},
  };
  for (const bool holes : {false, true}) {
    for (const Edited& e : edits) {
      Outcome outcome = Outcome::out_of_memory;
      for (std::int64_t n = 0; outcome != Outcome::done; ++n) {
        SCOPED_TRACE(std::string(e.name) + (holes ? ", with holes" : "") + ", allocation " +
                     std::to_string(n));
        Scene scene;
        scene.add(scenes::rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}), {});
        const ObjectId id = scene.add(box, settings);
        scene.add(Light::point({0.5, 0.25, 4}));
        if (holes) {
          const ObjectId gone = scene.add(box, {});
          ASSERT_EQ(scene.remove(gone), Status::ok);
          ASSERT_EQ(scene.remove(scene.add(named)), Status::ok);
        }
        const Scene before = scene;
        const std::uint64_t revision = SceneAccess::revision(scene);
        outcome = with_failure_at(n, [&] { e.edit(scene, id); });
        ASSERT_EQ(check_arrays(scene), "");
        if (outcome != Outcome::out_of_memory) continue;
        EXPECT_EQ(check_same_scene(before, scene), "");
        EXPECT_EQ(SceneAccess::revision(scene), revision);
        e.edit(scene, id);  // nothing is lost
        ASSERT_EQ(check_arrays(scene), "");
        if (HasFailure()) break;
      }
    }
  }
}

// Blocks of memory that an engine holds do not become more and more.
TEST(Memory, IsFlatOverAThousandRounds) {
  for (const Case& c : kCases) {
    SCOPED_TRACE("case " + std::to_string(&c - kCases));
    EditScript script(setting_named("resting"), 5);
    Engine engine(script.scene(), options_of(c));
    engine.update();
    std::int64_t after_some = 0;
    for (int k = 0; k < 1000; ++k) {
      const std::size_t item = script.size() / 2;
      script.remove(item);
      engine.update();
      script.add_back(item);
      script.swing(script.size() - 1);
      engine.update();
      script.swing(script.size() - 1);
      engine.update();
      if (k == 20) after_some = blocks_allocated;
    }
    EXPECT_LE(blocks_allocated, after_some + 16);
  }
}

TEST(Memory, AllIsGivenBack) {
  const auto live = [](std::uint64_t seed) {
    const std::int64_t before = blocks_allocated;
    {
      EditScript script(setting_named("stacks"), seed);
      Engine engine(script.scene(), options_of(kCases[seed % 4]));
      for (int k = 0; k < 20; ++k) {
        engine.update();
        script.step();
      }
    }
    return blocks_allocated - before;
  };
  live(0);  // what is made once
  for (std::uint64_t seed = 1; seed < 9; ++seed) EXPECT_EQ(live(seed), 0) << "seed " << seed;
}

}  // namespace
}  // namespace shadowcut::testing
