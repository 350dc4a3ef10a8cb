// The papers' scenes, drawn by every technique, against one ray for every pixel.
#include <gtest/gtest.h>

#include <cstdlib>

#include "ray_picture.hpp"
#include "technique.hpp"

namespace shadowcut::testing {
namespace {

// Above a place on the ground, on its way to the light.
Vec3 raised(const Scene& scene, const Vec3& place) {
  return place + 0.1 * (scene.lights()[0].position - place);
}

bool on_ground(const Scene& scene, const Pixel& pixel) {
  return pixel.facet != invalid_index &&
         scene.faces()[scene.facets()[pixel.facet].face].object == 0;
}

// Within a shadow that is seen on the ground, as far from its edge as there is any.
Vec3 some_place_in_shadow(const Scene& scene, const RayPicture& seen) {
  for (const int reach : {8, 4, 2, 1}) {
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const Pixel& pixel = seen.at(x, y);
        if (on_ground(scene, pixel) && !pixel.lit[0] && !seen.at_an_edge(x, y, reach) &&
            seen.in_shadow(raised(scene, pixel.place)))
          return raised(scene, pixel.place);
      }
  }
  throw Error("no shadow is seen");
}

// On the boundary of a shadow's volume.
Vec3 some_place_at_an_edge(const Scene& scene, const RayPicture& seen) {
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x + 1 < kWidth; ++x) {
      if (!on_ground(scene, seen.at(x, y)) || !on_ground(scene, seen.at(x + 1, y))) continue;
      Vec3 a = raised(scene, seen.at(x, y).place), b = raised(scene, seen.at(x + 1, y).place);
      const bool dark = seen.in_shadow(a);
      if (dark == seen.in_shadow(b)) continue;
      for (int k = 0; k < 50; ++k) {
        const Vec3 middle = (a + b) / 2;
        (seen.in_shadow(middle) == dark ? a : b) = middle;
      }
      return a;
    }
  throw Error("no shadow is seen");
}

// The papers' scenes, each from three cameras: out of all shadow; in a shadow's volume; and with a
// volume's side across the near plane's window. The last two are where standard and Kolic are wrong
// (below).
void paper_scene(const std::string& name, const Camera& outside) {
  const Scene scene = scenes::build(scenes::named(name));
  const RayPicture rays(scene, outside);
  ASSERT_FALSE(rays.in_shadow(outside.eye));
  const Vec3 within = some_place_in_shadow(scene, rays), edge = some_place_at_an_edge(scene, rays);
  need_context();
  const double near = render::Model(scene).frame(outside, kWidth, kHeight).near;
  const std::vector<std::pair<std::string, Camera>> cameras{
      {"outside", outside},
      {"in a volume", looking(within, outside.target)},
      {"near plane cuts",
       looking(edge - near * (outside.target - edge).normalized(), outside.target)}};
  for (const auto& [where, camera] : cameras) {
    const RayPicture here(scene, camera);
    if (where == "in a volume") {
      EXPECT_TRUE(here.in_shadow(camera.eye));
    }
    for (const std::string& technique : render::technique_names()) {
      const bool from_light_only = technique == "stencil-standard" || technique == "stencil-kolic";
      if (from_light_only && where != "outside") continue;
      const Difference d =
          difference(picture_of(scene, technique, camera), here, has_texels(technique));
      EXPECT_EQ(d.pixels, 0) << name << ", " << where << ", " << technique << ": " << d.pixels
                             << " of " << d.covered << " pixels differ; " << d.first;
    }
  }
}

TEST(Render, PaperSceneSphere) { paper_scene("sphere256", looking({3.6, -4.4, 3.6}, {0, 0, 0.5})); }
TEST(Render, PaperSceneSolids) { paper_scene("solids96", looking({3.6, -4.4, 3.6}, {0, 0, 0.5})); }
TEST(Render, PaperSceneTetrahedra1) {
  paper_scene("tetrahedra752:1", looking({1.6, -2, 1.6}, {0, 0, 0.2}));
}
TEST(Render, PaperSceneTetrahedra2) {
  paper_scene("tetrahedra752:2", looking({0.9, -1.1, 1.8}, {0, 0, 1.1}));
}
TEST(Render, PaperSceneCubes) { paper_scene("cubes1502", looking({6, -6.4, 5.6}, {0, 0, 1.5})); }
TEST(Render, PaperSceneBranch) {
  paper_scene("branch2878", looking({2.2, -2.4, 2.6}, {0, 0, 0.9}));
}
TEST(Render, PaperSceneFiveSpheres) {
  paper_scene("spheres2037:5", looking({5, -3, 4}, {2, 1.7, 1.2}));
}
// All of their spheres take minutes.
void in_a_soak(const std::string& name, const Camera& outside) {
  if (std::getenv("SHADOWCUT_SOAK") == nullptr) GTEST_SKIP() << "runs where SHADOWCUT_SOAK is set";
  paper_scene(name, outside);
}
TEST(Render, PaperScene100Spheres) {
  in_a_soak("spheres2037:100", looking({13, -4, 9}, {5, 4, 3}));
}
TEST(Render, PaperScene300Spheres) {
  in_a_soak("spheres2037:300", looking({19, -5, 12}, {7, 6, 4}));
}

}  // namespace
}  // namespace shadowcut::testing
