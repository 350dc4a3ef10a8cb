/* The C interface from a C program: every function, what it refuses, the C++ engine's areas to the last bit, buffers kept by changes
 * against buffers made anew, and what happens when memory runs out. A failure prints its line, and the seed where chance is in it. */
#include <math.h>
#include <shadowcut/c.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "c_support.h"

static int failures = 0;
static const char* context = "";

static void check(int holds, const char* what, int line) {
  if (holds) return;
  printf("c_test.c:%d: %s: failed: %s (last message: %s)\n", line, context, what,
         shadowcut_message());
  if (++failures > 20) exit(1);
}
#define CHECK(condition) check((condition) != 0, #condition, __LINE__)
#define OK(call) check((call) == SHADOWCUT_OK, #call, __LINE__)
#define STATUS(wanted, call) check((call) == (wanted), #call " is " #wanted, __LINE__)
#define INVALID(call) STATUS(SHADOWCUT_INVALID_ARGUMENT, call)

enum { most = 4096 }; /* objects, and faces, of any scene here */

/* Splitmix64. */
static uint64_t random_state;
static uint64_t next_random(void) {
  uint64_t z = (random_state += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}
static uint32_t below(uint32_t n) { return (uint32_t)(next_random() % n); }
static double between(double lo, double hi) {
  return lo + (hi - lo) * (double)(next_random() >> 11) / 9007199254740992.0;
}

static void* room_for(size_t count, size_t size) {
  void* room = calloc(count > 0 ? count : 1, size);
  if (!room) exit(2);
  return room;
}

/* ---- Small scenes ----------------------------------------------------------------------------------------------------------------- */

static shadowcut_mesh* square(double side, double z) {
  const double h = side / 2;
  const double xyz[12] = {-h, -h, z, h, -h, z, h, h, z, -h, h, z};
  const uint32_t corners[4] = {0, 1, 2, 3};
  shadowcut_mesh* mesh = NULL;
  OK(shadowcut_mesh_create(&mesh));
  OK(shadowcut_mesh_set_vertices(mesh, xyz, 4));
  OK(shadowcut_mesh_add_face(mesh, corners, 4));
  return mesh;
}

static shadowcut_object_id add_square(shadowcut_scene* scene, double side, double z,
                                      const char* name) {
  shadowcut_object_settings settings;
  shadowcut_object_id id = {0, 0, 0};
  shadowcut_mesh* mesh = square(side, z);
  OK(shadowcut_object_settings_init(&settings));
  settings.name = name;
  OK(shadowcut_scene_add_object(scene, mesh, &settings, &id));
  shadowcut_mesh_destroy(mesh);
  return id;
}

static shadowcut_light point_light(double x, double y, double z) {
  shadowcut_light light;
  OK(shadowcut_light_init(&light));
  light.at[0] = x, light.at[1] = y, light.at[2] = z;
  return light;
}

/* A unit square halfway up to the light takes four from a ground of 64. */
struct Small {
  shadowcut_scene* scene;
  shadowcut_object_id ground, sheet;
  shadowcut_light_id light;
};
static struct Small small_scene(void) {
  struct Small s;
  const shadowcut_light light = point_light(0, 0, 2);
  memset(&s, 0, sizeof s);
  OK(shadowcut_scene_create(&s.scene));
  s.ground = add_square(s.scene, 8, 0, "ground");
  s.sheet = add_square(s.scene, 1, 1, "sheet");
  OK(shadowcut_scene_add_light(s.scene, &light, &s.light));
  return s;
}

static void pose_at(double* pose, double x, double y, double z) {
  memset(pose, 0, 16 * sizeof *pose);
  pose[0] = pose[5] = pose[10] = pose[15] = 1;
  pose[3] = x, pose[7] = y, pose[11] = z;
}

static double shadowed_area(const shadowcut_shadows* shadows, uint32_t face) {
  shadowcut_face_area area = {0, 0, 0, 0, 0};
  OK(shadowcut_shadows_areas(shadows, face, 1, &area));
  return area.shadowed;
}

/* ---- Meshes, scenes --------------------------------------------------------------------------------------------------------------- */

static void test_meshes(void) {
  const double xyz[24] = {0, 0, 0, 4, 0, 0, 4, 4, 0, 0, 4, 0, 1, 1, 0, 3, 1, 0, 3, 3, 0, 1, 3, 0};
  const float flat[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const uint32_t outer[4] = {0, 1, 2, 3}, hole[4] = {4, 5, 6, 7}, faces[7] = {0, 1, 2, 0, 1, 2, 3};
  const int32_t counts[2] = {3, 4}, wrong[2] = {3, -4};
  const double* back = NULL;
  const uint32_t* loop = NULL;
  uint32_t n = 0;
  shadowcut_mesh* mesh = NULL;
  context = "meshes";
  INVALID(shadowcut_mesh_create(NULL));
  OK(shadowcut_mesh_create(&mesh));
  STATUS(SHADOWCUT_REFUSED, shadowcut_mesh_add_hole(mesh, hole, 4)); /* of no face */
  OK(shadowcut_mesh_set_vertices(mesh, xyz, 8));
  OK(shadowcut_mesh_add_face(mesh, outer, 4));
  OK(shadowcut_mesh_add_hole(mesh, hole, 4));
  OK(shadowcut_mesh_add_faces(mesh, faces, counts, 2));
  OK(shadowcut_mesh_add_faces(mesh, faces, NULL, 1));
  OK(shadowcut_mesh_add_faces(mesh, NULL, NULL, 0));
  OK(shadowcut_mesh_face_count(mesh, &n));
  CHECK(n == 4);
  OK(shadowcut_mesh_loop_count(mesh, 0, &n));
  CHECK(n == 2);
  OK(shadowcut_mesh_loop(mesh, 0, 1, &loop, &n));
  CHECK(n == 4 && loop[3] == 7);
  OK(shadowcut_mesh_loop(mesh, 2, 0, &loop, &n));
  CHECK(n == 4 && loop[0] == 0 && loop[3] == 3);
  OK(shadowcut_mesh_vertices(mesh, &back, &n));
  CHECK(n == 8 && back[23] == 0 && back[21] == 1);
  INVALID(shadowcut_mesh_loop(mesh, 0, 2, &loop, &n));
  INVALID(shadowcut_mesh_loop(mesh, 4, 0, &loop, &n));
  INVALID(shadowcut_mesh_loop(mesh, 0, 0, NULL, &n));
  INVALID(shadowcut_mesh_loop_count(mesh, 4, &n));
  INVALID(shadowcut_mesh_loop_count(NULL, 0, &n));
  INVALID(shadowcut_mesh_face_count(NULL, &n));
  INVALID(shadowcut_mesh_face_count(mesh, NULL));
  INVALID(shadowcut_mesh_vertices(NULL, &back, &n));
  INVALID(shadowcut_mesh_set_vertices(mesh, xyz, -1));
  INVALID(shadowcut_mesh_set_vertices(mesh, NULL, 8));
  INVALID(shadowcut_mesh_set_vertices(NULL, xyz, 8));
  INVALID(shadowcut_mesh_set_vertices_float(mesh, flat, -3));
  INVALID(shadowcut_mesh_add_face(mesh, outer, -4));
  INVALID(shadowcut_mesh_add_face(mesh, NULL, 4));
  INVALID(shadowcut_mesh_add_face(NULL, outer, 4));
  INVALID(shadowcut_mesh_add_hole(mesh, NULL, 4));
  INVALID(shadowcut_mesh_add_faces(mesh, faces, wrong, 2));
  INVALID(shadowcut_mesh_add_faces(mesh, faces, counts, -2));
  INVALID(shadowcut_mesh_add_faces(mesh, NULL, counts, 2));
  OK(shadowcut_mesh_face_count(mesh, &n));
  CHECK(n == 4);
  OK(shadowcut_mesh_set_vertices_float(mesh, flat, 3));
  OK(shadowcut_mesh_vertices(mesh, &back, &n));
  CHECK(n == 3 && back[7] == 1);
  shadowcut_mesh_destroy(mesh);
  shadowcut_mesh_destroy(NULL);
}

static void test_names(void) {
  context = "names";
  CHECK(strcmp(shadowcut_status_name(SHADOWCUT_OK), "OK") == 0);
  CHECK(strcmp(shadowcut_status_name(SHADOWCUT_INTERNAL_ERROR), "INTERNAL_ERROR") == 0);
  CHECK(strcmp(shadowcut_status_name(99), "") == 0 && strcmp(shadowcut_status_name(-1), "") == 0);
  CHECK(strlen(shadowcut_version()) >= 5);
  CHECK(strlen(shadowcut_describe(SHADOWCUT_NOT_FLAT)) > 0 &&
        strcmp(shadowcut_describe(8), "") == 0 && strcmp(shadowcut_describe(-1), "") == 0);
  CHECK(shadowcut_refuses(SHADOWCUT_DUPLICATE) == 1 && shadowcut_refuses(SHADOWCUT_NOT_FLAT) == 0 &&
        shadowcut_refuses(77) == 0);
  INVALID(shadowcut_mesh_create(NULL));
  CHECK(strlen(shadowcut_message()) > 0);
}

static void test_objects(void) {
  struct Small s = small_scene();
  shadowcut_scene* other = NULL;
  shadowcut_object_settings settings;
  shadowcut_object object;
  shadowcut_object_id id, twin;
  shadowcut_mesh* mesh = NULL;
  shadowcut_scene_counts counts;
  double pose[16], flatness = 0, coplanarity = 0;
  const double corners[12] = {-1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
  const float as_float[12] = {-1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
  const uint64_t start = 0;
  uint32_t changed[4], n = 0;
  context = "objects";

  OK(shadowcut_object_init(&object));
  OK(shadowcut_scene_object(s.scene, &s.sheet, &object));
  CHECK(strcmp(object.name, "sheet") == 0 && object.sides == SHADOWCUT_SIDES_OPEN &&
        object.face_count == 1 && object.pose[0] == 1);
  CHECK(object.casts == 1 && object.receives == 1 && object.moves == 0 &&
        object.vertex_count == 4 && object.edge_count == 4);
  OK(shadowcut_scene_object_id(s.scene, 1, &id));
  CHECK(memcmp(&id, &s.sheet, sizeof id) == 0);
  STATUS(SHADOWCUT_NOT_FOUND, shadowcut_scene_object_id(s.scene, 2, &id));

  OK(shadowcut_scene_counts_init(&counts));
  OK(shadowcut_scene_count(s.scene, &counts));
  CHECK(counts.objects == 2 && counts.lights == 1 && counts.faces == 2 && counts.facets == 2 &&
        counts.corners == 8 && counts.vertices == 8 && counts.edges == 8 && counts.planes == 2 &&
        counts.issues == 0);
  pose_at(pose, 0.5, 0, 0);
  OK(shadowcut_scene_set_pose(s.scene, &s.sheet, pose));
  OK(shadowcut_scene_changed_since(s.scene, &counts.revision, 4, changed, &n));
  CHECK(n == 1 && changed[0] == s.sheet.index);
  OK(shadowcut_scene_changed_since(s.scene, &start, 0, NULL, &n));
  CHECK(n == 2);
  INVALID(shadowcut_scene_changed_since(s.scene, &start, 4, NULL, &n));
  INVALID(shadowcut_scene_changed_since(s.scene, NULL, 4, changed, &n));
  pose[0] = 0;
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_set_pose(s.scene, &s.sheet, pose)); /* not invertible */
  pose[0] = NAN;
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_set_pose(s.scene, &s.sheet, pose));
  pose_at(pose, 0, 0, 0);
  pose[15] = 2;
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_set_pose(s.scene, &s.sheet, pose)); /* its last row */
  pose[15] = 1;
  INVALID(shadowcut_scene_set_pose(s.scene, &s.sheet, NULL));
  INVALID(shadowcut_scene_set_pose(s.scene, NULL, pose));
  INVALID(shadowcut_scene_set_pose(NULL, &s.sheet, pose));

  OK(shadowcut_scene_set_vertices(s.scene, &s.sheet, corners, 4));
  OK(shadowcut_scene_set_vertices_float(s.scene, &s.sheet, as_float, 4));
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_set_vertices(s.scene, &s.sheet, corners, 3));
  INVALID(shadowcut_scene_set_vertices(s.scene, &s.sheet, corners, -4));
  INVALID(shadowcut_scene_set_vertices_float(s.scene, &s.sheet, NULL, 4));
  OK(shadowcut_scene_set_casts(s.scene, &s.sheet, 0));
  OK(shadowcut_scene_set_receives(s.scene, &s.sheet, 0));
  INVALID(shadowcut_scene_set_casts(s.scene, &s.sheet, 2));
  INVALID(shadowcut_scene_set_receives(s.scene, &s.sheet, -1));

  /* Removed, and brought back as it was. */
  OK(shadowcut_object_settings_init(&settings));
  OK(shadowcut_scene_given(s.scene, &s.sheet, &mesh, &settings));
  CHECK(settings.casts == 0 && settings.receives == 0 && settings.pose[3] == 0.5 &&
        strcmp(settings.name, "sheet") == 0);
  settings.name = "back";
  OK(shadowcut_scene_remove_object(s.scene, &s.sheet));
  STATUS(SHADOWCUT_STALE, shadowcut_scene_remove_object(s.scene, &s.sheet));
  STATUS(SHADOWCUT_STALE, shadowcut_scene_object(s.scene, &s.sheet, &object));
  STATUS(SHADOWCUT_STALE, shadowcut_scene_given(s.scene, &s.sheet, &mesh, NULL));
  STATUS(SHADOWCUT_STALE, shadowcut_scene_set_casts(s.scene, &s.sheet, 1));
  STATUS(SHADOWCUT_STALE, shadowcut_scene_set_vertices(s.scene, &s.sheet, corners, 4));
  OK(shadowcut_scene_add_object(s.scene, mesh, &settings, &id));
  CHECK(id.index == s.sheet.index && id.generation != s.sheet.generation);
  STATUS(SHADOWCUT_STALE,
         shadowcut_scene_set_receives(s.scene, &s.sheet, 1)); /* its index is another's */
  OK(shadowcut_scene_object(s.scene, &id, &object));
  CHECK(strcmp(object.name, "back") == 0 && object.pose[3] == 0.5 && object.casts == 0);

  /* Another scene's ids; a copy's are the same. */
  OK(shadowcut_scene_create(&other));
  OK(shadowcut_scene_add_object(other, mesh, NULL, &twin));
  STATUS(SHADOWCUT_FOREIGN, shadowcut_scene_remove_object(s.scene, &twin));
  shadowcut_scene_destroy(other);
  OK(shadowcut_scene_copy(s.scene, &other));
  OK(shadowcut_scene_remove_object(other, &id));
  OK(shadowcut_scene_object(s.scene, &id, &object));
  shadowcut_scene_destroy(other);

  settings.sides = 3;
  INVALID(shadowcut_scene_add_object(s.scene, mesh, &settings, &id));
  settings.sides = SHADOWCUT_SIDES_CLOSED;
  settings.moves = 7;
  INVALID(shadowcut_scene_add_object(s.scene, mesh, &settings, &id));
  settings.moves = 1;
  settings.size -= 4;
  INVALID(shadowcut_scene_add_object(s.scene, mesh, &settings, &id));
  INVALID(shadowcut_scene_given(s.scene, &id, &mesh, &settings));
  INVALID(shadowcut_scene_add_object(s.scene, NULL, NULL, &id));
  INVALID(shadowcut_scene_add_object(s.scene, mesh, NULL, NULL));
  INVALID(shadowcut_scene_add_object(NULL, mesh, NULL, &id));
  object.size = 0;
  INVALID(shadowcut_scene_object(s.scene, &id, &object));
  counts.size = 1000000;
  INVALID(shadowcut_scene_count(s.scene, &counts));
  INVALID(shadowcut_object_settings_init(NULL));
  INVALID(shadowcut_object_init(NULL));
  INVALID(shadowcut_scene_counts_init(NULL));
  INVALID(shadowcut_scene_create(NULL));
  INVALID(shadowcut_scene_copy(NULL, &other));
  INVALID(shadowcut_scene_object_id(NULL, 0, &id));
  INVALID(shadowcut_scene_object_id(s.scene, 0, NULL));
  shadowcut_mesh_destroy(mesh);

  OK(shadowcut_scene_set_tolerances(s.scene, 1e-5, 0));
  OK(shadowcut_scene_tolerances(s.scene, &flatness, &coplanarity));
  CHECK(flatness == 1e-5 && coplanarity == 0);
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_set_tolerances(s.scene, NAN, 0));
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_set_tolerances(s.scene, 0, -1));
  INVALID(shadowcut_scene_tolerances(s.scene, NULL, &coplanarity));
  shadowcut_scene_destroy(s.scene);
  shadowcut_scene_destroy(NULL);
}

