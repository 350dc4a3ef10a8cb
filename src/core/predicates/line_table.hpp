// The lines of one light: lines of edges of the scene, and dividing lines of the k-d tree.
//
// A line's id is its edge's index until the object moves away from planes that it leaves behind in
// the trees: those planes keep the old lines, and the object gets a new block of ids.
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "light_space/light_space.hpp"
#include "support/assert.hpp"
#include "support/index.hpp"

namespace shadowcut {

class LineTable {
 public:
  const Line& operator[](LineId id) const {
    SHADOWCUT_ASSERT(id.value() < lines_.size());
    return lines_[id.value()];
  }
  std::size_t size() const { return lines_.size(); }
  // Exact kernel: two points that the line goes through.
  const std::pair<Vec3, Vec3>& ends(LineId id) const {
    SHADOWCUT_ASSERT(id.value() < ends_.size());
    return ends_[id.value()];
  }

  // One line for each edge, not computed yet. `with_ends`: for the exact kernel.
  void reset(std::size_t edges, std::size_t objects, bool with_ends);
  void set(LineId id, const Line& line) {
    SHADOWCUT_ASSERT(id.value() < lines_.size());
    lines_[id.value()] = line;
  }
  void set_ends(LineId id, const Vec3& a, const Vec3& b) {
    SHADOWCUT_ASSERT(with_ends_ && id.value() < ends_.size());
    ends_[id.value()] = {a, b};
  }

  // The k-d tree's lines come behind the edges' lines.
  void begin_kd_lines() { first_kd_line_ = static_cast<std::uint32_t>(lines_.size()); }
  LineId add_kd_line(const Line& line);
  void end_kd_lines() {
    kd_lines_ = static_cast<std::uint32_t>(lines_.size()) - first_kd_line_;
    if (with_ends_) ends_.resize(lines_.size());
  }
  bool is_kd_line(LineId id) const { return id.value() - first_kd_line_ < kd_lines_; }
  std::uint32_t first_kd_line() const { return first_kd_line_; }

  // The line of an edge of an object, as it stands.
  LineId of_edge(std::uint32_t object, std::uint32_t edge) const {
    SHADOWCUT_ASSERT(object < shift_.size());
    return LineId(edge + shift_[object]);
  }
  // Whether a line is the line of an edge of the object, as it stands.
  bool is_own(const Object& object, std::uint32_t index, LineId line) const {
    return line.value() - object.first_edge - shift_[index] < object.edge_count;
  }
  // The edge of the object that has the line; meaningless unless is_own().
  std::uint32_t edge_of(std::uint32_t object, LineId line) const {
    return line.value() - shift_[object];
  }

  // For edits. Blocks of ids: each object has one, and a block that planes left behind still use
  // is kept until the last of those planes goes.
  void start_blocks(std::span<const Object> objects);
  void grow(std::size_t objects);
  void take_block(std::uint32_t object, const Object& as);
  // After the object's removal: leaves its block to the planes left behind, if there are any.
  void leave_block(std::uint32_t object);
  void give_block_back(std::uint32_t object);
  // A plane left behind uses a line (or no longer does).
  void count_plane(LineId line, bool kept);

  // See SvbspTree::validate: the block of a line, of an object, and what the blocks count.
  std::uint32_t block_of_line(LineId line) const { return block_of_line_[line.value()]; }
  std::uint32_t block_of_object(std::uint32_t object) const { return block_of_object_[object]; }
  std::size_t block_count() const { return blocks_.size(); }
  std::uint32_t planes_left(std::size_t block) const { return blocks_[block].planes; }
  bool is_left(std::size_t block) const { return blocks_[block].left; }

 private:
  struct IdBlock {               // ids of one object's edges, at one of its poses
    std::uint32_t first, count;  // ids
    std::uint32_t planes;        // planes left behind that still use them
    bool left;                   // its object has other ids now
  };

  std::vector<Line> lines_;
  std::vector<std::pair<Vec3, Vec3>> ends_;  // exact kernel
  bool with_ends_ = false;
  std::vector<std::uint32_t> shift_;  // by object: line id less edge index
  std::uint32_t first_kd_line_ = 0, kd_lines_ = 0;
  std::vector<IdBlock> blocks_;
  std::vector<std::uint32_t> block_of_object_, block_of_line_;  // indices into blocks_, or none
  std::multimap<std::uint32_t, std::uint32_t> free_blocks_;     // by count
};

}  // namespace shadowcut
