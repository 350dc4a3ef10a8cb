// Vertex buffers that follow an engine. Fragments that go leave holes; fragments that come fill
// holes of their size, or are appended.

#include "engine/vertex_buffers.hpp"

#include <algorithm>
#include <limits>
#include <shadowcut/buffers.hpp>
#include <string>
#include <vector>

#include "support/free_list.hpp"

namespace shadowcut {
namespace {

// Fragments run counter-clockwise seen from the light; buffers, seen from the face's front. The
// first corner stays the first.
void turn_to_front(std::vector<Vec3>& corners, const Vec3& normal) {
  Vec3 doubled = Vec3::Zero();
  for (std::size_t i = 2; i < corners.size(); ++i)
    doubled += (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]);
  if (doubled.dot(normal) < 0) std::reverse(corners.begin() + 1, corners.end());
}

}  // namespace

FragmentBuffers::Impl::Impl(std::uint32_t light, const BufferLayout& layout)
    : light_(light), layout_(layout) {
  if (!(layout.hole_share >= 0 && layout.hole_share <= 1))
    throw Error("the share of holes must be between 0 and 1");
  set_origin(layout.origin);
}

void FragmentBuffers::Impl::set_origin(const Vec3& origin) {
  if (!origin.allFinite()) throw Error("the origin of the buffers must be finite");
  layout_.origin = origin;
  seen_ = 0;
}

void FragmentBuffers::Impl::update(const Engine& engine, const Changes& changes) {
  const std::uint64_t seen = seen_;
  begin();
  if (seen == 0 || changes.update != seen)
    follow(engine, changes, seen != 0 && changes.update == seen + 1);
  list_changes();
  seen_ = changes.update;
}

void FragmentBuffers::Impl::fill(const Engine& engine) {
  begin();
  refill(engine);
  list_changes();
}

void FragmentBuffers::Impl::fill(const Scene& scene, const Shadows& shadows) {
  if (light_ == all_lights)
    throw Error("buffers of all lights cannot be filled with the shadows of one");
  begin();
  clear();
  add_shadows(scene, shadows);
  list_changes();
}

void FragmentBuffers::Impl::fill(const Scene& scene, const LightPartition& partition) {
  if (light_ != all_lights)
    throw Error("buffers of one light cannot be filled with the partition by all");
  begin();
  clear();
  set_mask_words(std::max<std::size_t>(scene.lights().size(), 1));
  add_partition(scene, partition);
  list_changes();
}

// Until all is done, there is nothing that a later update could go on from.
void FragmentBuffers::Impl::begin() {
  seen_ = 0;
  refilled_ = grown_ = false;
  touched_.clear();
  ++updates_;
}

void FragmentBuffers::Impl::follow(const Engine& engine, const Changes& changes, bool next) {
  bool done = next;
  if (next && light_ == all_lights) {
    done = apply_to_faces(engine, changes);
  } else if (next) {
    for (const LightChanges& change : changes.lights) {
      if (change.light == light_) apply(engine, change);
    }
  }
  if (!done ||
      static_cast<double>(hole_vertices_) > layout_.hole_share * static_cast<double>(vertex_count_))
    refill(engine);
}

void FragmentBuffers::Impl::refill(const Engine& engine) {
  const Scene& scene = engine.scene();
  clear();
  if (light_ == all_lights) {
    set_mask_words(std::max<std::size_t>(scene.lights().size(), 1));
    add_partition(scene, engine.overlay());
  } else if (light_ < engine.light_count() && scene.light_id(light_).index != invalid_index) {
    add_shadows(scene, engine.shadows(light_));
  }
}

void FragmentBuffers::Impl::clear() {
  refilled_ = true;
  slots_.clear(), slots_of_face_.clear(), holes_.clear(), touched_.clear();
  vertex_count_ = index_count_ = fragment_count_ = hole_vertices_ = 0;
  if (light_ != all_lights) set_mask_words(std::size_t{light_} + 1);
}

void FragmentBuffers::Impl::apply(const Engine& engine, const LightChanges& change) {
  if (change.removed || change.rebuilt) return refill(engine);
  for (const FragmentId& id : change.gone) {
    const auto found = slots_.find(id);
    if (found == slots_.end()) continue;  // not shown
    remove(found->second);
    slots_.erase(found);
  }
  const Shadows& shadows = engine.shadows(light_);
  for (const LightChanges::Added& a : change.added) {
    const Block& block = shadows.blocks[a.id.cell];
    add_fragment(engine.scene(), {block, block.fragments[a.index]});
  }
}