static void test_lights(void) {
  struct Small s = small_scene();
  shadowcut_light light = point_light(1, 2, 3), found;
  const shadowcut_light* both[2] = {&light, &light};
  shadowcut_light_id id;
  context = "lights";
  light.name = "lamp";
  light.range = 50;
  light.has_spot = 1;
  light.spot_axis[2] = -1;
  light.spot_half_angle = 1;
  OK(shadowcut_scene_add_light(s.scene, &light, &id));
  OK(shadowcut_light_init(&found));
  OK(shadowcut_scene_light(s.scene, &id, &found));
  CHECK(found.kind == SHADOWCUT_POINT && found.at[2] == 3 && found.range == 50 &&
        found.has_spot == 1 && found.spot_half_angle == 1 && strcmp(found.name, "lamp") == 0);
  light.spot_half_angle = 4;
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_set_light(s.scene, &id, &light));
  light.spot_half_angle = 0.5;
  OK(shadowcut_scene_set_light(s.scene, &id, &light));
  light.at[0] = NAN;
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_add_light(s.scene, &light, &id));
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_replace_lights(s.scene, both, 2));
  light.at[0] = 0;
  light.kind = 2;
  INVALID(shadowcut_scene_add_light(s.scene, &light, &id));
  light.kind = SHADOWCUT_DIRECTIONAL;
  light.has_spot = 0;
  light.range = INFINITY;
  OK(shadowcut_scene_set_light(s.scene, &id, &light));
  OK(shadowcut_scene_remove_light(s.scene, &id));
  STATUS(SHADOWCUT_STALE, shadowcut_scene_remove_light(s.scene, &id));
  STATUS(SHADOWCUT_STALE, shadowcut_scene_light(s.scene, &id, &found));
  STATUS(SHADOWCUT_STALE, shadowcut_scene_set_light(s.scene, &id, &light));
  STATUS(SHADOWCUT_NOT_FOUND, shadowcut_scene_light_id(s.scene, 1, &id));
  OK(shadowcut_scene_replace_lights(s.scene, both, 2));
  OK(shadowcut_scene_light_id(s.scene, 1, &id));
  id.scene += 1000;
  STATUS(SHADOWCUT_FOREIGN, shadowcut_scene_remove_light(s.scene, &id));
  INVALID(shadowcut_scene_replace_lights(s.scene, NULL, 2));
  INVALID(shadowcut_scene_replace_lights(s.scene, both, -2));
  both[1] = NULL;
  INVALID(shadowcut_scene_replace_lights(s.scene, both, 2));
  OK(shadowcut_scene_replace_lights(s.scene, NULL, 0));
  light.size = 8;
  INVALID(shadowcut_scene_add_light(s.scene, &light, &id));
  INVALID(shadowcut_scene_add_light(s.scene, NULL, &id));
  INVALID(shadowcut_scene_remove_light(s.scene, NULL));
  INVALID(shadowcut_scene_light_id(s.scene, 0, NULL));
  INVALID(shadowcut_light_init(NULL));
  shadowcut_scene_destroy(s.scene);
}

