// Faces that were meant to lie in one plane: which of them get one, that motions change nothing of
// it.
#include "scene/coplanar_groups.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "brick_cube.hpp"
#include "random_scenes.hpp"

namespace shadowcut::testing {
namespace {

using scenes::append;
using scenes::Random;
using scenes::rectangle;

const Plane& plane_of(const Scene& scene, std::size_t facet) {
  return scene.planes()[scene.facets()[facet].plane];
}

// Up to its side, and with the same digits.
bool one_plane(const Plane& p, const Plane& q) {
  return p.point == q.point && p.flatness == q.flatness &&
         ((p.normal == q.normal && p.exact_normal == q.exact_normal) ||
          (p.normal == -q.normal && p.exact_normal == -q.exact_normal));
}

std::size_t count_planes(const Scene& scene) {
  std::vector<const Plane*> seen;
  for (std::size_t f = 0; f < scene.facets().size(); ++f) {
    if (scene.facets()[f].corner_count == 0) continue;
    const Plane& p = plane_of(scene, f);
    if (std::none_of(seen.begin(), seen.end(), [&](const Plane* q) { return one_plane(*q, p); }))
      seen.push_back(&p);
  }
  return seen.size();
}

std::vector<std::uint32_t> plane_indices(const Scene& scene) {
  std::vector<std::uint32_t> all;
  for (const Facet& f : scene.facets()) all.push_back(f.plane);
  return all;
}

// Every facet's corners are within its plane's flatness.
void expect_flat(const Scene& scene) {
  for (const Facet& f : scene.facets()) {
    const Plane& p = scene.planes()[f.plane];
    for (const Corner& c : scene.corners_of(f))
      ASSERT_LE(std::abs(p.normal.dot(scene.vertices()[c.vertex] - p.point)), p.flatness);
  }
}

TEST(Coplanar, SidesOfATurnedCubeAreSixPlanes) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    const Mesh mesh = turned(brick_cube(16), random_turn(random), random.in_cube(-3, 3));
    const Scene scene = scene_of(mesh);
    EXPECT_EQ(scene.planes().size(), 6u) << "seed " << seed;
    EXPECT_EQ(count_planes(scene), 6u) << "seed " << seed;
    EXPECT_GT(scene.objects()[0].aligned, scene.facets().size() / 2) << "seed " << seed;
    EXPECT_LT(scene.objects()[0].aligned_by, 1e-14) << "seed " << seed;
    expect_flat(scene);
  }
}

TEST(Coplanar, ExactPlanesStayWhatTheyAre) {
  const Scene scene = scene_of(brick_cube(8));
  EXPECT_EQ(count_planes(scene), 6u);
  EXPECT_EQ(scene.objects()[0].aligned, 0u);
  for (const Plane& p : scene.planes()) EXPECT_EQ(p.flatness, 0);
  // On a fine grid, and not along its axes: sums and products in double would lose digits.
  const Scene fine =
      scene_of(bricks({1.25, 0x1p-20, 3}, {1 + 0x1p-15, 0.5, 3 - 0x1p-14}, {-0.25, 0x1p-13, 2}, 8));
  EXPECT_EQ(count_planes(fine), 1u);
  EXPECT_EQ(fine.objects()[0].aligned, 0u);
  const Scene tilted = scene_of(bricks({0, 0, 0}, {8, 0, 24}, {0, 8, -16}, 8));
  EXPECT_EQ(count_planes(tilted), 1u);
  EXPECT_EQ(tilted.objects()[0].aligned, 0u);
}

TEST(Coplanar, SwitchedOffEveryFaceHasItsOwnPlane) {
  Random random(7);
  const Scene scene = scene_of(turned(brick_cube(8), random_turn(random)), 0);
  EXPECT_EQ(scene.planes().size(), scene.facets().size());
  EXPECT_EQ(scene.objects()[0].aligned, 0u);
  EXPECT_EQ(scene.objects()[0].aligned_by, 0);
}

