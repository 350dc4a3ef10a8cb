// The engine against the CGAL oracle, face by face and point by point: named geometries.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "scenes.hpp"
#include "shadow_checks.hpp"

namespace shadowcut::testing {
namespace {

using scenes::rectangle;
using scenes::SceneData;

struct Stage {
  Scene scene;
  std::uint32_t add(const Mesh& mesh, const ObjectSettings& settings = {}) {
    const std::uint32_t object = scene.add(mesh, settings).index;
    return scene.objects()[object].first_face;
  }
  std::uint32_t add(const Mesh& mesh, Sides sides) {
    ObjectSettings settings;
    settings.sides = sides;
    return add(mesh, settings);
  }
  std::uint32_t ground(double half = 4) {
    return add(rectangle({-half, -half, 0}, {2 * half, 0, 0}, {0, 2 * half, 0}));
  }
};

Mesh triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
  Mesh mesh;
  mesh.vertices = {a, b, c};
  mesh.add_face({0, 1, 2});
  return mesh;
}

TEST(Shadows, EmptyScene) {
  const Shadows shadows = cast_shadows(Scene(), Light::point({0, 0, 1}));
  EXPECT_TRUE(shadows.areas.empty());
  EXPECT_EQ(shadows.stats.lit_fragments, 0u);
}

TEST(Shadows, LoneFaceStaysWhole) {
  Stage s;
  const auto ground = s.ground();
  const Light light = Light::point({0.3, 0.2, 2});
  const Shadows shadows = cast_shadows(s.scene, light);
  EXPECT_EQ(shadows.areas[ground].lit, 64);
  EXPECT_EQ(shadows.stats.lit_fragments, 1u);
  expect_right(s.scene, light);
}

TEST(Shadows, SquareOverGroundNamesItsCaster) {
  Stage s;
  const auto ground = s.ground();
  const auto sheet = s.add(rectangle({-0.5, -0.5, 1}, {1, 0, 0}, {0, 1, 0}));
  const Light light = Light::point({0.125, -0.25, 2});
  const Shadows shadows = cast_shadows(s.scene, light);
  EXPECT_NEAR(shadows.areas[ground].lit, 60, 1e-9);
  for (const Block& block : shadows.blocks)
    for (const Fragment& f : block.fragments) EXPECT_EQ(f.caster, f.lit ? invalid_index : sheet);
  expect_right(s.scene, light);
}

TEST(Shadows, LightOnCasterPlane) {
  Stage s;
  s.ground();
  const auto fence = s.add(rectangle({-1, 0, 0}, {2, 0, 0}, {0, 0, 1}));
  const Light light = Light::point({0.5, 0, 3});
  EXPECT_EQ(cast_shadows(s.scene, light).areas[fence].facing, Facing::away);
  expect_right(s.scene, light);
  expect_right(s.scene, Light::directional({1, 0, -1}));
}

TEST(Shadows, LightOnReceiverPlane) {
  Stage s;
  s.ground();
  s.add(scenes::box({-1, -1, 0}, {1, 1, 1}));
  expect_right(s.scene, Light::point({3, 0.5, 0}));
  expect_right(s.scene, Light::directional({1, 0.5, 0}));
}

TEST(Shadows, LightOnEdgesExtension) {
  Stage s;
  s.ground();
  s.add(scenes::box({-1, -1, 1}, {1, 1, 2}));
  expect_right(s.scene, Light::point({1, 1, 4}));  // above an upright edge: two sides edge-on
  expect_right(s.scene, Light::point({3, 1, 2}));  // beyond a level edge
}

TEST(Shadows, LightStandsOnATable) {
  Stage s;
  s.ground();
  s.add(scenes::box({-1, -1, 0.5}, {1, 1, 1}));
  // within the table's top: it is edge-on, the table still casts
  expect_right(s.scene, Light::point({0.25, 0.125, 1}));
}

TEST(Shadows, LightAtAVertex) {
  Stage s;
  s.ground();
  s.add(scenes::box({-1, -1, 1}, {1, 1, 2}));
  expect_right(s.scene, Light::point({1, 1, 2}));
  expect_right(s.scene, Light::point({1, 1, 1}));
  expect_right(s.scene, Light::point({1, 0, 2}));  // within an edge
}

TEST(Shadows, LightInAClosedBox) {
  Stage s;
  const auto ground = s.ground();
  const auto inner = s.add(rectangle({-0.25, -0.25, 1.25}, {0.5, 0, 0}, {0, 0.5, 0}));
  s.add(scenes::box({-1, -1, 1}, {1, 1, 2}));
  const Light light = Light::point({0.1, 0.2, 1.5});
  const Shadows shadows = cast_shadows(s.scene, light);
  EXPECT_EQ(shadows.areas[ground].lit, 0);
  EXPECT_EQ(shadows.areas[inner].lit, 0.25);
  expect_right(s.scene, light);
}

TEST(Shadows, LightInTwoClosedBoxes) {
  Stage s;
  s.ground();
  s.add(scenes::box({-1, -1, 1}, {1, 1, 2}));
  s.add(scenes::box({-0.5, -2, 0.5}, {2, 0.5, 1.75}));
  expect_right(s.scene, Light::point({0.1, 0.2, 1.5}));
  expect_right(s.scene, Light::point({1.5, 0.2, 1.5}));  // in one of them
}

TEST(Shadows, LightInAnOpenBoxIsARoom) {
  Stage s;
  const auto ground = s.ground();
  const auto box = s.add(scenes::box({-1, -1, 1}, {1, 1, 2}), Sides::open);
  const Light light = Light::point({0.1, 0.2, 1.5});
  const Shadows shadows = cast_shadows(s.scene, light);
  EXPECT_EQ(shadows.areas[ground].lit, 0);
  for (std::uint32_t k = 0; k < 6; ++k)
    EXPECT_EQ(shadows.areas[box + k].lit, shadows.areas[box + k].area);
  expect_right(s.scene, light);
}

TEST(Shadows, FaceBehindTheLightCastsNothing) {
  Stage s;
  const auto ground = s.ground();
  s.add(rectangle({-9, -9, 3}, {18, 0, 0}, {0, 18, 0}));
  const Light light = Light::point({0.1, 0.3, 2});
  EXPECT_EQ(cast_shadows(s.scene, light).areas[ground].lit, 64);
  expect_right(s.scene, light);
}

TEST(Shadows, FacePassesTheLightOnBothSides) {
  Stage s;
  s.ground();
  // higher than the light, and through the ground
  s.add(rectangle({1, -5, -5}, {0, 10, 0}, {0, 0, 10}));
  s.add(rectangle({-2, -1, -1}, {0, 2, 0}, {1, 0, 4}));
  expect_right(s.scene, Light::point({0.1, 0.3, 2}));
}

TEST(Shadows, CastersShareAnEdge) {
  Stage s;
  const auto ground = s.ground();
  Mesh roof;
  roof.vertices = {{-1, -1, 1}, {0, -1, 1.5}, {1, -1, 1}, {-1, 1, 1}, {0, 1, 1.5}, {1, 1, 1}};
  roof.add_face({0, 1, 4, 3});
  roof.add_face({1, 2, 5, 4});
  s.add(roof);
  for (const Vec3& at : {Vec3(0, 0, 4), Vec3(3, 1, 3), Vec3(0.5, 0, 1.75)}) {
    SCOPED_TRACE(at.transpose());
    expect_right(s.scene, Light::point(at));
  }
  const Shadows shadows = cast_shadows(s.scene, Light::directional({0, 0, -1}));
  EXPECT_EQ(shadows.areas[ground].shadowed, 4);  // no light leaks through the ridge
}

TEST(Shadows, CastersMeetInAVertex) {
  Stage s;
  s.ground();
  s.add(triangle({0, 0, 1}, {1, 0, 1.5}, {0, 1, 1.25}));
  s.add(triangle({0, 0, 1}, {-1, 0, 1.5}, {0, -1, 1.25}));
  expect_right(s.scene, Light::point({0, 0, 3}));
  expect_right(s.scene, Light::point({0.7, 0.3, 3}));
}

TEST(Shadows, CrossingFaces) {
  Stage s;
  const auto flat = s.add(rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}));
  const auto steep = s.add(rectangle({-1, -0.5, -1}, {0, 1, 0}, {2, 0, 2}));
  const Light light = Light::directional({0, 0, -1});
  const Shadows shadows = cast_shadows(s.scene, light);
  EXPECT_NEAR(shadows.areas[flat].lit, 3, 1e-12);
  EXPECT_NEAR(shadows.areas[steep].lit, shadows.areas[steep].area / 2, 1e-12);
  EXPECT_GT(shadows.stats.crossing_lines, 0u);
  expect_right(s.scene, light);
  expect_right(s.scene, Light::point({0.3, 0.4, 2}));
}