static void test_flattened(void) {
  struct Small s = small_scene();
  shadowcut_face face;
  shadowcut_facet facet;
  shadowcut_corner corners[4];
  shadowcut_edge edge;
  shadowcut_plane plane;
  double xyz[24];
  context = "flattened";
  OK(shadowcut_scene_faces(s.scene, 1, 1, &face));
  CHECK(face.object == s.sheet.index && face.number == 0 && face.facet_count == 1 &&
        face.area == 1);
  OK(shadowcut_scene_facets(s.scene, face.first_facet, 1, &facet));
  CHECK(facet.face == 1 && facet.corner_count == 4);
  OK(shadowcut_scene_corners(s.scene, facet.first_corner, 4, corners));
  OK(shadowcut_scene_vertices(s.scene, 0, 8, xyz));
  CHECK(xyz[3 * corners[0].vertex + 2] == 1);
  OK(shadowcut_scene_edges(s.scene, corners[0].edge >> 1, 1, &edge));
  CHECK(edge.a < edge.b);
  OK(shadowcut_scene_planes(s.scene, facet.plane, 1, &plane));
  CHECK(plane.normal[2] == 1 && plane.point[2] == 1 && plane.exact_normal[2] > 0);
  OK(shadowcut_scene_faces(s.scene, 2, 0, NULL));
  INVALID(shadowcut_scene_faces(s.scene, 1, 2, &face));
  INVALID(shadowcut_scene_faces(s.scene, 3, 0, &face));
  INVALID(shadowcut_scene_faces(s.scene, 1, 0xFFFFFFFFu, &face));
  INVALID(shadowcut_scene_facets(s.scene, 0, 1, NULL));
  INVALID(shadowcut_scene_corners(NULL, 0, 1, corners));
  INVALID(shadowcut_scene_vertices(s.scene, 8, 1, xyz));
  INVALID(shadowcut_scene_edges(s.scene, 8, 1, &edge));
  INVALID(shadowcut_scene_planes(s.scene, 0, 1, NULL));
  shadowcut_scene_destroy(s.scene);
}

/* Faces that cannot be used are reported, and the others kept. */
static void test_issues(void) {
  const double xyz[15] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, NAN, 0, 0};
  const uint32_t corners[10] = {0, 1, 2, 0, 1, 4, 0, 1, 99, 0};
  const int32_t counts[4] = {3, 3, 3, 1};
  shadowcut_scene* scene = NULL;
  shadowcut_mesh* mesh = NULL;
  shadowcut_object_id id;
  shadowcut_scene_counts n;
  shadowcut_issue issues[3];
  context = "issues";
  OK(shadowcut_scene_create(&scene));
  OK(shadowcut_mesh_create(&mesh));
  OK(shadowcut_mesh_set_vertices(mesh, xyz, 5));
  OK(shadowcut_mesh_add_faces(mesh, corners, counts, 4));
  OK(shadowcut_scene_add_object(scene, mesh, NULL, &id));
  OK(shadowcut_scene_counts_init(&n));
  OK(shadowcut_scene_count(scene, &n));
  CHECK(n.issues == 3 && n.faces == 4);
  OK(shadowcut_scene_issues(scene, 0, 3, issues));
  CHECK(issues[0].reason == SHADOWCUT_NON_FINITE && issues[0].face == 1 && issues[0].object == 0);
  CHECK(issues[1].reason == SHADOWCUT_INDEX_OUT_OF_RANGE &&
        issues[2].reason == SHADOWCUT_TOO_FEW_CORNERS && issues[2].detail != NULL);
  INVALID(shadowcut_scene_issues(scene, 0, 4, issues));
  shadowcut_mesh_destroy(mesh);
  shadowcut_scene_destroy(scene);
}

/* ---- Shadows ------------------------------------------------------------------------------------------------------------------------ */