TEST(Coplanar, BothSidesOfASheet) {
  Random random(3);
  Mesh mesh = bricks({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 5);
  append(mesh, bricks({0.1, 0.1, 0}, {0, 0.7, 0}, {0.7, 0, 0}, 5));
  const Scene scene = scene_of(turned(mesh, random_turn(random), {1, 2, 3}));
  ASSERT_EQ(scene.planes().size(), 2u);
  const Plane &front = scene.planes()[0], &back = scene.planes()[1];
  EXPECT_TRUE(one_plane(front, back));
  EXPECT_EQ(front.normal, -back.normal);
  for (std::size_t f = 0; f < scene.facets().size(); ++f) {
    const auto c = scene.corners_of(scene.facets()[f]);
    const auto at = [&](std::size_t i) { return scene.vertices()[c[i].vertex]; };
    EXPECT_GT((at(1) - at(0)).cross(at(2) - at(0)).dot(plane_of(scene, f).normal), 0);
  }
}

// Each strip lies in its neighbours' planes within the tolerance, and they in theirs.
TEST(Coplanar, CurvedSheetIsNotOnePlane) {
  constexpr double tolerance = 1e-12, bend = 1e-9;
  Mesh mesh;
  for (unsigned i = 0; i < 1000; ++i) {
    const double x = i / 1000.0, y = (i + 1) / 1000.0;
    append(mesh, rectangle({x, 0, bend * x * x}, {y - x, 0, bend * (y * y - x * x)}, {0, 1, 0}));
  }
  const Scene scene = scene_of(mesh);
  EXPECT_GT(scene.planes().size(), 10u);
  EXPECT_LT(scene.planes().size(), 60u);
  for (const Plane& p : scene.planes()) EXPECT_LT(p.flatness, 2 * tolerance);
  EXPECT_LT(scene.objects()[0].aligned_by, 2 * tolerance);
  expect_flat(scene);
}

TEST(Coplanar, StepsAreToldFromTreads) {
  // sheets one upon another, thrice the tolerance apart, and a second sheet in each plane
  Mesh mesh;
  for (unsigned i = 0; i < 500; ++i) {
    append(mesh, rectangle({0, 0, 3e-12 * i}, {1, 0, 0}, {0, 1, 0}));
    append(mesh, rectangle({0.5, 0.25, 3e-12 * i + (i % 2 == 0 ? 4e-13 : 0)}, {0.25, 0, 0},
                           {0, 0.25, 0}));
  }
  const Scene scene = scene_of(mesh);
  EXPECT_EQ(count_planes(scene), 500u);
  for (std::uint32_t i = 0; i < 500; ++i)
    EXPECT_EQ(scene.facets()[2 * i].plane, scene.facets()[2 * i + 1].plane);
  EXPECT_EQ(scene.objects()[0].aligned, 250u);
}

TEST(Coplanar, TinyFaceAcrossAPlaneKeepsItsOwn) {
  Mesh mesh = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  append(mesh, rectangle({0.25, 0.25, 0}, {0.5, 0, 0}, {0, 0, 1e-13}));   // a fin
  append(mesh, rectangle({0.5, 0.75, 0}, {1e-13, 0, 0}, {0, 0, 1e-13}));  // a speck
  const Scene scene = scene_of(mesh);
  ASSERT_EQ(scene.facets().size(), 3u);
  EXPECT_EQ(count_planes(scene), 3u);
  EXPECT_EQ(scene.objects()[0].aligned, 0u);
}

// One plane, but not one doubt about how it stands.
TEST(Coplanar, NarrowFaceDoesNotBlurAWall) {
  Random random(5);
  Mesh mesh = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  append(mesh, rectangle({0, 1, 0}, {1, 0, 0}, {0, 1e-8, 0}));
  const Scene scene = scene_of(turned(mesh, random_turn(random)));
  EXPECT_EQ(count_planes(scene), 1u);
  ASSERT_EQ(scene.planes().size(), 2u);
  EXPECT_LT(plane_of(scene, 0).tilt, 1e-14);
  EXPECT_GT(plane_of(scene, 1).tilt, 1e-9);
}

TEST(Coplanar, DistortingPoseSharesNoMoreThanItKeepsFlat) {
  Mesh mesh = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  append(mesh, rectangle({1, 0, 5e-13}, {1, 0, 0}, {0, 1, 0}));
  EXPECT_EQ(count_planes(scene_of(mesh)), 1u);
  EXPECT_EQ(count_planes(scene_of(mesh, default_coplanarity, Pose(Eigen::Scaling(1e9)))), 1u);
  EXPECT_EQ(count_planes(scene_of(mesh, default_coplanarity, Pose(Eigen::Scaling(1.0, 1.0, 1e9)))),
            2u);
}

TEST(Coplanar, AnyMagnitude) {
  for (const double size : {1e-150, 1e-30, 1e-9, 1.0, 1e9, 1e30, 1e150}) {
    Random random(9);
    Mesh mesh = turned(brick_cube(4), random_turn(random));
    for (Vec3& v : mesh.vertices) v *= size;
    EXPECT_EQ(count_planes(scene_of(mesh)), 6u) << size;
  }
  for (const double shift : {1e3, 1e5, 1e7}) {  // coordinates keep fewer and fewer digits
    Random random(9);
    const Scene scene =
        scene_of(turned(brick_cube(4), random_turn(random), {shift, -shift, 0.3 * shift}));
    EXPECT_TRUE(scene.issues().empty()) << shift;
    EXPECT_EQ(count_planes(scene), 6u) << shift;
  }
}

TEST(Coplanar, FloatCoordinatesNeedAWiderTolerance) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    Mesh mesh = turned(brick_cube(8), random_turn(random));
    for (Vec3& v : mesh.vertices) v = v.cast<float>().cast<double>();
    EXPECT_GT(count_planes(scene_of(mesh)), 100u) << "seed " << seed;
    EXPECT_EQ(count_planes(scene_of(mesh, 3e-7)), 6u) << "seed " << seed;
  }
}

