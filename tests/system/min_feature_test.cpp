// The smallest fragment emitted (Options::min_feature).
//
// What the option promises, and what is asserted here against the result without the option, of
// the same scene and the same edits:
//   - The tree is the same: all numbers of nodes, cuts and pieces.
//   - The fragments are the same to the bit, ids and constructions too, but for those below the
//     size, which are left out. The area of a fragment is Fragment::area. A fragment that is a
//     whole facet stays.
//   - FaceArea::dropped is what lit and shadowed lack of the area: the areas of what is left out.
//     The areas of all other faces are the same to the bit.
//   - In the conforming form, corners that only a fragment left out had may be gone; no more area
//     of any face is dropped than in the merged form.
//   - Engine::update emits exactly the changes of all that.
//
// SHADOWCUT_SOAK=n runs about n random updates instead of some thousands, SHADOWCUT_SEED=k other
// ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "check.hpp"
#include "edit_checks.hpp"
#include "edit_scripts.hpp"
#include "min_feature_checks.hpp"
#include "settings.hpp"

namespace shadowcut::testing {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(),
                 kInfinity = std::numeric_limits<double>::infinity();
constexpr Kernel kKernels[] = {Kernel::fast, Kernel::exact};
constexpr Form kForms[] = {Form::pieces, Form::merged, Form::conforming};

std::string describe_all(const Options& o) {
  return text("kernel ", o.kernel == Kernel::exact ? "exact, " : "fast, ", describe(o),
              ", smallest area ", o.min_feature.area, ", smallest solid angle ",
              o.min_feature.solid_angle);
}

struct Case {
  std::string name;
  Scene scene;
  Light light;
};

// Scenes of every sort, each with its point light and a sun.
const std::vector<Case>& cases() {
  static const std::vector<Case> all = [] {
    std::vector<Case> out;
    for (const char* name : {"room:2", "furnished_room", "city:5", "spheres:4,12,7", "triangles:60",
                             "tetrahedron:2", "branch:2"}) {
      const scenes::SceneData data = scenes::named(name);
      for (const bool sun : {false, true}) {
        Scene scene = scenes::build(data);
        const Light light = sun ? Light::directional({0.36, 0.21, -0.9}) : data.light;
        scene.replace_lights({&light, 1});
        out.push_back({std::string(name) + (sun ? ", sun" : ""), std::move(scene), light});
      }
    }
    return out;
  }();
  return all;
}

Shadows by_engine(const Scene& scene, const Options& options) {
  Engine engine(scene, options);
  engine.update();
  EXPECT_EQ(engine.validate(), "") << describe_all(options);
  return engine.shadows(0);
}

// Sizes as shares of what faces have on average; a sun has no solid angles.
std::vector<MinFeature> some_sizes(const Scene& scene, const Light& light) {
  std::vector<MinFeature> out;
  const double area = mean_area(scene);
  for (const double share : {1e-6, 1e-3, 0.05, 1.0, 1e9}) out.push_back({share * area, 0});
  out.push_back({kInfinity, 0});
  if (light.kind == Light::Kind::directional) return out;
  for (const double angle : {1e-9, 1e-6, 1e-4, 1e-2, 100.0}) out.push_back({0, angle});
  out.push_back({1e-3 * area, 1e-5});
  return out;
}

TEST(MinFeature, FragmentsAreThoseWithoutItLessTheSmall) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    double dropped = 0;
    for (const Kernel kernel : kKernels) {
      for (const bool edits : {false, true}) {
        Options options;
        options.kernel = kernel, options.threads = 1, options.tuning.incremental = edits,
        options.tuning.facets_per_cell = edits ? 128 : 8;
        std::vector<Shadows> full;
        for (const Form form : kForms) {
          options.form = form;
          full.push_back(by_engine(c.scene, options));
        }
        std::size_t at = 0;
        for (const MinFeature& least : some_sizes(c.scene, c.light)) {
          // The exact kernel takes longest: every second size.
          if (kernel == Kernel::exact && (at++ + edits) % 2 != 0) continue;
          options.min_feature = least;
          SCOPED_TRACE(describe_all(options));
          std::vector<Shadows> kept;
          for (const Form form : kForms) {
            options.form = form;
            kept.push_back(by_engine(c.scene, options));
          }
          for (const std::size_t k : {0u, 1u}) {
            ASSERT_EQ(check_filter(c.scene, c.light, full[k], kept[k], least), "") << "form " << k;
          }
          ASSERT_EQ(check_conforming_filter(c.scene, full[2], kept[2], kept[1]), "");
          dropped += kept[0].stats.dropped_area;
        }
      }
    }
    EXPECT_GT(dropped, 0) << "no size is large enough to say anything";
  }
}

