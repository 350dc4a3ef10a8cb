// Kernel::exact against the exact oracle, on scenes made to break it: every fragment, every corner,
// the same points lit, without a tolerance. And the same after every update of scenes that are
// edited.
//
// SHADOWCUT_SOAK=n runs about n random scenes (and n / 20 updates) instead of some thousands,
// SHADOWCUT_SEED=k other ones; SHADOWCUT_SCENE=seed runs that one seed alone. A failure names kind,
// seed and options, and prints the scene without the faces, or the history without the edits, that
// it fails without.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "check.hpp"
#include "exact_checks.hpp"
#include "exact_scenes.hpp"
#include "gmp_oracle.hpp"
#include "settings.hpp"

namespace shadowcut::testing {
namespace {

using scenes::Random;

struct Seeds {
  std::uint64_t first, end;
};
Seeds seeds(std::uint64_t usual, std::uint64_t share_of_soak) {
  if (const auto one = environment("SHADOWCUT_SCENE")) return {*one, *one + 1};
  const std::uint64_t first = 1000000 * environment("SHADOWCUT_SEED").value_or(0),
                      soak = environment("SHADOWCUT_SOAK").value_or(0);
  return {first, first + (soak ? soak / share_of_soak + 1 : usual)};
}

Options some_options(std::uint64_t seed) {
  Random random(11 * seed + 5);
  constexpr std::array<std::uint32_t, 3> sizes{0, 2, 128};
  constexpr std::array<std::uint32_t, 4> thresholds{0, 2, 16, 1000000};
  Options o;
  o.kernel = Kernel::exact;
  o.constructions = true;
  o.form = static_cast<Form>(random.below(2));  // not conforming: it has no constructions
  o.tuning.order = static_cast<Order>(random.below(3));
  o.tuning.facets_per_cell = sizes[random.below(3)];
  o.tuning.join_threshold = thresholds[random.below(4)];
  o.tuning.incremental = random.below(4) != 0;
  o.threads = 1;
  o.tuning.seed = seed;
  return o;
}

std::string check_scene(const Scene& scene, const Light& light, const GmpOracle& oracle,
                        const Options& options) {
  if (!oracle.defined()) return {};
  try {
    return check_exact(oracle, cast_shadows(scene, light, options), options.form);
  } catch (const std::exception& e) {
    return std::string("thrown: ") + e.what() + "\n";
  }
}

std::string check_scene(const ExactScene& made, const Options& options) {
  const Scene scene = build(made);
  return check_scene(scene, made.light, GmpOracle(scene, made.light), options);
}

// For a failure's message.
std::string explain(const ExactScene& made, const Options& options) {
  const ExactScene least =
      reduced_scene(made, [&](const ExactScene& s) { return !check_scene(s, options).empty(); });
  return describe(options) + "\nleast scene that fails:\n" + describe(least) +
         "there: " + check_scene(least, options);
}

class ExactOf : public ::testing::TestWithParam<ExactKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, ExactOf, ::testing::ValuesIn(kAllExactKinds),
                         [](const auto& info) { return name_of(info.param); });

// Three settings a scene, all held against the one oracle: so any order of insertion and any prefix
// gives the same lit points.
TEST_P(ExactOf, RandomScenes) {
  // small numbers: quickly computed
  const bool on_grid = GetParam() >= ExactKind::grid && GetParam() <= ExactKind::pencil;
  const Seeds range = seeds(on_grid ? 500 : 120, std::size(kAllExactKinds));
  std::uint64_t defined = 0;
  for (std::uint64_t seed = range.first; seed < range.end; ++seed) {
    const ExactScene made = exact_scene(GetParam(), seed);
    const Scene scene = build(made);
    const GmpOracle oracle(scene, made.light);
    defined += oracle.defined();
    for (std::uint64_t k = 0; k < 3; ++k) {
      const Options options = some_options(3 * seed + k);
      const std::string what = check_scene(scene, made.light, oracle, options);
      ASSERT_EQ(what, "") << name_of(GetParam()) << ", seed " << seed << ", "
                          << explain(made, options);
    }
  }
  EXPECT_TRUE(range.end - range.first < 50 || 3 * defined > range.end - range.first)
      << "few scenes are within the definition";
}

bool same_numbers(const LightLine& a, const LightLine& b) {
  return a.crossing == b.crossing &&
         std::equal(a.v.begin(), a.v.begin() + (a.crossing ? 4 : 2), b.v.begin());
}

std::string check_same_constructions(const Shadows& a, const Shadows& b) {
  for (std::size_t k = 0; k < a.blocks.size(); ++k) {
    const auto &x = a.blocks[k].constructions, &y = b.blocks[k].constructions;
    if (x.size() != y.size())
      return "block " + std::to_string(k) + " has another number of constructions";
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (x[i].vertex != y[i].vertex ||
          (x[i].vertex == invalid_index &&
           !(same_numbers(x[i].in, y[i].in) && same_numbers(x[i].out, y[i].out))))
        return "block " + std::to_string(k) + ", construction " + std::to_string(i) + " differs";
    }
  }
  return {};
}

