// What of the walkthrough needs no window: walking, picking, dragging, and the way back.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "arrangement.hpp"
#include "pick.hpp"
#include "scenes.hpp"
#include "walk.hpp"
#include "walkthrough.hpp"

namespace shadowcut::view {
namespace {

using scenes::Random;

constexpr double kPi = std::numbers::pi;

void expect_near(const Vec3& a, const Vec3& b, double tolerance, const std::string& what = "") {
  EXPECT_LT((a - b).norm(), tolerance)
      << a.transpose() << " is not " << b.transpose() << " " << what;
}

render::Camera camera(const Vec3& eye, const Vec3& target) { return {eye, target}; }

render::Camera random_camera(Random& random, const Eigen::AlignedBox3d& box) {
  const auto within = [&]() -> Vec3 {
    return box.min() + Vec3(random.in(0.05, 0.95), random.in(0.05, 0.95), random.in(0.05, 0.95))
                           .cwiseProduct(box.sizes());
  };
  render::Camera camera{within(), within()};
  camera.fov = random.in(0.3, 2);
  return camera;
}

Screen screen_of(const render::Camera& camera) { return {camera, 320, 240, 0.01}; }

std::uint32_t index_of(const Scene& scene, const std::string& name) {
  for (std::uint32_t k = 0; k < scene.objects().size(); ++k)
    if (scene.objects()[k].name == name) return k;
  ADD_FAILURE() << name;
  return invalid_index;
}

// Moeller and Trumbore's test of a ray against a triangle: another way than pick_facet's.
double ray_meets_triangle(const Ray& ray, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 u = b - a, v = c - a, p = ray.along.cross(v), s = ray.from - a, q = s.cross(u);
  const double det = u.dot(p), bu = s.dot(p) / det, bv = ray.along.dot(q) / det;
  return bu >= 0 && bv >= 0 && bu + bv <= 1 ? v.dot(q) / det
                                            : std::numeric_limits<double>::infinity();
}

double nearest_triangle(const Scene& scene, const Ray& ray, double near) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Facet& facet : scene.facets()) {
    const auto corners = scene.corners_of(facet);
    for (std::size_t i = 2; i < corners.size(); ++i) {
      const double t = ray_meets_triangle(ray, scene.vertices()[corners[0].vertex],
                                          scene.vertices()[corners[i - 1].vertex],
                                          scene.vertices()[corners[i].vertex]);
      if (t >= near) nearest = std::min(nearest, t);
    }
  }
  return nearest;
}

TEST(Walking, GoesWhereTheEyeLooksButAlongTheFloor) {
  Walker walker(camera({1, 2, 3}, {2, 2, 2.5}), 2);
  walker.walk({.forward = 1}, 0.5);
  expect_near(walker.camera().eye, {2, 2, 3}, 1e-12);
  walker.walk({.right = 1}, 0.5);
  expect_near(walker.camera().eye, {2, 1, 3}, 1e-12);
  walker.walk({.forward = -1, .up = 1, .run = true}, 0.5);
  expect_near(walker.camera().eye, Vec3(2, 1, 3) + 4 / std::sqrt(2) * Vec3(-1, 0, 1), 1e-12,
              "running, at a slant no faster");
  const Vec3 ahead = walker.camera().target - walker.camera().eye;
  expect_near(ahead, {1, 0, -0.5}, 1e-12, "still looking there");
}

TEST(Walking, TheFirstCameraIsTheOneGiven) {
  for (const Vec3& target : {Vec3(5, 4, 0.3), Vec3(1, 2, -7), Vec3(1, 2, 9)}) {
    const render::Camera given = camera({1, 2, 3}, target);
    EXPECT_EQ(Walker(given, 1).camera().view().matrix(), given.view().matrix());
  }
}

TEST(Walking, TurnsStopBeforeStraightUpAndDown) {
  Walker walker(camera({0, 0, 0}, {1, 0, 0}), 1);
  walker.turn(kPi / 2, 0);
  expect_near(walker.camera().target, {0, -1, 0}, 1e-12);
  for (int k = 0; k < 10; ++k) walker.turn(0, 1);
  EXPECT_NEAR(walker.camera().target.z(), std::sin(89 * kPi / 180), 1e-12);
  for (int k = 0; k < 10; ++k) walker.turn(0, -1);
  EXPECT_NEAR(walker.camera().target.z(), -std::sin(89 * kPi / 180), 1e-12);
  walker.turn(-kPi / 2, 89 * kPi / 180);
  expect_near(walker.camera().target, {1, 0, 0}, 1e-12);
}