TEST(Shadows, ThreeFacesCrossInAPoint) {
  Stage s;
  s.add(rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}));
  s.add(rectangle({0, -1, -1}, {0, 2, 0}, {0, 0, 2}));
  s.add(rectangle({-1, 0, -1}, {2, 0, 0}, {0, 0, 2}));
  expect_right(s.scene, Light::point({2, 3, 4}));
  expect_right(s.scene, Light::directional({-1, -1, -1}));
}

TEST(Shadows, CrossingFacesAboveAThird) {
  Stage s;
  s.ground();
  s.add(rectangle({-1, -1, 1}, {2, 0, 0.5}, {0, 2, 0}));
  s.add(rectangle({-1, -0.5, 1.75}, {2, 0, -1}, {0, 1, 0}));
  s.add(rectangle({-0.5, -1, 1.1}, {1, 0, 0.1}, {0.2, 2, 0.7}));
  expect_right(s.scene, Light::point({0.3, 0.4, 5}));
}

TEST(Shadows, CoplanarPosterNeitherCastsNorIsShadowed) {
  Stage s;
  const auto wall = s.add(rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
  const auto poster = s.add(rectangle({1, 1, 0}, {1, 0, 0}, {0, 1, 0}));
  s.add(rectangle({1, 1, 0}, {1, 0, 0}, {0, 1, 0}));  // and once more the same
  for (const Light& light :
       {Light::point({1, 2, 3}), Light::point({1, 2, -3}), Light::directional({1, 1, 1})}) {
    const Shadows shadows = cast_shadows(s.scene, light);
    EXPECT_EQ(shadows.areas[wall].lit, 16);
    EXPECT_EQ(shadows.areas[poster].lit, 1);
    expect_right(s.scene, light);
  }
}

TEST(Shadows, TiltedPosterTouchesUpToRounding) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    scenes::Random random(seed);
    Pose pose = Pose::Identity();
    pose.rotate(Eigen::AngleAxisd(3 * random.unit(), random.in_ball(1).normalized()));
    pose.pretranslate(random.in_cube(-1, 1));
    ObjectSettings settings;
    settings.pose = pose;
    Stage s;
    const auto wall = s.add(rectangle({-1, -1, 0}, {3, 0, 0}, {0, 3, 0}), settings);
    const auto poster = s.add(
        rectangle({random.unit(), random.unit(), 0}, {0.3, 0.1, 0}, {-0.1, 0.3, 0}), settings);
    const Light light = Light::point(pose * Vec3(0.4, 0.3, 2));
    const Shadows shadows = cast_shadows(s.scene, light);
    EXPECT_NEAR(shadows.areas[wall].lit, 9, 9e-9);
    EXPECT_NEAR(shadows.areas[poster].lit, 0.1, 1e-10);
    expect_right(s.scene, light);
  }
}

