// Edits without end: what repeats itself leaves nothing behind, and trees do not rot.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <tuple>

#include "check.hpp"
#include "follower.hpp"
#include "settings.hpp"

namespace shadowcut::testing {
namespace {

using scenes::Random;

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
        if (f.id.place != invalid_index) largest_place = std::max(largest_place, f.id.place);
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
  all[1].tuning.join_threshold = 0;
  all[1].form = Form::pieces;
  all[2].tuning.join_threshold = 1000000;
  all[2].tuning.facets_per_cell = 4;
  all[3].form = Form::conforming;
  all[3].tuning.facets_per_cell = 0;
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
    options.tuning.join_threshold = threshold;
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
  options.tuning.order = Order::as_given;
  options.tuning.facets_per_cell = 0;  // both without a prefix, which would be another one
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

}  // namespace
}  // namespace shadowcut::testing