// The partition of a face stays as it is where no light's fragments on it have changed. False: it
// has to be made as a whole.
bool FragmentBuffers::Impl::apply_to_faces(const Engine& engine, const Changes& changes) {
  std::vector<std::uint32_t> faces;
  for (const LightChanges& change : changes.lights) {
    if (change.removed || change.rebuilt) return false;
    const Shadows& shadows = engine.shadows(change.light);
    for (const LightChanges::Added& a : change.added)
      faces.push_back(shadows.blocks[a.id.cell].fragments[a.index].face);
    for (const LightChanges::Area& a : change.areas) faces.push_back(a.face);
  }
  if (faces.empty()) return true;
  sort_unique(faces);
  for (const std::uint32_t f : faces) {
    if (f >= slots_of_face_.size()) break;
    for (const Slot& slot : slots_of_face_[f]) remove(slot);
    slots_of_face_[f].clear();
  }
  add_partition(engine.scene(), engine.overlay(faces));
  return true;
}

void FragmentBuffers::Impl::add_shadows(const Scene& scene, const Shadows& shadows) {
  for (const auto fragment : shadows.fragments()) add_fragment(scene, fragment);
}

void FragmentBuffers::Impl::add_fragment(const Scene& scene, const FragmentView& fragment) {
  if (!shows(fragment->lit)) return;
  mask_.assign(mask_words_, 0);
  if (fragment->lit && mask_words_ > 0) mask_[light_ / 32] = std::uint32_t{1} << (light_ % 32);
  const Slot slot =
      add(scene, {fragment->face, fragment->facet, fragment->lit, mask_}, fragment.corners());
  slots_.insert_or_assign(fragment->id, slot);
}

void FragmentBuffers::Impl::add_partition(const Scene& scene, const LightPartition& partition) {
  slots_of_face_.resize(std::max(slots_of_face_.size(), scene.faces().size()));
  for (std::size_t i = 0; i < partition.fragments.size(); ++i) {
    const LightPartition::Fragment& fragment = partition.fragments[i];
    mask_.clear();
    for (std::size_t w = 0; w < partition.words; ++w) {
      const std::uint64_t word = partition.lights[i * partition.words + w];
      mask_.push_back(static_cast<std::uint32_t>(word));
      mask_.push_back(static_cast<std::uint32_t>(word >> 32));
    }
    const bool lit =
        std::any_of(mask_.begin(), mask_.end(), [](std::uint32_t word) { return word != 0; });
    if (!shows(lit)) continue;
    slots_of_face_[fragment.face].push_back(
        add(scene, {fragment.face, fragment.facet, lit, mask_}, partition.corners_of(fragment)));
  }
}

FragmentBuffers::Impl::Slot FragmentBuffers::Impl::add(const Scene& scene, const Source& source,
                                                       std::span<const Vec3> corners) {
  const Vec3& normal = scene.planes()[scene.facets()[source.facet].plane].normal;
  const std::uint32_t object = scene.faces()[source.face].object;
  corners_.assign(corners.begin(), corners.end());
  turn_to_front(corners_, normal);
  const auto count = static_cast<std::uint32_t>(corners_.size());
  const Slot slot = take_slot(count);
  std::uint32_t vertex = slot.first_vertex, index = slot.first_index;
  write_source(vertex, vertices_of(count), source, object, normal);
  if (layout_.indexed) {
    for (const Vec3& x : corners_) write_position(vertex++, x);
    for (std::uint32_t i = 2; i < count; ++i)
      for (const std::uint32_t k : {0u, i - 1, i}) indices_[index++] = slot.first_vertex + k;
  } else {
    for (std::uint32_t i = 2; i < count; ++i)
      for (const std::uint32_t k : {0u, i - 1, i}) write_position(vertex++, corners_[k]);
  }
  ++fragment_count_;
  return slot;
}

void FragmentBuffers::Impl::remove(const Slot& slot) {
  const std::uint32_t vertices = vertices_of(slot.corners), indices = indices_of(slot.corners);
  write_source(slot.first_vertex, vertices, {invalid_index, invalid_index, false, {}},
               invalid_index, Vec3::Zero());
  for (std::uint32_t v = slot.first_vertex; v < slot.first_vertex + vertices; ++v)
    write_position(v, layout_.origin);
  std::fill_n(indices_.begin() + slot.first_index, indices, slot.first_vertex);
  if (slot.corners >= holes_.size()) holes_.resize(slot.corners + 1);
  holes_[slot.corners].push_back({slot, updates_});
  hole_vertices_ += vertices;
  --fragment_count_;
  if (!refilled_) touched_.push_back(slot);
}

