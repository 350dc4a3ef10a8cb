/* The C interface's buffers, kept by changes, against buffers made for the scene as it stands. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "c_checks.h"

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

static int compare_triangles(const void* a, const void* b) {
  return memcmp(a, b, sizeof(struct Triangle));
}

struct Triangle* triangles_of(const struct Device* device, const shadowcut_buffers* buffers,
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
    if (t->face == SHADOWCUT_INVALID_INDEX) { /* a hole: nothing to be seen */
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
  w->layout.hole_share = doubles ? 0.03 : 0.5; /* some are laid out again now and then */
  OK(shadowcut_buffers_create(light, &w->layout, &w->buffers));
}

/* Of one light: the same triangles, to the bit. Of all: the same areas of every face under every
 * set of lights. */
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
    OK(shadowcut_scene_source(p->scene, &p->ids[o], &p->mesh[o], &p->settings[o]));
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
    OK(shadowcut_scene_set_casts_shadows(p->scene, &p->ids[o], (int32_t)below(2)));
  } else if (kind == 17 && p->present[o]) {
    OK(shadowcut_scene_set_receives_shadows(p->scene, &p->ids[o], (int32_t)below(2)));
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

void test_mirrors(uint64_t seed) {
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

void test_buffers(void) {
  struct Small s = small_scene();
  shadowcut_engine *engine = NULL, *other = NULL;
  shadowcut_scene* empty = NULL;
  const shadowcut_scene* view = NULL;
  shadowcut_light_partition* partition = NULL;
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
  OK(shadowcut_scene_set_casts_shadows(s.scene, &s.sheet, 0));
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
  OK(shadowcut_engine_overlay(other, &partition));
  OK(shadowcut_buffers_fill_partition(all, view, partition));
  OK(shadowcut_buffers_get_info(all, &info));
  OK(shadowcut_light_partition_count(partition, &i, &each));
  CHECK(info.fragment_count == i);
  OK(shadowcut_scene_create(&empty));
  STATUS(SHADOWCUT_REFUSED, shadowcut_buffers_fill_partition(all, empty, partition));
  STATUS(SHADOWCUT_REFUSED, shadowcut_buffers_fill_partition(buffers, view, partition));
  INVALID(shadowcut_buffers_fill_partition(all, view, NULL));
  INVALID(shadowcut_buffers_fill_partition(all, NULL, partition));
  INVALID(shadowcut_buffers_fill_partition(NULL, view, partition));
  STATUS(SHADOWCUT_REFUSED, shadowcut_buffers_fill(buffers, empty, shadows));
  shadowcut_scene_destroy(empty);
  shadowcut_light_partition_destroy(partition);
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