// A wall's far end does not suffer from its plane being one tile's.
TEST(Coplanar, PlaneOfManyTilesIsAsGoodAsTheirCorners) {
  Random random(21);
  const Scene scene =
      scene_of(turned(bricks({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 128), random_turn(random)));
  EXPECT_EQ(count_planes(scene), 1u);
  EXPECT_LT(scene.planes()[0].flatness, 8 * 0x1p-53);
}

// The same groups as asking every leader.
TEST(Coplanar, GroupsAreThoseOfASearchOfAll) {
  constexpr double tolerance = 1e-12, most_turn = 1e-6;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Random random(seed);
    Mesh mesh;
    const std::size_t planes = 1 + random.below(6);
    std::vector<Eigen::Quaterniond> turns;
    for (std::size_t p = 0; p < planes; ++p)
      turns.push_back(p > 0 && random.below(2) == 0 ? turns.back() : random_turn(random));
    for (std::size_t f = 0; f < 60; ++f) {
      const std::size_t p = random.below(planes);
      const double size = std::exp(random.in(-20, 0)), width = size * std::exp(random.in(-12, 0));
      const double off = random.below(2) == 0 ? 0 : random.in(-3, 3) * 1e-12;
      Mesh face =
          rectangle({random.in(-1, 1), random.in(-1, 1), 0.1 * static_cast<double>(p) + off},
                    {size, 0, 0}, {0, width, 0});
      append(mesh,
             turned(face, turns[p] * (random.below(2) == 0 ? Eigen::Quaterniond(0, 1, 0, 0)
                                                           : Eigen::Quaterniond::Identity())));
    }
    const Scene scene = scene_of(mesh, 0);
    std::vector<Patch> patches;
    for (std::uint32_t f = 0; f < scene.facets().size(); ++f) patches.push_back({f, f + 1});
    const Figure figure{scene.facets(), scene.corners(), scene.vertices()};
    const std::vector<Membership> groups = find_groups(figure, patches, tolerance, most_turn);

    double largest = 0;
    for (const Vec3& v : scene.vertices()) largest = std::max(largest, v.cwiseAbs().maxCoeff());
    for (std::uint32_t f = 0; f < patches.size(); ++f) {
      const auto c = scene.corners_of(scene.facets()[f]);
      double area = scene.faces()[scene.facets()[f].face].area, outline = 0;
      for (std::size_t i = 0; i < c.size(); ++i)
        outline +=
            (scene.vertices()[c[i].vertex] - scene.vertices()[c[(i + 1) % c.size()].vertex]).norm();
      const double reach = std::min(tolerance * largest, most_turn * area / outline);
      const double off = distance_from(plane_of(scene, groups[f].leader), figure, patches[f]);
      EXPECT_EQ(groups[groups[f].leader].leader, groups[f].leader);
      EXPECT_TRUE(groups[f].leader == f || off <= reach * (1 + 1e-9) + 1e-15)
          << "seed " << seed << ", face " << f;
      if (groups[f].leader != f || 8 * 0x1p-53 * outline > 1e-6 * area / outline) continue;
      // a leader, though a larger one would have taken it?
      for (std::uint32_t g = 0; g < patches.size(); ++g) {
        if (groups[g].leader != g ||
            scene.faces()[scene.facets()[g].face].area <= area * (1 + 1e-9))
          continue;
        const auto d = scene.corners_of(scene.facets()[g]);
        double round = 0;
        for (std::size_t i = 0; i < d.size(); ++i)
          round += (scene.vertices()[d[i].vertex] - scene.vertices()[d[(i + 1) % d.size()].vertex])
                       .norm();
        // splinters do not lead
        if (8 * 0x1p-53 * round > 0.9e-6 * scene.faces()[scene.facets()[g].face].area / round)
          continue;
        EXPECT_GT(distance_from(plane_of(scene, g), figure, patches[f]), reach * (1 - 1e-9) - 1e-15)
            << "seed " << seed << ", faces " << f << ", " << g;
      }
    }
  }
}

