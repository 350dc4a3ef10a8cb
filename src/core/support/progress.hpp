// Progress of a build, for the user's callback.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <mutex>

namespace shadowcut {

// Calls the user's progress function, from one thread at a time, when at least a percent of the
// work has been added. A share of the whole work, from `begin` to `end`, is done in `steps` steps.
class Progress {
 public:
  Progress(const std::function<void(double)>& report, double begin, double end, std::size_t steps)
      : report_(report),
        begin_(begin),
        end_(end),
        steps_(static_cast<double>(std::max<std::size_t>(steps, 1))) {}

  void step(std::size_t n = 1) {
    if (!report_) return;
    const std::lock_guard lock(mutex_);
    const double share = begin_ + (end_ - begin_) * static_cast<double>(done_ += n) / steps_;
    if (share < last_ + 0.01) return;
    last_ = share;
    report_(share);
  }

 private:
  const std::function<void(double)>& report_;
  double begin_, end_, steps_, last_ = 0;
  std::size_t done_ = 0;
  std::mutex mutex_;
};

}  // namespace shadowcut
