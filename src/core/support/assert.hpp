// SHADOWCUT_ASSERT states a contract between parts of the engine. It never depends on user input:
// bad input is refused with an Error long before. Compiled in by the CMake option
// SHADOWCUT_ASSERTIONS, which the presets debug, asan and tsan set.
#pragma once

#ifdef SHADOWCUT_ASSERTIONS
#include <cstdio>
#include <cstdlib>
#define SHADOWCUT_ASSERT(condition)                                                              \
  ((condition)                                                                                   \
       ? static_cast<void>(0)                                                                    \
       : (std::fprintf(stderr, "%s:%d: assertion failed: %s\n", __FILE__, __LINE__, #condition), \
          std::abort()))
#else
#define SHADOWCUT_ASSERT(condition) static_cast<void>(sizeof((condition) ? 1 : 0))
#endif
