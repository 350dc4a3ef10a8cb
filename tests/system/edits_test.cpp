// Edits. After every update an engine must be as if it had been made for the scene as it now is:
// regions, areas, facing; and what it hands out must be exactly what changed.
//
// SHADOWCUT_SOAK=n runs about n random updates instead of some ten thousand, SHADOWCUT_SEED=k other
// ones. A failure names setting, seed, options and step; SHADOWCUT_HISTORY=seed runs that one
// history alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <set>

#include "check.hpp"
#include "edit_checks.hpp"
#include "edit_scripts.hpp"
#include "settings.hpp"

namespace shadowcut::testing {
namespace {

using scenes::Random;
using scenes::SceneData;
using std::chrono::nanoseconds;

std::uint64_t first_seed() { return 1000000 * environment("SHADOWCUT_SEED").value_or(0); }

Options some_options(std::uint64_t seed) {
  Random random(7 * seed + 3);
  constexpr std::array<std::uint32_t, 3> sizes{0, 4, 128};
  constexpr std::array<std::uint32_t, 4> thresholds{0, 2, 16, 1000000};
  Options o;
  o.form = static_cast<Form>(random.below(3));
  o.order = static_cast<Order>(random.below(3));
  o.facets_per_cell = sizes[random.below(3)];
  o.join_threshold = thresholds[random.below(4)];
  o.threads = random.below(4) == 0 ? 2 : 1;
  o.edits = random.below(8) != 0;
  o.seed = seed;
  return o;
}

bool limited(const Light& light) { return std::isfinite(light.range) || light.spot; }

std::size_t live_facets(const Scene& scene) {
  std::size_t n = 0;
  for (const Object& o : scene.objects()) n += o.facet_count;
  return n;
}

// Whether the light stands in the box of a closed object.
bool may_stand_inside(const Scene& scene, const Light& light) {
  return std::any_of(scene.objects().begin(), scene.objects().end(), [&](const Object& o) {
    Eigen::AlignedBox3d box;
    for (const Vec3& v : scene.vertices().subspan(o.first_vertex, o.vertex_count)) box.extend(v);
    return o.alive && o.sides == Sides::closed && box.contains(light.at);
  });
}

// One light's shadows against shadows cast for the scene as it stands. What either leaves undecided
// may differ.
std::string check_against_new(const Scene& scene, const Light& light, const Shadows& shadows,
                              const Undecided& undecided, Form form) {
  Options once;
  once.threads = 1;
  once.edits = false;
  auto [fresh, open] = cast_alone(scene, light, once);
  for (std::size_t f = 0; f < open.size(); ++f) open[f] += undecided[f];
  std::string what = check_same_areas(scene, fresh, shadows, kAreaTolerance, &open);
  if (!what.empty()) return what;
  for (std::size_t i = 0; i < fresh.areas.size(); ++i) {
    if (std::abs(fresh.areas[i].area - shadows.areas[i].area) >
        kAreaTolerance * fresh.areas[i].area)
      return "the area of face " + std::to_string(i) + " differs\n";
  }
  what += check_fragments(scene, light, shadows, kAreaTolerance, form);
  return what.empty() ? check_same_regions(scene, light, fresh, shadows, &open) : what;
}

// Far sides of closed objects cast nothing that near sides do not, but for a light inside; where
// the near ones are out of reach; and where the object cuts through itself. Only in the first case
// must they cast.
std::string check_against_oracle(const Scene& scene, const Light& light, const Shadows& shadows,
                                 const Undecided& undecided, std::uint64_t seed, bool solids) {
  const bool inside = light.kind == Light::Kind::point && may_stand_inside(scene, light),
             only_facing = limited(light) || !solids;
  if (inside && only_facing) return {};
  const CgalOracle oracle(scene, light, only_facing);
  return check_areas(scene, shadows, oracle, &undecided) +
         check_points(scene, shadows, oracle, seed, 20, true);
}

std::string check_combined(const Engine& engine) {
  const LightSets sets = engine.combined();
  for (std::size_t k = 0; k < engine.light_count(); ++k) {
    if (engine.scene().light_id(k).index == none) continue;
    const std::vector<double> lit = lit_areas(engine.scene(), sets, k);
    for (std::size_t face = 0; face < lit.size(); ++face) {
      const FaceArea& alone = engine.shadows(k).areas[face];
      if (std::abs(lit[face] - alone.lit) > kAreaTolerance * alone.area)
        return "combined: light " + std::to_string(k) + " reaches " + std::to_string(lit[face]) +
               " of face " + std::to_string(face) + ", should be " + std::to_string(alone.lit) +
               "\n";
    }
  }
  return {};
}

// Every light of the engine against new shadows of engine.scene(), and everything that needs no
// other engine. solids: closed objects are.
std::string check_lights(const Engine& engine, std::uint64_t step, bool solids,
                         Form form = Form::merged) {
  const Scene& scene = engine.scene();
  if (engine.light_count() != scene.lights().size())
    return "the engine has other lights than its scene\n";
  for (std::size_t k = 0; k < engine.light_count(); ++k) {
    if (scene.light_id(k).index == none) {
      try {
        engine.shadows(k);
        return "a light is removed, and has shadows\n";
      } catch (const Error&) {
        continue;
      }
    }
    const Light& light = scene.lights()[k];
    const Shadows& shadows = engine.shadows(k);
    const Undecided undecided = engine.undecided(k);
    std::string what = check_against_new(scene, light, shadows, undecided, form);
    // About a hundred thousand pairs of facets for the oracle in a history.
    const std::size_t facets = live_facets(scene);
    if (what.empty() && step % std::max<std::size_t>(8, facets * facets / 400) == 0)
      what = check_against_oracle(scene, light, shadows, undecided, step, solids);
    if (!what.empty()) return "light " + std::to_string(k) + ": " + what;
  }
  return {};
}

// An engine that follows a script's scene, and a mirror that follows the engine.
class Follower {
 public:
  Follower(const Setting& setting, std::uint64_t seed, const Options& options)
      : where_(std::string("setting ") + setting.name + ", seed " + std::to_string(seed) + ", " +
               testing::describe(options)),
        options_(options),
        script(setting, seed),
        engine(script.scene(), options) {}

