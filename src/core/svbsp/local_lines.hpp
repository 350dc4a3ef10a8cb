// A cell's own lines: where two planes cross, and copies of lines whose object or node has gone.
// Counted by use: a line is free when no node and no stored piece uses it.
#pragma once

#include <span>
#include <vector>

#include "predicates/cell_predicates.hpp"
#include "support/free_list.hpp"

namespace shadowcut {

class LocalLines {
 public:
  std::span<const LocalLine> all() const { return lines_; }
  std::size_t size() const { return lines_.size() - free_.size(); }
  std::size_t bytes() const { return lines_.size() * sizeof(LocalLine); }
  const Line& line(LineId id) const {
    SHADOWCUT_ASSERT(is_local(id) && id.value() - first_local_line < lines_.size());
    return lines_[id.value() - first_local_line].line;
  }

  void clear() {
    lines_.clear();
    free_.clear(), idle_.clear();
  }

  LineId add(const Line& line, const LightLine& exact) {
    SHADOWCUT_ASSERT(line.error >= 0 || line.error != line.error);
    LineId id;
    if (free_.empty()) {
      id = LineId(first_local_line + lines_.size());
      lines_.push_back({line, 0, exact});
    } else {
      id = free_.take();
      lines_[id.value() - first_local_line] = {line, 0, exact};
    }
    return id;
  }
  // A line that is released at the end of the edit unless something stored uses it by then.
  LineId add_idle(const Line& line, const LightLine& exact) {
    const LineId id = add(line, exact);
    idle_.push_back(id);
    return id;
  }

  // Lines of the LineTable are not counted.
  void count_use(LineId id, bool more) {
    if (!is_local(id)) return;
    std::uint32_t& uses = lines_[id.value() - first_local_line].uses;
    SHADOWCUT_ASSERT(uses != invalid_index && (more || uses > 0));
    if (more) {
      ++uses;
    } else if (--uses == 0) {
      idle_.push_back(id);
    }
  }

  // At the end of an edit: lines that nothing uses are free from now on.
  void release_idle() {
    for (const LineId id : idle_) {
      std::uint32_t& uses = lines_[id.value() - first_local_line].uses;
      if (uses != 0) continue;
      uses = invalid_index;  // the list may hold the line twice
      SHADOWCUT_ASSERT(is_local(id));
      free_.give_back(id);
    }
    idle_.clear();
  }

 private:
  std::vector<LocalLine> lines_;
  FreeList<LineId> free_;
  std::vector<LineId> idle_;  // used by nothing stored at some moment of this edit
};

}  // namespace shadowcut
