/* The C interface's meshes, objects, lights and issues. */
#include <math.h>
#include <string.h>

#include "c_checks.h"

void test_meshes(void) {
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

void test_names(void) {
  context = "names";
  CHECK(strcmp(shadowcut_status_name(SHADOWCUT_OK), "OK") == 0);
  CHECK(strcmp(shadowcut_status_name(SHADOWCUT_INTERNAL_ERROR), "INTERNAL_ERROR") == 0);
  CHECK(strcmp(shadowcut_status_name(99), "") == 0 && strcmp(shadowcut_status_name(-1), "") == 0);
  CHECK(strlen(shadowcut_version()) >= 5);
  CHECK(strlen(shadowcut_reason_text(SHADOWCUT_NOT_FLAT)) > 0 &&
        strcmp(shadowcut_reason_text(8), "") == 0 && strcmp(shadowcut_reason_text(-1), "") == 0);
  CHECK(shadowcut_is_refusal(SHADOWCUT_DUPLICATE) == 1 &&
        shadowcut_is_refusal(SHADOWCUT_NOT_FLAT) == 0 && shadowcut_is_refusal(77) == 0);
  INVALID(shadowcut_mesh_create(NULL));
  CHECK(strlen(shadowcut_message()) > 0);
}

void test_objects(void) {
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
  CHECK(object.casts_shadows == 1 && object.receives_shadows == 1 && object.dynamic == 0 &&
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
  OK(shadowcut_scene_set_casts_shadows(s.scene, &s.sheet, 0));
  OK(shadowcut_scene_set_receives_shadows(s.scene, &s.sheet, 0));
  INVALID(shadowcut_scene_set_casts_shadows(s.scene, &s.sheet, 2));
  INVALID(shadowcut_scene_set_receives_shadows(s.scene, &s.sheet, -1));

  /* Removed, and brought back as it was. */
  OK(shadowcut_object_settings_init(&settings));
  OK(shadowcut_scene_source(s.scene, &s.sheet, &mesh, &settings));
  CHECK(settings.casts_shadows == 0 && settings.receives_shadows == 0 && settings.pose[3] == 0.5 &&
        strcmp(settings.name, "sheet") == 0);
  settings.name = "back";
  OK(shadowcut_scene_remove_object(s.scene, &s.sheet));
  STATUS(SHADOWCUT_STALE, shadowcut_scene_remove_object(s.scene, &s.sheet));
  STATUS(SHADOWCUT_STALE, shadowcut_scene_object(s.scene, &s.sheet, &object));
  STATUS(SHADOWCUT_STALE, shadowcut_scene_source(s.scene, &s.sheet, &mesh, NULL));
  STATUS(SHADOWCUT_STALE, shadowcut_scene_set_casts_shadows(s.scene, &s.sheet, 1));
  STATUS(SHADOWCUT_STALE, shadowcut_scene_set_vertices(s.scene, &s.sheet, corners, 4));
  OK(shadowcut_scene_add_object(s.scene, mesh, &settings, &id));
  CHECK(id.index == s.sheet.index && id.generation != s.sheet.generation);
  STATUS(SHADOWCUT_STALE,
         shadowcut_scene_set_receives_shadows(s.scene, &s.sheet, 1)); /* its index is another's */
  OK(shadowcut_scene_object(s.scene, &id, &object));
  CHECK(strcmp(object.name, "back") == 0 && object.pose[3] == 0.5 && object.casts_shadows == 0);

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
  settings.dynamic = 7;
  INVALID(shadowcut_scene_add_object(s.scene, mesh, &settings, &id));
  settings.dynamic = 1;
  settings.size -= 4;
  INVALID(shadowcut_scene_add_object(s.scene, mesh, &settings, &id));
  INVALID(shadowcut_scene_source(s.scene, &id, &mesh, &settings));
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

void test_lights(void) {
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
  CHECK(found.kind == SHADOWCUT_POINT && found.position[2] == 3 && found.range == 50 &&
        found.has_spot == 1 && found.spot_half_angle == 1 && strcmp(found.name, "lamp") == 0);
  light.spot_half_angle = 4;
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_set_light(s.scene, &id, &light));
  light.spot_half_angle = 0.5;
  OK(shadowcut_scene_set_light(s.scene, &id, &light));
  light.position[0] = NAN;
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_add_light(s.scene, &light, &id));
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_replace_lights(s.scene, both, 2));
  light.position[0] = 0;
  light.kind = 2;
  INVALID(shadowcut_scene_add_light(s.scene, &light, &id));
  light.kind = SHADOWCUT_DIRECTIONAL;
  light.has_spot = 0;
  light.range = INFINITY;
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_set_light(s.scene, &id, &light)); /* no direction */
  light.direction[0] = 1, light.direction[1] = 2, light.direction[2] = 3;
  light.range = 50;
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_set_light(s.scene, &id, &light));
  light.range = INFINITY, light.has_spot = 1;
  STATUS(SHADOWCUT_REFUSED, shadowcut_scene_set_light(s.scene, &id, &light));
  light.has_spot = 0;
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

void test_flattened(void) {
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
void test_issues(void) {
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
