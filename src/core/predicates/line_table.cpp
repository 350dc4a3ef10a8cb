#include "predicates/line_table.hpp"

#include <algorithm>
#include <new>

#include "predicates/cone.hpp"

namespace shadowcut {

void LineTable::reset(std::size_t edges, std::size_t objects, bool with_ends) {
  with_ends_ = with_ends;
  lines_.resize(edges);
  if (with_ends) ends_.resize(edges);
  shift_.assign(objects, 0);
}

LineId LineTable::add_kd_line(const Line& line) {
  SHADOWCUT_ASSERT(lines_.size() < first_local_line);
  lines_.push_back(line);
  return LineId(lines_.size() - 1);
}

void LineTable::start_blocks(std::span<const Object> objects) {
  blocks_.clear();
  free_blocks_.clear();
  block_of_object_.assign(objects.size(), invalid_index);
  block_of_line_.assign(lines_.size(), invalid_index);
  for (std::uint32_t o = 0; o < objects.size(); ++o) {
    const Object& object = objects[o];
    if (!object.alive) continue;
    block_of_object_[o] = static_cast<std::uint32_t>(blocks_.size());
    SHADOWCUT_ASSERT(object.first_edge + object.edge_count <= lines_.size());
    std::fill_n(block_of_line_.begin() + object.first_edge, object.edge_count, block_of_object_[o]);
    blocks_.push_back({object.first_edge, object.edge_count, 0, false});
  }
}

void LineTable::grow(std::size_t objects) {
  if (shift_.size() < objects) shift_.resize(objects, 0u);
  if (block_of_object_.size() < objects) block_of_object_.resize(objects, invalid_index);
}

void LineTable::count_plane(LineId line, bool kept) {
  const std::uint32_t b = block_of_line_[line.value()];
  SHADOWCUT_ASSERT(b < blocks_.size());
  IdBlock& block = blocks_[b];
  SHADOWCUT_ASSERT(kept || block.planes > 0);
  if (kept) {
    ++block.planes;
  } else if (--block.planes == 0 && block.left) {
    free_blocks_.emplace(block.count, b);
  }
}

void LineTable::leave_block(std::uint32_t object) {
  if (object >= block_of_object_.size()) return;
  const std::uint32_t b = block_of_object_[object];
  if (b == invalid_index || blocks_[b].planes == 0) return;
  IdBlock& block = blocks_[b];
  block.left = true;
  // The vertices of these lines are going to move: the lines no longer name them.
  for (std::uint32_t id = block.first; id < block.first + block.count; ++id)
    lines_[id].a = lines_[id].b = invalid_index;
  block_of_object_[object] = invalid_index;
}

void LineTable::give_block_back(std::uint32_t object) {
  const std::uint32_t b = block_of_object_[object];
  if (b == invalid_index) return;
  SHADOWCUT_ASSERT(blocks_[b].planes == 0);
  free_blocks_.emplace(blocks_[b].count, b);
  block_of_object_[object] = invalid_index;
}

void LineTable::take_block(std::uint32_t o, const Object& object) {
  if (const std::uint32_t b = block_of_object_[o];
      b != invalid_index && blocks_[b].count < object.edge_count)
    give_block_back(o);
  std::uint32_t& b = block_of_object_[o];
  if (b == invalid_index) {
    const auto fit = free_blocks_.lower_bound(object.edge_count);
    if (fit != free_blocks_.end()) {
      b = fit->second;
      free_blocks_.erase(fit);
    } else {
      const std::size_t first = lines_.size();
      if (first + object.edge_count > first_local_line) throw std::bad_alloc();
      lines_.resize(first + object.edge_count);
      if (with_ends_) ends_.resize(first + object.edge_count);
      b = static_cast<std::uint32_t>(blocks_.size());
      block_of_line_.resize(lines_.size(), b);
      blocks_.push_back({static_cast<std::uint32_t>(first), object.edge_count, 0, false});
    }
    blocks_[b].left = false;
  }
  SHADOWCUT_ASSERT(blocks_[b].planes == 0 && blocks_[b].count >= object.edge_count);
  shift_[o] = blocks_[b].first - object.first_edge;
}

}  // namespace shadowcut
