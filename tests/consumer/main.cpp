// Casts one shadow with the installed library: a unit square halfway up to the light takes four
// from the ground.
#include <cmath>
#include <cstdio>
#include <shadowcut/shadows.hpp>

int main() {
  using namespace shadowcut;
  Mesh ground, sheet;
  ground.vertices = {{-4, -4, 0}, {4, -4, 0}, {4, 4, 0}, {-4, 4, 0}};
  ground.add_face({0, 1, 2, 3});
  sheet.vertices = {{-0.5, -0.5, 1}, {0.5, -0.5, 1}, {0.5, 0.5, 1}, {-0.5, 0.5, 1}};
  sheet.add_face({0, 1, 2, 3});
  Scene scene;
  scene.add(ground, {});
  scene.add(sheet, {});
  const Shadows shadows = cast_shadows(scene, Light::point({0, 0, 2}));
  std::printf("shadowed: %.12g of %.12g\n", shadows.areas[0].shadowed, shadows.areas[0].area);
  return std::abs(shadows.areas[0].shadowed - 4) < 1e-12 ? 0 : 1;
}
