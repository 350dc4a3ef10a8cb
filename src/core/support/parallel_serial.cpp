// The loops of parallel.hpp where there is one thread, and no oneTBB.

#include "support/parallel.hpp"

namespace shadowcut {

struct Threads::Arena {};

Threads::Threads(unsigned) {}
Threads::~Threads() = default;

void Threads::execute(const void* task, void (*run)(const void*)) { run(task); }

void run_ranges(std::size_t count, std::size_t, const void* task,
                void (*run)(const void*, std::size_t, std::size_t)) {
  if (count > 0) run(task, 0, count);
}

}  // namespace shadowcut
