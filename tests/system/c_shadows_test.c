/* The C interface's shadows and engines: what is refused, and the C++ engine's areas to the last
 * bit. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "c_checks.h"

void test_cast(void) {
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
        options.tuning.facets_per_cell == 128 && options.tuning.incremental == 1 &&
        options.tuning.join_threshold == 2);
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
            f.lit == (f.caster == SHADOWCUT_INVALID_INDEX));
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
  light.position[1] = INFINITY;
  STATUS(SHADOWCUT_REFUSED, shadowcut_cast_shadows(s.scene, &light, NULL, &shadows));
  light.position[1] = 0;
  options.min_area = -1;
  STATUS(SHADOWCUT_REFUSED, shadowcut_cast_shadows(s.scene, &light, &options, &shadows));
  options.min_area = 0;
  options.kernel = 3;
  INVALID(shadowcut_cast_shadows(s.scene, &light, &options, &shadows));
  options.kernel = 0, options.form = -1;
  INVALID(shadowcut_cast_shadows(s.scene, &light, &options, &shadows));
  options.form = 0, options.tuning.order = 9;
  INVALID(shadowcut_cast_shadows(s.scene, &light, &options, &shadows));
  options.tuning.order = 0, options.tuning.incremental = 5;
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
void test_same_as_cpp(void) {
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

void test_engine(void) {
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
  double pose[16], uncertain[2], share = -1;
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
  OK(shadowcut_engine_uncertain_area(engine, 0, 2, uncertain));
  CHECK(uncertain[0] >= 0 && uncertain[0] < 1e-9);
  INVALID(shadowcut_engine_uncertain_area(engine, 0, 1, uncertain));
  STATUS(SHADOWCUT_NOT_FOUND, shadowcut_engine_uncertain_area(engine, 1, 2, uncertain));
  OK(shadowcut_engine_validate(engine));

  /* Its scene is to be read, and no more. */
  OK(shadowcut_engine_scene(engine, &view));
  OK(shadowcut_scene_counts_init(&counts));
  OK(shadowcut_scene_count(view, &counts));
  CHECK(counts.objects == 2);
  INVALID(shadowcut_engine_create(view, NULL, &second));
  INVALID(shadowcut_scene_set_casts_shadows((shadowcut_scene*)(uintptr_t)view, &s.sheet, 0));
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

void test_overlay(void) {
  struct Small s = small_scene();
  shadowcut_light second = point_light(1, 0, 2);
  shadowcut_light_id id;
  shadowcut_engine* engine = NULL;
  shadowcut_light_partition* partition = NULL;
  shadowcut_partition_fragment* fragments;
  const uint64_t* masks = NULL;
  const double* xyz = NULL;
  const uint32_t faces[2] = {0, 999};
  uint32_t n = 0, words = 0, corners = 0, i, part = 0;
  double by_mask[4] = {0, 0, 0, 0};
  context = "overlay";
  OK(shadowcut_scene_add_light(s.scene, &second, &id));
  OK(shadowcut_engine_create(s.scene, NULL, &engine));
  OK(shadowcut_engine_update(engine));
  OK(shadowcut_engine_overlay(engine, &partition));
  OK(shadowcut_light_partition_count(partition, &n, &words));
  CHECK(words == 1);
  fragments = room_for(n, sizeof *fragments);
  OK(shadowcut_light_partition_fragments(partition, 0, n, fragments));
  OK(shadowcut_light_partition_masks(partition, &masks));
  OK(shadowcut_light_partition_corners(partition, &xyz, &corners));
  for (i = 0; i < n; ++i)
    if (fragments[i].face == 0)
      ++part, by_mask[masks[i]] +=
              fan_area(xyz + 3 * fragments[i].first_corner, fragments[i].corner_count);
  CHECK(fabs(by_mask[0] - 2) < 1e-9 && fabs(by_mask[1] - 2) < 1e-9 && fabs(by_mask[2] - 2) < 1e-9 &&
        fabs(by_mask[3] - 58) < 1e-9);
  INVALID(shadowcut_light_partition_fragments(partition, 0, n + 1, fragments));
  INVALID(shadowcut_light_partition_count(NULL, &n, &words));
  INVALID(shadowcut_light_partition_masks(partition, NULL));
  INVALID(shadowcut_light_partition_corners(NULL, &xyz, &corners));
  shadowcut_light_partition_destroy(partition);
  OK(shadowcut_engine_overlay_faces(engine, faces, 2, &partition));
  OK(shadowcut_light_partition_count(partition, &n, &words));
  CHECK(n == part);
  shadowcut_light_partition_destroy(partition);
  shadowcut_light_partition_destroy(NULL);
  INVALID(shadowcut_engine_overlay_faces(engine, faces, -1, &partition));
  INVALID(shadowcut_engine_overlay_faces(engine, NULL, 1, &partition));
  INVALID(shadowcut_engine_overlay(engine, NULL));
  INVALID(shadowcut_engine_overlay(NULL, &partition));
  free(fragments);
  shadowcut_engine_destroy(engine);
  shadowcut_scene_destroy(s.scene);
}