FragmentBuffers::Impl::Slot FragmentBuffers::Impl::take_slot(std::uint32_t corners) {
  const std::uint32_t vertices = vertices_of(corners), indices = indices_of(corners);
  if (corners < holes_.size() && !holes_[corners].empty()) {
    const Hole hole = holes_[corners].back();
    holes_[corners].pop_back();
    hole_vertices_ -= vertices;
    if (!refilled_ && hole.made != updates_) touched_.push_back(hole.slot);
    return hole.slot;
  }
  const Slot slot{vertex_count_, index_count_, corners};
  reserve(std::uint64_t{vertex_count_} + vertices, std::uint64_t{index_count_} + indices);
  vertex_count_ += vertices, index_count_ += indices;
  if (!refilled_) touched_.push_back(slot);
  return slot;
}

void FragmentBuffers::Impl::reserve(std::uint64_t vertices, std::uint64_t indices) {
  if (vertices <= vertex_capacity_ && indices <= index_capacity_) return;
  static constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
  if (std::max(vertices, indices) > most)
    throw Error("more than 2^32 vertices or indices in one buffer");
  const auto larger = [](std::uint64_t needed, std::uint32_t capacity) {
    return needed <= capacity ? capacity
                              : static_cast<std::uint32_t>(std::min(needed + needed / 2, most));
  };
  const std::uint32_t capacity = larger(vertices, vertex_capacity_),
                      more_indices = larger(indices, index_capacity_);
  const std::size_t n = capacity;
  if (layout_.doubles) double_positions_.resize(3 * n);
  else positions_.resize(3 * n);
  if (layout_.normals) normals_.resize(3 * n);
  if (layout_.faces) faces_.resize(n);
  if (layout_.objects) objects_.resize(n);
  if (layout_.states) states_.resize(n);
  masks_.resize(mask_words_ * n);
  indices_.resize(more_indices);
  vertex_capacity_ = capacity, index_capacity_ = more_indices;
  grown_ = true;
}

// Only while there is nothing in the buffers.
void FragmentBuffers::Impl::set_mask_words(std::size_t lights) {
  const auto words = static_cast<std::uint32_t>(layout_.masks ? (lights + 31) / 32 : 0);
  if (words == mask_words_) return;
  masks_.assign(std::size_t{words} * vertex_capacity_, 0);
  mask_words_ = words;
  grown_ = true;
}

void FragmentBuffers::Impl::write_position(std::size_t vertex, const Vec3& position) {
  const Vec3 x = position - layout_.origin;
  if (layout_.doubles) {
    std::copy_n(x.data(), 3, double_positions_.data() + 3 * vertex);
  } else {
    for (Eigen::Index k = 0; k < 3; ++k)
      positions_[3 * vertex + static_cast<std::size_t>(k)] = static_cast<float>(x[k]);
  }
}

// What a fragment's vertices have in common.
void FragmentBuffers::Impl::write_source(std::size_t first, std::size_t count, const Source& source,
                                         std::uint32_t object, const Vec3& normal) {
  if (layout_.normals) {
    const Eigen::Vector3f n = normal.cast<float>();
    for (std::size_t v = first; v < first + count; ++v)
      std::copy_n(n.data(), 3, normals_.data() + 3 * v);
  }
  if (layout_.faces) std::fill_n(faces_.data() + first, count, source.face);
  if (layout_.objects) std::fill_n(objects_.data() + first, count, object);
  if (layout_.states)
    std::fill_n(states_.data() + first, count, static_cast<std::uint8_t>(source.lit ? 1 : 0));
  for (std::size_t w = 0; w < mask_words_; ++w) {
    const std::uint32_t word = w < source.mask.size() ? source.mask[w] : 0;
    for (std::size_t v = first; v < first + count; ++v) masks_[v * mask_words_ + w] = word;
  }
}

void FragmentBuffers::Impl::list_changes() {
  changed_vertices_.clear(), changed_indices_.clear();
  if (refilled_ || grown_) {
    if (vertex_count_ > 0) changed_vertices_.push_back({0, vertex_count_});
    if (index_count_ > 0) changed_indices_.push_back({0, index_count_});
    return;
  }
  std::sort(touched_.begin(), touched_.end(),
            [](const Slot& a, const Slot& b) { return a.first_vertex < b.first_vertex; });
  const auto cover = [this](std::vector<Range>& ranges, std::uint32_t first, std::uint32_t count) {
    if (count == 0) return;
    if (!ranges.empty() &&
        first <= std::uint64_t{ranges.back().first} + ranges.back().count + layout_.joined_gap) {
      ranges.back().count = std::max(ranges.back().count, first + count - ranges.back().first);
    } else {
      ranges.push_back({first, count});
    }
  };
  for (const Slot& slot : touched_) {
    cover(changed_vertices_, slot.first_vertex, vertices_of(slot.corners));
    cover(changed_indices_, slot.first_index, indices_of(slot.corners));
  }
}

}  // namespace shadowcut