  // Applies the last edits and checks everything there is to check.
  std::string update(const std::string& edits = "the first update") {
    edits_ = edits;
    const Changes& changes = engine.update();
    if (!changes.complete) return "an update without a budget is not complete\n";
    return check(changes);
  }
  std::string compact() {
    edits_ = "compact";
    const Changes& changes = engine.compact();
    for (const LightChanges& c : changes.lights) {
      if (!c.rebuilt) return "compact: a tree is not new\n";
    }
    return check(changes);
  }
  std::string check(const Changes& changes) {
    ++step_;
    std::string what = engine.validate();
    if (what.empty()) what = check_arrays(script.scene());
    if (what.empty()) what = check_same_scene(script.scene(), engine.scene());
    if (what.empty()) what = mirror.apply(changes, engine);
    if (what.empty() && step_ % 4 == 0) what = mirror.check_find(engine, options_.edits ? 1 : 16);
    if (what.empty()) what = check_lights(engine, step_, !script.deformed(), options_.form);
    // Where objects are far away, what was one corner may be two, a rounding of that distance
    // apart.
    if (what.empty() && options_.form == Form::conforming && step_ % 4 == 0 && script.reach() < 4)
      what = check_conforming_lights();
    return what;
  }
  std::string check_conforming_lights() const {
    std::string what;
    for (std::size_t k = 0; k < engine.light_count() && what.empty(); ++k) {
      if (engine.scene().light_id(k).index != none)
        what = check_conforming(engine.scene(), engine.shadows(k));
    }
    return what;
  }
  std::string where() const { return where_ + ", step " + std::to_string(step_) + ": " + edits_; }

