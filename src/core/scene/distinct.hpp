// Sets of distinct positions and of distinct outlines, while an object is imported.
#pragma once

#include <tsl/robin_set.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "scene/convex_decomposition.hpp"
#include "support/hash.hpp"

namespace shadowcut {

struct PositionHash {
  std::size_t operator()(const Vec3& v) const {
    std::uint64_t bits[3];
    std::memcpy(bits, v.data(), sizeof bits);
    return mix(bits[0] + mix(bits[1] + mix(bits[2])));
  }
};

// Positions by their indices into an array of distinct positions.
class PositionSet {
 public:
  PositionSet(const std::vector<Vec3>& positions, std::size_t expected)
      : indices_(0, Hash{&positions}, Equal{&positions}) {
    indices_.reserve(expected);
  }
  // Enters position i. Returns i, or the index of an equal position entered before.
  std::uint32_t enter(std::uint32_t i) { return *indices_.insert(i).first; }

 private:
  struct Hash {
    const std::vector<Vec3>* positions;
    std::size_t operator()(std::uint32_t i) const { return PositionHash()((*positions)[i]); }
  };
  struct Equal {
    const std::vector<Vec3>* positions;
    bool operator()(std::uint32_t i, std::uint32_t j) const {
      return (*positions)[i] == (*positions)[j];
    }
  };
  tsl::robin_set<std::uint32_t, Hash, Equal> indices_;
};

// The outlines of the faces kept so far, to find duplicates. Outlines are numbered from 0.
class OutlineSet {
 public:
  explicit OutlineSet(std::size_t expected) : known_(0, Hash{this}, Equal{this}) {
    known_.reserve(expected);
  }
  OutlineSet(const OutlineSet&) = delete;  // the table refers to it
  OutlineSet& operator=(const OutlineSet&) = delete;

  // Enters the outline of a face; false if there is an equal one. Each loop is turned to begin with
  // its smallest corner.
  bool enter(std::span<const Loop> loops) {
    const std::size_t begin = corners_.size();
    for (const Loop& l : loops) {
      const auto smallest =
          static_cast<std::size_t>(std::min_element(l.begin(), l.end()) - l.begin());
      for (std::size_t i = 0; i < l.size(); ++i) corners_.push_back(l[(smallest + i) % l.size()]);
    }
    std::uint64_t hash = loops.size();
    for (std::size_t i = begin; i < corners_.size(); ++i) hash = mix(hash + corners_[i]);
    hashes_.push_back(hash);
    begins_.push_back(corners_.size());
    if (known_.insert(static_cast<std::uint32_t>(hashes_.size() - 1)).second) return true;
    hashes_.pop_back(), begins_.pop_back();
    corners_.resize(begin);
    return false;
  }

 private:
  struct Hash {
    const OutlineSet* set;
    std::size_t operator()(std::uint32_t i) const { return set->hashes_[i]; }
  };
  struct Equal {
    const OutlineSet* set;
    bool operator()(std::uint32_t i, std::uint32_t j) const {
      const auto a = set->outline(i), b = set->outline(j);
      return std::equal(a.begin(), a.end(), b.begin(), b.end());
    }
  };
  std::span<const std::uint32_t> outline(std::uint32_t i) const {
    return std::span(corners_).subspan(begins_[i], begins_[i + 1] - begins_[i]);
  }

  std::vector<std::uint32_t> corners_;
  std::vector<std::size_t> begins_{0};  // into corners_; one more than outlines
  std::vector<std::uint64_t> hashes_;   // by outline
  tsl::robin_set<std::uint32_t, Hash, Equal> known_;
};

}  // namespace shadowcut