TEST(Walking, DependsOnTheTimeAndNotOnTheFrames) {
  Random random(7);
  for (int round = 0; round < 50; ++round) {
    const auto axis = [&] { return static_cast<double>(random.below(3)) - 1; };
    const Steps steps{axis(), axis(), axis(), axis(), 0, random.below(2) == 0};
    Walker once(camera({1, 2, 3}, {4, 3, 2}), 1.7), often = once;
    once.walk(steps, 2);
    for (double left = 2; left > 0;) {
      const double frame = std::min(left, random.in(0.001, 0.2));
      often.walk(steps, frame);
      left -= frame;
    }
    expect_near(once.camera().eye, often.camera().eye, 1e-9, "round " + std::to_string(round));
    expect_near(once.camera().target, often.camera().target, 1e-9,
                "round " + std::to_string(round));
  }
}

TEST(Walking, StartsInsideOfARoomAndOutsideOfWhatIsNone) {
  const Scene room = scenes::build(scenes::furnished_room()),
              tower = scenes::build(scenes::tetrahedron(2));
  EXPECT_TRUE(is_room(room));
  EXPECT_TRUE(box_of(room).contains(first_camera(room).eye));
  EXPECT_TRUE(box_of(room).contains(light_for(room).position));
  EXPECT_FALSE(is_room(tower));
  EXPECT_FALSE(box_of(tower).contains(first_camera(tower).eye));
  EXPECT_FALSE(box_of(tower).contains(light_for(tower).position));
  EXPECT_NEAR(light_for(tower).position.x(), box_of(tower).center().x(), 1e-12);
}

TEST(Picking, ARayGoesThroughThePixelThatItsPointsAreDrawnAt) {
  Random random(11);
  const Eigen::AlignedBox3d box(Vec3(-3, -2, 0), Vec3(4, 5, 3));
  for (int round = 0; round < 1000; ++round) {
    const Screen screen = screen_of(random_camera(random, box));
    const Eigen::Vector2d pixel(random.in(0, 320), random.in(0, 240));
    const Ray ray = screen.ray(pixel);
    const auto back = screen.pixel(ray.from + random.in(0.02, 50) * ray.along);
    ASSERT_TRUE(back) << round;
    EXPECT_LT((*back - pixel).norm(), 1e-8) << round;
    EXPECT_FALSE(screen.pixel(ray.from - ray.along)) << round;
  }
}

TEST(Picking, LinesEndAtTheNearPlane) {
  const Screen screen = screen_of(camera({0, 0, 0}, {1, 0, 0}));
  EXPECT_FALSE(screen.line({-1, 0, 0}, {0.005, 1, 0}));
  const auto line = screen.line({-1, 0, 0}, {1, 0.1, 0});
  ASSERT_TRUE(line);
  EXPECT_LT((line->second - *screen.pixel({1, 0.1, 0})).norm(), 1e-9);
  EXPECT_TRUE(line->first.allFinite());
}

TEST(Picking, FindsTheNearestFacetAsABruteRayDoes) {
  for (const std::string name : {"furnished_room", "branch:2", "triangles:200", "spheres:3,8,5"}) {
    const Scene scene = scenes::build(scenes::named(name));
    Random random(13);
    int hits = 0;
    for (int round = 0; round < 1000; ++round) {
      const Screen screen = screen_of(random_camera(random, box_of(scene)));
      const Eigen::Vector2d pixel(random.in(0, 320), random.in(0, 240));
      const Ray ray = screen.ray(pixel);
      const double expected = nearest_triangle(scene, ray, screen.near);
      const auto hit = pick_facet(scene, screen, pixel);
      ASSERT_EQ(hit.has_value(), std::isfinite(expected)) << name << " " << round;
      if (!hit) continue;
      ++hits;
      expect_near(hit->at, ray.from + expected * ray.along, 1e-9 * (1 + expected),
                  name + " " + std::to_string(round));
      EXPECT_EQ(scene.faces()[scene.facets()[hit->facet].face].object, hit->index);
    }
    EXPECT_GT(hits, 100) << name;
  }
}

