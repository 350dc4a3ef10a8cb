// Lists of indices: what has been given back, to be used again (places in a vector, and stretches
// of one); and those without repetition.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

namespace shadowcut {

// Free indices. The lowest is used first: so indices stay low, and what is done and undone again
// and again finds the same ones.
class FreeList {
 public:
  bool empty() const { return heap_.empty(); }
  std::size_t size() const { return heap_.size(); }
  void clear() { heap_.clear(); }
  void give_back(std::uint32_t index) {
    heap_.push_back(index);
    std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
  }
  std::uint32_t take() {  // not when empty
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    const std::uint32_t index = heap_.back();
    heap_.pop_back();
    return index;
  }

 private:
  std::vector<std::uint32_t> heap_;
};

// Stretches of a vector, used again for others of the same length.
class RangeList {
 public:
  // Where a stretch of this length begins in `v`: one given back, or a new one at the end.
  template <class T>
  std::uint32_t take(std::vector<T>& v, std::uint32_t length) {
    if (length < free_.size() && !free_[length].empty()) {
      const std::uint32_t first = free_[length].back();
      free_[length].pop_back();
      unused_ -= length;
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
  std::vector<std::vector<std::uint32_t>> free_;  // by length
  std::size_t unused_ = 0;
};

// Sorted, and each value once.
template <class T>
void sort_unique(std::vector<T>& v) {
  std::sort(v.begin(), v.end());
  v.erase(std::unique(v.begin(), v.end()), v.end());
}

}  // namespace shadowcut