 private:
  std::string where_, edits_;
  Options options_;
  std::uint64_t step_ = 0;

 public:
  EditScript script;
  Engine engine;
  Mirror mirror;
};

// One random history from a fresh scene; false when something is wrong.
bool run_history(const Setting& setting, std::uint64_t seed, std::uint64_t updates) {
  Follower f(setting, seed, some_options(seed));
  std::string what = f.update();
  for (std::uint64_t k = 1; k < updates && what.empty(); ++k) {
    if (seed % 2 == 0 && k % 50 == 49) what = f.compact();
    if (k % 30 == 29) {  // an engine may be moved about
      Engine moved = std::move(f.engine);
      f.engine = std::move(moved);
    }
    if (what.empty()) what = f.update(f.script.step());
  }
  EXPECT_EQ(what, "") << f.where();
  return what.empty();
}

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
      ASSERT_EQ(check_combined(f.engine), "") << f.where() << ", update " << step;
    }
  }
}

// The same history gives the same bits, whatever the number of threads, and handed-out changes too.
TEST_P(EditsOf, SameHistorySameBits) {
  for (std::uint64_t seed = 5000 + first_seed(); seed < 5004 + first_seed(); ++seed) {
    std::vector<std::unique_ptr<Follower>> all;
    for (const unsigned threads : {1u, 1u, 2u}) {
      Options options = some_options(seed);
      options.edits = true;
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
          if (all[0]->engine.scene().light_id(k).index == none) continue;
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
        ASSERT_TRUE(a->sides == b.sides && a->casts == b.casts && a->receives == b.receives &&
                    a->moves == b.moves);
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
        if (scene.light_id(k).index == none) continue;
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

// What an engine holds, to see that it does not grow and that history repeats itself.
struct State {
  std::vector<FaceArea> areas;
  std::uint64_t nodes, pieces, marked, fragments, bytes;
  std::uint32_t largest_piece = 0, largest_place = 0;

  explicit State(const Shadows& s)
      : areas(s.areas),
        nodes(s.stats.nodes),
        pieces(s.stats.pieces),
        marked(s.stats.marked_nodes),
        fragments(s.stats.lit_fragments + s.stats.shadowed_fragments),
        bytes(s.stats.bytes) {
    for (const Block& block : s.blocks) {
      for (const Fragment& f : block.fragments) {
        largest_piece = std::max(largest_piece, f.id.piece);
        if (f.id.place != none) largest_place = std::max(largest_place, f.id.place);
      }
    }
  }
  auto sizes() const { return std::tuple(nodes, pieces, marked, fragments); }
};

bool same_bits(const std::vector<FaceArea>& a, const std::vector<FaceArea>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const FaceArea& x, const FaceArea& y) {
                      return x.facing == y.facing && x.area == y.area && x.lit == y.lit &&
                             x.shadowed == y.shadowed;
                    });
}

// Runs `round`, which leaves the scene as it was, a thousand times. Two engines with the same
// history agree to the bit after every round, areas are those of the first round, and after the
// first tenth nothing grows. (Fragments need not repeat: now and then a cell is built again.)
// (Fewer times in the conforming form, which looks at all fragments in every update.)
template <class Round>
void expect_rounds_repeat(const Setting& setting, std::uint64_t seed, const Options& options,
                          const Round& round) {
  const int rounds = options.form == Form::conforming ? 200 : 1000;
  Follower f(setting, seed, options);
  SCOPED_TRACE(f.where());
  ASSERT_EQ(f.update(), "");
  EditScript again(setting, seed);  // the same scene, and the same edits
  Engine twin(again.scene(), options);
  twin.update();
  const State first(f.engine.shadows(0));
  State most = first;
  for (int k = 0; k < rounds; ++k) {
    round(f.script, [&f] { f.engine.update(); });
    round(again, [&twin] { twin.update(); });
    const State now(f.engine.shadows(0)), other(twin.shadows(0));
    ASSERT_TRUE(same_bits(now.areas, other.areas))
        << "areas are not those of the same history, round " << k + 1;
    ASSERT_EQ(now.sizes(), other.sizes()) << "round " << k + 1;
    for (std::size_t i = 0; i < now.areas.size(); ++i)
      ASSERT_NEAR(now.areas[i].lit, first.areas[i].lit, kAreaTolerance * first.areas[i].area)
          << "face " << i << ", round " << k + 1;
    if (k < rounds / 10) {
      most.bytes = std::max(most.bytes, now.bytes);
      most.largest_piece = std::max(most.largest_piece, now.largest_piece);
      most.largest_place = std::max(most.largest_place, now.largest_place);
      continue;
    }
    ASSERT_LE(static_cast<double>(now.bytes), 1.25 * static_cast<double>(most.bytes))
        << "memory grows, round " << k + 1;
    ASSERT_LE(now.largest_piece, std::uint64_t{2} * most.largest_piece)
        << "ids grow, round " << k + 1;
    ASSERT_LE(now.largest_place, std::uint64_t{2} * most.largest_place)
        << "ids grow, round " << k + 1;
  }
  ASSERT_EQ(f.engine.validate(), "");
  ASSERT_EQ(check_lights(f.engine, 1, false, options.form), "");
}

std::vector<Options> options_for_rounds() {
  std::vector<Options> all(4);
  all[1].join_threshold = 0;
  all[1].form = Form::pieces;
  all[2].join_threshold = 1000000;
  all[2].facets_per_cell = 4;
  all[3].form = Form::conforming;
  all[3].facets_per_cell = 0;
  for (Options& o : all) o.threads = 1;
  return all;
}

class RoundsOf : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Settings, RoundsOf,
                         ::testing::Values("resting", "furnished_box", "stacks", "turned_boxes",
                                           "city"),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(RoundsOf, RemoveAndAddBackAThousandTimes) {
  std::uint64_t seed = 20;
  for (const Options& options : options_for_rounds()) {
    expect_rounds_repeat(setting_named(GetParam()), seed++, options,
                         [](EditScript& script, const auto& update) {
                           const std::size_t item = script.size() / 2;
                           const ObjectId old = script.item(item).id;
                           script.remove(item);
                           update();
                           script.add_back(item);
                           update();
                           ASSERT_EQ(script.item(item).id.index, old.index);
                           ASSERT_NE(script.item(item).id.generation, old.generation);
                         });
  }
}

TEST_P(RoundsOf, MoveToAndFroAThousandTimes) {
  std::uint64_t seed = 40;
  for (const Options& options : options_for_rounds()) {
    expect_rounds_repeat(setting_named(GetParam()), seed++, options,
                         [](EditScript& script, const auto& update) {
                           const std::size_t item = script.size() - 1;
                           script.swing(item);
                           update();
                           script.swing(item);
                           update();
                         });
  }
}

// The lit regions after a round trip are what they were before it, too.
TEST_P(RoundsOf, RemovalOfEachObjectAndItsReturn) {
  for (std::uint64_t seed = 60; seed < 63; ++seed) {
    Follower f(setting_named(GetParam()), seed, some_options(seed));
    SCOPED_TRACE(f.where());
    ASSERT_EQ(f.update(), "");
    const std::size_t objects = std::min<std::size_t>(f.script.size(), 24);
    for (std::size_t k = 0; k < objects; ++k) {
      const std::string name = f.script.item(k).settings.name;
      f.script.remove(k);
      ASSERT_EQ(f.update("remove " + name), "") << f.where();
      f.script.add_back(k);
      ASSERT_EQ(f.update("add back " + name), "") << f.where();
    }
    for (std::size_t k = 0; k < objects; ++k) {  // to nothing, and back
      f.script.remove(k);
      ASSERT_EQ(f.update("remove, one after another, " + f.script.item(k).settings.name), "")
          << f.where();
    }
    for (std::size_t k = objects; k-- > 0;) {
      f.script.add_back(k);
      ASSERT_EQ(f.update("add, one after another, " + f.script.item(k).settings.name), "")
          << f.where();
    }
  }
}

// Long runs. Trees must not rot: nodes stay within one and a half times those of a new tree.
constexpr double kRot = 1.5;

std::uint64_t nodes_of_new(const Scene& scene, const Options& options) {
  Engine fresh(scene, options);
  fresh.update();
  return fresh.shadows(0).stats.nodes;
}

class LongRunsOf : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Settings, LongRunsOf,
                         ::testing::Values("city", "rooms", "spheres", "triangles"),
                         [](const auto& info) { return std::string(info.param); });