TEST_P(ExactOf, TwoThreadsSameBits) {
  for (std::uint64_t seed = 5000; seed < 5012; ++seed) {
    const ExactScene made = exact_scene(GetParam(), seed);
    const Scene scene = build(made);
    Options options = some_options(seed);
    options.tuning.facets_per_cell = 2;
    const Shadows one = cast_shadows(scene, made.light, options);
    options.threads = 2;
    const Shadows two = cast_shadows(scene, made.light, options);
    ASSERT_EQ(check_identical(one, two), "")
        << name_of(GetParam()) << ", seed " << seed << ", " << describe(options);
    ASSERT_EQ(check_same_constructions(one, two), "")
        << name_of(GetParam()) << ", seed " << seed << ", " << describe(options);
  }
}

// Asking how corners are made changes nothing else.
TEST_P(ExactOf, ConstructionsChangeNothing) {
  for (std::uint64_t seed = 6000; seed < 6012; ++seed) {
    const ExactScene made = exact_scene(GetParam(), seed);
    const Scene scene = build(made);
    Options options = some_options(seed);
    const Shadows with = cast_shadows(scene, made.light, options);
    options.constructions = false;
    ASSERT_EQ(check_identical(with, cast_shadows(scene, made.light, options)), "")
        << name_of(GetParam()) << ", seed " << seed;
  }
}

TEST_P(ExactOf, EveryPredicateIsDecidedOnOneRung) {
  for (std::uint64_t seed = 7000; seed < 7020; ++seed) {
    const ExactScene made = exact_scene(GetParam(), seed);
    const Scene scene = build(made);
    const Stats s = cast_shadows(scene, made.light, some_options(seed)).stats;
    ASSERT_EQ(s.by_identity + s.by_filter + s.by_exact, s.predicates)
        << name_of(GetParam()) << ", seed " << seed;
  }
}

// The areas of faces are doubles and rounded; in scenes of usual size, to what the fast kernel's
// are held to.
TEST(Exact, AreasOfFaces) {
  for (const ExactKind kind :
       {ExactKind::soup, ExactKind::grid, ExactKind::grid_solids, ExactKind::folded,
        ExactKind::coplanar, ExactKind::fan, ExactKind::pencil}) {
    for (std::uint64_t seed = 8000; seed < 8030; ++seed) {
      const ExactScene made = exact_scene(kind, seed);
      const Scene scene = build(made);
      const GmpOracle oracle(scene, made.light);
      if (!oracle.defined()) continue;
      const Shadows shadows = cast_shadows(scene, made.light, some_options(seed));
      for (std::uint32_t i = 0; i < scene.faces().size(); ++i) {
        const Face& face = scene.faces()[i];
        const FaceArea& area = shadows.areas[i];
        if (area.facing != Facing::toward) continue;
        double lit = 0;
        for (std::uint32_t f = face.first_facet; f < face.first_facet + face.facet_count; ++f)
          lit += oracle.area(f, oracle.lit(f)).get_d() * oracle.stretch(f).second;
        EXPECT_NEAR(area.lit, lit, 1e-9 * area.area)
            << name_of(kind) << ", seed " << seed << ", face " << i;
        EXPECT_NEAR(area.lit + area.shadowed, area.area, 1e-9 * area.area)
            << name_of(kind) << ", seed " << seed << ", face " << i;
      }
    }
  }
}

