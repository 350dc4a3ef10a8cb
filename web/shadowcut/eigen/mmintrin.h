// Stands in for MMX's header when the engine is compiled to WebAssembly. Eigen adds up in another
// order with SSE than without, and results are to be those of x86-64 to the last bit; Emscripten
// has SSE2 on WebAssembly's SIMD. Eigen includes this header on its way there and uses nothing of
// it; but for old compilers of GNU's kind, as clang says it is, it writes x86 assembly, so it must
// not take clang for one.
#pragma once

#undef EIGEN_COMP_GNUC
#define EIGEN_COMP_GNUC 0