constexpr int kLongRun = 3000;

// A quarter of the objects, never the first, which is ground or room.
TEST_P(LongRunsOf, SomeObjectsMove) {
  for (const std::uint32_t threshold : {0u, 16u}) {
    Options options;
    options.threads = 1;
    options.join_threshold = threshold;
    EditScript script(setting_named(GetParam()), 3);
    Engine engine(script.scene(), options);
    engine.update();
    Random random(11);
    for (int k = 1; k <= kLongRun; ++k) {
      const std::string edit =
          script.move(1 + 4 * random.below((script.size() + 2) / 4) % (script.size() - 1));
      engine.update();
      if (k % 300 != 0) continue;
      SCOPED_TRACE(std::string(GetParam()) + ", " + describe(options) + ", move " +
                   std::to_string(k) + ", " + edit);
      ASSERT_EQ(engine.validate(), "");
      ASSERT_EQ(check_lights(engine, 1, true), "");
      const std::uint64_t nodes = nodes_of_new(script.scene(), options);
      EXPECT_LE(static_cast<double>(engine.shadows(0).stats.nodes),
                kRot * static_cast<double>(nodes))
          << "nodes of a new tree: " << nodes;
    }
  }
}

// Everything moves, the ground too. The new tree to compare with takes the objects in the order
// that the options name, as the engine does whenever it builds a cell again. These scenes are so
// small that one move may halve the tree that they need, which the engine learns of at the next
// edits only: so sizes are compared over the run.
TEST_P(LongRunsOf, AllObjectsMove) {
  Options options;
  options.threads = 1;
  options.order = Order::as_given;
  options.facets_per_cell = 0;  // both without a prefix, which would be another one
  EditScript script(setting_named(GetParam()), 4);
  Engine engine(script.scene(), options);
  engine.update();
  Random random(12);
  double sum = 0, sum_of_new = 0;
  for (int k = 1; k <= kLongRun; ++k) {
    const std::size_t item = random.below(script.size());
    const std::string edit = script.move(item);
    engine.update();
    if (k % 300 != 0) continue;
    SCOPED_TRACE(std::string(GetParam()) + ", " + describe(options) + ", move " +
                 std::to_string(k) + ", " + edit);
    ASSERT_EQ(engine.validate(), "");
    ASSERT_EQ(check_lights(engine, 1, true), "");
    const std::uint64_t nodes = nodes_of_new(script.scene(), options);
    sum += static_cast<double>(engine.shadows(0).stats.nodes);
    sum_of_new += static_cast<double>(nodes);
  }
  EXPECT_LE(sum, kRot * sum_of_new);
}

