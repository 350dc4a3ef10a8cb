/* What the C program's tests take from C++: made scenes, the C++ engine's answers, and an operator
 * new that can be made to fail. */
#ifndef SHADOWCUT_TESTS_C_SUPPORT_H
#define SHADOWCUT_TESTS_C_SUPPORT_H

#include <shadowcut/c.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A made scene (scenes::named) with its light and, if `sun` is set, a directional one, entered
 * through the C interface. The ids of its objects go to `ids`; returns how many there are. */
uint32_t support_scene(const char* name, int sun, shadowcut_scene* scene, shadowcut_object_id* ids);
/* Areas of the same scene under its light `light` (1: the sun) by the C++ engine, with the kernel
 * of this number; returns the faces. */
uint32_t support_areas(const char* name, uint32_t light, int32_t kernel, double* lit,
                       double* shadowed, uint32_t* fragments);
/* The n-th allocation from now (0: the next) fails, once. Returns 1 if one has failed since the
 * last call; n < 0: none will. */
int support_fail_allocation(int64_t n);

#ifdef __cplusplus
}
#endif

#endif
