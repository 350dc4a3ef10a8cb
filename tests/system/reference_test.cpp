// The shipped scenes, read from their files, against the shipped areas and against points.
#include "reference.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <shadowcut/io.hpp>

#include "check.hpp"

namespace shadowcut::testing {
namespace {

class ShippedScene : public ::testing::TestWithParam<ReferenceScene> {};

void compare(const Scene& scene, const Shadows& shadows, const std::vector<ReferenceArea>& rows) {
  ASSERT_EQ(rows.size(), scene.faces().size());
  for (std::uint32_t i = 0; i < rows.size(); ++i) {
    const Face& face = scene.faces()[i];
    ASSERT_EQ(rows[i].object, scene.objects()[face.object].name);
    ASSERT_EQ(rows[i].face, face.number);
    EXPECT_NEAR(shadows.areas[i].area, rows[i].area, kAreaTolerance * rows[i].area)
        << rows[i].object << " face " << face.number;
    EXPECT_NEAR(shadows.areas[i].lit, rows[i].lit, kAreaTolerance * rows[i].area)
        << rows[i].object << " face " << face.number;
  }
}

TEST_P(ShippedScene, MatchesItsReferenceAreas) {
  Scene scene = io::read_scene(GetParam().path);
  EXPECT_TRUE(scene.issues().empty());
  const auto rows = read_areas(areas_path(SHADOWCUT_DATA, GetParam().name));
  for (const Form form : {Form::pieces, Form::merged, Form::conforming}) {
    Options options;
    options.form = form;
    const Shadows shadows = cast_shadows(scene, GetParam().light, options);
    compare(scene, shadows, rows);
    EXPECT_EQ(check_fragments(scene, GetParam().light, shadows), "");
  }
}

TEST_P(ShippedScene, MatchesThousandsOfRays) {
  Scene scene = io::read_scene(GetParam().path);
  const CgalOracle oracle(scene, GetParam().light);
  EXPECT_EQ(check_points(scene, cast_shadows(scene, GetParam().light), oracle, 2024, 3000), "");
}

TEST_P(ShippedScene, ConformsAndIsValid) {
  Scene scene = io::read_scene(GetParam().path);
  Options options;
  options.form = Form::conforming;
  scene.replace_lights({&GetParam().light, 1});
  Engine engine(scene, options);
  engine.update();
  EXPECT_EQ(engine.validate(), "");
  EXPECT_EQ(check_conforming(scene, engine.shadows(0)), "");
}

INSTANTIATE_TEST_SUITE_P(Data, ShippedScene, ::testing::ValuesIn(reference_scenes(SHADOWCUT_DATA)),
                         [](const auto& info) { return info.param.name; });

TEST(ShippedScenes, AreAllThere) { EXPECT_EQ(reference_scenes(SHADOWCUT_DATA).size(), 11u); }

}  // namespace
}  // namespace shadowcut::testing
