/* What the tests of the C interface have in common: checks, chance, small scenes. */
#ifndef SHADOWCUT_TESTS_C_CHECKS_H
#define SHADOWCUT_TESTS_C_CHECKS_H

#include <shadowcut/c.h>
#include <stddef.h>

#include "c_support.h"

extern int failures;
extern const char* context;

void check(int holds, const char* what, const char* file, int line);
#define CHECK(condition) check((condition) != 0, #condition, __FILE__, __LINE__)
#define OK(call) check((call) == SHADOWCUT_OK, #call, __FILE__, __LINE__)
#define STATUS(wanted, call) check((call) == (wanted), #call " is " #wanted, __FILE__, __LINE__)
#define INVALID(call) STATUS(SHADOWCUT_INVALID_ARGUMENT, call)

enum { most = 4096 }; /* objects, and faces, of any scene here */

/* Splitmix64. */
extern uint64_t random_state;
uint32_t below(uint32_t n);
double between(double lo, double hi);

void* room_for(size_t count, size_t size);

shadowcut_mesh* square(double side, double z);
shadowcut_object_id add_square(shadowcut_scene* scene, double side, double z, const char* name);
shadowcut_light point_light(double x, double y, double z);

/* A unit square halfway up to the light takes four from a ground of 64. */
struct Small {
  shadowcut_scene* scene;
  shadowcut_object_id ground, sheet;
  shadowcut_light_id light;
};
struct Small small_scene(void);

void pose_at(double* pose, double x, double y, double z);
double shadowed_area(const shadowcut_shadows* shadows, uint32_t face);
double fan_area(const double* xyz, uint32_t count); /* of a convex polygon */

/* What a graphics interface would hold: only what was said to have changed is copied here. */
struct Device {
  unsigned char* stream[7];
  uint32_t each[7];
};

/* A triangle as drawn. */
struct Triangle {
  uint32_t face, object, mask, state;
  double corner[9];
  float normal[3];
  uint32_t unused;
};

/* All triangles that are not holes, sorted; from a device, or from what the buffers hold
 * themselves. */
struct Triangle* triangles_of(const struct Device* device, const shadowcut_buffers* buffers,
                              uint32_t* count);

/* The tests. */
void test_meshes(void);
void test_names(void);
void test_objects(void);
void test_lights(void);
void test_flattened(void);
void test_issues(void);
void test_cast(void);
void test_same_as_cpp(void);
void test_engine(void);
void test_overlay(void);
void test_mirrors(uint64_t seed);
void test_buffers(void);
void test_memory_of_updates(int first);
void test_memory_elsewhere(void);

#endif