// Many faces in one place, and several cells.
TEST(Exact, CrowdedGrid) {
  const Seeds range = seeds(12, 2000);
  for (std::uint64_t seed = range.first; seed < range.end; ++seed) {
    Random random(77 + seed);
    ExactScene made;
    for (std::uint64_t n = 25 + random.below(25); n > 0; --n)
      made.objects.push_back(grid_object(random));
    made.light = grid_light(random);
    const Scene scene = build(made);
    const GmpOracle oracle(scene, made.light);
    for (std::uint64_t k = 0; k < 3; ++k) {
      const Options options = some_options(3 * seed + k);
      ASSERT_EQ(check_scene(scene, made.light, oracle, options), "")
          << "seed " << seed << ", " << explain(made, options);
    }
  }
}

// A stack higher than its parallel sheets' distances are long: a hundred, each one ulp above the
// one before.
TEST(Exact, SixtySheetsOneUlpApart) {
  for (const bool sun : {false, true}) {
    ExactScene made;
    double z = 1;
    for (int k = 0; k < 60; ++k, z = std::nextafter(z, 2)) {
      ExactObject sheet;
      const double x = k % 7, y = k % 5;
      sheet.vertices = {{x, y, z}, {x + 4, y, z}, {x + 4, y + 4, z}, {x, y + 4, z}};
      sheet.faces = {{0, 1, 2, 3}};
      made.objects.push_back(sheet);
    }
    made.light = sun ? Light::directional({1, 2, -9}) : Light::point({3, 3, 1 + 0x1p-40});
    const Scene scene = build(made);
    const GmpOracle oracle(scene, made.light);
    for (std::uint64_t k = 0; k < 3; ++k)
      ASSERT_EQ(check_scene(scene, made.light, oracle, some_options(k)), "") << "options " << k;
  }
}

// Edits. A history is a list of these, each of which applies to any scene: so a history may be made
// shorter.
struct GridEdit {
  enum class What {
    update,
    add,
    remove,
    move,
    deform,
    casts,
    receives,
    add_light,
    move_light,
    remove_light,
    compact
  } what;
  std::uint64_t pick = 0;  // of the objects or lights there are
  ExactObject object;
  Pose pose = Pose::Identity();
  Light light;
  Vec3 at = Vec3::Zero();  // deform: where one vertex goes
};
using What = GridEdit::What;

// The grid onto itself, moved by whole or half steps; or, one time in eight, any rigid motion.
Pose some_pose(Random& random) {
  Pose pose = Pose::Identity();
  if (random.below(8) == 0) {
    pose.rotate(Eigen::AngleAxisd(6.3 * random.unit(),
                                  (random.in_cube(-1, 1) + Vec3(0, 0, 1.5)).normalized()));
    pose.pretranslate(random.in_cube(-1, 1));
    return pose;
  }
  if (random.below(2) == 0) {
    Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
    const auto first = static_cast<Eigen::Index>(random.below(3));
    const double a = random.below(2) ? 1 : -1, b = random.below(2) ? 1 : -1,
                 c = random.below(2) ? 1 : -1;
    turn(first, 0) = a, turn((first + 1) % 3, 1) = b, turn((first + 2) % 3, 2) = c;
    pose.linear() = turn;
    for (Eigen::Index i = 0; i < 3; ++i) pose.translation()[i] = turn.row(i).sum() < 0 ? 3 : 0;
  }
  const double step = random.below(4) == 0 ? 0.5 : 1;
  for (Eigen::Index i = 0; i < 3; ++i)
    pose.translation()[i] += step * (static_cast<double>(random.below(5)) - 2);
  return pose;
}

