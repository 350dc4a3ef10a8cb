// Edits. After every update an engine must be as if it had been made for the scene as it now is:
// regions, areas, facing; and an update must report exactly the fragments that changed.
//
// SHADOWCUT_SOAK=n runs about n random updates instead of some ten thousand, SHADOWCUT_SEED=k other
// ones. A failure names setting, seed, options and step; SHADOWCUT_HISTORY=seed runs that one
// history alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "check.hpp"
#include "follower.hpp"
#include "settings.hpp"

namespace shadowcut::testing {
namespace {

using std::chrono::nanoseconds;

class EditsOf : public ::testing::TestWithParam<Setting> {};
INSTANTIATE_TEST_SUITE_P(Settings, EditsOf,
                         ::testing::ValuesIn(all_settings().begin(), all_settings().end()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_P(EditsOf, RandomHistories) {
  if (const auto seed = environment("SHADOWCUT_HISTORY")) {
    run_history(GetParam(), *seed, 240);
    return;
  }
  const std::uint64_t updates =
      environment("SHADOWCUT_SOAK").value_or(10500) / all_settings().size() + 1;
  std::uint64_t done = 0;
  for (std::uint64_t seed = first_seed(); done < updates; ++seed) {
    const std::uint64_t length = seed % 8 == 7 ? 240 : 30 + 30 * (seed % 3);
    if (!run_history(GetParam(), seed, length)) return;
    done += length;
  }
}

// The common partition of all lights asks trees that have been edited.
TEST_P(EditsOf, CombinedLights) {
  for (std::uint64_t seed = 3000 + first_seed(); seed < 3008 + first_seed(); ++seed) {
    Follower f(GetParam(), seed, some_options(seed));
    ASSERT_EQ(f.update(), "") << f.where();
    for (int step = 0; step < 40; ++step) {
      f.script.step();
      if (step % 4 != 0) continue;
      f.engine.update();
      ASSERT_EQ(check_overlay(f.engine), "") << f.where() << ", update " << step;
    }
  }
}

// The same history gives the same bits, whatever the number of threads, and handed-out changes too.
TEST_P(EditsOf, SameHistorySameBits) {
  for (std::uint64_t seed = 5000 + first_seed(); seed < 5004 + first_seed(); ++seed) {
    std::vector<std::unique_ptr<Follower>> all;
    for (const unsigned threads : {1u, 1u, 2u}) {
      Options options = some_options(seed);
      options.tuning.incremental = true;
      options.threads = threads;
      all.push_back(std::make_unique<Follower>(GetParam(), seed, options));
    }
    std::vector<std::string> steps(3, "the first update");
    for (int step = 0; step < 30; ++step) {
      SCOPED_TRACE(all[0]->where() + ", step " + std::to_string(step) + ": " + steps[0]);
      std::vector<const Changes*> changes;
      for (const auto& f : all) changes.push_back(&f->engine.update());
      for (const std::size_t other : {1u, 2u}) {
        SCOPED_TRACE(other == 1 ? "again" : "two threads");
        ASSERT_EQ(steps[0], steps[other]);
        ASSERT_EQ(check_identical(*changes[0], *changes[other]), "");
        for (std::size_t k = 0; k < all[0]->engine.light_count(); ++k) {
          if (all[0]->engine.scene().light_id(k).index == invalid_index) continue;
          ASSERT_EQ(check_identical(all[0]->engine.shadows(k), all[other]->engine.shadows(k)), "")
              << "light " << k;
        }
      }
      for (std::size_t i = 0; i < 3; ++i) steps[i] = all[i]->script.step();
    }
  }
}

// With no time at all each call still applies an object, and what it leaves is right for the scene
// it says it is of.
TEST_P(EditsOf, BudgetOfNothing) {
  for (std::uint64_t seed = 7000 + first_seed(); seed < 7004 + first_seed(); ++seed) {
    const Options options = some_options(seed);
    Follower f(GetParam(), seed, options);
    ASSERT_EQ(f.update(), "") << f.where();
    for (int round = 0; round < 6; ++round) {
      std::string edits;
      for (int k = 0; k < 6; ++k) edits += f.script.edit() + "; ";
      std::size_t calls = 0, most = f.script.size() + 6;
      for (bool complete = false; !complete; ++calls) {
        SCOPED_TRACE(f.where() + ", round " + std::to_string(round) + ", call " +
                     std::to_string(calls) + ": " + edits);
        if (calls == 2 && round % 2 == 0) {  // more comes in between
          for (int k = 0; k < 3; ++k) edits += f.script.edit() + "; ";
          most += f.script.size();
        }
        ASSERT_LT(calls, most) << "never complete";
        const Scene before = f.engine.scene();
        const Changes& changes = f.engine.update(nanoseconds(0));
        complete = changes.complete;
        ASSERT_GE(changes.applied, 1u);
        const Scene &now = f.engine.scene(), &wanted = f.script.scene();
        for (std::size_t i = 0; i < std::max(now.objects().size(), wanted.objects().size()); ++i)
          ASSERT_TRUE(same_object(now, before, i) || same_object(now, wanted, i)) << "object " << i;
        for (std::size_t i = 0; i < std::max(now.lights().size(), wanted.lights().size()); ++i)
          ASSERT_TRUE(same_light(now, before, i) || same_light(now, wanted, i)) << "light " << i;
        ASSERT_EQ(f.engine.validate(), "");
        ASSERT_EQ(check_arrays(now), "");
        ASSERT_EQ(f.mirror.apply(changes, f.engine), "");
        ASSERT_EQ(check_lights(f.engine, 1, false, options.form), "");
      }
      ASSERT_EQ(check_same_scene(f.script.scene(), f.engine.scene()), "") << f.where() << edits;
      const Changes& nothing = f.engine.update(nanoseconds(0));
      EXPECT_TRUE(nothing.complete && nothing.lights.empty() && nothing.applied == 0)
          << f.where() << edits;
    }
    f.script.step();
    EXPECT_TRUE(f.engine.update(std::chrono::hours(1)).complete) << f.where();
  }
}

// A scene as it has become through edits, and the same objects added where they now are.
TEST_P(EditsOf, EditedObjectIsTheObjectAddedThere) {
  for (std::uint64_t seed = 9000 + first_seed(); seed < 9004 + first_seed(); ++seed) {
    EditScript script(GetParam(), seed);
    std::string edits;
    for (int step = 0; step < 40; ++step) {
      edits = script.step();
      SCOPED_TRACE(std::string("setting ") + GetParam().name + ", seed " + std::to_string(seed) +
                   ", step " + std::to_string(step) + ": " + edits);
      const Scene& scene = script.scene();
      ASSERT_EQ(check_arrays(scene), "");
      Scene fresh;
      // an object, and its index in the fresh scene
      std::vector<std::pair<const Object*, std::size_t>> pairs;
      for (std::size_t k = 0; k < script.size(); ++k) {
        const auto& item = script.item(k);
        ASSERT_EQ(scene.find(item.id) != nullptr, item.present);
        if (item.present)
          pairs.emplace_back(scene.find(item.id), fresh.add(item.mesh, item.settings).index);
      }
      ASSERT_EQ(scene.issues().size(), fresh.issues().size());
      for (const auto& [a, index] : pairs) {
        const Object& b = fresh.objects()[index];
        SCOPED_TRACE(a->name);
        ASSERT_EQ(a->name, b.name);
        ASSERT_TRUE(a->sides == b.sides && a->casts_shadows == b.casts_shadows &&
                    a->receives_shadows == b.receives_shadows && a->dynamic == b.dynamic);
        ASSERT_EQ(a->pose.matrix(), b.pose.matrix());
        ASSERT_EQ(a->vertex_count, b.vertex_count);
        ASSERT_EQ(a->edge_count, b.edge_count);
        ASSERT_EQ(a->facet_count, b.facet_count);
        ASSERT_EQ(a->face_count, b.face_count);
        const double size = 1 + std::abs(a->signed_volume);
        ASSERT_NEAR(a->signed_volume, b.signed_volume,
                    1e-9 * size * (1 + a->pose.translation().norm()));
        for (std::uint32_t v = 0; v < a->vertex_count; ++v)
          ASSERT_EQ(scene.vertices()[a->first_vertex + v], fresh.vertices()[b.first_vertex + v])
              << "vertex " << v;
        for (std::uint32_t f = 0; f < a->face_count; ++f) {
          const Face &x = scene.faces()[a->first_face + f], &y = fresh.faces()[b.first_face + f];
          ASSERT_EQ(x.facet_count, y.facet_count) << "face " << f;
          ASSERT_NEAR(x.area, y.area, 1e-12 * y.area) << "face " << f;
        }
      }
      if (step % 4 != 0) continue;
      for (std::size_t k = 0; k < scene.lights().size(); ++k) {
        if (scene.light_id(k).index == invalid_index) continue;
        const Shadows here = cast_shadows(scene, scene.lights()[k]),
                      there = cast_shadows(fresh, scene.lights()[k]);
        for (const auto& [a, index] : pairs) {
          for (std::uint32_t f = 0; f < a->face_count; ++f) {
            const FaceArea &x = here.areas[a->first_face + f],
                           &y = there.areas[fresh.objects()[index].first_face + f];
            ASSERT_EQ(x.facing, y.facing) << a->name << ", face " << f << ", light " << k;
            ASSERT_NEAR(x.lit, y.lit, kAreaTolerance * y.area)
                << a->name << ", face " << f << ", light " << k;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace shadowcut::testing
