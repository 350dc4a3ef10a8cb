// See follower.hpp.
#include "follower.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "check.hpp"
#include "settings.hpp"

namespace shadowcut::testing {
namespace {

bool limited(const Light& light) { return std::isfinite(light.range) || light.spot; }

std::size_t live_facets(const Scene& scene) {
  std::size_t n = 0;
  for (const Object& o : scene.objects()) n += o.facet_count;
  return n;
}

// Whether the light stands in the box of a closed object.
bool may_stand_inside(const Scene& scene, const Light& light) {
  if (light.kind != Light::Kind::point) return false;
  return std::any_of(scene.objects().begin(), scene.objects().end(), [&](const Object& o) {
    Eigen::AlignedBox3d box;
    for (const Vec3& v : scene.vertices().subspan(o.first_vertex, o.vertex_count)) box.extend(v);
    return o.alive && o.sides == Sides::closed && box.contains(light.position);
  });
}

// One light's shadows against shadows cast for the scene as it stands. What either leaves uncertain
// may differ.
std::string check_against_new(const Scene& scene, const Light& light, const Shadows& shadows,
                              const UncertainArea& uncertain, Form form) {
  Options once;
  once.threads = 1;
  once.tuning.incremental = false;
  auto [fresh, open] = cast_alone(scene, light, once);
  for (std::size_t f = 0; f < open.size(); ++f) open[f] += uncertain[f];
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
                                 const UncertainArea& uncertain, std::uint64_t seed, bool solids) {
  const bool inside = light.kind == Light::Kind::point && may_stand_inside(scene, light),
             only_facing = limited(light) || !solids;
  if (inside && only_facing) return {};
  const CgalOracle oracle(scene, light, only_facing);
  return check_areas(scene, shadows, oracle, &uncertain) +
         check_points(scene, shadows, oracle, seed, 20, true);
}

}  // namespace

std::uint64_t first_seed() { return 1000000 * environment("SHADOWCUT_SEED").value_or(0); }

Options some_options(std::uint64_t seed) {
  scenes::Random random(7 * seed + 3);
  constexpr std::array<std::uint32_t, 3> sizes{0, 4, 128};
  constexpr std::array<std::uint32_t, 4> thresholds{0, 2, 16, 1000000};
  Options o;
  o.form = static_cast<Form>(random.below(3));
  o.tuning.order = static_cast<Order>(random.below(3));
  o.tuning.facets_per_cell = sizes[random.below(3)];
  o.tuning.join_threshold = thresholds[random.below(4)];
  o.threads = random.below(4) == 0 ? 2 : 1;
  o.tuning.incremental = random.below(8) != 0;
  o.tuning.seed = seed;
  return o;
}

std::string check_overlay(const Engine& engine) {
  const LightPartition sets = engine.overlay();
  for (std::size_t k = 0; k < engine.light_count(); ++k) {
    if (engine.scene().light_id(k).index == invalid_index) continue;
    const std::vector<double> lit = lit_areas(engine.scene(), sets, k);
    for (std::size_t face = 0; face < lit.size(); ++face) {
      const FaceArea& alone = engine.shadows(k).areas[face];
      if (std::abs(lit[face] - alone.lit) > kAreaTolerance * alone.area)
        return "overlay: light " + std::to_string(k) + " reaches " + std::to_string(lit[face]) +
               " of face " + std::to_string(face) + ", should be " + std::to_string(alone.lit) +
               "\n";
    }
  }
  return {};
}

std::string check_lights(const Engine& engine, std::uint64_t step, bool solids, Form form) {
  const Scene& scene = engine.scene();
  if (engine.light_count() != scene.lights().size())
    return "the engine has other lights than its scene\n";
  for (std::size_t k = 0; k < engine.light_count(); ++k) {
    if (scene.light_id(k).index == invalid_index) {
      try {
        engine.shadows(k);
        return "a light is removed, and has shadows\n";
      } catch (const Error&) {
        continue;
      }
    }
    const Light& light = scene.lights()[k];
    const Shadows& shadows = engine.shadows(k);
    const UncertainArea uncertain = engine.uncertain_area(k);
    std::string what = check_against_new(scene, light, shadows, uncertain, form);
    // About a hundred thousand pairs of facets for the oracle in a history.
    const std::size_t facets = live_facets(scene);
    if (what.empty() && step % std::max<std::size_t>(8, facets * facets / 400) == 0)
      what = check_against_oracle(scene, light, shadows, uncertain, step, solids);
    if (!what.empty()) return "light " + std::to_string(k) + ": " + what;
  }
  return {};
}

std::uint64_t nodes_of_new(const Scene& scene, const Options& options) {
  Engine fresh(scene, options);
  fresh.update();
  return fresh.shadows(0).stats.nodes;
}

Follower::Follower(const Setting& setting, std::uint64_t seed, const Options& options)
    : where_(std::string("setting ") + setting.name + ", seed " + std::to_string(seed) + ", " +
             testing::describe(options)),
      options_(options),
      script(setting, seed),
      engine(script.scene(), options) {}

std::string Follower::update(const std::string& edits) {
  edits_ = edits;
  const Changes& changes = engine.update();
  if (!changes.complete) return "an update without a budget is not complete\n";
  return check(changes);
}

std::string Follower::compact() {
  edits_ = "compact";
  const Changes& changes = engine.compact();
  for (const LightChanges& c : changes.lights) {
    if (!c.rebuilt) return "compact: a tree is not new\n";
  }
  return check(changes);
}

std::string Follower::check(const Changes& changes) {
  ++step_;
  std::string what = engine.validate();
  if (what.empty()) what = check_arrays(script.scene());
  if (what.empty()) what = check_same_scene(script.scene(), engine.scene());
  if (what.empty()) what = mirror.apply(changes, engine);
  if (what.empty() && step_ % 4 == 0)
    what = mirror.check_find(engine, options_.tuning.incremental ? 1 : 16);
  if (what.empty()) what = check_lights(engine, step_, !script.deformed(), options_.form);
  // Where objects are far away, what was one corner may be two, a rounding of that distance
  // apart.
  if (what.empty() && options_.form == Form::conforming && step_ % 4 == 0 && script.reach() < 4)
    what = check_conforming_lights();
  return what;
}

std::string Follower::check_conforming_lights() const {
  std::string what;
  for (std::size_t k = 0; k < engine.light_count() && what.empty(); ++k) {
    if (engine.scene().light_id(k).index != invalid_index)
      what = check_conforming(engine.scene(), engine.shadows(k));
  }
  return what;
}

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

}  // namespace shadowcut::testing