GridEdit some_edit(Random& random) {
  constexpr std::array choices{What::add,        What::remove,       What::move,
                               What::move,       What::move,         What::deform,
                               What::casts,      What::receives,     What::add_light,
                               What::move_light, What::remove_light, What::compact};
  GridEdit edit{choices[random.below(choices.size())], random.next(), {}, {}, {}, {}};
  edit.object = grid_object(random);
  edit.pose = some_pose(random);
  edit.light = grid_light(random);
  edit.at = Vec3(static_cast<double>(random.below(4)), static_cast<double>(random.below(4)),
                 static_cast<double>(random.below(4)));
  return edit;
}

using History = std::vector<GridEdit>;

History some_history(std::uint64_t seed, std::size_t updates) {
  Random random(31 * seed + 1);
  History history;
  const auto put = [&](What what) {
    history.push_back(some_edit(random));
    history.back().what = what;
  };
  for (std::uint64_t n = 3 + random.below(6); n > 0; --n) put(What::add);
  for (std::uint64_t n = 1 + random.below(2); n > 0; --n) put(What::add_light);
  for (std::size_t k = 0; k < updates; ++k) {
    for (std::uint64_t n = 1 + random.below(3); n > 0; --n) history.push_back(some_edit(random));
    put(What::update);
  }
  return history;
}

std::string text_of(const GridEdit& edit) {
  constexpr std::array names{"update",     "add",          "remove",   "move",
                             "deform",     "casts",        "receives", "add light",
                             "move light", "remove light", "compact"};
  std::string out = std::string(names[static_cast<std::size_t>(edit.what)]) + " (pick " +
                    std::to_string(edit.pick) + ") ";
  const auto number = [&](double x) {
    char buffer[40];
    std::snprintf(buffer, sizeof buffer, " %.17g", x);
    out += buffer;
  };
  if (edit.what == What::add) return out + describe(edit.object);
  if (edit.what == What::add_light || edit.what == What::move_light)
    return out + describe(edit.light);
  if (edit.what == What::move) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index j = 0; j < 4; ++j) number(edit.pose(i, j));
    }
  }
  if (edit.what == What::deform) {
    for (const double x : edit.at) number(x);
  }
  return out + '\n';
}

std::string text_of(const History& history) {
  std::string out;
  for (const GridEdit& edit : history) out += text_of(edit);
  return out;
}

// A scene, its engine, and what is known of them.
class Run {
 public:
  explicit Run(const Options& options) : options_(options), engine_(scene_, options) {}

  std::string apply(const GridEdit& edit) {
    if (edit.what == What::update || edit.what == What::compact) {
      if (edit.what == What::compact) engine_.compact();
      else engine_.update();
      return check();
    }
    if (edit.what == What::add)
      objects_.push_back(scene_.add(mesh_of(edit.object), settings_of(edit.object)));
    else if (edit.what == What::add_light && lights_.size() < 3)
      lights_.push_back(scene_.add(edit.light));
    else if (edit.what == What::move_light || edit.what == What::remove_light) edit_light(edit);
    else if (!objects_.empty()) edit_object(edit);
    return {};
  }

  std::string check() const {
    std::string what = engine_.validate();
    for (std::size_t k = 0; k < engine_.light_count() && what.empty(); ++k) {
      if (engine_.scene().light_id(k).index == invalid_index) continue;
      const GmpOracle oracle(engine_.scene(), engine_.scene().lights()[k]);
      if (oracle.defined()) what = check_exact(oracle, engine_.shadows(k), options_.form);
      if (!what.empty()) what = "light " + std::to_string(k) + ": " + what;
    }
    return what;
  }

