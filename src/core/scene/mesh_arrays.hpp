// The six arrays of a scene or of a mesh, one after another.
#pragma once

#include <array>
#include <cstdint>
#include <shadowcut/scene.hpp>

namespace shadowcut {

enum ArrayIndex : std::size_t {
  vertex_array,
  edge_array,
  plane_array,
  facet_array,
  corner_array,
  face_array,
  array_count
};

// Calls f(index, array...) for each of the six arrays of one or more MeshArrays.
template <class F, class... Arrays>
void for_each_array(const F& f, Arrays&&... arrays) {
  f(vertex_array, arrays.vertices...);
  f(edge_array, arrays.edges...);
  f(plane_array, arrays.planes...);
  f(facet_array, arrays.facets...);
  f(corner_array, arrays.corners...);
  f(face_array, arrays.faces...);
}

using ArrayCounts = std::array<std::uint32_t, array_count>;

inline ArrayCounts counts_of(const MeshArrays& arrays) {
  ArrayCounts counts{};
  for_each_array(
      [&](ArrayIndex k, const auto& v) { counts[k] = static_cast<std::uint32_t>(v.size()); },
      arrays);
  return counts;
}

// A range of every array.
struct ArrayRanges {
  ArrayCounts first, count;

  bool has_room_for(const ArrayCounts& counts) const {
    for (std::size_t k = 0; k < array_count; ++k) {
      if (counts[k] > count[k]) return false;
    }
    return true;
  }
};

// What stands in the holes of the arrays: a facet without corners, a face without facets.
inline Vec3 hole_in(const std::vector<Vec3>&) { return Vec3::Zero(); }
inline Edge hole_in(const std::vector<Edge>&) { return {0, 0}; }
inline Plane hole_in(const std::vector<Plane>&) {
  return {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), 0, 0};
}
inline Facet hole_in(const std::vector<Facet>&) { return {0, 0, 0, 0}; }
inline Corner hole_in(const std::vector<Corner>&) { return {0, 0}; }
inline Face hole_in(const std::vector<Face>&) { return {invalid_index, 0, 0, 0, 0.0}; }

}  // namespace shadowcut
