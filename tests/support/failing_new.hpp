// An operator new that can be made to fail, for programs that have failing_new.cpp among their
// sources.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>

namespace shadowcut::testing {

inline constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();
// until one fails (0: the next), once; below 0: it has. never: none will
extern std::atomic<std::int64_t> allocations_left;
extern std::atomic<std::int64_t> blocks_allocated;  // now

}  // namespace shadowcut::testing
