// How an engine follows a scene: revisions, and copies of single objects at the same indices.

#include "scene/scene_access.hpp"

#include <algorithm>

#include "scene/scene_storage.hpp"
#include "support/assert.hpp"

namespace shadowcut {

std::uint64_t SceneAccess::object_revision(const Scene& scene, std::size_t index) {
  return scene.slots_[index].revision;
}
std::uint64_t SceneAccess::light_revision(const Scene& scene, std::size_t index) {
  return scene.light_slots_[index].revision;
}

std::vector<std::uint32_t> SceneAccess::changed_since(const Scene& scene, std::uint64_t revision) {
  std::vector<std::uint32_t> changed;
  for (std::uint32_t i = scene.newest_; i != invalid_index && scene.slots_[i].revision > revision;
       i = scene.slots_[i].older)
    changed.push_back(i);
  std::reverse(changed.begin(), changed.end());
  return changed;
}

std::uint32_t SceneAccess::owner_of_allocation(const Scene& scene, const Scene& other,
                                               std::uint32_t index) {
  const std::uint32_t allocation =
      index < other.slots_.size() ? other.slots_[index].allocation : invalid_index;
  return allocation < scene.allocations_.size() ? scene.allocations_[allocation].owner
                                                : invalid_index;
}

void SceneAccess::copy_objects(Scene& to, const Scene& from,
                               std::span<const std::uint32_t> indices) {
  if (to.objects_.size() < from.objects_.size()) {
    Object empty{};
    empty.alive = false;
    for (std::uint32_t i = count_of(to.objects_); i < from.objects_.size(); ++i)
      to.free_objects_.push_back(i);
    to.objects_.resize(from.objects_.size(), empty);
    to.slots_.resize(from.slots_.size());
  }
  for (std::size_t a = to.allocations_.size(); a < from.allocations_.size(); ++a) {
    to.allocations_.push_back({from.allocations_[a].ranges, invalid_index});
    grow_to(to.arrays_, to.allocations_[a].ranges);
    to.free_allocations_.emplace(to.allocations_[a].ranges.count[corner_array],
                                 static_cast<std::uint32_t>(a));
  }
  for (const std::uint32_t i : indices) to.release_copy(i);
  for (const std::uint32_t i : indices) to.take_copy(from, i);
  for (const Issue& i : from.issues_) {
    if (std::find(indices.begin(), indices.end(), i.object) != indices.end())
      to.issues_.push_back(i);
  }
}

// Frees the allocation of an object that is to be copied.
void Scene::release_copy(std::uint32_t index) {
  const std::uint32_t allocation = slots_[index].allocation;
  if (allocation == invalid_index) return;
  const ArrayRanges& ranges = allocations_[allocation].ranges;
  clear(arrays_, ranges);
  std::erase_if(issues_, [index](const Issue& i) { return i.object == index; });
  allocations_[allocation].owner = invalid_index;
  free_allocations_.emplace(ranges.count[corner_array], allocation);
}

// Copies an object into the allocation that it owns in the other scene, which is free here.
void Scene::take_copy(const Scene& from, std::uint32_t index) {
  SHADOWCUT_ASSERT(index < from.slots_.size() && index < slots_.size());
  const Slot& source = from.slots_[index];
  if (objects_[index].alive != from.objects_[index].alive) {
    if (from.objects_[index].alive) std::erase(free_objects_, index);
    else free_objects_.push_back(index);
  }
  objects_[index] = from.objects_[index];
  Slot& slot = slots_[index];
  slot.allocation = source.allocation;
  slot.generation = source.generation;
  slot.revision = source.revision;
  slot.source = source.source;
  revision_ = std::max(revision_, source.revision);
  make_newest(index);
  if (slot.allocation == invalid_index) return;
  Allocation& allocation = allocations_[slot.allocation];
  SHADOWCUT_ASSERT(allocation.owner == invalid_index);
  allocation.owner = index;
  const auto [first, last] = free_allocations_.equal_range(allocation.ranges.count[corner_array]);
  free_allocations_.erase(
      std::find_if(first, last, [&slot](const auto& a) { return a.second == slot.allocation; }));
  for_each_array(
      [&ranges = allocation.ranges](ArrayIndex k, auto& target, const auto& other) {
        std::copy_n(other.begin() + ranges.first[k], ranges.count[k],
                    target.begin() + ranges.first[k]);
      },
      arrays_, from.arrays_);
}

void SceneAccess::copy_light(Scene& to, const Scene& from, std::uint32_t index) {
  while (to.lights_.size() < from.lights_.size()) {
    to.free_lights_.push_back(count_of(to.lights_));
    to.lights_.emplace_back();
    to.light_slots_.emplace_back();
  }
  const bool was_alive = to.light_slots_[index].alive, is_alive = from.light_slots_[index].alive;
  if (was_alive && !is_alive) to.free_lights_.push_back(index);
  if (!was_alive && is_alive) std::erase(to.free_lights_, index);
  to.lights_[index] = from.lights_[index];
  to.light_slots_[index] = from.light_slots_[index];
  to.revision_ = std::max(to.revision_, to.light_slots_[index].revision);
}

}  // namespace shadowcut