static double fan_area(const double* xyz, uint32_t count) {
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

static void test_cast(void) {
  struct Small s = small_scene();
  shadowcut_light light = point_light(0, 0, 2);
  shadowcut_options options;
  shadowcut_shadows* shadows = NULL;
  shadowcut_stats stats;
  shadowcut_construction construction;
  uint32_t blocks = 0, b, i, n = 0, corners = 0, on_ground = 0, constructions = 0;
  double lit = 0;
  context = "cast";
  OK(shadowcut_options_init(&options));
  CHECK(options.kernel == SHADOWCUT_KERNEL_FAST && options.form == SHADOWCUT_FORM_MERGED &&
        options.facets_per_cell == 128 && options.edits == 1 && options.join_threshold == 2);
  options.kernel = SHADOWCUT_KERNEL_EXACT;
  options.constructions = 1;
  OK(shadowcut_cast_shadows(s.scene, &light, &options, &shadows));
  CHECK(fabs(shadowed_area(shadows, 0) - 4) < 1e-12);
  OK(shadowcut_shadows_block_count(shadows, &blocks));
  for (b = 0; b < blocks; ++b) {
    const double* xyz = NULL;
    OK(shadowcut_shadows_fragment_count(shadows, b, &n));
    OK(shadowcut_shadows_corners(shadows, b, &xyz, &corners));
    OK(shadowcut_shadows_construction_count(shadows, b, &constructions));
    CHECK(constructions == corners);
    for (i = 0; i < n; ++i) {
      shadowcut_fragment f;
      OK(shadowcut_shadows_fragments(shadows, b, i, 1, &f));
      CHECK(f.id.cell == b && f.first_corner + f.corner_count <= corners &&
            f.lit == (f.caster == SHADOWCUT_NONE));
      CHECK(fabs(fan_area(xyz + 3 * f.first_corner, f.corner_count) - f.area) < 1e-12);
      if (f.face == 0 && f.lit) lit += f.area;
      if (f.face == 0) ++on_ground;
    }
  }
  CHECK(fabs(lit - 60) < 1e-12 && on_ground >= 5);
  OK(shadowcut_shadows_area_count(shadows, &n));
  CHECK(n == 2);
  OK(shadowcut_stats_init(&stats));
  OK(shadowcut_shadows_stats(shadows, &stats));
  CHECK(stats.faces == 2 && stats.facing_faces == 2 &&
        stats.lit_fragments + stats.shadowed_fragments >= 6 && stats.bytes > 0 &&
        fabs(stats.lit_area - 61) < 1e-12);
  INVALID(shadowcut_shadows_fragment_count(shadows, blocks, &n));
  INVALID(shadowcut_shadows_fragments(shadows, 0, 0, 100000, NULL));
  INVALID(shadowcut_shadows_corners(shadows, 0, NULL, &n));
  INVALID(shadowcut_shadows_construction_count(shadows, blocks, &n));
  INVALID(shadowcut_shadows_constructions(shadows, 0, 0xFFFFFFFFu, 1, &construction));
  for (b = 0; b < blocks; ++b) {
    OK(shadowcut_shadows_construction_count(shadows, b, &n));
    if (n > 0) OK(shadowcut_shadows_constructions(shadows, b, 0, 1, &construction));
  }
  INVALID(shadowcut_shadows_areas(shadows, 2, 1, NULL));
  INVALID(shadowcut_shadows_area_count(shadows, NULL));
  INVALID(shadowcut_shadows_block_count(NULL, &n));
  stats.size = 4;
  INVALID(shadowcut_shadows_stats(shadows, &stats));
  INVALID(shadowcut_stats_init(NULL));
  shadowcut_shadows_destroy(shadows);
  shadowcut_shadows_destroy(NULL);

  OK(shadowcut_cast_shadows(s.scene, &light, NULL, &shadows));
  shadowcut_shadows_destroy(shadows);
  light.at[1] = INFINITY;
  STATUS(SHADOWCUT_REFUSED, shadowcut_cast_shadows(s.scene, &light, NULL, &shadows));
  light.at[1] = 0;
  options.min_area = -1;
  STATUS(SHADOWCUT_REFUSED, shadowcut_cast_shadows(s.scene, &light, &options, &shadows));
  options.min_area = 0;
  options.kernel = 3;
  INVALID(shadowcut_cast_shadows(s.scene, &light, &options, &shadows));
  options.kernel = 0, options.form = -1;
  INVALID(shadowcut_cast_shadows(s.scene, &light, &options, &shadows));
  options.form = 0, options.order = 9;
  INVALID(shadowcut_cast_shadows(s.scene, &light, &options, &shadows));
  options.order = 0, options.edits = 5;
  INVALID(shadowcut_cast_shadows(s.scene, &light, &options, &shadows));
  options.size = 0;
  INVALID(shadowcut_cast_shadows(s.scene, &light, &options, &shadows));
  INVALID(shadowcut_cast_shadows(NULL, &light, NULL, &shadows));
  INVALID(shadowcut_cast_shadows(s.scene, NULL, NULL, &shadows));
  INVALID(shadowcut_cast_shadows(s.scene, &light, NULL, NULL));
  INVALID(shadowcut_options_init(NULL));
  shadowcut_scene_destroy(s.scene);
}

/* Every kernel, two lights: areas by face to the last bit, and fragments by number. */
static void test_same_as_cpp(void) {
  static const char* const names[] = {"room:2", "furnished_room", "branch:3", "triangles:200"};
  static shadowcut_object_id ids[most];
  static double lit[most], shadowed[most];
  static shadowcut_face_area areas[most];
  size_t k;
  for (k = 0; k < sizeof names / sizeof *names; ++k) {
    int32_t kernel;
    shadowcut_scene* scene = NULL;
    context = names[k];
    OK(shadowcut_scene_create(&scene));
    support_scene(names[k], 1, scene, ids);
    for (kernel = SHADOWCUT_KERNEL_FAST; kernel <= SHADOWCUT_KERNEL_EXACT; ++kernel) {
      uint32_t l;
      for (l = 0; l < 2; ++l) {
        shadowcut_light_id id;
        shadowcut_light light;
        shadowcut_options options;
        shadowcut_shadows* shadows = NULL;
        uint32_t f, n = 0, blocks = 0, fragments = 0, wanted = 0;
        const uint32_t faces = support_areas(names[k], l, kernel, lit, shadowed, &wanted);
        OK(shadowcut_options_init(&options));
        OK(shadowcut_light_init(&light));
        options.kernel = kernel;
        OK(shadowcut_scene_light_id(scene, l, &id));
        OK(shadowcut_scene_light(scene, &id, &light));
        OK(shadowcut_cast_shadows(scene, &light, &options, &shadows));
        OK(shadowcut_shadows_area_count(shadows, &n));
        CHECK(n == faces);
        OK(shadowcut_shadows_areas(shadows, 0, n, areas));
        for (f = 0; f < n; ++f)
          CHECK(memcmp(&areas[f].lit, &lit[f], sizeof *lit) == 0 &&
                memcmp(&areas[f].shadowed, &shadowed[f], sizeof *lit) == 0);
        OK(shadowcut_shadows_block_count(shadows, &blocks));
        for (f = 0; f < blocks; ++f) {
          OK(shadowcut_shadows_fragment_count(shadows, f, &n));
          fragments += n;
        }
        CHECK(fragments == wanted && fragments > 0);
        shadowcut_shadows_destroy(shadows);
      }
    }
    shadowcut_scene_destroy(scene);
  }
}

/* ---- Engines ------------------------------------------------------------------------------------------------------------------------ */

static void test_engine(void) {
  struct Small s = small_scene();
  shadowcut_engine *engine = NULL, *second = NULL;
  const shadowcut_scene* view = NULL;
  const shadowcut_shadows* shadows = NULL;
  shadowcut_changes changes;
  shadowcut_light_changes light;
  shadowcut_added* added;
  shadowcut_fragment_id* gone;
  shadowcut_changed_area areas[2];
  shadowcut_fragment f;
  shadowcut_fragment_id nothing = {0, 12345, 6789};
  shadowcut_scene_counts counts;
  double pose[16], undecided[2], share = -1;
  uint32_t n = 0, i;
  context = "engine";
  OK(shadowcut_engine_create(s.scene, NULL, &engine));
  OK(shadowcut_changes_init(&changes));
  STATUS(SHADOWCUT_NOT_FOUND, shadowcut_engine_changes(engine, &changes));
  STATUS(SHADOWCUT_NOT_FOUND, shadowcut_engine_shadows(engine, 0, &shadows));
  OK(shadowcut_engine_update(engine));
  OK(shadowcut_engine_changes(engine, &changes));
  CHECK(changes.light_count == 1 && changes.update == 1 && changes.complete == 1 &&
        changes.applied == 3 && changes.ms >= 0);
  OK(shadowcut_engine_progress(engine, &share));
  CHECK(share == 1);
  OK(shadowcut_engine_shadows(engine, 0, &shadows));
  CHECK(fabs(shadowed_area(shadows, 0) - 4) < 1e-12);
  OK(shadowcut_light_changes_init(&light));
  OK(shadowcut_engine_light_changes(engine, 0, &light));
  CHECK(light.light == 0 && light.rebuilt == 1 && light.removed == 0 && light.gone_count == 0 &&
        light.added_count >= 6 && light.area_count == 2);

  /* The sheet sinks: its shadow shrinks. */
  pose_at(pose, 0, 0, -0.5);
  OK(shadowcut_scene_set_pose(s.scene, &s.sheet, pose));
  OK(shadowcut_engine_update_within(engine, 1000));
  OK(shadowcut_engine_changes(engine, &changes));
  CHECK(changes.light_count == 1 && changes.applied == 1 && changes.update == 2);
  OK(shadowcut_engine_light_changes(engine, 0, &light));
  CHECK(light.rebuilt == 0 && light.gone_count > 0 && light.added_count > 0 &&
        light.area_count >= 1 && light.area_count <= 2);
  gone = room_for(light.gone_count, sizeof *gone);
  added = room_for(light.added_count, sizeof *added);
  OK(shadowcut_engine_gone(engine, 0, 0, light.gone_count, gone));
  OK(shadowcut_engine_added(engine, 0, 0, light.added_count, added));
  OK(shadowcut_engine_changed_areas(engine, 0, 0, light.area_count, areas));
  for (i = 0; i < light.added_count; ++i) {
    shadowcut_fragment same;
    OK(shadowcut_engine_find(engine, 0, &added[i].id, &f));
    OK(shadowcut_shadows_fragments(shadows, added[i].id.cell, added[i].index, 1, &same));
    CHECK(memcmp(&f.id, &same.id, sizeof f.id) == 0 && f.area == same.area);
  }
  CHECK(fabs(shadowed_area(shadows, 0) - 16.0 / 9) < 1e-12);
  INVALID(shadowcut_engine_gone(engine, 0, 0, light.gone_count + 1, gone));
  INVALID(shadowcut_engine_added(engine, 1, 0, 0, added));
  INVALID(shadowcut_engine_changed_areas(engine, 0, 9, 1, areas));
  INVALID(shadowcut_engine_light_changes(engine, 1, &light));
  free(gone);
  free(added);
  STATUS(SHADOWCUT_NOT_FOUND, shadowcut_engine_find(engine, 0, &nothing, &f));
  STATUS(SHADOWCUT_NOT_FOUND, shadowcut_engine_find(engine, 7, &nothing, &f));
  INVALID(shadowcut_engine_find(engine, 0, NULL, &f));
  OK(shadowcut_engine_light_count(engine, &n));
  CHECK(n == 1);
  OK(shadowcut_engine_undecided(engine, 0, 2, undecided));
  CHECK(undecided[0] >= 0 && undecided[0] < 1e-9);
  INVALID(shadowcut_engine_undecided(engine, 0, 1, undecided));
  STATUS(SHADOWCUT_NOT_FOUND, shadowcut_engine_undecided(engine, 1, 2, undecided));
  OK(shadowcut_engine_validate(engine));

  /* Its scene is to be read, and no more. */
  OK(shadowcut_engine_scene(engine, &view));
  OK(shadowcut_scene_counts_init(&counts));
  OK(shadowcut_scene_count(view, &counts));
  CHECK(counts.objects == 2);
  INVALID(shadowcut_engine_create(view, NULL, &second));
  INVALID(shadowcut_scene_set_casts((shadowcut_scene*)(uintptr_t)view, &s.sheet, 0));
  shadowcut_scene_destroy((shadowcut_scene*)(uintptr_t)view); /* does nothing */
  shadowcut_shadows_destroy((shadowcut_shadows*)(uintptr_t)shadows);
  OK(shadowcut_scene_count(view, &counts));

  /* A light that goes leaves an empty handle; the scene may go before the engine. */
  OK(shadowcut_scene_remove_light(s.scene, &s.light));
  OK(shadowcut_engine_update(engine));
  OK(shadowcut_engine_light_changes(engine, 0, &light));
  CHECK(light.removed == 1);
  STATUS(SHADOWCUT_NOT_FOUND, shadowcut_shadows_area_count(shadows, &n));
  STATUS(SHADOWCUT_NOT_FOUND, shadowcut_engine_shadows(engine, 0, &shadows));
  OK(shadowcut_engine_compact(engine));
  INVALID(shadowcut_engine_update_within(engine, -1));
  INVALID(shadowcut_engine_update_within(engine, NAN));
  INVALID(shadowcut_engine_update(NULL));
  INVALID(shadowcut_engine_compact(NULL));
  INVALID(shadowcut_engine_create(NULL, NULL, &second));
  INVALID(shadowcut_engine_create(s.scene, NULL, NULL));
  INVALID(shadowcut_engine_progress(NULL, &share));
  INVALID(shadowcut_engine_changes(NULL, &changes));
  INVALID(shadowcut_engine_changes(engine, NULL));
  INVALID(shadowcut_engine_scene(NULL, &view));
  INVALID(shadowcut_engine_light_count(engine, NULL));
  INVALID(shadowcut_engine_shadows(engine, 0, NULL));
  INVALID(shadowcut_engine_validate(NULL));
  INVALID(shadowcut_changes_init(NULL));
  INVALID(shadowcut_light_changes_init(NULL));
  shadowcut_scene_destroy(s.scene);
  OK(shadowcut_engine_update(engine));
  shadowcut_engine_destroy(engine);
  shadowcut_engine_destroy(NULL);
}

static void test_combined(void) {
  struct Small s = small_scene();
  shadowcut_light second = point_light(1, 0, 2);
  shadowcut_light_id id;
  shadowcut_engine* engine = NULL;
  shadowcut_light_sets* sets = NULL;
  shadowcut_set_fragment* fragments;
  const uint64_t* masks = NULL;
  const double* xyz = NULL;
  const uint32_t faces[2] = {0, 999};
  uint32_t n = 0, words = 0, corners = 0, i, part = 0;
  double by_mask[4] = {0, 0, 0, 0};
  context = "combined";
  OK(shadowcut_scene_add_light(s.scene, &second, &id));
  OK(shadowcut_engine_create(s.scene, NULL, &engine));
  OK(shadowcut_engine_update(engine));
  OK(shadowcut_engine_combined(engine, &sets));
  OK(shadowcut_light_sets_count(sets, &n, &words));
  CHECK(words == 1);
  fragments = room_for(n, sizeof *fragments);
  OK(shadowcut_light_sets_fragments(sets, 0, n, fragments));
  OK(shadowcut_light_sets_masks(sets, &masks));
  OK(shadowcut_light_sets_corners(sets, &xyz, &corners));
  for (i = 0; i < n; ++i)
    if (fragments[i].face == 0)
      ++part, by_mask[masks[i]] +=
              fan_area(xyz + 3 * fragments[i].first_corner, fragments[i].corner_count);
  CHECK(fabs(by_mask[0] - 2) < 1e-9 && fabs(by_mask[1] - 2) < 1e-9 && fabs(by_mask[2] - 2) < 1e-9 &&
        fabs(by_mask[3] - 58) < 1e-9);
  INVALID(shadowcut_light_sets_fragments(sets, 0, n + 1, fragments));
  INVALID(shadowcut_light_sets_count(NULL, &n, &words));
  INVALID(shadowcut_light_sets_masks(sets, NULL));
  INVALID(shadowcut_light_sets_corners(NULL, &xyz, &corners));
  shadowcut_light_sets_destroy(sets);
  OK(shadowcut_engine_combined_faces(engine, faces, 2, &sets));
  OK(shadowcut_light_sets_count(sets, &n, &words));
  CHECK(n == part);
  shadowcut_light_sets_destroy(sets);
  shadowcut_light_sets_destroy(NULL);
  INVALID(shadowcut_engine_combined_faces(engine, faces, -1, &sets));
  INVALID(shadowcut_engine_combined_faces(engine, NULL, 1, &sets));
  INVALID(shadowcut_engine_combined(engine, NULL));
  INVALID(shadowcut_engine_combined(NULL, &sets));
  free(fragments);
  shadowcut_engine_destroy(engine);
  shadowcut_scene_destroy(s.scene);
}

/* ---- Buffers ------------------------------------------------------------------------------------------------------------------------ */

/* What a graphics interface would hold: only what was said to have changed is copied here. */
struct Device {
  unsigned char* stream[7];
  uint32_t each[7];
};

static void upload(struct Device* device, const shadowcut_buffers* buffers) {
  shadowcut_buffers_info info;
  int s;
  OK(shadowcut_buffers_info_init(&info));
  OK(shadowcut_buffers_get_info(buffers, &info));
  for (s = 0; s < 7; ++s) {
    const void* data = NULL;
    uint32_t each = 0, i;
    const uint32_t ranges =
        s == SHADOWCUT_INDICES ? info.changed_index_ranges : info.changed_vertex_ranges;
    if (shadowcut_buffers_stream(buffers, s, &data, &each) != SHADOWCUT_OK) continue;
    if (info.grown) {
      free(device->stream[s]);
      device->stream[s] =
          room_for(s == SHADOWCUT_INDICES ? info.index_capacity : info.vertex_capacity, each);
      device->each[s] = each;
    }
    CHECK(device->each[s] == each || info.vertex_capacity == 0);
    for (i = 0; i < ranges; ++i) {
      shadowcut_range range = {0, 0};
      if (s == SHADOWCUT_INDICES) OK(shadowcut_buffers_changed_indices(buffers, i, 1, &range));
      else OK(shadowcut_buffers_changed_vertices(buffers, i, 1, &range));
      CHECK(range.count > 0 && range.first + range.count <=
                                   (s == SHADOWCUT_INDICES ? info.index_count : info.vertex_count));
      memcpy(device->stream[s] + (size_t)range.first * each,
             (const unsigned char*)data + (size_t)range.first * each, (size_t)range.count * each);
    }
  }
}

static void free_device(struct Device* device) {
  int s;
  for (s = 0; s < 7; ++s) free(device->stream[s]);
}

/* A triangle as drawn. */
struct Triangle {
  uint32_t face, object, mask, state;
  double corner[9];
  float normal[3];
  uint32_t unused;
};
static int compare_triangles(const void* a, const void* b) {
  return memcmp(a, b, sizeof(struct Triangle));
}

/* All triangles that are not holes, sorted; from a device, or from what the buffers hold themselves. */
static struct Triangle* triangles_of(const struct Device* device, const shadowcut_buffers* buffers,
                                     uint32_t* count) {
  shadowcut_buffers_info info;
  const unsigned char* stream[7];
  uint32_t each[7], i, corners;
  struct Triangle* all;
  int s;
  OK(shadowcut_buffers_info_init(&info));
  OK(shadowcut_buffers_get_info(buffers, &info));
  for (s = 0; s < 7; ++s) {
    const void* data = NULL;
    each[s] = 0;
    stream[s] = NULL;
    if (shadowcut_buffers_stream(buffers, s, &data, &each[s]) == SHADOWCUT_OK)
      stream[s] = device ? device->stream[s] : data;
  }
  corners = stream[SHADOWCUT_INDICES] ? info.index_count : info.vertex_count;
  all = room_for(corners / 3, sizeof *all);
  *count = 0;
  for (i = 0; i + 2 < corners; i += 3) {
    struct Triangle* t = &all[*count];
    uint32_t k, v = 0;
    for (k = 0; k < 3; ++k) {
      int c;
      v = i + k;
      if (stream[SHADOWCUT_INDICES]) memcpy(&v, stream[SHADOWCUT_INDICES] + 4 * (size_t)(i + k), 4);
      if (v >= info.vertex_count) {
        CHECK(v < info.vertex_count);
        return all;
      }
      for (c = 0; c < 3; ++c) {
        const unsigned char* at =
            stream[SHADOWCUT_POSITIONS] + (size_t)v * each[SHADOWCUT_POSITIONS];
        float as_float;
        if (each[SHADOWCUT_POSITIONS] == 24) {
          memcpy(&t->corner[3 * k + (uint32_t)c], at + 8 * c, 8);
        } else {
          memcpy(&as_float, at + 4 * c, 4);
          t->corner[3 * k + (uint32_t)c] = (double)as_float;
        }
      }
    }
    memcpy(&t->face, stream[SHADOWCUT_FACES] + 4 * (size_t)v, 4);
    if (t->face == SHADOWCUT_NONE) { /* a hole: nothing to be seen */
      CHECK(fan_area(t->corner, 3) == 0);
      memset(t, 0, sizeof *t);
      continue;
    }
    if (stream[SHADOWCUT_OBJECTS]) memcpy(&t->object, stream[SHADOWCUT_OBJECTS] + 4 * (size_t)v, 4);
    if (stream[SHADOWCUT_NORMALS])
      memcpy(t->normal, stream[SHADOWCUT_NORMALS] + 12 * (size_t)v, 12);
    if (stream[SHADOWCUT_STATES]) t->state = stream[SHADOWCUT_STATES][v];
    if (stream[SHADOWCUT_MASKS])
      memcpy(&t->mask, stream[SHADOWCUT_MASKS] + (size_t)v * each[SHADOWCUT_MASKS], 4);
    ++*count;
  }
  qsort(all, *count, sizeof *all, compare_triangles);
  return all;
}

enum { watched = 6 };
struct Watched {
  uint32_t light;
  shadowcut_buffer_layout layout;
  shadowcut_buffers* buffers;
  struct Device device;
};

static void watch(struct Watched* w, uint32_t light, int indexed, int doubles, int32_t show) {
  memset(w, 0, sizeof *w);
  w->light = light;
  OK(shadowcut_buffer_layout_init(&w->layout));
  w->layout.indexed = indexed, w->layout.doubles = doubles, w->layout.show = show;
  w->layout.masks = w->layout.objects = 1;
  w->layout.origin[0] = 1.5, w->layout.origin[2] = 0.7;
  w->layout.joined_gap = indexed ? 0 : 16;
  w->layout.hole_share = doubles ? 0.03 : 0.5; /* some are laid out anew now and then */
  OK(shadowcut_buffers_create(light, &w->layout, &w->buffers));
}

/* Of one light: the same triangles, to the bit. Of all: the same areas of every face under every set of lights. */
static void check_watched(struct Watched* w, const shadowcut_engine* engine) {
  shadowcut_buffers* fresh = NULL;
  struct Triangle *kept, *wanted;
  uint32_t n = 0, m = 0, i;
  OK(shadowcut_buffers_update(w->buffers, engine));
  upload(&w->device, w->buffers);
  OK(shadowcut_buffers_create(w->light, &w->layout, &fresh));
  OK(shadowcut_buffers_update(fresh, engine));
  kept = triangles_of(&w->device, w->buffers, &n);
  wanted = triangles_of(NULL, fresh, &m);
  if (w->light != SHADOWCUT_ALL_LIGHTS) {
    CHECK(n == m);
    CHECK(n != m || n == 0 || memcmp(kept, wanted, n * sizeof *kept) == 0);
  } else {
    static double area[most][8];
    double worst = 0;
    uint32_t f, k;
    memset(area, 0, sizeof area);
    for (i = 0; i < n; ++i) area[kept[i].face][kept[i].mask & 7] += fan_area(kept[i].corner, 3);
    for (i = 0; i < m; ++i)
      area[wanted[i].face][wanted[i].mask & 7] -= fan_area(wanted[i].corner, 3);
    for (f = 0; f < most; ++f)
      for (k = 0; k < 8; ++k) worst = fmax(worst, fabs(area[f][k]));
    CHECK(worst < (w->layout.doubles ? 1e-9 : 1e-4));
  }
  free(kept);
  free(wanted);
  shadowcut_buffers_destroy(fresh);
}

struct Play {
  shadowcut_scene* scene;
  shadowcut_object_id ids[most];
  int present[most];
  shadowcut_mesh* mesh[most];
  shadowcut_object_settings settings[most];
  uint32_t objects;
  shadowcut_light_id third;
  int has_third;
};

static void random_edit(struct Play* p) {
  const uint32_t o = 1 + below(p->objects - 1); /* not the ground */
  const uint32_t kind = below(20);
  double pose[16];
  if (kind < 12) {
    pose_at(pose, between(-0.3, 0.3), between(-0.3, 0.3), between(0, 0.2));
    if (p->present[o]) OK(shadowcut_scene_set_pose(p->scene, &p->ids[o], pose));
  } else if (kind < 14 && p->present[o]) {
    OK(shadowcut_object_settings_init(&p->settings[o]));
    OK(shadowcut_scene_given(p->scene, &p->ids[o], &p->mesh[o], &p->settings[o]));
    p->settings[o].name = NULL;
    OK(shadowcut_scene_remove_object(p->scene, &p->ids[o]));
    p->present[o] = 0;
  } else if (kind < 16) {
    uint32_t k;
    for (k = 0; k < p->objects; ++k) {
      if (p->present[k]) continue;
      OK(shadowcut_scene_add_object(p->scene, p->mesh[k], &p->settings[k], &p->ids[k]));
      shadowcut_mesh_destroy(p->mesh[k]);
      p->present[k] = 1;
    }
  } else if (kind == 16 && p->present[o]) {
    OK(shadowcut_scene_set_casts(p->scene, &p->ids[o], (int32_t)below(2)));
  } else if (kind == 17 && p->present[o]) {
    OK(shadowcut_scene_set_receives(p->scene, &p->ids[o], (int32_t)below(2)));
  } else if (kind == 18) {
    shadowcut_light_id id;
    shadowcut_light light = point_light(between(2, 4), between(2, 4), between(2, 2.4));
    OK(shadowcut_scene_light_id(p->scene, 0, &id));
    OK(shadowcut_scene_set_light(p->scene, &id, &light));
  } else if (kind == 19) {
    shadowcut_light light = point_light(between(1, 3), between(1, 3), between(1.8, 2.4));
    if (p->has_third) OK(shadowcut_scene_remove_light(p->scene, &p->third));
    else OK(shadowcut_scene_add_light(p->scene, &light, &p->third));
    p->has_third = !p->has_third;
  }
}

static void test_mirrors(uint64_t seed) {
  static struct Play p;
  static char name[64];
  struct Watched w[watched];
  shadowcut_engine* engine = NULL;
  uint32_t i, k, grown = 0, ranges = 0;
  memset(&p, 0, sizeof p);
  random_state = seed;
  snprintf(name, sizeof name, "mirrors, seed %u", (unsigned)seed);
  context = name;
  OK(shadowcut_scene_create(&p.scene));
  p.objects = support_scene("room:1", 1, p.scene, p.ids);
  for (i = 0; i < p.objects; ++i) p.present[i] = 1;
  watch(&w[0], 0, 0, 0, SHADOWCUT_SHOW_ALL);
  watch(&w[1], 0, 1, 1, SHADOWCUT_SHOW_LIT);
  watch(&w[2], 1, 1, 0, SHADOWCUT_SHOW_SHADOWED);
  watch(&w[3], 2, 0, 1, SHADOWCUT_SHOW_ALL); /* a light that comes and goes */
  watch(&w[4], SHADOWCUT_ALL_LIGHTS, 0, 1, SHADOWCUT_SHOW_ALL);
  watch(&w[5], SHADOWCUT_ALL_LIGHTS, 1, 0, SHADOWCUT_SHOW_LIT);
  OK(shadowcut_engine_create(p.scene, NULL, &engine));
  for (i = 0; i < 150 && failures == 0; ++i) {
    const uint32_t edits = 1 + below(3);
    for (k = 0; k < edits; ++k) random_edit(&p);
    if (i % 50 == 49) OK(shadowcut_engine_compact(engine));
    else if (i % 7 == 3) OK(shadowcut_engine_update_within(engine, 0));
    else OK(shadowcut_engine_update(engine));
    for (k = 0; k < watched; ++k) {
      shadowcut_buffers_info info;
      if (k == 2 && i % 5 == 4) continue; /* misses an update */
      check_watched(&w[k], engine);
      OK(shadowcut_buffers_info_init(&info));
      OK(shadowcut_buffers_get_info(w[k].buffers, &info));
      grown += info.grown != 0, ranges += info.changed_vertex_ranges;
      if (failures > 0) printf("  after step %u, buffers %u\n", (unsigned)i, (unsigned)k);
    }
  }
  OK(shadowcut_engine_validate(engine));
  printf("mirrors, seed %u: %u buffers grew, %u ranges\n", (unsigned)seed, (unsigned)grown,
         (unsigned)ranges);
  for (k = 0; k < watched; ++k) {
    free_device(&w[k].device);
    shadowcut_buffers_destroy(w[k].buffers);
  }
  for (k = 0; k < p.objects; ++k)
    if (!p.present[k]) shadowcut_mesh_destroy(p.mesh[k]);
  shadowcut_engine_destroy(engine);
  shadowcut_scene_destroy(p.scene);
}

static void test_buffers(void) {
  struct Small s = small_scene();
  shadowcut_engine *engine = NULL, *other = NULL;
  shadowcut_scene* empty = NULL;
  const shadowcut_scene* view = NULL;
  shadowcut_light_sets* sets = NULL;
  shadowcut_shadows* shadows = NULL;
  shadowcut_light light = point_light(0, 0, 2);
  shadowcut_buffer_layout layout;
  shadowcut_buffers *buffers = NULL, *all = NULL;
  shadowcut_buffers_info info;
  shadowcut_range range;
  const void* data = NULL;
  const double far[3] = {1e7, 0, 0};
  double pose[16], origin[3] = {NAN, 0, 0};
  const float* xyz;
  uint32_t each = 0, i;
  float lowest = 0;
  context = "buffers";
  OK(shadowcut_buffer_layout_init(&layout));
  CHECK(layout.normals == 1 && layout.hole_share == 0.5);
  OK(shadowcut_buffers_create(0, NULL, &buffers));
  OK(shadowcut_buffers_info_init(&info));
  OK(shadowcut_buffers_get_info(buffers, &info));
  CHECK(info.vertex_count == 0 && info.vertex_capacity == 0);
  OK(shadowcut_engine_create(s.scene, NULL, &engine));
  STATUS(SHADOWCUT_NOT_FOUND,
         shadowcut_buffers_update(buffers, engine)); /* it was never brought up to date */
  OK(shadowcut_engine_update(engine));
  OK(shadowcut_buffers_update(buffers, engine));
  OK(shadowcut_buffers_get_info(buffers, &info));
  CHECK(info.grown == 1 && info.changed_vertex_ranges == 1 && info.changed_index_ranges == 0 &&
        info.vertex_count % 3 == 0 && info.vertex_count <= info.vertex_capacity &&
        info.fragment_count >= 6 && info.mask_words == 0);
  OK(shadowcut_buffers_changed_vertices(buffers, 0, 1, &range));
  CHECK(range.first == 0 && range.count == info.vertex_count);
  OK(shadowcut_buffers_update(buffers, engine)); /* once more: nothing has changed */
  OK(shadowcut_buffers_get_info(buffers, &info));
  CHECK(info.grown == 0 && info.changed_vertex_ranges == 0);
  OK(shadowcut_buffers_stream(buffers, SHADOWCUT_STATES, &data, &each));
  CHECK(each == 1);
  OK(shadowcut_buffers_stream(buffers, SHADOWCUT_NORMALS, &data, &each));
  CHECK(each == 12 && ((const float*)data)[2] == 1.0f);
  STATUS(SHADOWCUT_NOT_FOUND, shadowcut_buffers_stream(buffers, SHADOWCUT_MASKS, &data, &each));
  STATUS(SHADOWCUT_NOT_FOUND, shadowcut_buffers_stream(buffers, SHADOWCUT_INDICES, &data, &each));
  STATUS(SHADOWCUT_NOT_FOUND, shadowcut_buffers_stream(buffers, SHADOWCUT_OBJECTS, &data, &each));
  INVALID(shadowcut_buffers_stream(buffers, 7, &data, &each));
  INVALID(shadowcut_buffers_stream(buffers, -1, &data, &each));
  INVALID(shadowcut_buffers_stream(buffers, 0, NULL, &each));
  INVALID(shadowcut_buffers_stream(NULL, 0, &data, &each));
  INVALID(shadowcut_buffers_changed_vertices(buffers, 0, 1, &range));
  INVALID(shadowcut_buffers_changed_indices(buffers, 0, 1, &range));

  /* Ten thousand kilometres off, float positions keep their digits by the origin. */
  pose_at(pose, far[0], 0.0009765625, 0);
  OK(shadowcut_scene_set_pose(s.scene, &s.sheet, pose));
  OK(shadowcut_engine_update(engine));
  OK(shadowcut_buffers_set_origin(buffers, far));
  OK(shadowcut_buffers_update(buffers, engine));
  OK(shadowcut_buffers_get_info(buffers, &info));
  OK(shadowcut_buffers_stream(buffers, SHADOWCUT_POSITIONS, &data, &each));
  xyz = data;
  for (i = 0; i < info.vertex_count; ++i)
    if (fabsf(xyz[3 * i]) < 10 && xyz[3 * i + 1] < lowest) lowest = xyz[3 * i + 1];
  CHECK(lowest == -0.5f + 0.0009765625f);
  STATUS(SHADOWCUT_REFUSED, shadowcut_buffers_set_origin(buffers, origin));
  INVALID(shadowcut_buffers_set_origin(buffers, NULL));
  INVALID(shadowcut_buffers_set_origin(NULL, far));

  /* Another engine with as many updates behind it. */
  OK(shadowcut_scene_set_casts(s.scene, &s.sheet, 0));
  OK(shadowcut_engine_create(s.scene, NULL, &other));
  for (i = 0; i < 3; ++i) OK(shadowcut_engine_update(other));
  OK(shadowcut_buffers_update(buffers, other));
  OK(shadowcut_buffers_get_info(buffers, &info));
  CHECK(info.changed_vertex_ranges == 1);

  /* Without an engine; and for all lights. */
  OK(shadowcut_cast_shadows(s.scene, &light, NULL, &shadows));
  OK(shadowcut_buffers_fill(buffers, s.scene, shadows));
  OK(shadowcut_buffers_create(SHADOWCUT_ALL_LIGHTS, NULL, &all));
  STATUS(SHADOWCUT_REFUSED, shadowcut_buffers_fill(all, s.scene, shadows));
  OK(shadowcut_engine_update(other));
  OK(shadowcut_engine_scene(other, &view));
  OK(shadowcut_engine_combined(other, &sets));
  OK(shadowcut_buffers_fill_sets(all, view, sets));
  OK(shadowcut_buffers_get_info(all, &info));
  OK(shadowcut_light_sets_count(sets, &i, &each));
  CHECK(info.fragment_count == i);
  OK(shadowcut_scene_create(&empty));
  STATUS(SHADOWCUT_REFUSED, shadowcut_buffers_fill_sets(all, empty, sets));
  STATUS(SHADOWCUT_REFUSED, shadowcut_buffers_fill_sets(buffers, view, sets));
  INVALID(shadowcut_buffers_fill_sets(all, view, NULL));
  INVALID(shadowcut_buffers_fill_sets(all, NULL, sets));
  INVALID(shadowcut_buffers_fill_sets(NULL, view, sets));
  STATUS(SHADOWCUT_REFUSED, shadowcut_buffers_fill(buffers, empty, shadows));
  shadowcut_scene_destroy(empty);
  shadowcut_light_sets_destroy(sets);
  add_square(s.scene, 1, 3, "another");
  STATUS(SHADOWCUT_REFUSED,
         shadowcut_buffers_fill(buffers, s.scene, shadows)); /* not this scene's */
  INVALID(shadowcut_buffers_fill(buffers, NULL, shadows));
  INVALID(shadowcut_buffers_fill(buffers, s.scene, NULL));
  INVALID(shadowcut_buffers_fill(NULL, s.scene, shadows));
  INVALID(shadowcut_buffers_update(NULL, engine));
  INVALID(shadowcut_buffers_update(buffers, NULL));
  INVALID(shadowcut_buffers_get_info(NULL, &info));
  info.size = 3;
  INVALID(shadowcut_buffers_get_info(buffers, &info));
  shadowcut_buffers_destroy(all);
  layout.hole_share = 2;
  STATUS(SHADOWCUT_REFUSED, shadowcut_buffers_create(0, &layout, &all));
  layout.hole_share = 0.5, layout.origin[1] = INFINITY;
  STATUS(SHADOWCUT_REFUSED, shadowcut_buffers_create(0, &layout, &all));
  layout.origin[1] = 0, layout.show = 3;
  INVALID(shadowcut_buffers_create(0, &layout, &all));
  layout.show = 0, layout.indexed = -1;
  INVALID(shadowcut_buffers_create(0, &layout, &all));
  layout.size = 0;
  INVALID(shadowcut_buffers_create(0, &layout, &all));
  INVALID(shadowcut_buffers_create(0, NULL, NULL));
  INVALID(shadowcut_buffer_layout_init(NULL));
  INVALID(shadowcut_buffers_info_init(NULL));
  shadowcut_shadows_destroy(shadows);
  shadowcut_buffers_destroy(buffers);
  shadowcut_buffers_destroy(NULL);
  shadowcut_engine_destroy(other);
  shadowcut_engine_destroy(engine);
  shadowcut_scene_destroy(s.scene);
}

/* ---- Out of memory ------------------------------------------------------------------------------------------------------------------ */

static int64_t after(int64_t n) { return n < 40 ? n + 1 : n + n / 8; }

/* Whatever allocation of an update fails: the status says so, the engine answers nothing until it is compacted, and then all is right. */
static void test_memory_of_updates(int first) {
  int64_t n;
  int reached = 1, compactions = 0;
  context = first ? "out of memory in the first update" : "out of memory in an update";
  for (n = 0; reached; n = after(n)) {
    struct Small s = small_scene();
    shadowcut_options options;
    shadowcut_engine* engine = NULL;
    shadowcut_buffers* buffers = NULL;
    const shadowcut_shadows* shadows = NULL;
    shadowcut_status status;
    double pose[16];
    uint32_t count;
    OK(shadowcut_options_init(&options));
    options.threads = 1;
    OK(shadowcut_engine_create(s.scene, &options, &engine));
    OK(shadowcut_buffers_create(0, NULL, &buffers));
    pose_at(pose, 0, 0, -0.5);
    if (!first) {
      OK(shadowcut_engine_update(engine));
      OK(shadowcut_buffers_update(buffers, engine));
    }
    OK(shadowcut_scene_set_pose(s.scene, &s.sheet, pose));
    support_fail_allocation(n);
    status = shadowcut_engine_update(engine);
    reached = support_fail_allocation(-1);
    CHECK(status == SHADOWCUT_OK || (reached && status == SHADOWCUT_OUT_OF_MEMORY));
    if (status != SHADOWCUT_OK && shadowcut_engine_update(engine) != SHADOWCUT_OK) {
      shadowcut_fragment f;
      shadowcut_light_sets* sets = NULL;
      const shadowcut_fragment_id id = {0, 0, 0};
      const shadowcut_scene* view = NULL;
      shadowcut_changes changes;
      double area;
      ++compactions;
      OK(shadowcut_changes_init(&changes));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_engine_update(engine));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_engine_update_within(engine, 1));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_engine_changes(engine, &changes));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_engine_shadows(engine, 0, &shadows));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_engine_find(engine, 0, &id, &f));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_engine_scene(engine, &view));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_engine_light_count(engine, &count));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_engine_undecided(engine, 0, 1, &area));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_engine_combined(engine, &sets));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_engine_validate(engine));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_buffers_update(buffers, engine));
      OK(shadowcut_engine_compact(engine));
    }
    OK(shadowcut_engine_validate(engine));
    OK(shadowcut_engine_shadows(engine, 0, &shadows));
    CHECK(fabs(shadowed_area(shadows, 0) - 16.0 / 9) < 1e-12);
    /* Buffers that run out of memory fill themselves anew. */
    support_fail_allocation(n);
    status = shadowcut_buffers_update(buffers, engine);
    support_fail_allocation(-1);
    CHECK(status == SHADOWCUT_OK || status == SHADOWCUT_OUT_OF_MEMORY);
    {
      struct Triangle *kept, *wanted;
      uint32_t m = 0;
      shadowcut_buffers* fresh = NULL;
      OK(shadowcut_buffers_update(buffers, engine));
      OK(shadowcut_buffers_create(0, NULL, &fresh));
      OK(shadowcut_buffers_update(fresh, engine));
      kept = triangles_of(NULL, buffers, &count);
      wanted = triangles_of(NULL, fresh, &m);
      CHECK(count == m && memcmp(kept, wanted, m * sizeof *kept) == 0);
      free(kept);
      free(wanted);
      shadowcut_buffers_destroy(fresh);
    }
    shadowcut_buffers_destroy(buffers);
    shadowcut_engine_destroy(engine);
    shadowcut_scene_destroy(s.scene);
  }
  CHECK(compactions > 10);
}

