// Compiled without ThreadSanitizer (parallel.hpp says why), so it must make no use of what depends
// on that.

#include "support/parallel.hpp"

#include <tbb/blocked_range.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace shadowcut {
namespace {

// No more than TBB has workers for: asked for more it gives none, and says so on stderr.
int threads_for(unsigned wanted) {
  const int most = tbb::info::default_concurrency();
  return wanted == 0 || wanted > static_cast<unsigned>(most) ? most : static_cast<int>(wanted);
}

}  // namespace

struct Threads::Arena {
  tbb::task_arena arena;
};

Threads::Threads(unsigned count) : arena_(new Arena{tbb::task_arena(threads_for(count))}) {}
Threads::~Threads() = default;

void Threads::execute(const void* task, void (*run)(const void*)) {
  arena_->arena.execute([=] { run(task); });
}

void run_ranges(std::size_t count, std::size_t grain, const void* task,
                void (*run)(const void*, std::size_t, std::size_t)) {
  using Range = tbb::blocked_range<std::size_t>;
  tbb::parallel_for(Range(0, count, grain),
                    [=](const Range& range) { run(task, range.begin(), range.end()); });
}

}  // namespace shadowcut
