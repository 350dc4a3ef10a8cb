// The comparison of replay --verify: areas of symmetric differences, and tolerances.
#include "difference.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "scenes.hpp"

namespace shadowcut::cli {
namespace {

constexpr double kSame = 1e-13;

// A floor of 10 x 10 under a square lamp shade that is no receiver, the sun right above: the
// shade's shadow is 2 x 2.
Scene shaded(double x) {
  Scene scene;
  scene.add(scenes::rectangle({0, 0, 0}, {10, 0, 0}, {0, 10, 0}), {.name = "floor"});
  scene.add(scenes::rectangle({x, 4, 1}, {2, 0, 0}, {0, 2, 0}),
            {.name = "shade", .receives_shadows = false});
  return scene;
}

Shadows noon(double x) { return cast_shadows(shaded(x), Light::directional({0, 0, -1})); }

TEST(Compare, SameRegionsInOtherFragments) {
  for (const scenes::SceneData& data :
       {scenes::room(2), scenes::city(8), scenes::triangles(200), scenes::branch(2)}) {
    const Scene scene = scenes::build(data);
    Options other;
    other.tuning.order = Order::random;
    other.form = Form::pieces;
    other.tuning.facets_per_cell = 8;
    const Difference d = greatest_difference(scene, cast_shadows(scene, data.light),
                                             cast_shadows(scene, data.light, other));
    EXPECT_LT(d.share, 1e-11) << data.name;
    EXPECT_NE(d.face, invalid_index);
  }
}

TEST(Compare, SliversAreMeasured) {
  for (const double shift : {1e-3, 1e-7, 1e-10}) {
    const Difference d = greatest_difference(shaded(3), noon(3), noon(3 + shift));
    EXPECT_EQ(d.face, 0u);
    EXPECT_NEAR(d.share, 2 * 2 * shift / 100, kSame) << shift;
  }
}

TEST(Compare, DisjointAndOppositeAreWhole) {
  EXPECT_NEAR(greatest_difference(shaded(1), noon(1), noon(6)).share, 8.0 / 100, kSame);
  Shadows dark = noon(3);
  for (Block& block : dark.blocks)
    for (Fragment& f : block.fragments) f.lit = false;
  EXPECT_NEAR(greatest_difference(shaded(3), noon(3), dark).share, 0.96, kSame);
}

TEST(Compare, AFragmentTwiceDoesNotMakeUpForAMissingOne) {
  Shadows wrong = noon(3);
  std::vector<Fragment*> lit;
  for (Block& block : wrong.blocks)
    for (Fragment& f : block.fragments)
      if (f.lit && f.face == 0) lit.push_back(&f);
  ASSERT_GE(lit.size(), 2u);
  const double lost = lit[0]->area, twice = lit[1]->area;
  const FragmentId id = lit[0]->id;
  *lit[0] = *lit[1];
  lit[0]->id = id;
  EXPECT_NEAR(greatest_difference(shaded(3), noon(3), wrong).share, (lost + twice) / 100, kSame);
}

TEST(Compare, StatedAreasCount) {
  Shadows wrong = noon(3);
  wrong.areas[0].lit += 0.5;
  EXPECT_NEAR(greatest_difference(shaded(3), noon(3), wrong).share, 0.005, kSame);
  wrong.areas[0].lit = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(std::isfinite(greatest_difference(shaded(3), noon(3), wrong).share));
}

// A corner on a straight side, beside another: the line through the two has a direction of its own.
TEST(Compare, CornersAHairApart) {
  const Shadows right = noon(3);
  for (const double apart : {1e-9, 1e-12, 1e-15}) {
    Shadows odd = right;
    Block& block = odd.blocks[0];
    for (Fragment& f : block.fragments) {
      std::vector<Vec3> corners(block.corners_of(f).begin(), block.corners_of(f).end());
      const Vec3 middle = 0.5 * (corners[0] + corners[1]),
                 along = (corners[1] - corners[0]).normalized();
      corners.insert(corners.begin() + 1, {middle, middle + along * apart + Vec3(1, 1, 0) * 1e-16});
      f.first_corner = static_cast<std::uint32_t>(block.corners.size());
      f.corner_count += 2;
      block.corners.insert(block.corners.end(), corners.begin(), corners.end());
    }
    EXPECT_LT(greatest_difference(shaded(3), right, odd).share, kSame) << apart;
  }
}

TEST(Compare, ToleranceGrowsAsTheLightComesNearTheFacesPlane) {
  const Scene scene = shaded(3);
  const auto exact = [&](double height) {
    return tolerance_of(scene, Light::directional({1, 0, -height}), 0, Kernel::exact);
  };
  EXPECT_LT(exact(1), 1.1e-12);
  EXPECT_LT(exact(1), exact(1e-6));
  EXPECT_EQ(exact(1e-12), 1e-9);
  EXPECT_EQ(exact(0), 1e-9);
  EXPECT_EQ(tolerance_of(scene, Light::directional({0, 0, -1}), 0, Kernel::fast), 1e-9);
}

}  // namespace
}  // namespace shadowcut::cli