/* Everything else leaves things as they were. */
static void test_memory_elsewhere(void) {
  const uint32_t corners[3] = {0, 1, 2};
  int64_t n;
  int reached = 1;
  context = "out of memory elsewhere";
  for (n = 0; reached; n = after(n)) {
    struct Small s = small_scene();
    shadowcut_scene *scene = NULL, *copy = NULL;
    shadowcut_mesh *mesh = square(1, 0), *fresh = NULL, *given = NULL;
    shadowcut_object_id id;
    shadowcut_light light = point_light(0, 0, 2);
    shadowcut_light_id light_id;
    shadowcut_shadows* shadows = NULL;
    shadowcut_engine* engine = NULL;
    shadowcut_buffers* buffers = NULL;
    shadowcut_status status[9];
    shadowcut_options options;
    uint32_t faces;
    int k;
    OK(shadowcut_options_init(&options));
    options.threads = 1;
    light.name = "a name that is too long for a small string";
    reached = 0;
#define FAILING(k, call)      \
  support_fail_allocation(n); \
  status[k] = call;           \
  reached |= support_fail_allocation(-1)
    FAILING(0, shadowcut_scene_create(&scene));
    FAILING(1, shadowcut_scene_copy(s.scene, &copy));
    FAILING(2, shadowcut_mesh_create(&fresh));
    FAILING(3, shadowcut_scene_add_object(s.scene, mesh, NULL, &id));
    FAILING(4, shadowcut_scene_add_light(s.scene, &light, &light_id));
    FAILING(5, shadowcut_cast_shadows(s.scene, &light, &options, &shadows));
    FAILING(6, shadowcut_engine_create(s.scene, &options, &engine));
    FAILING(7, shadowcut_buffers_create(0, NULL, &buffers));
    FAILING(8, shadowcut_scene_given(s.scene, &s.sheet, &given, NULL));
    for (k = 0; k < 9; ++k)
      CHECK(status[k] == SHADOWCUT_OK || status[k] == SHADOWCUT_OUT_OF_MEMORY);
    CHECK((status[0] == SHADOWCUT_OK) == (scene != NULL) &&
          (status[5] == SHADOWCUT_OK) == (shadows != NULL));
    FAILING(0, shadowcut_mesh_add_face(mesh, corners, 3));
    CHECK(status[0] == SHADOWCUT_OK
              ? shadowcut_mesh_face_count(mesh, &faces) == SHADOWCUT_OK
              : shadowcut_mesh_face_count(mesh, &faces) == SHADOWCUT_INVALID_ARGUMENT);
#undef FAILING
    shadowcut_scene_destroy(scene);
    shadowcut_scene_destroy(copy);
    shadowcut_mesh_destroy(mesh);
    shadowcut_mesh_destroy(fresh);
    shadowcut_mesh_destroy(given);
    shadowcut_shadows_destroy(shadows);
    shadowcut_engine_destroy(engine);
    shadowcut_buffers_destroy(buffers);
    shadowcut_scene_destroy(s.scene);
  }
}

int main(void) {
  uint64_t seed;
  test_names();
  test_meshes();
  test_objects();
  test_lights();
  test_flattened();
  test_issues();
  test_cast();
  test_same_as_cpp();
  test_engine();
  test_combined();
  test_buffers();
  for (seed = 1; seed <= 3; ++seed) test_mirrors(seed);
  test_memory_of_updates(1);
  test_memory_of_updates(0);
  test_memory_elsewhere();
  if (failures) printf("%d checks failed\n", failures);
  else printf("all checks hold\n");
  return failures ? 1 : 0;
}
