// The oracle itself against areas known by hand: whoever guards the engine must be right first.
#include "cgal_oracle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "random_scenes.hpp"
#include "scenes.hpp"

namespace shadowcut::testing {
namespace {

using scenes::rectangle;

std::uint32_t add(Scene& scene, const Mesh& mesh, Sides sides = Sides::automatic) {
  ObjectSettings settings;
  settings.sides = sides;
  const std::uint32_t object = scene.add(mesh, settings).index;
  return scene.objects()[object].first_face;
}

TEST(CgalOracle, SquareHalfwayUpShadowsFourTimesItsArea) {
  Scene scene;
  const auto ground = add(scene, rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}));
  const auto sheet = add(scene, rectangle({-0.5, -0.5, 1}, {1, 0, 0}, {0, 1, 0}));
  const CgalOracle oracle(scene, Light::point({0.125, -0.25, 2}));
  EXPECT_DOUBLE_EQ(oracle.area(ground).lit, 60);
  EXPECT_DOUBLE_EQ(oracle.area(sheet).lit, 1);
  EXPECT_FALSE(oracle.lit(scene.faces()[ground].first_facet, {0, 0, 0}));
  EXPECT_TRUE(oracle.lit(scene.faces()[ground].first_facet, {2, 0, 0}));
}

TEST(CgalOracle, SunCastsABoxesOwnShape) {
  Scene scene;
  const auto ground = add(scene, rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}));
  const auto box = add(scene, scenes::box({-0.5, -0.5, 0}, {0.5, 0.5, 1}));
  const CgalOracle oracle(scene, Light::directional({1, 0, -1}));
  EXPECT_DOUBLE_EQ(oracle.area(ground).lit, 64 - 2);
  EXPECT_EQ(oracle.area(box).facing, Facing::away);  // the bottom
  EXPECT_EQ(oracle.area(box + 1).facing, Facing::toward);
  EXPECT_DOUBLE_EQ(oracle.area(box + 1).lit, 1);
  EXPECT_EQ(oracle.area(box + 2).facing, Facing::away);  // edge-on
}

TEST(CgalOracle, CrossingSheetsShadowEachOtherInPart) {
  Scene scene;
  const auto flat = add(scene, rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}));
  const auto steep = add(scene, rectangle({-1, -0.5, -1}, {0, 1, 0}, {2, 0, 2}));
  const CgalOracle oracle(scene, Light::directional({0, 0, -1}));
  EXPECT_DOUBLE_EQ(oracle.area(flat).lit, 3);
  EXPECT_DOUBLE_EQ(oracle.area(steep).lit, oracle.area(steep).area / 2);
}

TEST(CgalOracle, ContactIsNotOcclusion) {
  Scene scene;
  const auto wall = add(scene, rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
  const auto poster = add(scene, rectangle({1, 1, 0}, {1, 0, 0}, {0, 1, 0}));
  const CgalOracle oracle(scene, Light::point({1, 2, 3}));
  EXPECT_DOUBLE_EQ(oracle.area(wall).lit, 16);
  EXPECT_DOUBLE_EQ(oracle.area(poster).lit, 1);
}

TEST(CgalOracle, LightInAClosedBoxReachesNothingOutside) {
  Scene scene;
  const auto ground = add(scene, rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}));
  const auto box = add(scene, scenes::box({-1, -1, 1}, {1, 1, 2}));
  const CgalOracle oracle(scene, Light::point({0.1, 0.2, 1.5}));
  EXPECT_DOUBLE_EQ(oracle.area(ground).lit, 0);
  for (std::uint32_t k = 0; k < 6; ++k) EXPECT_EQ(oracle.area(box + k).facing, Facing::away);
}

TEST(CgalOracle, FacesBehindTheLightDoNotCast) {
  Scene scene;
  const auto ground = add(scene, rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}));
  add(scene, rectangle({-9, -9, 3}, {18, 0, 0}, {0, 18, 0}));
  const CgalOracle oracle(scene, Light::point({0, 0, 2}));
  EXPECT_DOUBLE_EQ(oracle.area(ground).lit, 64);
}

TEST(CgalOracle, RangeAndConeLeaveFacesOut) {
  Scene scene;
  const auto near = add(scene, rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}));
  const auto far = add(scene, rectangle({8, -1, 0}, {2, 0, 0}, {0, 2, 0}));
  Light light = Light::point({0, 0, 2});
  light.range = 3;
  EXPECT_EQ(CgalOracle(scene, light).area(near).facing, Facing::toward);
  EXPECT_EQ(CgalOracle(scene, light).area(far).facing, Facing::out_of_reach);
  light.range = 8.5;  // the nearest point of the far one is sqrt(68) away
  EXPECT_EQ(CgalOracle(scene, light).area(far).facing, Facing::toward);
  light.spot = Light::Spot{{0, 0, -1}, 0.1};
  EXPECT_EQ(CgalOracle(scene, light).area(near).facing, Facing::toward);
  EXPECT_EQ(CgalOracle(scene, light).area(far).facing, Facing::out_of_reach);
}

// The pointwise and the areal oracle are two programs; they must agree.
TEST(CgalOracle, PointsAgreeWithAreas) {
  for (const Kind kind : kAllKinds) {
    for (std::uint64_t seed = 900; seed < 904; ++seed) {
      const scenes::SceneData data = random_scene(kind, seed);
      SCOPED_TRACE(data.name);
      const Scene scene = scenes::build(data);
      const CgalOracle oracle(scene, data.light);
      scenes::Random random(seed);
      for (std::uint32_t i = 0; i < scene.facets().size(); ++i) {
        const Facet& facet = scene.facets()[i];
        const Face& face = scene.faces()[facet.face];
        if (face.facet_count != 1) continue;
        const CgalOracle::Area area = oracle.area(facet.face);
        if (area.facing != Facing::toward) continue;
        ASSERT_GE(area.lit, -1e-12 * area.area);
        ASSERT_LE(area.lit, area.area * (1 + 1e-12));
        const auto corners = scene.corners_of(facet);
        const Vec3 &a = scene.vertices()[corners[0].vertex],
                   &b = scene.vertices()[corners[1].vertex];
        const Vec3& d = scene.vertices()[corners[corners.size() - 1].vertex];
        int lit = 0, tried = 0;
        for (; tried < 60; ++tried) {
          double u = random.unit(), v = random.unit();
          if (corners.size() == 3 && u + v > 1) u = 1 - u, v = 1 - v;
          lit += oracle.lit(i, a + u * (b - a) + v * (d - a));
        }
        // Every random quadrilateral here is a parallelogram, so the points are even over the face;
        // five standard deviations.
        const double share = std::clamp(area.lit / area.area, 0.0, 1.0),
                     spread = std::sqrt(share * (1 - share) * tried);
        EXPECT_NEAR(lit, share * tried,
                    5 * spread + 1e-6 + (share > 1e-6 && share < 1 - 1e-6 ? 2 : 0))
            << "face " << facet.face;
      }
    }
  }
}

}  // namespace
}  // namespace shadowcut::testing