 private:
  void edit_light(const GridEdit& edit) {
    if (lights_.empty()) return;
    const std::size_t k = edit.pick % lights_.size();
    if (edit.what == What::move_light) {
      EXPECT_EQ(scene_.set_light(lights_[k], edit.light), Status::ok);
    } else if (lights_.size() > 1) {
      EXPECT_EQ(scene_.remove(lights_[k]), Status::ok);
      lights_.erase(lights_.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }

  void edit_object(const GridEdit& edit) {
    const std::size_t k = edit.pick % objects_.size();
    const ObjectId id = objects_[k];
    if (edit.what == What::remove) {
      EXPECT_EQ(scene_.remove(id), Status::ok);
      objects_.erase(objects_.begin() + static_cast<std::ptrdiff_t>(k));
    } else if (edit.what == What::move) {
      EXPECT_EQ(scene_.set_pose(id, edit.pose), Status::ok);
    } else if (edit.what == What::deform) {
      std::vector<Vec3> vertices = scene_.source(id)->first.vertices;
      vertices[edit.pick / 64 % vertices.size()] = edit.at;
      EXPECT_EQ(scene_.set_vertices(id, vertices), Status::ok);
    } else if (edit.what == What::casts) {
      EXPECT_EQ(scene_.set_casts_shadows(id, !scene_.find(id)->casts_shadows), Status::ok);
    } else if (edit.what == What::receives) {
      EXPECT_EQ(scene_.set_receives_shadows(id, !scene_.find(id)->receives_shadows), Status::ok);
    }
  }

  Options options_;
  Scene scene_;
  Engine engine_;
  std::vector<ObjectId> objects_;
  std::vector<LightId> lights_;
};

std::string run(const History& history, const Options& options) {
  try {
    Run all(options);
    for (std::size_t k = 0; k < history.size(); ++k) {
      const std::string what = all.apply(history[k]);
      if (!what.empty()) return "after edit " + std::to_string(k) + ": " + what;
    }
    return {};
  } catch (const std::exception& e) {
    return std::string("thrown: ") + e.what() + "\n";
  }
}

// The shortest history, and the smallest objects, found by leaving out one at a time.
std::string explain(History history, const Options& options) {
  for (bool again = true; again;) {
    again = false;
    for (std::size_t k = history.size(); k-- > 0;) {
      History shorter = history;
      shorter.erase(shorter.begin() + static_cast<std::ptrdiff_t>(k));
      if (run(shorter, options).empty()) continue;
      history = std::move(shorter);
      again = true;
    }
  }
  for (GridEdit& edit : history) {
    for (std::size_t f = edit.object.faces.size();
         edit.what == What::add && edit.object.faces.size() > 1 && f-- > 0;) {
      const auto kept = edit.object.faces;
      edit.object.faces.erase(edit.object.faces.begin() + static_cast<std::ptrdiff_t>(f));
      if (run(history, options).empty()) edit.object.faces = kept;
    }
  }
  return describe(options) + "\nleast history that fails:\n" + text_of(history) +
         "there: " + run(history, options);
}

TEST(ExactEdits, GridHistories) {
  constexpr std::size_t updates = 16;
  const Seeds range = seeds(80, 20 * updates);
  for (std::uint64_t seed = range.first; seed < range.end; ++seed) {
    const History history = some_history(seed, seed % 8 == 7 ? 6 * updates : updates);
    Options options = some_options(seed);
    options.tuning.incremental = seed % 8 != 0;
    const std::string what = run(history, options);
    ASSERT_EQ(what, "") << "seed " << seed << ", " << explain(history, options);
  }
}

}  // namespace
}  // namespace shadowcut::testing
