// See c_support.h.
#include "c_support.h"

#include <cstdio>
#include <cstdlib>
#include <shadowcut/shadows.hpp>

#include "failing_new.hpp"
#include "scenes.hpp"

namespace {

void expect_ok(shadowcut_status status) {
  if (status == SHADOWCUT_OK) return;
  std::fprintf(stderr, "support: %s\n", shadowcut_message());
  std::abort();
}

const shadowcut::Vec3 sun_direction(0.3, -0.45, -1);

shadowcut_object_id enter(shadowcut_scene* scene, const shadowcut::Mesh& mesh,
                          const shadowcut::ObjectSettings& as) {
  shadowcut_mesh* m = nullptr;
  expect_ok(shadowcut_mesh_create(&m));
  expect_ok(shadowcut_mesh_set_vertices(m, mesh.vertices.front().data(),
                                        static_cast<std::int32_t>(mesh.vertices.size())));
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    for (std::size_t k = 0; k < mesh.loop_count(f); ++k) {
      const auto loop = mesh.loop(f, k);
      expect_ok((k == 0 ? shadowcut_mesh_add_face : shadowcut_mesh_add_hole)(
          m, loop.data(), static_cast<std::int32_t>(loop.size())));
    }
  }
  shadowcut_object_settings settings;
  expect_ok(shadowcut_object_settings_init(&settings));
  settings.name = as.name.c_str();
  settings.sides = static_cast<std::int32_t>(as.sides);
  settings.casts_shadows = as.casts_shadows, settings.receives_shadows = as.receives_shadows,
  settings.dynamic = as.dynamic;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) settings.pose[4 * r + c] = as.pose.matrix()(r, c);
  shadowcut_object_id id;
  expect_ok(shadowcut_scene_add_object(scene, m, &settings, &id));
  shadowcut_mesh_destroy(m);
  return id;
}

}  // namespace

uint32_t support_scene(const char* name, int sun, shadowcut_scene* scene,
                       shadowcut_object_id* ids) {
  const shadowcut::scenes::SceneData data = shadowcut::scenes::named(name);
  std::uint32_t count = 0;
  for (const auto& [mesh, settings] : data.objects) ids[count++] = enter(scene, mesh, settings);
  shadowcut_light light;
  shadowcut_light_id id;
  expect_ok(shadowcut_light_init(&light));
  for (int k = 0; k < 3; ++k) light.position[k] = data.light.position[k];
  expect_ok(shadowcut_scene_add_light(scene, &light, &id));
  if (!sun) return count;
  light.kind = SHADOWCUT_DIRECTIONAL;
  for (int k = 0; k < 3; ++k) light.direction[k] = sun_direction[k];
  expect_ok(shadowcut_scene_add_light(scene, &light, &id));
  return count;
}

uint32_t support_areas(const char* name, uint32_t light, int32_t kernel, double* lit,
                       double* shadowed, uint32_t* fragments) {
  using namespace shadowcut;
  const scenes::SceneData data = scenes::named(name);
  Scene scene;
  for (const auto& [mesh, settings] : data.objects) scene.add(mesh, settings);
  Options options;
  options.kernel = static_cast<Kernel>(kernel);
  const Shadows shadows =
      cast_shadows(scene, light == 0 ? data.light : Light::directional(sun_direction), options);
  *fragments = 0;
  for (const Block& block : shadows.blocks)
    *fragments += static_cast<std::uint32_t>(block.fragments.size());
  for (std::size_t f = 0; f < shadows.areas.size(); ++f)
    lit[f] = shadows.areas[f].lit, shadowed[f] = shadows.areas[f].shadowed;
  return static_cast<std::uint32_t>(shadows.areas.size());
}

int support_fail_allocation(int64_t n) {
  using namespace shadowcut::testing;
  return allocations_left.exchange(n < 0 ? never : n) < 0 ? 1 : 0;
}