// Updates hand out what changed, and leave the rest alone.

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
    options.facets_per_cell = size;
    const SceneData data = scenes::city(12);
    Scene scene = scenes::build(data);
    Engine engine(scene, options);
    engine.update();
    const ObjectId house = scene.object_id(70);
    const Pose home = scene.find(house)->pose;
    for (int k = 1; k <= 8; ++k) {
      Pose pose = home;
      pose.pretranslate(Vec3(k % 2 ? 0.05 : 0, 0, 0));
      ASSERT_EQ(scene.set_pose(house, pose), Edit::done);
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
  ASSERT_EQ(scene.set_light(sun, Light::directional({0.25, 0.25, -1})), Edit::done);
  const Changes& moved = engine.update();
  EXPECT_EQ(moved.applied, 1u);
  ASSERT_EQ(moved.lights.size(), 1u);
  EXPECT_EQ(moved.lights[0].light, 1u);
  EXPECT_TRUE(moved.lights[0].rebuilt);
  ASSERT_EQ(scene.remove(sun), Edit::done);
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
    options.edits = edits;
    options.facets_per_cell = 4;
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
    ASSERT_EQ(scene.remove(first), Edit::done);
    ASSERT_EQ(update(), "");
    for (const ObjectId box : boxes) {
      ASSERT_EQ(scene.remove(box), Edit::done);
      ASSERT_EQ(update(), "");
    }
    ASSERT_EQ(scene.remove(second), Edit::done);
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
  ASSERT_EQ(scene.remove(scene.add(scenes::box({0, 0, 3}, {1, 1, 4}), {})), Edit::done);
  ASSERT_EQ(scene.remove(scene.add(Light::point({1, 1, 9}))), Edit::done);
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

// Named geometry.

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
    ASSERT_EQ(scene.set_pose(id, pose), Edit::done);
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
        t.options.join_threshold = threshold;
        t.options.facets_per_cell = size;
        SCOPED_TRACE(describe(t.options));
        play(t);
        if (::testing::Test::HasFailure()) return;
      }
    }
  }
}