TEST(Picking, LightsComeFirstAndWithinTheirMarkers) {
  Scene scene = scenes::build(scenes::room(1));
  const LightId sun = scene.add(Light::directional({0.2, 0.3, -1}));
  const Eigen::AlignedBox3d box = box_of(scene);
  const Light lamp = scene.lights()[0];
  const Screen screen = screen_of(camera({0.5, 1.5, 1}, lamp.position + Vec3(0, 0.1, -0.2)));
  const Eigen::Vector2d marker = *screen.pixel(lamp.position);
  const auto on = pick(scene, screen, marker + Eigen::Vector2d(5, 6), 9, box);
  ASSERT_TRUE(on);
  EXPECT_TRUE(on->is_light);
  EXPECT_EQ(on->index, 0u);
  EXPECT_EQ(on->at, lamp.position);
  const auto beside = pick(scene, screen, marker + Eigen::Vector2d(8, 8), 9, box);
  ASSERT_TRUE(beside);
  EXPECT_FALSE(beside->is_light);

  const Vec3 above = marker_of(scene.lights()[sun.index], box);
  EXPECT_FALSE(box.contains(above));
  const Light turned = moved_to(scene.lights()[sun.index], above + Vec3(1, 0, 0), box);
  expect_near(marker_of(turned, box) - box.center(),
              0.75 * box.diagonal().norm() * (above + Vec3(1, 0, 0) - box.center()).normalized(),
              1e-9);
  EXPECT_EQ(scene.remove(sun), Status::ok);
  EXPECT_TRUE(pick(scene, screen, marker, 9, box)->is_light)
      << "a light that is gone is not picked";
}

TEST(Dragging, KeepsTheGrabbedPointUnderTheCursor) {
  Random random(17);
  const Eigen::AlignedBox3d box(Vec3(0, 0, 0), Vec3(10, 7, 2.7));
  int moved = 0;
  for (int round = 0; round < 2000; ++round) {
    const Screen screen = screen_of(random_camera(random, box));
    const Ray grab = screen.ray({random.in(0, 320), random.in(0, 240)});
    const Vec3 held = grab.from + random.in(0.5, 8) * grab.along;
    const bool upright = random.below(2) == 0;
    const Eigen::Vector2d cursor(random.in(0, 320), random.in(0, 240));
    const Vec3 now = dragged(held, screen.ray(cursor), screen.camera, upright, 30);
    if (now == held) continue;
    ++moved;
    EXPECT_LT((*screen.pixel(now) - cursor).norm(), 1e-6) << round;
    EXPECT_LE((now - screen.camera.eye).norm(), 30) << round;
    if (upright) {
      const Vec3 right = screen.camera.view().linear().row(0);
      EXPECT_NEAR(right.cross(Vec3::UnitZ()).dot(now - held), 0, 1e-9) << round;
    } else {
      EXPECT_NEAR(now.z(), held.z(), 1e-9) << round;
    }
  }
  EXPECT_GT(moved, 500);
}

TEST(Dragging, StaysWhereTheCursorLeavesThePlane) {
  const render::Camera level = camera({0, 0, 1}, {1, 0, 1});
  const Vec3 held(3, 0, 0.5);
  EXPECT_EQ(dragged(held, {level.eye, {1, 0, 0.2}}, level, false, 100), held)
      << "above the horizon";
  EXPECT_EQ(dragged(held, {level.eye, {1, 0, -0.001}}, level, false, 100), held)
      << "almost along the plane";
  EXPECT_EQ(dragged(held, {level.eye, {1, 0, -0.03}}, level, false, 10), held) << "too far away";
  expect_near(dragged(held, {level.eye, {1, 0, -0.03}}, level, false, 100), {0.5 / 0.03, 0, 0.5},
              1e-9);
  expect_near(dragged(held, {level.eye, {1, 0, 0.2}}, level, true, 100), {3, 0, 1.6}, 1e-9);
}

