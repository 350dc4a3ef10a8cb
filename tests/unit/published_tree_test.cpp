// The published tree against the engine's exact kernel: after the build and after every edit, with
// each way of joining, every face's lit area. A failure names scene, seed, joining and step.
//
// Its limits (src/compare/published_tree.hpp): one epsilon and no exact signs. Faces that are apart
// by the last bits only shadow each other to the exact kernel and touch to an epsilon; there the
// fast kernel is asked, which calls that contact too.
#include "compare/published_tree.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "check.hpp"
#include "random_scenes.hpp"
#include "settings.hpp"
#include "text.hpp"

namespace shadowcut::testing {
namespace {

using compare::Joining;
using compare::PublishedTree;
using scenes::Random;
using scenes::SceneData;

constexpr Joining kAllJoinings[] = {Joining::filter, Joining::merge, Joining::reinsert};

Shadows cast(const Scene& scene, Kernel kernel) {
  Options options;
  options.kernel = kernel;
  options.threads = 1;
  options.tuning.incremental = false;
  return cast_shadows(scene, scene.lights()[0], options);
}

// Every face against the exact kernel. Where that differs, the fast kernel must not: what is apart
// by a last bit is contact to both of them.
std::string check_tree(const Scene& scene, const PublishedTree& tree) {
  if (const std::string what = tree.validate(); !what.empty()) return what;
  const Shadows exact = cast(scene, Kernel::exact);
  const std::vector<double> lit = tree.lit_areas();
  const auto differs = [&](const Shadows& shadows, std::size_t f) {
    return !(std::abs(lit[f] - shadows.areas[f].lit) <= kAreaTolerance * shadows.areas[f].area);
  };
  std::string what;
  std::optional<Shadows> fast;
  for (std::size_t f = 0; f < lit.size(); ++f) {
    if (!differs(exact, f)) continue;
    if (!fast) fast = cast(scene, Kernel::fast);
    if (!differs(*fast, f)) continue;
    what += text("face ", f, " of ", scene.objects()[scene.faces()[f].object].name, ", ",
                 scene.faces()[f].object, ": lit ", lit[f], ", should be ", exact.areas[f].lit,
                 " of ", exact.areas[f].area, "\n");
  }
  return what;
}

// An object that moves, goes, or comes back.
struct Editor {
  Scene scene;
  std::vector<std::pair<Mesh, ObjectSettings>> given;
  std::vector<ObjectId> ids;
  std::vector<bool> present;
  Random random;
  double grid;

  Editor(const SceneData& data, std::uint64_t seed, double g)
      : given(data.objects), random(seed * 77 + 5), grid(g) {
    for (auto& [mesh, settings] : given) {
      if (random.below(12) == 0) settings.casts_shadows = false;
      if (random.below(12) == 0) settings.receives_shadows = false;
      ids.push_back(scene.add(mesh, settings));
      present.push_back(true);
    }
    scene.add(data.light);
  }

  // Where it may go: somewhere on the grid near by, so that things touch again; or home.
  Pose some_pose(std::size_t k) {
    const Vec3 by = random.in_cube(-2, 2);
    Pose pose = given[k].second.pose;
    if (random.below(3) != 0) pose = Eigen::Translation3d(Vec3(grid * by.array().round())) * pose;
    return pose;
  }

  std::string edit(PublishedTree& tree) {
    const std::size_t k = random.below(ids.size());
    const std::uint32_t object = ids[k].index;
    if (!present[k]) {
      ids[k] = scene.add(given[k].first, given[k].second);
      present[k] = true;
      tree.insert(ids[k].index);
      return text("object ", k, " comes back");
    }
    tree.remove(object);
    if (random.below(4) == 0) {
      EXPECT_EQ(scene.remove(ids[k]), Status::ok);
      present[k] = false;
      return text("object ", k, " goes");
    }
    EXPECT_EQ(scene.set_pose(ids[k], some_pose(k)), Status::ok);
    tree.insert(object);
    return text("object ", k, " moves");
  }
};

void run_history(const SceneData& data, std::uint64_t seed, Joining joining, int steps,
                 double grid) {
  Editor editor(data, seed, grid);
  PublishedTree tree(editor.scene, editor.scene.lights()[0], joining);
  const std::string where = text(data.name, ", seed ", seed, ", ", compare::name_of(joining));
  ASSERT_EQ(check_tree(editor.scene, tree), "") << where << ", after the build";
  for (int step = 0; step < steps; ++step) {
    const std::string how = editor.edit(tree);
    ASSERT_EQ(check_tree(editor.scene, tree), "") << where << ", step " << step << ": " << how;
  }
}

class PublishedTreeTest : public ::testing::TestWithParam<Kind> {};

TEST_P(PublishedTreeTest, AgreesWithTheEngineAfterEveryEdit) {
  const auto histories = environment("SHADOWCUT_SOAK").value_or(12);
  const std::uint64_t first = 1000000 * environment("SHADOWCUT_SEED").value_or(0);
  for (std::uint64_t seed = first; seed < first + histories; ++seed)
    for (const Joining joining : kAllJoinings) {
      run_history(random_scene(GetParam(), seed), seed, joining, 30, 0.5);
      if (HasFatalFailure()) return;
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, PublishedTreeTest, ::testing::ValuesIn(kAllKinds),
                         [](const auto& info) { return std::string(name_of(info.param)); });

class PublishedTreeSceneTest : public ::testing::TestWithParam<const char*> {};

TEST_P(PublishedTreeSceneTest, AgreesWithTheEngineAfterEveryEdit) {
  for (const Joining joining : kAllJoinings)
    run_history(scenes::named(GetParam()), 1, joining, 40, 0.125);
}

INSTANTIATE_TEST_SUITE_P(Scenes, PublishedTreeSceneTest,
                         ::testing::Values("room:1", "room:4", "furnished_room", "tetrahedron:3",
                                           "city:8", "spheres:5,12,8", "triangles:200",
                                           "branch:3"));

}  // namespace
}  // namespace shadowcut::testing
