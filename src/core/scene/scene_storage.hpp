// The private parts of a scene: allocations in its arrays, and slots of objects and lights.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "scene/mesh_arrays.hpp"
#include "scene/mesh_import.hpp"

namespace shadowcut {

struct Scene::Source {
  Mesh mesh;
  Sides sides;                           // as in the settings
  std::vector<std::uint32_t> vertex_of;  // see ImportedMesh
  std::vector<PlaneOrigin> origins;      // likewise
};

struct Scene::Allocation {
  ArrayRanges ranges;
  std::uint32_t owner;  // index of an object, or invalid_index
};

struct Scene::Slot {
  std::uint32_t generation = 0;
  std::uint32_t allocation = invalid_index;
  std::uint64_t revision = 0;
  // the objects in the order of their last change
  std::uint32_t older = invalid_index, newer = invalid_index;
  std::shared_ptr<const Source> source;
};

struct Scene::LightSlot {
  std::uint32_t generation = 0;
  bool alive = false;
  std::uint64_t revision = 0;
};

template <class T>
std::uint32_t count_of(const T& v) {
  return static_cast<std::uint32_t>(v.size());
}

// Makes the arrays long enough to hold a range.
inline void grow_to(MeshArrays& arrays, const ArrayRanges& ranges) {
  for_each_array(
      [&](ArrayIndex k, auto& v) {
        const std::size_t end = std::size_t{ranges.first[k]} + ranges.count[k];
        if (v.size() < end) v.resize(end, hole_in(v));
      },
      arrays);
}

// Takes the facets and faces of an object out of the arrays.
inline void clear(MeshArrays& arrays, const ArrayRanges& ranges) {
  const auto fill = [&ranges](ArrayIndex k, auto& v) {
    std::fill_n(v.begin() + ranges.first[k], ranges.count[k], hole_in(v));
  };
  fill(facet_array, arrays.facets);
  fill(face_array, arrays.faces);
}

}  // namespace shadowcut