TEST(Dragging, TheShellHoldsFast) {
  const Scene scene = scenes::build(scenes::furnished_room());
  const Eigen::AlignedBox3d all = box_of(scene);
  const Vec3 eye(5, 3, 1.7);
  for (std::uint32_t k = 0; k < scene.objects().size(); ++k)
    EXPECT_EQ(is_draggable(scene, k, all, eye), scene.objects()[k].name != "room")
        << scene.objects()[k].name;
  const std::uint32_t desk = index_of(scene, "desk.1");
  Vec3 within = Vec3::Zero();
  for (std::uint32_t v = 0; v < scene.objects()[desk].vertex_count; ++v)
    within += scene.vertices()[scene.objects()[desk].first_vertex + v] /
              scene.objects()[desk].vertex_count;
  EXPECT_FALSE(is_draggable(scene, desk, all, within)) << "the eye is in it";

  // A floor and a wall of their own, and a thing on the floor.
  Scene parts;
  const auto add = [&](const char* name, Mesh mesh) {
    return parts.add(mesh, {.name = name}).index;
  };
  const std::uint32_t floor = add("floor", scenes::rectangle({0, 0, 0}, {9, 0, 0}, {0, 8, 0}));
  const std::uint32_t wall = add("wall", scenes::rectangle({0, 0, 0}, {0, 8, 0}, {0, 0, 3}));
  const std::uint32_t thing = add("thing", scenes::box({3, 3, 0}, {4, 7, 1}));
  EXPECT_FALSE(is_draggable(parts, floor, box_of(parts), eye));
  EXPECT_FALSE(is_draggable(parts, wall, box_of(parts), eye));
  EXPECT_TRUE(is_draggable(parts, thing, box_of(parts), {1, 1, 1}));

  Scene alone;
  alone.add(scenes::box({0, 0, 0}, {1, 1, 1}), {.name = "box"});
  EXPECT_TRUE(is_draggable(alone, 0, box_of(alone), {9, 9, 9})) << "what is alone is no shell";
}

TEST(Arranging, EverythingGoesBack) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Scene scene = scenes::build(scenes::room(2));
    scene.add(Light::directional({0.1, 0.2, -1}));
    const Scene first = scene;
    Arrangement arrangement(scene);
    Random random(seed);
    for (int step = 0; step < 60; ++step) {
      const auto object = static_cast<std::uint32_t>(random.below(scene.objects().size()));
      const auto light = static_cast<std::uint32_t>(random.below(scene.lights().size()));
      const bool has_object = scene.objects()[object].alive,
                 has_light = scene.light_id(light).index != invalid_index;
      switch (random.below(5)) {
        case 0:
          if (has_object)
            arrangement.set_pose(
                object, Eigen::Translation3d(random.in_ball(1)) * scene.objects()[object].pose);
          break;
        case 1:
          if (has_light)
            arrangement.set_light(
                light, moved_to(scene.lights()[light], random.in_ball(2), box_of(first)));
          break;
        case 2:
          if (has_object) arrangement.remove(false, object);
          break;
        case 3:
          if (has_light) arrangement.remove(true, light);
          break;
        default: {
          const bool none_away = arrangement.away() == 0;
          EXPECT_EQ(arrangement.bring_back().empty(), none_away) << "seed " << seed;
        }
      }
    }
    arrangement.reset();
    EXPECT_EQ(arrangement.away(), 0u);
    for (const Object& object : first.objects()) {
      const Object& now = scene.objects()[index_of(scene, object.name)];
      EXPECT_EQ(now.pose.matrix(), object.pose.matrix()) << object.name << " seed " << seed;
      ASSERT_EQ(now.vertex_count, object.vertex_count);
      for (std::uint32_t v = 0; v < now.vertex_count; ++v)
        EXPECT_EQ(scene.vertices()[now.first_vertex + v], first.vertices()[object.first_vertex + v])
            << object.name << " seed " << seed;
    }
    for (const Light& light : first.lights()) {
      EXPECT_TRUE(std::any_of(scene.lights().begin(), scene.lights().end(),
                              [&](const Light& l) {
                                return l.kind == light.kind && l.position == light.position &&
                                       l.direction == light.direction;
                              }))
          << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace shadowcut::view