// The exact kernel says of every corner what it is; so it does of those that are left.
TEST(MinFeature, ConstructionsStayWithTheirCorners) {
  for (const Case& c : cases()) {
    for (const Form form : {Form::pieces, Form::merged}) {
      for (const bool edits : {false, true}) {
        Options options;
        options.kernel = Kernel::exact, options.constructions = true;
        options.form = form, options.tuning.incremental = edits, options.threads = 1;
        const Shadows full = by_engine(c.scene, options);
        options.min_feature.area = 1e-2 * mean_area(c.scene);
        SCOPED_TRACE(c.name + ", " + describe_all(options));
        ASSERT_EQ(
            check_filter(c.scene, c.light, full, by_engine(c.scene, options), options.min_feature),
            "");
      }
    }
  }
}

// What is no larger than any fragment leaves nothing out, and changes no bit.
TEST(MinFeature, WhatIsSmallerThanAllPartsDropsNothing) {
  for (const Case& c : cases()) {
    for (const bool edits : {false, true}) {
      Options options;
      options.form = Form::pieces, options.tuning.incremental = edits, options.threads = 1;
      SCOPED_TRACE(c.name + ", " + describe(options));
      const Shadows full = by_engine(c.scene, options);
      double least = kInfinity;
      for (const Block& block : full.blocks) {
        for (const Fragment& f : block.fragments) {
          if (full.areas[f.face].facing == Facing::toward) least = std::min(least, f.area);
        }
      }
      for (const double size : {0.0, -0.0, least / 2, least}) {
        options.min_feature.area = size;
        const Shadows shadows = by_engine(c.scene, options);
        ASSERT_EQ(shadows.blocks.size(), full.blocks.size());
        EXPECT_LE(shadows.stats.dropped_area, size == 0 ? 0 : 1e-12 * shadows.stats.facing_area)
            << size;
        Shadows same = shadows;
        for (FaceArea& a : same.areas) a.dropped = 0;
        EXPECT_EQ(check_identical(full, same), "") << size;
      }
    }
  }
}

// No size takes away a face that no cut divides.
TEST(MinFeature, WholeFacetsStayWhateverTheSize) {
  Scene scene;
  scene.add(scenes::rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0}), {});
  scene.add(scenes::rectangle({1, 1, 1}, {0.5, 0, 0}, {0, 0.5, 0}), {});
  scene.add(scenes::rectangle({9, 9, 1}, {0.5, 0, 0}, {0, 0.5, 0}), {});
  const Light light = Light::point({1.25, 1.25, 4});
  scene.add(light);
  for (const Kernel kernel : kKernels) {
    for (const Form form : kForms) {
      for (const MinFeature& least : {MinFeature{kInfinity, 0}, MinFeature{0, kInfinity}}) {
        Options options;
        options.kernel = kernel, options.form = form, options.min_feature = least;
        SCOPED_TRACE(describe_all(options));
        const Shadows shadows = by_engine(scene, options);
        EXPECT_EQ(shadows.areas[0].lit + shadows.areas[0].shadowed, 0) << "cut, and too small";
        EXPECT_EQ(shadows.areas[0].dropped, shadows.areas[0].area);
        for (const std::size_t whole : {1u, 2u}) {
          EXPECT_NEAR(shadows.areas[whole].lit, 0.25, 1e-15);
          EXPECT_NEAR(shadows.areas[whole].dropped, 0, 1e-15);
        }
        EXPECT_EQ(shadows.stats.lit_fragments, 2u);
        EXPECT_EQ(shadows.stats.shadowed_fragments, 0u);
        EXPECT_NEAR(shadows.stats.dropped_area, shadows.areas[0].area, 1e-14);
      }
    }
  }
}

TEST(MinFeature, SameBitsForAnyNumberOfThreads) {
  for (const Case& c : cases()) {
    for (const Kernel kernel : kKernels) {
      for (const bool edits : {false, true}) {
        Options options;
        options.kernel = kernel, options.tuning.incremental = edits, options.threads = 1,
        options.tuning.facets_per_cell = 16;
        options.min_feature.area = 1e-3 * mean_area(c.scene);
        SCOPED_TRACE(c.name + ", " + describe_all(options));
        const Shadows one = by_engine(c.scene, options);
        options.threads = 2;
        EXPECT_EQ(check_identical(one, by_engine(c.scene, options)), "");
      }
    }
  }
}

TEST(MinFeature, TheCallIsTheEngine) {
  for (const Case& c : cases()) {
    Options options;
    options.tuning.incremental = false;
    options.min_feature.area = 1e-3 * mean_area(c.scene);
    EXPECT_EQ(check_identical(cast_shadows(c.scene, c.light, options), by_engine(c.scene, options)),
              "")
        << c.name;
  }
}

