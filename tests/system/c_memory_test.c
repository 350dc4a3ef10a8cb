/* The C interface when memory runs out. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "c_checks.h"

static int64_t after(int64_t n) { return n < 40 ? n + 1 : n + n / 8; }

/* Whatever allocation of an update fails: the status says so, the engine answers nothing until it
 * is compacted, and then all is right. */
void test_memory_of_updates(int first) {
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
      shadowcut_light_partition* partition = NULL;
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
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_engine_uncertain_area(engine, 0, 1, &area));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_engine_overlay(engine, &partition));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_engine_validate(engine));
      STATUS(SHADOWCUT_MUST_COMPACT, shadowcut_buffers_update(buffers, engine));
      OK(shadowcut_engine_compact(engine));
    }
    OK(shadowcut_engine_validate(engine));
    OK(shadowcut_engine_shadows(engine, 0, &shadows));
    CHECK(fabs(shadowed_area(shadows, 0) - 16.0 / 9) < 1e-12);
    /* Buffers that run out of memory fill themselves from the start. */
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
void test_memory_elsewhere(void) {
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
    FAILING(8, shadowcut_scene_source(s.scene, &s.sheet, &given, NULL));
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
