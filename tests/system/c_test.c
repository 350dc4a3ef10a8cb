/* The C interface from a C program: every function, what it refuses, the C++ engine's areas to the
 * last bit, buffers kept by changes, and what happens when memory runs out. A failure prints its
 * line, and the seed where chance is in it. */
#include <stdio.h>

#include "c_checks.h"

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
  test_overlay();
  test_buffers();
  for (seed = 1; seed <= 3; ++seed) test_mirrors(seed);
  test_memory_of_updates(1);
  test_memory_of_updates(0);
  test_memory_elsewhere();
  if (failures) printf("%d checks failed\n", failures);
  else printf("all checks hold\n");
  return failures ? 1 : 0;
}