TEST(MinFeature, BadSizesAreRefused) {
  const Case &point = cases()[0], &sun = cases()[1];
  for (const double bad : {-1.0, -1e-300, -kInfinity, kNaN}) {
    for (const MinFeature& least :
         {MinFeature{bad, 0}, MinFeature{0, bad}, MinFeature{bad, 1}, MinFeature{1, bad}}) {
      for (const Kernel kernel : kKernels) {
        Options options;
        options.kernel = kernel, options.min_feature = least;
        for (const Case* c : {&point, &sun}) {
          EXPECT_THROW(cast_shadows(c->scene, c->light, options), Error) << describe_all(options);
          EXPECT_THROW(
              {
                Engine engine(c->scene, options);
                engine.update();
              },
              Error)
              << describe_all(options);
        }
      }
    }
  }
  Options options;
  options.min_feature.solid_angle = 1e-6;
  EXPECT_THROW(cast_shadows(sun.scene, sun.light, options), Error);
  Engine engine(sun.scene, options);
  EXPECT_THROW(engine.update(), Error);
  EXPECT_NO_THROW(cast_shadows(point.scene, point.light, options));
}

// A light that cannot be is an error of that update; the engine goes on once it is gone.
TEST(MinFeature, ALightThatBecomesASunIsAnErrorOnce) {
  Scene scene = cases()[0].scene;
  const Light point = cases()[0].light, sun = Light::directional({0, 0.1, -1});
  Options options, without;
  options.min_feature.solid_angle = 1e-5;
  Engine engine(scene, options);
  Mirror mirror;
  ASSERT_EQ(mirror.apply(engine.update(), engine), "");
  const LightId id = scene.light_id(0);
  for (int round = 0; round < 2; ++round) {
    ASSERT_EQ(scene.set_light(id, sun), Status::ok);
    for (int again = 0; again < 2; ++again) {
      try {
        engine.update();
        FAIL() << "no error";
      } catch (const Error& e) {
        EXPECT_NE(std::string(e.what()).find("solid angle"), std::string::npos) << e.what();
      }
    }
    EXPECT_THROW(engine.compact(), Error);
    EXPECT_THROW(engine.update(std::chrono::nanoseconds(0)), Error);
    EXPECT_EQ(engine.validate(), "");
    ASSERT_EQ(scene.set_light(id, point), Status::ok);
    ASSERT_EQ(mirror.apply(engine.update(), engine), "");
    EXPECT_EQ(engine.validate(), "");
    Engine full(scene, without), fresh(scene, options);
    full.update();
    fresh.update();
    EXPECT_EQ(check_same_areas(scene, fresh.shadows(0), engine.shadows(0)), "");
    EXPECT_EQ(check_filter(scene, point, full.shadows(0), fresh.shadows(0), options.min_feature),
              "");
  }
}

std::uint64_t first_seed() { return 1000000 * environment("SHADOWCUT_SEED").value_or(0); }

Options some_options(std::uint64_t seed) {
  scenes::Random random(11 * seed + 5);
  constexpr std::array<std::uint32_t, 3> cells{0, 4, 128};
  Options o;
  o.kernel = std::array{Kernel::fast, Kernel::fast, Kernel::exact}[random.below(3)];
  o.form = static_cast<Form>(random.below(3));
  o.tuning.order = static_cast<Order>(random.below(3));
  o.tuning.facets_per_cell = cells[random.below(3)];
  o.tuning.join_threshold = std::array{0u, 2u, 1000000u}[random.below(3)];
  o.threads = random.below(4) == 0 ? 2 : 1;
  o.tuning.incremental = random.below(8) != 0;
  o.tuning.seed = seed;
  return o;
}

// A sun has no solid angles: it becomes a lamp far away on the same side.
void replace_suns(Scene& scene) {
  for (std::size_t k = 0; k < scene.lights().size(); ++k) {
    const LightId id = scene.light_id(k);
    if (id.index == invalid_index || scene.lights()[k].kind == Light::Kind::point) continue;
    Eigen::AlignedBox3d box;
    for (const Object& o : scene.objects()) {
      for (const Vec3& v : scene.vertices().subspan(o.first_vertex, o.vertex_count)) box.extend(v);
    }
    const Vec3 middle = box.isEmpty() ? Vec3(Vec3::Zero()) : Vec3(box.center());
    const double size = box.isEmpty() ? 1 : 1 + box.diagonal().norm();
    const Light lamp = Light::point(middle - 2 * size * scene.lights()[k].direction.normalized());
    ASSERT_EQ(scene.set_light(id, lamp), Status::ok);
  }
}

// Engines that follow one scene: with a smallest feature, without, and of the conforming form the
// merged one with it.
class Followers {
 public:
  Followers(const Scene& scene, const Options& options)
      : options_(options), kept_(scene, options), full_(scene, without(options)) {
    if (options.form != Form::conforming) return;
    Options merged = options;
    merged.form = Form::merged;
    merged_ = std::make_unique<Engine>(scene, merged);
  }