// Edits large enough to be spread over threads: two buildings of five of a city at once. (Of more,
// all would be built anew.)
TEST(Moves, ManyAtOnceSameBitsOnAnyNumberOfThreads) {
  for (const Kernel kernel : {Kernel::fast, Kernel::exact}) {
    const SceneData data = scenes::city(12);
    Scene scene = scenes::build(data);
    std::vector<std::unique_ptr<Engine>> engines;
    for (const unsigned threads : {1u, 2u, 3u}) {
      Options options;
      options.kernel = kernel;
      options.threads = threads;
      options.facets_per_cell = 32;
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
        ASSERT_EQ(scene.set_pose(scene.object_id(i), pose), Edit::done);
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
              Edit::done);
    engine.update();
    if (k % 100 != 0) continue;
    ASSERT_EQ(engine.validate(), "");
    ASSERT_EQ(check_lights(engine, 1, true), "");
    EXPECT_LE(static_cast<double>(engine.shadows(0).stats.nodes),
              kRot * static_cast<double>(nodes_of_new(scene, options)));
  }
  EXPECT_LE(engine.shadows(0).stats.cells_built_again, 20u);
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
    ASSERT_EQ(scene.set_pose(desks[d], Eigen::Translation3d(by) * homes[d]), Edit::done);
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
      ASSERT_EQ(t.scene.remove(pile[static_cast<std::size_t>(k)]), Edit::done);
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
      ASSERT_EQ(t.scene.set_casts(screen, false), Edit::done);
      t.expect_right();
      ASSERT_EQ(t.scene.set_receives(screen, false), Edit::done);
      t.expect_right();
      ASSERT_EQ(t.scene.set_casts(screen, true), Edit::done);
      t.expect_right();
      ASSERT_EQ(t.scene.set_receives(screen, true), Edit::done);
      t.move(screen, Vec3::Zero());
      t.expect_right();
    }
    ASSERT_EQ(t.scene.remove(screen), Edit::done);
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
      ASSERT_EQ(t.scene.set_vertices(id, vertices), Edit::done);
      t.expect_right();
    }
  });
}

// Ids.