TEST(Shadows, PosterAHairAboveTheWallCasts) {
  Stage s;
  const auto wall = s.ground();
  s.add(rectangle({1, 1, 1e-8}, {1, 0, 0}, {0, 1, 0}));
  const Shadows shadows = cast_shadows(s.scene, Light::directional({0, 0, -1}));
  EXPECT_NEAR(shadows.areas[wall].shadowed, 1, 1e-9);
}

TEST(Shadows, VertexOneUlpOffPlane) {
  for (const double start : {0.0, 1.0, 2.5}) {
    for (const double to : {-10.0, 10.0}) {
      Stage s;
      s.add(rectangle({-4, -4, start}, {8, 0, 0}, {0, 8, 0}));
      const double z = std::nextafter(start, to);
      s.add(triangle({0, 0, z}, {1, 0, start}, {0, 1, start}));
      s.add(triangle({-1, -1, z}, {-2, -1, start + 1}, {-1, -2, start + 1}));
      s.add(rectangle({1, -1, z}, {1, 0, 0}, {0, -1, 1}));
      expect_right(s.scene, Light::point({0.3, 0.2, 5}));
      expect_right(s.scene, Light::point({0.9, 0.8, start}));
      expect_right(s.scene, Light::directional({0.3, 0.2, -1}));
    }
  }
}