  std::string update() {
    ++step_;
    const Changes& changes = kept_.update();
    full_.update();
    if (merged_) merged_->update();
    std::string what = kept_.validate();
    if (what.empty()) what = mirror_.apply(changes, kept_);
    if (what.empty() && step_ % 8 == 0)
      what = mirror_.check_find(kept_, options_.tuning.incremental ? 1 : 16);
    const Scene& scene = kept_.scene();
    for (std::size_t k = 0; k < kept_.light_count() && what.empty(); ++k) {
      if (scene.light_id(k).index != invalid_index) what = check(scene, k);
    }
    return what;
  }

  const Engine& kept() const { return kept_; }
  double dropped() const { return dropped_; }

 private:
  static Options without(Options options) {
    options.min_feature = {};
    return options;
  }

  std::string check(const Scene& scene, std::size_t light) {
    const Shadows &full = full_.shadows(light), &kept = kept_.shadows(light);
    dropped_ += kept.stats.dropped_area;
    if (merged_) return check_conforming_filter(scene, full, kept, merged_->shadows(light));
    std::vector<FragmentId> gone;
    std::string what =
        check_filter(scene, scene.lights()[light], full, kept, options_.min_feature, &gone);
    for (std::size_t i = step_ % 16; i < gone.size() && what.empty(); i += 16) {
      if (kept_.find(light, gone[i]))
        what = text("a fragment is left out, and found: piece ", gone[i].piece, "\n");
    }
    return what;
  }

  Options options_;
  Engine kept_, full_;
  std::unique_ptr<Engine> merged_;
  Mirror mirror_;
  std::uint64_t step_ = 0;
  double dropped_ = 0;
};

class MinFeatureOf : public ::testing::TestWithParam<Setting> {};
INSTANTIATE_TEST_SUITE_P(Settings, MinFeatureOf,
                         ::testing::ValuesIn(all_settings().begin(), all_settings().end()),
                         [](const auto& info) { return std::string(info.param.name); });

// Histories of random edits; after every update all that is promised above. by_angle: sizes are
// solid angles.
void run_histories(const Setting& setting, std::uint64_t first, bool by_angle) {
  const std::uint64_t updates =
      environment("SHADOWCUT_SOAK").value_or(2600) / all_settings().size() + 1;
  std::uint64_t done = 0;
  double dropped = 0;
  for (std::uint64_t seed = first + first_seed(); done < updates; ++seed) {
    EditScript script(setting, seed);
    Options options = some_options(seed);
    if (by_angle) options.min_feature.solid_angle = std::array{1e-6, 1e-4, 1e-2, 0.3}[seed % 4];
    else
      options.min_feature.area =
          std::array{1e-6, 1e-3, 0.05, 1.0}[seed % 4] * mean_area(script.scene());
    if (by_angle) replace_suns(script.scene());
    Followers followers(script.scene(), options);
    std::string edits = "the first update";
    for (int step = 0; step < 30; ++step, ++done) {
      SCOPED_TRACE(text("setting ", setting.name, ", seed ", seed, ", ", describe_all(options),
                        ", step ", step, ": ", edits));
      ASSERT_EQ(followers.update(), "");
      edits = script.step();
      if (by_angle) replace_suns(script.scene());
    }
    dropped += followers.dropped();
  }
  EXPECT_GT(dropped, 0) << "no size is large enough to say anything";
}

TEST_P(MinFeatureOf, AreasInRandomHistories) { run_histories(GetParam(), 40000, false); }
TEST_P(MinFeatureOf, SolidAnglesInRandomHistories) { run_histories(GetParam(), 50000, true); }

// A mover that comes and goes does not wear its surroundings away: whenever the scene is what it
// was, about as much is dropped as at first.
TEST(MinFeature, ComingAndGoingDoesNotWearFacesAway) {
  for (const char* name : {"rooms", "city", "spheres", "triangles"}) {
    EditScript script(setting_named(name), 1);
    Options options;
    options.threads = 1;
    options.min_feature.area = 1e-2 * mean_area(script.scene());
    Followers followers(script.scene(), options);
    ASSERT_EQ(followers.update(), "") << name;
    const double at_first = followers.kept().shadows(0).stats.dropped_area;
    EXPECT_GT(at_first, 0);
    for (std::size_t round = 0; round < 200; ++round) {
      for (int k = 0; k < 2; ++k) {
        script.swing(round % 7 % script.size());
        ASSERT_EQ(followers.update(), "") << name << ", round " << round;
      }
      ASSERT_LT(followers.kept().shadows(0).stats.dropped_area, 4 * at_first)
          << name << ", round " << round;
    }
  }
}

}  // namespace
}  // namespace shadowcut::testing
