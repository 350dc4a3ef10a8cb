// What the engine does on several threads: its loops, the threads they may use, and what a thread
// keeps for itself. Over oneTBB, of which no other file knows. Where there are no threads (the
// CMake option SHADOWCUT_THREADS) SHADOWCUT_SERIAL is defined, oneTBB is not needed, and the same
// loops run one body after another.
//
// ThreadSanitizer cannot see into oneTBB as distributions ship it, so it is told here what oneTBB
// guarantees: what came before a loop came before each body, and each body before what follows the
// loop. Nothing is said to order one body with another, so a race between two of them is found. For
// the same reason TBB's templates are in parallel.cpp, which is compiled without ThreadSanitizer:
// of a library half seen it reports races that are none, and takes its counters for an order of the
// bodies, which may hide some that are.
#pragma once

#ifndef SHADOWCUT_SERIAL
#include <tbb/enumerable_thread_specific.h>
#endif

#include <cstddef>
#include <memory>

#if defined(__SANITIZE_THREAD__)
#define SHADOWCUT_TSAN
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define SHADOWCUT_TSAN
#endif
#endif
#ifdef SHADOWCUT_TSAN
#include <sanitizer/tsan_interface.h>
#endif

namespace shadowcut {

// The order between a caller and bodies. It is of the caller, and begins with its fork and ends
// with its join, which have an address each: a body that ends must not release what another, about
// to begin, acquires.
class ForkJoin {
 public:
  ForkJoin() { release(&fork_); }
  ~ForkJoin() { acquire(&join_); }
  ForkJoin(const ForkJoin&) = delete;
  ForkJoin& operator=(const ForkJoin&) = delete;

  class Body {  // as long as a body runs
   public:
    explicit Body(const ForkJoin& order) : order_(order) { acquire(&order_.fork_); }
    ~Body() { release(&order_.join_); }
    Body(const Body&) = delete;
    Body& operator=(const Body&) = delete;

   private:
    const ForkJoin& order_;
  };

 private:
#ifdef SHADOWCUT_TSAN
  static void release(void* at) { __tsan_release(at); }
  static void acquire(void* at) { __tsan_acquire(at); }
#else
  static void release(void*) {}
  static void acquire(void*) {}
#endif

  mutable char fork_, join_;  // nothing but addresses
};

// Calls run(task, begin, end) for ranges that make up [0, count), on any of the threads; divides
// none that is no longer than the grain.
void run_ranges(std::size_t count, std::size_t grain, const void* task,
                void (*run)(const void* task, std::size_t begin, std::size_t end));

// Calls body(i) for every i of [0, count), in any order.
template <class Body>
void parallel_for(std::size_t count, std::size_t grain, const Body& body) {
  struct Loop {
    const Body& body;
    ForkJoin order;  // last: what is before it has been written when it forks
    static void run(const void* task, std::size_t begin, std::size_t end) {
      const Loop& loop = *static_cast<const Loop*>(task);
      const ForkJoin::Body running(loop.order);
      for (std::size_t i = begin; i != end; ++i) loop.body(i);
    }
  };
  const Loop loop{body, {}};
  run_ranges(count, grain, &loop, Loop::run);
}

// As many threads as loops within run() may use, the caller's one of them.
class Threads {
 public:
  explicit Threads(unsigned count);  // 0: one for each processor, which is also the most
  ~Threads();

  // Calls step(): mostly on this thread, but on another one if all places are taken.
  template <class Step>
  void run(const Step& step) {
    struct Call {
      const Step& step;
      ForkJoin order;  // last, as above
      static void run(const void* task) {
        const Call& call = *static_cast<const Call*>(task);
        const ForkJoin::Body running(call.order);
        call.step();
      }
    };
    const Call call{step, {}};
    execute(&call, Call::run);
  }

 private:
  void execute(const void* task, void (*run)(const void* task));

  struct Arena;
  std::unique_ptr<Arena> arena_;
};

// One T for each thread that asks for its own, by local().
#ifdef SHADOWCUT_SERIAL
template <class T>
class PerThread {
 public:
  T& local() { return value_; }

 private:
  T value_;
};
#else
template <class T>
using PerThread = tbb::enumerable_thread_specific<T>;
#endif

}  // namespace shadowcut