// What a dividing plane of the prefix, or another face's edge, cuts off at such a vertex is a
// sliver 1e-15 wide, whose corners lie on every line that passes near: its shadow volume must not
// be the whole cell.
TEST(Shadows, VertexUlpsOffADividingPlane) {
  for (int ulps = -24; ulps <= 24; ++ulps) {
    SCOPED_TRACE(ulps);
    Stage s;
    Mesh fan;
    fan.vertices = {{ulps * 0x1p-52, -0.31, 0.91},
                    {0.47, 0.36, 0.64},
                    {1.37, -0.05, -0.48},
                    {1.34, -0.96, 0.33}};
    for (const auto& [a, b, c] : {std::array{0u, 1u, 2u}, {0u, 2u, 3u}, {1u, 0u, 3u}, {2u, 1u, 3u}})
      fan.add_face({a, b, c});
    s.add(fan);
    s.add(rectangle({-9, -8, 4}, {18, 0, 1}, {0, 16, 2}));
    s.add(rectangle({-8, -9, 6}, {16, 0, 1}, {0, 18, 2}));
    for (const std::uint32_t cell : {0u, 2u, 4u}) {
      for (const Order order : {Order::as_given, Order::solid_angle}) {
        Options o;
        o.tuning.facets_per_cell = cell, o.tuning.order = order;
        expect_right(s.scene, Light::point({0, 0, 0}), o);
      }
    }
  }
}

// In range with one part, in the cone with the other: reached, as a whole.
TEST(Shadows, RangeAndConeReachDifferentParts) {
  Stage s;
  Mesh folded;  // not flat: two facets
  folded.vertices = {{0, 0, 0}, {1, 0, 0.5}, {1, 1, 0}, {0, 1, 0.5}};
  folded.add_face({0, 1, 2, 3});
  const auto face = s.add(folded);
  Light light = Light::point({-0.5, 0.5, 1});
  for (const double range : {0.6, 0.8, 1.0}) {
    light.range = range;
    for (const double turn : {0.2, 0.5, 0.8, 1.1}) {
      light.spot = Light::Spot{{1, 0, -0.6}, turn};
      const CgalOracle oracle(s.scene, light);
      EXPECT_EQ(check_areas(s.scene, cast_shadows(s.scene, light), oracle), "")
          << range << " " << turn;
    }
  }
  EXPECT_EQ(cast_shadows(s.scene, light).areas[face].facing, Facing::toward);
}

TEST(Shadows, ShadowEdgeOnReceiverEdge) {
  Stage s;
  s.ground(2);
  // from (0,0,2) its shadow is the ground, to the edge
  s.add(rectangle({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}));
  expect_right(s.scene, Light::point({0, 0, 2}));
  s.add(rectangle({-1, -1, 1}, {1, 0, 0}, {0, 1, 0.5}));
  expect_right(s.scene, Light::point({0, 0, 2}));
}

TEST(Shadows, IdenticalFacesOneBehindTheOther) {
  Stage s;
  s.ground();
  for (double z = 0.5; z < 3; z += 0.5) s.add(rectangle({-1, -1, z}, {2, 0, 0}, {0, 2, 0}));
  expect_right(s.scene, Light::directional({0, 0, -1}));
  expect_right(s.scene, Light::directional({0, 0, 1}));
  expect_right(s.scene, Light::point({0, 0, 4}));
}

TEST(Shadows, SameSolidTwice) {
  Stage s;
  s.ground();
  s.add(scenes::box({-1, -1, 0}, {1, 1, 1}));
  s.add(scenes::box({-1, -1, 0}, {1, 1, 1}));
  expect_right(s.scene, Light::point({2, 3, 4}));
}

