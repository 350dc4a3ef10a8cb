/* See c_checks.h. */
#include "c_checks.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int failures = 0;
const char* context = "";

void check(int holds, const char* what, const char* file, int line) {
  const char* slash = strrchr(file, '/');
  if (holds) return;
  printf("%s:%d: %s: failed: %s (last message: %s)\n", slash ? slash + 1 : file, line, context,
         what, shadowcut_message());
  if (++failures > 20) exit(1);
}

uint64_t random_state;
static uint64_t next_random(void) {
  uint64_t z = (random_state += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}
uint32_t below(uint32_t n) { return (uint32_t)(next_random() % n); }
double between(double lo, double hi) {
  return lo + (hi - lo) * (double)(next_random() >> 11) / 9007199254740992.0;
}

void* room_for(size_t count, size_t size) {
  void* room = calloc(count > 0 ? count : 1, size);
  if (!room) exit(2);
  return room;
}

shadowcut_mesh* square(double side, double z) {
  const double h = side / 2;
  const double xyz[12] = {-h, -h, z, h, -h, z, h, h, z, -h, h, z};
  const uint32_t corners[4] = {0, 1, 2, 3};
  shadowcut_mesh* mesh = NULL;
  OK(shadowcut_mesh_create(&mesh));
  OK(shadowcut_mesh_set_vertices(mesh, xyz, 4));
  OK(shadowcut_mesh_add_face(mesh, corners, 4));
  return mesh;
}

shadowcut_object_id add_square(shadowcut_scene* scene, double side, double z, const char* name) {
  shadowcut_object_settings settings;
  shadowcut_object_id id = {0, 0, 0};
  shadowcut_mesh* mesh = square(side, z);
  OK(shadowcut_object_settings_init(&settings));
  settings.name = name;
  OK(shadowcut_scene_add_object(scene, mesh, &settings, &id));
  shadowcut_mesh_destroy(mesh);
  return id;
}

shadowcut_light point_light(double x, double y, double z) {
  shadowcut_light light;
  OK(shadowcut_light_init(&light));
  light.position[0] = x, light.position[1] = y, light.position[2] = z;
  return light;
}

struct Small small_scene(void) {
  struct Small s;
  const shadowcut_light light = point_light(0, 0, 2);
  memset(&s, 0, sizeof s);
  OK(shadowcut_scene_create(&s.scene));
  s.ground = add_square(s.scene, 8, 0, "ground");
  s.sheet = add_square(s.scene, 1, 1, "sheet");
  OK(shadowcut_scene_add_light(s.scene, &light, &s.light));
  return s;
}

void pose_at(double* pose, double x, double y, double z) {
  memset(pose, 0, 16 * sizeof *pose);
  pose[0] = pose[5] = pose[10] = pose[15] = 1;
  pose[3] = x, pose[7] = y, pose[11] = z;
}

double shadowed_area(const shadowcut_shadows* shadows, uint32_t face) {
  shadowcut_face_area area = {0, 0, 0, 0, 0};
  OK(shadowcut_shadows_areas(shadows, face, 1, &area));
  return area.shadowed;
}

double fan_area(const double* xyz, uint32_t count) {
  double sum[3] = {0, 0, 0};
  uint32_t i;
  for (i = 2; i < count; ++i) {
    double u[3], v[3];
    int k;
    for (k = 0; k < 3; ++k)
      u[k] = xyz[3 * (i - 1) + (uint32_t)k] - xyz[k], v[k] = xyz[3 * i + (uint32_t)k] - xyz[k];
    for (k = 0; k < 3; ++k)
      sum[k] += u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
  }
  return sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]) / 2;
}
