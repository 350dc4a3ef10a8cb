// Loops and threads of src/core, and what ThreadSanitizer sees of them: a race between two bodies,
// and nothing where there is none.

#include "support/parallel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

using namespace shadowcut;

namespace {

void pause(int microseconds) {
  std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
}

}  // namespace

TEST(Parallel, EveryIndexOnce) {
  for (const unsigned count : {0u, 1u, 2u, 3u, 1000000u}) {
    Threads threads(count);
    for (const std::size_t size : {0u, 1u, 2u, 1000u}) {
      for (const std::size_t grain : {1u, 16u, 5000u}) {
        std::vector<int> calls(size, 0);
        threads.run([&] { parallel_for(size, grain, [&](std::size_t i) { ++calls[i]; }); });
        EXPECT_EQ(std::count(calls.begin(), calls.end(), 1), static_cast<std::ptrdiff_t>(size))
            << count << " threads, grain " << grain;
      }
    }
  }
}

// What one loop writes the caller moves about, and the next loop reads elsewhere.
TEST(Parallel, LoopsHandOverToEachOther) {
  Threads threads(2);
  PerThread<std::vector<std::size_t>> kept;
  std::vector<int> values(200, 0);
  for (int round = 0; round < 50; ++round) {
    threads.run([&] {
      parallel_for(values.size(), 1, [&](std::size_t i) {
        ++values[i];
        kept.local().push_back(i);
        pause(5);
      });
      std::rotate(values.begin(), values.begin() + 77, values.end());
      parallel_for(values.size(), 16, [&](std::size_t i) { ++values[i]; });
    });
  }
  EXPECT_EQ(std::accumulate(values.begin(), values.end(), 0), 2 * 50 * 200);
  std::size_t all = 0;
  for (const auto& of_thread : kept) all += of_thread.size();
  EXPECT_EQ(all, 50u * 200u);
}

TEST(Parallel, ExceptionsReachTheCaller) {
  Threads threads(2);
  std::vector<int> values(200, 0);
  for (int round = 0; round < 50; ++round) {
    try {
      threads.run([&] {
        parallel_for(values.size(), 1, [&](std::size_t i) {
          values[i] = round;
          pause(5);
          if (i == 150) throw std::runtime_error("body " + std::to_string(i));
        });
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& e) {
      EXPECT_STREQ(e.what(), "body 150");
    }
    values.assign(200, -1);
  }
}

TEST(Parallel, MoreCallersThanPlaces) {
  Threads threads(2);
  std::vector<int> sums(4, 0);
  std::vector<std::thread> callers;
  for (int& sum : sums) {
    callers.emplace_back([&] {
      for (int round = 0; round < 20; ++round) {
        std::vector<int> values(100, 0);
        threads.run([&] {
          parallel_for(values.size(), 1, [&](std::size_t i) { values[i] = 1, pause(5); });
        });
        sum = std::accumulate(values.begin(), values.end(), sum);
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(sums, std::vector<int>(4, 2000));
}

#ifdef SHADOWCUT_TSAN
// The one has ended what it writes long before the other begins, which is luck, and no order.
TEST(ParallelDeathTest, ThreadSanitizerReportsARaceBetweenBodies) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "takes two processors";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto race = [] {
    int value = 0;
    std::atomic<bool> begun = false;  // relaxed, it orders nothing
    Threads(2).run([&] {
      parallel_for(2, 1, [&](std::size_t i) {
        if (i == 0) {
          ++value;
          for (int k = 0; k < 10000 && !begun.load(std::memory_order_relaxed); ++k) pause(1000);
        } else {
          begun.store(true, std::memory_order_relaxed);
          pause(10000);
          ++value;
        }
      });
    });
    std::exit(value == 2 ? 0 : 1);  // which ThreadSanitizer makes 66 if it has found something
  };
  EXPECT_EXIT(race(), testing::ExitedWithCode(66), "data race");
}
#endif
