/* Casts one shadow with the installed C library: a unit square halfway up to the light takes four
 * from the ground. */
#include <shadowcut/c.h>
#include <stdio.h>

static int add_square(shadowcut_scene* scene, double side, double height) {
  const double h = side / 2, xyz[12] = {-h, -h, height, h, -h, height, h, h, height, -h, h, height};
  const uint32_t corners[4] = {0, 1, 2, 3};
  shadowcut_mesh* mesh = NULL;
  shadowcut_object_id id;
  const int good = shadowcut_mesh_create(&mesh) == SHADOWCUT_OK &&
                   shadowcut_mesh_set_vertices(mesh, xyz, 4) == SHADOWCUT_OK &&
                   shadowcut_mesh_add_face(mesh, corners, 4) == SHADOWCUT_OK &&
                   shadowcut_scene_add_object(scene, mesh, NULL, &id) == SHADOWCUT_OK;
  shadowcut_mesh_destroy(mesh);
  return good;
}

int main(void) {
  shadowcut_scene* scene = NULL;
  shadowcut_shadows* shadows = NULL;
  shadowcut_light light;
  shadowcut_face_area area = {0, 0, 0, 0, 0};
  int good = shadowcut_scene_create(&scene) == SHADOWCUT_OK && add_square(scene, 8, 0) &&
             add_square(scene, 1, 1) && shadowcut_light_init(&light) == SHADOWCUT_OK;
  light.position[2] = 2;
  good = good && shadowcut_cast_shadows(scene, &light, NULL, &shadows) == SHADOWCUT_OK &&
         shadowcut_shadows_areas(shadows, 0, 1, &area) == SHADOWCUT_OK;
  printf("shadowed: %.12g of %.12g\n", area.shadowed, area.area);
  shadowcut_shadows_destroy(shadows);
  shadowcut_scene_destroy(scene);
  return good && area.shadowed > 4 - 1e-12 && area.shadowed < 4 + 1e-12 ? 0 : 1;
}
