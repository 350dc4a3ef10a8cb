// Small promises of the public headers: versions, bulk meshes, the range of all fragments, errors
// of options that do not apply.
#include <gtest/gtest.h>

#include <shadowcut/buffers.hpp>
#include <shadowcut/shadows.hpp>
#include <shadowcut/version.hpp>
#include <type_traits>
#include <utility>

#include "random_scenes.hpp"
#include "scenes.hpp"

namespace shadowcut::testing {
namespace {

static_assert(std::is_constructible_v<Engine, const Scene&>);
static_assert(!std::is_constructible_v<Engine, Scene>);  // it would refer to a temporary
static_assert(!std::is_constructible_v<Engine, Scene, Options>);
static_assert(std::is_nothrow_move_constructible_v<Scene>);

TEST(Version, IsTheProjects) {
  EXPECT_STREQ(SHADOWCUT_VERSION_STRING, SHADOWCUT_PROJECT_VERSION);
  EXPECT_STREQ(version(), SHADOWCUT_VERSION_STRING);
  EXPECT_EQ(std::to_string(SHADOWCUT_VERSION_MAJOR) + "." +
                std::to_string(SHADOWCUT_VERSION_MINOR) + "." +
                std::to_string(SHADOWCUT_VERSION_PATCH),
            SHADOWCUT_VERSION_STRING);
}

TEST(BulkMesh, IsTheMeshMadeFaceByFace) {
  const std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const std::vector<std::uint32_t> triangles{0, 1, 2, 0, 2, 3};
  const Mesh bulk(vertices, triangles);
  ASSERT_EQ(bulk.face_count(), 2u);
  EXPECT_EQ(bulk.vertices, vertices);
  for (std::size_t f = 0; f < 2; ++f) {
    ASSERT_EQ(bulk.loop_count(f), 1u);
    const auto loop = bulk.loop(f, 0);
    EXPECT_TRUE(std::equal(loop.begin(), loop.end(), triangles.begin() + 3 * f));
  }
  Mesh mesh;
  mesh.add_face({3, 2, 1});
  mesh.add_faces(std::vector<std::uint32_t>{0, 1, 2, 3, 2, 1, 0}, std::vector<std::uint32_t>{4, 3});
  ASSERT_EQ(mesh.face_count(), 3u);
  EXPECT_EQ(mesh.loop(1, 0).size(), 4u);
  EXPECT_EQ(mesh.loop(2, 0)[0], 2u);
  mesh.add_faces({}, {});
  EXPECT_EQ(mesh.face_count(), 3u);
}

TEST(BulkMesh, LengthsAreChecked) {
  const std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  const std::vector<std::uint32_t> corners{0, 1, 2, 0};
  EXPECT_THROW(Mesh(vertices, corners), Error);
  Mesh mesh;
  EXPECT_THROW(mesh.add_faces(corners, std::vector<std::uint32_t>{3}), Error);
  EXPECT_THROW(mesh.add_faces(corners, std::vector<std::uint32_t>{3, 2}), Error);
  EXPECT_EQ(mesh.face_count(), 0u);
}

TEST(Fragments, TheRangeHoldsAllOfThem) {
  for (const Kind kind : kAllKinds) {
    const scenes::SceneData data = random_scene(kind, 7);
    const Scene scene = scenes::build(data);
    Options options;
    options.tuning.facets_per_cell = 4;  // several blocks, some of them empty
    const Shadows shadows = cast_shadows(scene, data.light, options);
    std::size_t n = 0;
    auto it = shadows.fragments().begin();
    for (const Block& block : shadows.blocks) {
      for (const Fragment& fragment : block.fragments) {
        ASSERT_NE(it, shadows.fragments().end());
        EXPECT_EQ(&**it, &fragment);
        EXPECT_EQ((*it).corners().data(), block.corners_of(fragment).data());
        ++it, ++n;
      }
    }
    EXPECT_EQ(it, shadows.fragments().end());
    EXPECT_EQ(shadows.fragments().size(), n);
    double area = 0, sum = 0;
    for (const auto f : shadows.fragments()) sum += f->area, area += (*f).area;
    EXPECT_EQ(area, sum);
  }
  const Shadows empty;
  EXPECT_EQ(empty.fragments().begin(), empty.fragments().end());
}

TEST(OptionsThatDoNotApply, AreErrors) {
  const scenes::SceneData data = random_scene(Kind::solids, 1);
  const Scene scene = scenes::build(data);
  Options options;
  options.constructions = true;
  EXPECT_THROW(cast_shadows(scene, data.light, options), Error);
  EXPECT_THROW(Engine(scene, options), Error);
  options.kernel = Kernel::exact, options.form = Form::conforming;
  EXPECT_THROW(cast_shadows(scene, data.light, options), Error);
  EXPECT_THROW(Engine(scene, options), Error);
  options.form = Form::pieces;
  EXPECT_NO_THROW(cast_shadows(scene, data.light, options));
  EXPECT_NO_THROW(Engine(scene, options));
  options.min_feature.area = -1;
  EXPECT_THROW(Engine(scene, options), Error);
}

TEST(Buffers, ACopyIsIndependent) {
  const scenes::SceneData data = random_scene(Kind::solids, 3);
  Scene scene = scenes::build(data);
  scene.replace_lights({&data.light, 1});
  Engine engine(scene);
  FragmentBuffers buffers(0);
  buffers.update(engine, engine.update());
  ASSERT_GT(buffers.vertex_count(), 0u);
  const FragmentBuffers copy = buffers;
  const auto same = [&] {
    const auto a = buffers.positions(), b = copy.positions();
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  };
  EXPECT_TRUE(same());
  ASSERT_EQ(scene.remove(scene.object_id(0)), Status::ok);
  buffers.update(engine, engine.update());
  EXPECT_FALSE(same());
  const FragmentBuffers moved = std::move(buffers);
  EXPECT_GT(moved.vertex_count(), 0u);
}

}  // namespace
}  // namespace shadowcut::testing