TEST(Shadows, ConcaveCasterWithHoles) {
  Stage s;
  s.ground(8);
  Mesh mesh;
  mesh.vertices = {{0, 0, 2}, {4, 0, 2}, {4, 4, 2}, {0, 4, 2},
                   {1, 1, 2}, {3, 1, 2}, {3, 3, 2}, {1, 3, 2}};
  mesh.add_face({0, 1, 2, 3});
  constexpr std::array<std::uint32_t, 4> hole{4, 7, 6, 5};
  mesh.add_hole(hole);
  const auto frame = s.add(mesh);
  EXPECT_DOUBLE_EQ(s.scene.faces()[frame].area, 12);
  const Shadows shadows = cast_shadows(s.scene, Light::directional({0, 0, -1}));
  EXPECT_NEAR(shadows.areas[0].shadowed, 12, 1e-12);
  expect_right(s.scene, Light::point({2, 1, 5}));
  expect_right(s.scene, Light::directional({1, 2, -3}));
}

TEST(Shadows, NonFlatFaceShadowsItself) {
  Stage s;
  Mesh mesh;  // a tent along one diagonal; the light low on one side
  mesh.vertices = {{0, 0, 0}, {1, 0, 1}, {1, 1, 0}, {0, 1, 1}};
  mesh.add_face({0, 1, 2, 3});
  s.add(mesh);
  ASSERT_EQ(s.scene.issues().size(), 1u);
  for (const Form form : {Form::pieces, Form::merged, Form::conforming}) {
    SCOPED_TRACE("form " + std::to_string(static_cast<int>(form)));
    Options options;
    options.form = form;
    expect_right(s.scene, Light::point({4, 3.5, 0.7}), options);
    expect_right(s.scene, Light::point({0.3, 0.4, 3}), options);
  }
}

TEST(Shadows, NonFlatFaceFoldedTowardTheLight) {
  Stage s;
  Mesh mesh;  // its two facets lie one behind the other
  mesh.vertices = {{0, 5, 2}, {3, -1, -2}, {-1, 4, 5}, {-2, -2, -2}};
  mesh.add_face({0, 1, 2, 3});
  s.add(mesh, Sides::open);
  for (const Form form : {Form::pieces, Form::merged, Form::conforming}) {
    SCOPED_TRACE("form " + std::to_string(static_cast<int>(form)));
    Options options;
    options.form = form;
    expect_right(s.scene, Light::directional({4, 5, 2}), options);
  }
}

TEST(Shadows, CastsAndReceives) {
  Stage s;
  const auto ground = s.ground();
  ObjectSettings ghost, mask;
  ghost.casts_shadows = false;
  mask.receives_shadows = false;
  const auto ghost_face = s.add(rectangle({-2, -1, 1}, {1, 0, 0}, {0, 1, 0}), ghost);
  const auto mask_face = s.add(rectangle({1, -1, 1}, {1, 0, 0}, {0, 1, 0}), mask);
  s.add(rectangle({-2, -1, 2}, {0.5, 0, 0}, {0, 0.5, 0}));
  const Light light = Light::directional({0, 0, -1});
  const Shadows shadows = cast_shadows(s.scene, light);
  EXPECT_NEAR(shadows.areas[ground].shadowed, 1 + 0.25, 1e-12);
  EXPECT_NEAR(shadows.areas[ghost_face].shadowed, 0.25, 1e-12);
  for (const Block& block : shadows.blocks)
    for (const Fragment& f : block.fragments) {
      EXPECT_NE(f.face, mask_face);
      EXPECT_NE(f.caster, ghost_face);
    }
  expect_right(s.scene, light);
  expect_right(s.scene, Light::point({0.2, 0.3, 3}));
}

TEST(Shadows, RangeLeavesFarFacesOut) {
  Stage s;
  const auto near = s.ground(1);
  const auto far = s.add(rectangle({8, -1, 0}, {2, 0, 0}, {0, 2, 0}));
  Light light = Light::point({0, 0, 2});
  light.range = 3;
  const Shadows shadows = cast_shadows(s.scene, light);
  EXPECT_EQ(shadows.areas[near].facing, Facing::toward);
  EXPECT_EQ(shadows.areas[far].facing, Facing::out_of_reach);
  EXPECT_EQ(shadows.areas[far].shadowed, 4);
  expect_right(s.scene, light);
}

}  // namespace
}  // namespace shadowcut::testing