TEST(Ids, StaleOnesChangeNothing) {
  Scene scene = scenes::build(scenes::city(2));
  Engine engine(scene);
  engine.update();
  const ObjectId gone = scene.object_id(2);
  ASSERT_EQ(scene.remove(gone), Edit::done);
  const LightId lamp = scene.add(Light::point({9, 9, 9}));
  ASSERT_EQ(scene.remove(lamp), Edit::done);
  const Scene before = scene;
  const std::uint64_t revision = scene.revision();
  const std::vector<Vec3> vertices(8, Vec3::Zero());
  const auto expect_refused = [&](ObjectId object, LightId light, Edit as) {
    EXPECT_EQ(scene.remove(object), as);
    EXPECT_EQ(scene.set_pose(object, Pose::Identity()), as);
    EXPECT_EQ(scene.set_vertices(object, vertices), as);
    EXPECT_EQ(scene.set_casts(object, false), as);
    EXPECT_EQ(scene.set_receives(object, false), as);
    EXPECT_EQ(scene.remove(light), as);
    EXPECT_EQ(scene.set_light(light, Light::point({1, 2, 3})), as);
    EXPECT_EQ(scene.find(object), nullptr);
    EXPECT_EQ(scene.find(light), nullptr);
    EXPECT_EQ(check_same_scene(before, scene), "");
    EXPECT_EQ(scene.revision(), revision);
  };
  expect_refused(gone, lamp, Edit::stale);
  expect_refused({}, {}, Edit::foreign);
  Scene other = scenes::build(scenes::city(2));
  expect_refused(other.object_id(1), other.light_id(0), Edit::foreign);
  ObjectId beyond = scene.object_id(1);
  beyond.index = 100;
  LightId light_beyond = scene.light_id(0);
  light_beyond.index = 100;
  expect_refused(beyond, light_beyond, Edit::foreign);
  EXPECT_EQ(scene.object_id(2), ObjectId{});
  EXPECT_EQ(scene.object_id(100), ObjectId{});
  EXPECT_EQ(scene.light_id(1), LightId{});
  // An index used again does not bring an old id back.
  const ObjectId again = scene.add(scenes::box({0, 0, 0}, {1, 1, 1}), {});
  EXPECT_EQ(again.index, gone.index);
  EXPECT_NE(again.generation, gone.generation);
  EXPECT_EQ(scene.remove(gone), Edit::stale);
  EXPECT_NE(scene.find(again), nullptr);
}

TEST(Ids, BadArgumentsChangeNothing) {
  Scene scene = scenes::build(scenes::city(2));
  const ObjectId house = scene.object_id(1);
  const Scene before = scene;
  const std::uint64_t revision = scene.revision();
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
  EXPECT_EQ(scene.revision(), revision);
}

TEST(Ids, CopyOfASceneKnowsThem) {
  Scene scene = scenes::build(scenes::city(2));
  const ObjectId house = scene.object_id(1);
  Scene copy = scene;
  ASSERT_EQ(copy.remove(house), Edit::done);
  EXPECT_NE(scene.find(house), nullptr);
  EXPECT_EQ(scene.set_casts(house, false), Edit::done);
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
  EXPECT_EQ(scene.remove(first), Edit::stale);
  EXPECT_EQ(scene.remove(second), Edit::stale);
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
    ASSERT_EQ(scene.remove(a), Edit::done);
    ASSERT_EQ(scene.remove(l), Edit::done);
    ASSERT_EQ(scene.remove(b), Edit::done);
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
    ASSERT_EQ(scene.set_vertices(id, k % 2 ? box.vertices : folded), Edit::done);
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
  ASSERT_EQ(scene.set_pose(id, far.pose), Edit::done);
  fresh.add(mesh, far);
  EXPECT_EQ(scene.find(id)->vertex_count, fresh.objects()[0].vertex_count);
  EXPECT_EQ(scene.find(id)->edge_count, fresh.objects()[0].edge_count);
  ASSERT_EQ(scene.set_pose(id, Pose::Identity()), Edit::done);
  EXPECT_EQ(scene.find(id)->vertex_count, 8u);
}

}  // namespace
}  // namespace shadowcut::testing
