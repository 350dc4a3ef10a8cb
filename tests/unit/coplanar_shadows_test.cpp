// Faces that share a plane do not cross, and shadow each other nowhere.
#include <gtest/gtest.h>

#include <cmath>

#include "brick_cube.hpp"
#include "check.hpp"
#include "exact_checks.hpp"

namespace shadowcut::testing {
namespace {

using scenes::Random;

using scenes::append;
using scenes::rectangle;

// The sum of a side's lit areas, where sides have `faces` faces each of which the last lies over
// others.
std::vector<double> lit_by_side(const Scene& scene, const Shadows& shadows, bool posters) {
  const std::uint32_t count = scene.objects()[0].face_count / 6;
  std::vector<double> lit;
  for (std::uint32_t side = 0; side < 6; ++side) {
    double sum = 0;
    for (std::uint32_t f = side * count; f < (side + 1) * count - (posters ? 1 : 0); ++f)
      sum += shadows.areas[f].lit;
    lit.push_back(sum);
  }
  return lit;
}

// A turned cube in bricks below a plate, which shades a part of it.
struct Shaded {
  Mesh mesh, plain;
  Mesh plate = rectangle({-0.6, -0.7, 3}, {1, 0, 0}, {0, 1, 0});
  Light light;
  explicit Shaded(std::uint64_t seed, unsigned n = 8) {
    Random random(seed);
    const Eigen::Quaterniond q = random_turn(random);
    mesh = turned(brick_cube(n), q), plain = turned(plain_cube(), q);
    light = random.below(2) == 0 ? Light::point(random.in_cube(-1, 1) + Vec3(0, 0, 7))
                                 : Light::directional(random.in_cube(-1, 1) - Vec3(0, 0, 4));
  }
  Scene scene(const Mesh& cube, double tolerance, const Pose& pose = Pose::Identity()) const {
    Scene s = scene_of(cube, tolerance, pose, Sides::closed);
    s.add(plate, {});
    return s;
  }
};

TEST(CoplanarShadows, BricksOfATurnedCubeDoNotCross) {
  std::uint64_t crossings_without = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const Shaded made(seed);
    Options options;
    options.kernel = Kernel::exact;
    options.constructions = true;
    const Scene scene = made.scene(made.mesh, default_coplanarity),
                plain = made.scene(made.plain, default_coplanarity);
    const Shadows shadows = cast_shadows(scene, made.light, options);
    EXPECT_EQ(shadows.stats.crossing_lines, 0u) << "seed " << seed;
    EXPECT_EQ(check_fragments(scene, made.light, shadows), "") << "seed " << seed;
    const auto lit = lit_by_side(scene, shadows, true),
               whole = lit_by_side(plain, cast_shadows(plain, made.light, options), false);
    for (std::size_t side = 0; side < 6; ++side)
      EXPECT_NEAR(lit[side], whole[side], 1e-12) << "seed " << seed << ", side " << side;
    if (seed < 3) {
      const GmpOracle oracle(scene, made.light);
      ASSERT_TRUE(oracle.defined()) << oracle.why_undefined();
      EXPECT_EQ(check_exact(oracle, shadows, options.form), "") << "seed " << seed;
    }
    crossings_without +=
        cast_shadows(made.scene(made.mesh, 0), made.light, options).stats.crossing_lines;
  }
  EXPECT_GT(crossings_without, 1000u);  // so the tolerance did it
}

// Front and back of one sheet, each in bricks of its own, neither of them shaded by the other.
TEST(CoplanarShadows, BothSidesOfASheetTouch) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    Mesh mesh = bricks({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 4);
    append(mesh, bricks({0.1, 0.2, 0}, {0, 0.7, 0}, {0.6, 0, 0}, 3));
    mesh = turned(mesh, random_turn(random));
    Options options;
    options.kernel = random.below(4) == 0 ? Kernel::fast : Kernel::exact;
    const Light light = Light::directional(random.in_cube(-1, 1));
    const Scene scene = scene_of(mesh);
    const Shadows shadows = cast_shadows(scene, light, options);
    EXPECT_EQ(shadows.stats.crossing_lines, 0u) << "seed " << seed;
    EXPECT_NEAR(shadows.stats.lit_area, 1.42, 1e-12) << "seed " << seed;
    EXPECT_NEAR(shadows.stats.shadowed_area, 0, 1e-12) << "seed " << seed;
  }
}

TEST(CoplanarShadows, NorAfterAThousandMotions) {
  const Shaded made(4, 4);
  Options options;
  options.kernel = Kernel::exact;
  options.threads = 1;
  Scene scene = made.scene(made.mesh, default_coplanarity);
  scene.add(made.light);
  Engine engine(scene, options);
  engine.update();
  Random random(17);
  Pose pose = Pose::Identity();
  for (unsigned k = 0; k < 1000; ++k) {
    pose = Eigen::Translation3d(0.05 * random.in_cube(-1, 1)) * Pose(random_turn(random)) * pose;
    if (pose.translation().norm() > 1) pose.translation() *= 0.5;
    ASSERT_EQ(scene.set_pose(scene.object_id(0), pose), Status::ok);
    engine.update();
    ASSERT_EQ(engine.shadows(0).stats.crossing_lines, 0u) << "motion " << k;
    if (k % 50 != 49) continue;
    const Scene plain = made.scene(made.plain, default_coplanarity, pose);
    const auto lit = lit_by_side(engine.scene(), engine.shadows(0), true),
               whole = lit_by_side(plain, cast_shadows(plain, made.light, options), false);
    for (std::size_t side = 0; side < 6; ++side)
      ASSERT_NEAR(lit[side], whole[side], 1e-12) << "motion " << k << ", side " << side;
  }
  ASSERT_EQ(engine.validate(), "");
}

}  // namespace
}  // namespace shadowcut::testing
