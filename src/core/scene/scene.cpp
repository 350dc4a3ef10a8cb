// Scene: imported objects in flat arrays, and the edits that change them.
//
// Every object owns an *allocation*: a range of each array. The allocation of a removed object is
// given to a later object that fits. Objects are in a list by their last change, so that an engine
// finds the changed objects in time proportional to their number.

#include <algorithm>
#include <atomic>

#include "scene/scene_storage.hpp"
#include "support/assert.hpp"

namespace shadowcut {

namespace {

std::uint32_t new_tag() {
  static std::atomic<std::uint32_t> last{0};
  return ++last;
}

template <class T>
void reserve_more(std::vector<T>& v, std::size_t more) {
  if (v.capacity() - v.size() < more) v.reserve(std::max(v.size() + more, 2 * v.capacity()));
}

std::string described(const Light& light, std::size_t index) {
  return light.name.empty() ? "light " + std::to_string(index) : "light '" + light.name + "'";
}

void check_pose(const Pose& pose, const std::string& name) {
  if (!pose.matrix().allFinite() || pose.linear().determinant() == 0)
    throw Error("object '" + name + "': its pose is not finite and invertible");
}

// Makes sure that a range of this size can be appended without an exception.
void reserve(MeshArrays& arrays, const ArrayCounts& counts) {
  if (arrays.edges.size() + counts[edge_array] > max_edges ||
      arrays.corners.size() + counts[corner_array] >= invalid_index)
    throw Error("the scene is larger than 2^29 edges");
  for_each_array([&](ArrayIndex k, auto& v) { reserve_more(v, counts[k]); }, arrays);
}

// Moves the arrays of an object into its ranges: indices, which count from the first element of the
// object, now count from the first element of the scene.
void place(const MeshArrays& from, const ArrayRanges& ranges, std::uint32_t object,
           MeshArrays& to) {
  const auto& [vertex0, edge0, plane0, facet0, corner0, face0] = ranges.first;
  const auto put = [&ranges](ArrayIndex k, const auto& source, auto& target, const auto& shift) {
    std::transform(source.begin(), source.end(), target.begin() + ranges.first[k], shift);
  };
  const auto same = [](const auto& x) { return x; };
  put(vertex_array, from.vertices, to.vertices, same);
  put(plane_array, from.planes, to.planes, same);
  put(edge_array, from.edges, to.edges, [v = vertex0](const Edge& e) {
    return Edge{e.a + v, e.b + v};
  });
  put(corner_array, from.corners, to.corners, [v = vertex0, e = edge0](const Corner& c) {
    return Corner{c.vertex + v, c.edge + (e << 1)};
  });
  put(facet_array, from.facets, to.facets, [f = face0, p = plane0, c = corner0](const Facet& t) {
    return Facet{t.face + f, t.plane + p, t.first_corner + c, t.corner_count};
  });
  put(face_array, from.faces, to.faces, [object, t = facet0](const Face& f) {
    return Face{object, f.number, f.first_facet + t, f.facet_count, f.area};
  });
}

}  // namespace

Scene::Scene() : tag_(new_tag()) {}
Scene::~Scene() = default;
Scene::Scene(const Scene&) = default;
Scene& Scene::operator=(const Scene&) = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

void Scene::touch(std::uint32_t index) {
  SHADOWCUT_ASSERT(index < slots_.size() && slots_.size() == objects_.size());
  slots_[index].revision = ++revision_;
  make_newest(index);
}

// Puts an object at the end of the list by last change.
void Scene::make_newest(std::uint32_t index) {
  Slot& slot = slots_[index];
  if (newest_ == index) return;
  if (slot.older != invalid_index) slots_[slot.older].newer = slot.newer;
  if (slot.newer != invalid_index) slots_[slot.newer].older = slot.older;
  SHADOWCUT_ASSERT(newest_ == invalid_index || slots_[newest_].newer == invalid_index);
  slot.older = newest_;
  slot.newer = invalid_index;
  if (newest_ != invalid_index) slots_[newest_].newer = index;
  newest_ = index;
}

// Imports an object into an allocation that fits. An exception leaves the scene as it was.
void Scene::import_object(std::uint32_t index, std::shared_ptr<const Source> source,
                          const ObjectSettings& settings) {
  ImportedMesh in =
      import_mesh(source->mesh, settings.pose, {flatness_tolerance, coplanarity_tolerance});
  const ArrayCounts counts = counts_of(in);
  try {
    reserve(arrays_, counts);
  } catch (const Error& e) {
    throw Error("object '" + settings.name + "': " + e.what());
  }
  reserve_more(allocations_, 1);
  reserve_more(issues_, in.issues.size());
  auto with_map = std::make_shared<Source>(
      Source{source->mesh, settings.sides, std::move(in.vertex_of), std::move(in.origins)});
  Slot& slot = slots_[index];
  decltype(free_allocations_) given_up;  // memory for that comes first, too
  if (slot.allocation != invalid_index)
    given_up.emplace(allocations_[slot.allocation].ranges.count[corner_array], slot.allocation);
  std::string name = settings.name;

  // From here on nothing throws.
  if (slot.allocation != invalid_index) {
    Allocation& old = allocations_[slot.allocation];
    clear(arrays_, old.ranges);
    std::erase_if(issues_, [index](const Issue& i) { return i.object == index; });
    if (!old.ranges.has_room_for(counts)) {
      old.owner = invalid_index;
      free_allocations_.merge(given_up);
      slot.allocation = invalid_index;
    }
  }
  if (slot.allocation == invalid_index) allocate(index, counts);
  const ArrayRanges& ranges = allocations_[slot.allocation].ranges;
  SHADOWCUT_ASSERT(ranges.has_room_for(counts) && allocations_[slot.allocation].owner == index);
  place(in, ranges, index, arrays_);

  Object& o = objects_[index];
  o.name = std::move(name);
  o.sides = settings.sides != Sides::automatic ? settings.sides
            : in.closed                        ? Sides::closed
                                               : Sides::open;
  o.casts_shadows = settings.casts_shadows, o.receives_shadows = settings.receives_shadows;
  o.dynamic = settings.dynamic;
  o.first_face = ranges.first[face_array], o.face_count = counts[face_array];
  o.first_vertex = ranges.first[vertex_array], o.vertex_count = counts[vertex_array];
  o.first_facet = ranges.first[facet_array], o.facet_count = counts[facet_array];
  o.first_edge = ranges.first[edge_array], o.edge_count = counts[edge_array];
  o.signed_volume = in.signed_volume;
  o.aligned = in.aligned, o.aligned_by = in.aligned_by;
  o.pose = settings.pose;
  o.alive = true;
  for (Issue& i : in.issues) {
    i.object = index;
    issues_.push_back(std::move(i));
  }
  slot.source = std::move(with_map);
  touch(index);
}

// Gives an object the smallest of some free allocations with enough of everything, or a new one at
// the end.
void Scene::allocate(std::uint32_t index, const ArrayCounts& counts) {
  int tries = 16;
  for (auto it = free_allocations_.lower_bound(counts[corner_array]);
       it != free_allocations_.end() && tries > 0; ++it, --tries) {
    Allocation& free = allocations_[it->second];
    if (!free.ranges.has_room_for(counts)) continue;
    free.owner = index;
    slots_[index].allocation = it->second;
    free_allocations_.erase(it);
    return;
  }
  slots_[index].allocation = count_of(allocations_);
  allocations_.push_back({{counts_of(arrays_), counts}, index});
  grow_to(arrays_, allocations_.back().ranges);
}

ObjectId Scene::add(const Mesh& mesh, const ObjectSettings& settings) {
  check_pose(settings.pose, settings.name);
  auto source = std::make_shared<const Source>(Source{mesh, settings.sides, {}, {}});
  const bool fresh = free_objects_.empty();
  const std::uint32_t index = fresh ? count_of(objects_) : free_objects_.back();
  if (fresh) {
    reserve_more(objects_, 1);
    reserve_more(slots_, 1);
    // removing never fails
    reserve_more(free_objects_, objects_.size() + 1 - free_objects_.size());
    Object empty{};
    empty.alive = false;
    objects_.push_back(std::move(empty));
    slots_.emplace_back();
  }
  try {
    import_object(index, std::move(source), settings);
  } catch (...) {
    if (fresh) objects_.pop_back(), slots_.pop_back();
    throw;
  }
  if (!fresh) free_objects_.pop_back();
  return object_id(index);
}

template <class Id, class Slots, class Alive>
Status Scene::status(Id id, const Slots& slots, const Alive& alive) const {
  if (id.scene != tag_ || id.index >= slots.size()) return Status::foreign;
  return alive(id.index) && slots[id.index].generation == id.generation ? Status::ok
                                                                        : Status::stale;
}
Status Scene::status(ObjectId id) const {
  return status(id, slots_, [this](std::uint32_t i) { return objects_[i].alive; });
}
Status Scene::status(LightId id) const {
  return status(id, light_slots_, [this](std::uint32_t i) { return light_slots_[i].alive; });
}

Status Scene::remove(ObjectId id) {
  if (const Status s = status(id); s != Status::ok) return s;
  Slot& slot = slots_[id.index];
  Allocation& allocation = allocations_[slot.allocation];
  free_allocations_.emplace(allocation.ranges.count[corner_array], slot.allocation);
  clear(arrays_, allocation.ranges);
  std::erase_if(issues_, [id](const Issue& i) { return i.object == id.index; });
  allocation.owner = invalid_index;
  slot.allocation = invalid_index;
  slot.source.reset();
  ++slot.generation;
  Object dead{};
  dead.alive = false;
  objects_[id.index] = std::move(dead);
  free_objects_.push_back(id.index);
  touch(id.index);
  return Status::ok;
}

Status Scene::set_pose(ObjectId id, const Pose& pose) {
  if (const Status s = status(id); s != Status::ok) return s;
  Object& o = objects_[id.index];
  check_pose(pose, o.name);
  const std::shared_ptr<const Source> source = slots_[id.index].source;
  const std::uint32_t first_plane =
      allocations_[slots_[id.index].allocation].ranges.first[plane_array];
  const Tolerances tolerances{flatness_tolerance, coplanarity_tolerance};
  const RigidMotion motion{source->mesh, source->vertex_of, source->origins, pose, tolerances};
  if (const auto moved = apply_rigid_motion(motion, *this, o, first_plane)) {
    std::copy(moved->vertices.begin(), moved->vertices.end(),
              arrays_.vertices.begin() + o.first_vertex);
    std::copy(moved->planes.begin(), moved->planes.end(), arrays_.planes.begin() + first_plane);
    for (std::uint32_t f = 0; f < o.face_count; ++f)
      arrays_.faces[o.first_face + f].area = moved->areas[f];
    o.pose = pose;
    touch(id.index);
  } else {
    import_object(id.index, source,
                  {o.name, pose, source->sides, o.casts_shadows, o.receives_shadows, o.dynamic});
  }
  return Status::ok;
}

Status Scene::set_vertices(ObjectId id, std::span<const Vec3> local) {
  if (const Status s = status(id); s != Status::ok) return s;
  const Object& o = objects_[id.index];
  const Source& old = *slots_[id.index].source;
  if (local.size() != old.mesh.vertices.size()) {
    throw Error("object '" + o.name + "': its mesh has " +
                std::to_string(old.mesh.vertices.size()) + " vertices, and " +
                std::to_string(local.size()) + " were given");
  }
  Source changed{old.mesh, old.sides, {}, {}};
  changed.mesh.vertices.assign(local.begin(), local.end());
  import_object(id.index, std::make_shared<const Source>(std::move(changed)),
                {o.name, o.pose, old.sides, o.casts_shadows, o.receives_shadows, o.dynamic});
  return Status::ok;
}

Status Scene::set_casts_shadows(ObjectId id, bool casts) {
  if (const Status s = status(id); s != Status::ok) return s;
  objects_[id.index].casts_shadows = casts;
  touch(id.index);
  return Status::ok;
}

Status Scene::set_receives_shadows(ObjectId id, bool receives) {
  if (const Status s = status(id); s != Status::ok) return s;
  objects_[id.index].receives_shadows = receives;
  touch(id.index);
  return Status::ok;
}

LightId Scene::add(const Light& light) {
  const bool fresh = free_lights_.empty();
  const std::uint32_t index = fresh ? count_of(lights_) : free_lights_.back();
  light.check(described(light, index));
  if (fresh) {
    reserve_more(light_slots_, 1);
    reserve_more(free_lights_, lights_.size() + 1 - free_lights_.size());
    lights_.push_back(light);
    light_slots_.emplace_back();
  } else {
    lights_[index] = Light(light);  // copied before anything changes
    free_lights_.pop_back();
  }
  light_slots_[index].alive = true;
  light_slots_[index].revision = ++revision_;
  return light_id(index);
}

Status Scene::remove(LightId id) {
  if (const Status s = status(id); s != Status::ok) return s;
  LightSlot& slot = light_slots_[id.index];
  slot.alive = false;
  ++slot.generation;
  slot.revision = ++revision_;
  free_lights_.push_back(id.index);
  return Status::ok;
}

Status Scene::set_light(LightId id, const Light& light) {
  if (const Status s = status(id); s != Status::ok) return s;
  light.check(described(light, id.index));
  lights_[id.index] = Light(light);  // copied before anything changes
  light_slots_[id.index].revision = ++revision_;
  return Status::ok;
}

void Scene::replace_lights(std::span<const Light> lights) {
  const std::vector<Light> fresh(lights.begin(), lights.end());  // they may be our own
  for (std::size_t i = 0; i < fresh.size(); ++i) fresh[i].check(described(fresh[i], i));
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    if (light_slots_[i].alive) static_cast<void>(remove(light_id(i)));
  }
  std::sort(free_lights_.rbegin(), free_lights_.rend());
  for (const Light& light : fresh) add(light);
}

const Object* Scene::find(ObjectId id) const {
  return status(id) == Status::ok ? &objects_[id.index] : nullptr;
}
const Light* Scene::find(LightId id) const {
  return status(id) == Status::ok ? &lights_[id.index] : nullptr;
}

std::optional<std::pair<Mesh, ObjectSettings>> Scene::source(ObjectId id) const {
  const Object* o = find(id);
  if (o == nullptr) return std::nullopt;
  const Source& source = *slots_[id.index].source;
  return std::pair(source.mesh, ObjectSettings{o->name, o->pose, source.sides, o->casts_shadows,
                                               o->receives_shadows, o->dynamic});
}

ObjectId Scene::object_id(std::size_t index) const {
  if (index >= objects_.size() || !objects_[index].alive) return {};
  return {static_cast<std::uint32_t>(index), slots_[index].generation, tag_};
}
LightId Scene::light_id(std::size_t index) const {
  if (index >= lights_.size() || !light_slots_[index].alive) return {};
  return {static_cast<std::uint32_t>(index), light_slots_[index].generation, tag_};
}

}  // namespace shadowcut
