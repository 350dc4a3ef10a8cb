// A hash table from keys that live elsewhere to dense ids: the caller compares keys, the table
// holds 4 bytes a slot.
#pragma once

#include <bit>
#include <cstdint>
#include <shadowcut/scene.hpp>
#include <vector>

#include "support/hash.hpp"

namespace shadowcut {

class IdTable {
 public:
  explicit IdTable(std::size_t expected) : slots_(std::bit_ceil(expected * 2 + 8), none) {}

  // The id for which same(id) holds among those with this hash, or `next` after entering it under
  // the hash. ids below `next` are in the table; rehash(id) gives an entered id's hash again when
  // the table grows.
  template <class Same, class Hash>
  std::uint32_t find_or_add(std::uint64_t hash, std::uint32_t next, Same same, Hash rehash) {
    if ((count_ + 1) * 2 > slots_.size()) grow(rehash);
    const std::size_t mask = slots_.size() - 1;
    std::size_t i = hash & mask;
    for (; slots_[i] != none; i = (i + 1) & mask) {
      if (same(slots_[i])) return slots_[i];
    }
    slots_[i] = next;
    ++count_;
    return next;
  }

 private:
  template <class Hash>
  void grow(Hash rehash) {
    std::vector<std::uint32_t> old(slots_.size() * 2, none);
    old.swap(slots_);
    const std::size_t mask = slots_.size() - 1;
    for (const std::uint32_t id : old) {
      if (id == none) continue;
      std::size_t i = rehash(id) & mask;
      while (slots_[i] != none) i = (i + 1) & mask;
      slots_[i] = id;
    }
  }

  std::vector<std::uint32_t> slots_;
  std::size_t count_ = 0;
};

}  // namespace shadowcut
