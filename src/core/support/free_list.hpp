// Free indices and free ranges of a vector, kept for reuse; and sorted lists without repetition.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "support/assert.hpp"

namespace shadowcut {

// Free indices. The lowest is reused first: indices stay low, and an edit that is done and undone
// repeatedly gets the same indices every time.
template <class I>
class FreeList {
 public:
  bool empty() const { return heap_.empty(); }
  std::size_t size() const { return heap_.size(); }
  void clear() { heap_.clear(); }
  void give_back(I index) {
    SHADOWCUT_ASSERT(index.valid());
    heap_.push_back(index);
    std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
  }
  I take() {
    SHADOWCUT_ASSERT(!empty());
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    const I index = heap_.back();
    heap_.pop_back();
    return index;
  }

 private:
  std::vector<I> heap_;
};

// Free ranges of a vector, reused for ranges of the same length.
class RangeList {
 public:
  // The start of a range of this length in `v`: a free one, or a new one at the end of `v`.
  template <class T>
  std::uint32_t take(std::vector<T>& v, std::uint32_t length) {
    if (length < free_.size() && !free_[length].empty()) {
      const std::uint32_t first = free_[length].back();
      free_[length].pop_back();
      unused_ -= length;
      SHADOWCUT_ASSERT(first + length <= v.size());
      return first;
    }
    const auto first = static_cast<std::uint32_t>(v.size());
    v.resize(v.size() + length);
    return first;
  }
  void give_back(std::uint32_t first, std::uint32_t length) {
    if (length >= free_.size()) free_.resize(length + 1);
    free_[length].push_back(first);
    unused_ += length;
  }
  std::size_t unused() const { return unused_; }
  void clear() { free_.clear(), unused_ = 0; }

 private:
  std::vector<std::vector<std::uint32_t>> free_;  // starts, by length
  std::size_t unused_ = 0;
};

// Sorts and removes repetitions.
template <class T>
void sort_unique(std::vector<T>& v) {
  std::sort(v.begin(), v.end());
  v.erase(std::unique(v.begin(), v.end()), v.end());
}

}  // namespace shadowcut
