// The state of FragmentBuffers: the slots of fragments in the vertex and index arrays.
#pragma once

#include <tsl/robin_map.h>

#include <shadowcut/buffers.hpp>
#include <vector>

#include "support/hash.hpp"

namespace shadowcut {

struct FragmentIdHash {
  std::size_t operator()(const FragmentId& id) const {
    return mix((std::uint64_t{id.cell} << 32 | id.piece) ^ mix(id.place));
  }
};

struct FragmentBuffers::Impl {
  struct Slot {  // of a fragment
    std::uint32_t first_vertex, first_index, corners;
  };
  struct Hole {
    Slot slot;
    std::uint64_t made;  // in which update
  };
  struct Source {  // what all vertices of a fragment have in common
    std::uint32_t face, facet;
    bool lit;
    std::span<const std::uint32_t> mask;
  };

  Impl(std::uint32_t light, const BufferLayout& layout);
  void set_origin(const Vec3& origin);
  void update(const Engine& engine, const Changes& changes);
  void fill(const Engine& engine);
  void fill(const Scene& scene, const Shadows& shadows);
  void fill(const Scene& scene, const LightPartition& partition);

  std::uint32_t vertices_of(std::uint32_t corners) const {
    return layout_.indexed ? corners : 3 * (corners - 2);
  }
  std::uint32_t indices_of(std::uint32_t corners) const {
    return layout_.indexed ? 3 * (corners - 2) : 0;
  }
  bool shows(bool lit) const {
    return layout_.show == Show::all || lit == (layout_.show == Show::lit);
  }
  void begin();
  void follow(const Engine& engine, const Changes& changes, bool next);
  void refill(const Engine& engine);
  void clear();
  void apply(const Engine& engine, const LightChanges& change);
  bool apply_to_faces(const Engine& engine, const Changes& changes);
  void add_shadows(const Scene& scene, const Shadows& shadows);
  void add_fragment(const Scene& scene, const FragmentView& fragment);
  void add_partition(const Scene& scene, const LightPartition& partition);
  Slot add(const Scene& scene, const Source& source, std::span<const Vec3> corners);
  void remove(const Slot& slot);
  Slot take_slot(std::uint32_t corners);
  void reserve(std::uint64_t vertices, std::uint64_t indices);
  void set_mask_words(std::size_t lights);
  void write_position(std::size_t vertex, const Vec3& position);
  void write_source(std::size_t first, std::size_t count, const Source& source,
                    std::uint32_t object, const Vec3& normal);
  void list_changes();

  std::uint32_t light_;
  BufferLayout layout_;
  std::uint64_t seen_ = 0;  // the last update applied; 0: the next one cannot be applied to it
  std::uint32_t vertex_count_ = 0, vertex_capacity_ = 0, index_count_ = 0, index_capacity_ = 0;
  std::uint32_t fragment_count_ = 0, hole_vertices_ = 0, mask_words_ = 0;
  std::vector<float> positions_, normals_;
  std::vector<double> double_positions_;
  std::vector<std::uint32_t> faces_, objects_, masks_, indices_;
  std::vector<std::uint8_t> states_;

  tsl::robin_map<FragmentId, Slot, FragmentIdHash> slots_;  // of one light
  std::vector<std::vector<Slot>> slots_of_face_;            // of all lights
  std::vector<std::vector<Hole>> holes_;                    // by their number of corners
  std::vector<Slot> touched_;                               // since the update began
  std::uint64_t updates_ = 0;
  bool refilled_ = false, grown_ = false;
  std::vector<Range> changed_vertices_, changed_indices_;
  std::vector<std::uint32_t> mask_;  // of the current fragment
  std::vector<Vec3> corners_;        // of the current fragment
};

}  // namespace shadowcut