TEST(Coplanar, MotionsChangeNothing) {
  // with a concave face an object goes through all checks of the mesh import again
  for (const bool concave : {false, true}) {
    Random random(11);
    Mesh mesh = turned(brick_cube(8), random_turn(random), {0.5, 0.25, 0.125});
    append(mesh, rectangle({3, 0, 0}, {1, 0, 0}, {0, 1, 0}));
    append(mesh, rectangle({4, 0, 9e-13}, {1, 0, 0}, {0, 1, 0}));  // near the limit
    if (concave) {
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (const Vec3& v : {Vec3(6, 0, 0), Vec3(9, 0, 0), Vec3(9, 3, 0), Vec3(8, 1, 0)})
        mesh.vertices.push_back(v);
      mesh.add_face({first, first + 1, first + 2, first + 3});
    }
    Scene scene = scene_of(mesh);
    ASSERT_EQ(scene.issues().size(), 0u);
    const std::vector<std::uint32_t> before = plane_indices(scene);
    EXPECT_EQ(scene.facets()[before.size() - (concave ? 3 : 1)].plane,
              scene.facets()[before.size() - (concave ? 4 : 2)].plane);
    const std::uint32_t aligned = scene.objects()[0].aligned;
    Pose pose = Pose::Identity();
    for (unsigned k = 0; k < 1000; ++k) {
      pose = Eigen::Translation3d(random.in_cube(-1, 1)) * Pose(random_turn(random)) * pose;
      ASSERT_EQ(scene.set_pose(scene.object_id(0), pose), Status::ok);
      ASSERT_EQ(plane_indices(scene), before) << "motion " << k;
      if (k % 50 == 0) expect_flat(scene);
      for (const Plane& p : scene.planes()) ASSERT_LT(p.flatness, 2e-12) << "motion " << k;
    }
    ASSERT_EQ(scene.set_pose(scene.object_id(0), Pose::Identity()), Status::ok);
    const Scene fresh = scene_of(mesh);
    EXPECT_EQ(plane_indices(fresh), before);
    EXPECT_EQ(scene.objects()[0].aligned, aligned);
    for (std::size_t p = 0; p < fresh.planes().size(); ++p)
      EXPECT_TRUE(one_plane(fresh.planes()[p], scene.planes()[p])) << p;
  }
}

TEST(Coplanar, FrontAndBackStayOnePlane) {
  Random random(19);
  Mesh mesh = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  append(mesh, rectangle({0.1, 0.2, 0}, {0, 0.7, 0}, {0.3, 0, 0}));
  Scene scene = scene_of(turned(mesh, random_turn(random), {1, 2, 3}));
  for (unsigned k = 0; k < 100; ++k) {
    ASSERT_EQ(scene.set_pose(scene.object_id(0), Pose(random_turn(random))), Status::ok);
    ASSERT_EQ(scene.planes().size(), 2u);
    ASSERT_TRUE(one_plane(scene.planes()[0], scene.planes()[1])) << "motion " << k;
    expect_flat(scene);
  }
}

TEST(Coplanar, DeformingDecidesAgain) {
  Random random(13);
  const Mesh flat = turned(bricks({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 4), random_turn(random));
  Scene scene = scene_of(flat);
  const ObjectId id = scene.object_id(0);
  EXPECT_EQ(count_planes(scene), 1u);
  Mesh bent = flat;
  // the first brick's
  for (std::size_t i = 0; i < 4; ++i) bent.vertices[i] += 1e-6 * plane_of(scene, 0).normal;
  ASSERT_EQ(scene.set_vertices(id, bent.vertices), Status::ok);
  EXPECT_EQ(count_planes(scene), 2u);
  Pose pose = Pose(random_turn(random));
  ASSERT_EQ(scene.set_pose(id, pose), Status::ok);
  EXPECT_EQ(count_planes(scene), 2u);
  ASSERT_EQ(scene.set_vertices(id, flat.vertices), Status::ok);
  EXPECT_EQ(count_planes(scene), 1u);
}

TEST(Coplanar, PartsOfAFoldedFaceKeepTheirs) {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0.01}, {1, 1, 0}, {0, 1, 0.01}};
  mesh.add_face({0, 1, 2, 3});
  const Scene scene = scene_of(mesh);
  EXPECT_EQ(scene.facets().size(), 2u);
  EXPECT_EQ(count_planes(scene), 2u);
}

}  // namespace
}  // namespace shadowcut::testing
