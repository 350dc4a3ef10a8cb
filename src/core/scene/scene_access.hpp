// The part of a scene that engines need to follow it: revisions, and copies of single objects at
// the same indices.
#pragma once

#include <cstdint>
#include <shadowcut/scene.hpp>
#include <span>
#include <vector>

namespace shadowcut {

class SceneAccess {
 public:
  // The number of changes made to the scene, and the revision in which an object or a light was
  // changed last.
  static std::uint64_t revision(const Scene& scene) { return scene.revision_; }
  static std::uint64_t object_revision(const Scene& scene, std::size_t index);
  static std::uint64_t light_revision(const Scene& scene, std::size_t index);
  // The indices of the objects changed after a revision, the least recently changed one first.
  // Cost: proportional to their number.
  static std::vector<std::uint32_t> changed_since(const Scene& scene, std::uint64_t revision);

  // Copies objects from another scene, to the same indices in all arrays. Together the objects must
  // own every allocation that they own there (see owner_of_allocation).
  static void copy_objects(Scene& to, const Scene& from, std::span<const std::uint32_t> indices);
  static void copy_light(Scene& to, const Scene& from, std::uint32_t index);
  // The object of `scene` that owns the allocation which the object `index` owns in `other`;
  // invalid_index if it is free.
  static std::uint32_t owner_of_allocation(const Scene& scene, const Scene& other,
                                           std::uint32_t index);
};

}  // namespace shadowcut
