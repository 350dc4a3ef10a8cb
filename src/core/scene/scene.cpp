// Scene: what has passed the door, in flat arrays, and the edits that change it.
//
// Every object has its *room*: a stretch of each array. A removed object's room is given to a later
// one that fits. Objects stand in a list by their last change, so that an engine finds what is new
// in time proportional to that.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

#include "scene/mesh_import.hpp"

namespace shadowcut {

void Mesh::add_face(std::span<const std::uint32_t> outer) {
  corners_.insert(corners_.end(), outer.begin(), outer.end());
  loop_ends_.push_back(corners_.size());
  face_ends_.push_back(loop_ends_.size());
}

void Mesh::add_hole(std::span<const std::uint32_t> loop) {
  if (face_ends_.empty()) throw Error("a hole needs a face");
  corners_.insert(corners_.end(), loop.begin(), loop.end());
  loop_ends_.push_back(corners_.size());
  face_ends_.back() = loop_ends_.size();
}

std::size_t Mesh::loop_count(std::size_t face) const {
  return face_ends_[face] - (face ? face_ends_[face - 1] : 0);
}

std::span<const std::uint32_t> Mesh::loop(std::size_t face, std::size_t k) const {
  const std::size_t l = (face ? face_ends_[face - 1] : 0) + k;
  const std::size_t begin = l ? loop_ends_[l - 1] : 0;
  return std::span(corners_).subspan(begin, loop_ends_[l] - begin);
}

const char* describe(Reason reason) {
  switch (reason) {
    case Reason::non_finite:
      return "a coordinate is not finite";
    case Reason::index_out_of_range:
      return "a corner's index is out of range";
    case Reason::too_few_corners:
      return "fewer than three distinct corners";
    case Reason::zero_area:
      return "zero area";
    case Reason::self_intersecting:
      return "the outline intersects itself";
    case Reason::duplicate:
      return "duplicate of an earlier face";
    case Reason::repeated_corner:
      return "repeated corner removed";
    case Reason::not_flat:
      return "not flat, triangulated";
  }
  return "";
}

bool refuses(Reason reason) {
  return reason != Reason::repeated_corner && reason != Reason::not_flat;
}

void check(const Light& light, const std::string& who) {
  if (!light.at.allFinite()) throw Error(who + ": a coordinate is not finite");
  if (light.kind == Light::Kind::directional && light.at.isZero(0))
    throw Error(who + ": its direction is zero");
  if (!(light.range > 0)) throw Error(who + ": its range is not positive");
  if (light.spot) {
    if (!light.spot->axis.allFinite() || light.spot->axis.isZero(0))
      throw Error(who + ": its spot axis is zero or not finite");
    if (!(light.spot->half_angle > 0) || light.spot->half_angle > std::numbers::pi)
      throw Error(who + ": its spot angle is not in (0, pi]");
  }
}

struct Scene::Source {
  Mesh mesh;
  Sides sides;                           // as asked for
  std::vector<std::uint32_t> vertex_of;  // see Admitted
  std::vector<PlaneOrigin> origins;      // likewise
};

namespace {

enum Array : std::size_t {
  vertex_array,
  edge_array,
  plane_array,
  facet_array,
  corner_array,
  face_array
};

std::uint32_t new_tag() {
  static std::atomic<std::uint32_t> last{0};
  return ++last;
}

template <class T>
std::uint32_t count_of(const T& v) {
  return static_cast<std::uint32_t>(v.size());
}

template <class T>
void reserve_more(std::vector<T>& v, std::size_t more) {
  if (v.capacity() - v.size() < more) v.reserve(std::max(v.size() + more, 2 * v.capacity()));
}

constexpr Facet no_facet{0, 0, 0, 0};
constexpr Face no_face{none, 0, 0, 0, 0.0};

void check_pose(const Pose& pose, const std::string& name) {
  if (!pose.matrix().allFinite() || pose.linear().determinant() == 0)
    throw Error("object '" + name + "': its pose is not finite and invertible");
}

}  // namespace

Scene::Scene() : tag_(new_tag()) {}

// Makes sure that a room of this size can be taken without an exception.
void Scene::reserve_room(const std::uint32_t (&counts)[6]) {
  if (edges_.size() + counts[edge_array] > max_edges ||
      corners_.size() + counts[corner_array] >= none)
    throw Error("the scene is larger than 2^29 edges");
  reserve_more(vertices_, counts[vertex_array]);
  reserve_more(edges_, counts[edge_array]);
  reserve_more(planes_, counts[plane_array]);
  reserve_more(facets_, counts[facet_array]);
  reserve_more(corners_, counts[corner_array]);
  reserve_more(faces_, counts[face_array]);
  reserve_more(rooms_, 1);
}

void Scene::grow_to(const Room& room) {
  const auto grow = [&room](auto& v, Array a, const auto& filler) {
    const std::size_t end = std::size_t{room.first[a]} + room.count[a];
    if (v.size() < end) v.resize(end, filler);
  };
  grow(vertices_, vertex_array, Vec3(Vec3::Zero()));
  grow(edges_, edge_array, Edge{0, 0});
  grow(planes_, plane_array, Plane{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), 0, 0});
  grow(facets_, facet_array, no_facet);
  grow(corners_, corner_array, Corner{0, 0});
  grow(faces_, face_array, no_face);
}

// The smallest free room with enough of everything, or a new one at the end.
void Scene::take_room(std::uint32_t index, const std::uint32_t (&counts)[6]) {
  int tries = 16;
  for (auto it = free_rooms_.lower_bound(counts[corner_array]);
       it != free_rooms_.end() && tries > 0; ++it, --tries) {
    Room& room = rooms_[it->second];
    if (!std::equal(counts, counts + 6, room.count,
                    [](std::uint32_t want, std::uint32_t have) { return want <= have; }))
      continue;
    room.owner = index;
    slots_[index].room = it->second;
    free_rooms_.erase(it);
    return;
  }
  Room room{{count_of(vertices_), count_of(edges_), count_of(planes_), count_of(facets_),
             count_of(corners_), count_of(faces_)},
            {},
            index};
  std::copy(counts, counts + 6, room.count);
  slots_[index].room = count_of(rooms_);
  rooms_.push_back(room);
  grow_to(room);
}

// Takes an object's facets and faces out of the arrays; its room stays its own.
void Scene::clear_room(std::uint32_t index) {
  const Room& room = rooms_[slots_[index].room];
  std::fill_n(facets_.begin() + room.first[facet_array], room.count[facet_array], no_facet);
  std::fill_n(faces_.begin() + room.first[face_array], room.count[face_array], no_face);
  std::erase_if(issues_, [index](const Issue& i) { return i.object == index; });
}

void Scene::touch(std::uint32_t index) {
  slots_[index].revision = ++revision_;
  make_newest(index);
}

// Puts an object at the end of the list by last change.
void Scene::make_newest(std::uint32_t index) {
  Slot& slot = slots_[index];
  if (newest_ == index) return;
  if (slot.older != none) slots_[slot.older].newer = slot.newer;
  if (slot.newer != none) slots_[slot.newer].older = slot.older;
  slot.older = newest_;
  slot.newer = none;
  if (newest_ != none) slots_[newest_].newer = index;
  newest_ = index;
}

std::vector<std::uint32_t> Scene::changed_since(std::uint64_t revision) const {
  std::vector<std::uint32_t> changed;
  for (std::uint32_t i = newest_; i != none && slots_[i].revision > revision; i = slots_[i].older)
    changed.push_back(i);
  std::reverse(changed.begin(), changed.end());
  return changed;
}

// Puts an object through the door, into room that fits. An exception leaves the scene as it was.
void Scene::admit(std::uint32_t index, std::shared_ptr<const Source> source,
                  const ObjectSettings& settings) {
  Admitted in =
      shadowcut::admit(source->mesh, settings.pose, {flatness_tolerance, coplanarity_tolerance});
  const std::uint32_t counts[6] = {count_of(in.vertices), count_of(in.edges),   count_of(in.planes),
                                   count_of(in.facets),   count_of(in.corners), count_of(in.faces)};
  try {
    reserve_room(counts);
  } catch (const Error& e) {
    throw Error("object '" + settings.name + "': " + e.what());
  }
  reserve_more(issues_, in.issues.size());
  auto with_map = std::make_shared<Source>(
      Source{source->mesh, settings.sides, std::move(in.vertex_of), std::move(in.origins)});
  decltype(free_rooms_) given_up;  // memory for that comes first, too
  if (slots_[index].room != none)
    given_up.emplace(rooms_[slots_[index].room].count[corner_array], slots_[index].room);
  std::string name = settings.name;

  std::uint32_t old = slots_[index].room;
  if (old != none) {
    clear_room(index);
    const Room& room = rooms_[old];
    if (!std::equal(counts, counts + 6, room.count,
                    [](std::uint32_t want, std::uint32_t have) { return want <= have; })) {
      rooms_[old].owner = none;
      free_rooms_.merge(given_up);
      old = none;
    }
  }
  if (old == none) take_room(index, counts);
  const Room& room = rooms_[slots_[index].room];
  const std::uint32_t vertex0 = room.first[vertex_array], edge0 = room.first[edge_array],
                      plane0 = room.first[plane_array], facet0 = room.first[facet_array],
                      corner0 = room.first[corner_array], face0 = room.first[face_array];

  Object& o = objects_[index];
  o.name = std::move(name);
  o.sides = settings.sides != Sides::automatic ? settings.sides
            : in.closed                        ? Sides::closed
                                               : Sides::open;
  o.casts = settings.casts, o.receives = settings.receives, o.moves = settings.moves;
  o.first_face = face0, o.face_count = counts[face_array];
  o.first_vertex = vertex0, o.vertex_count = counts[vertex_array];
  o.first_facet = facet0, o.facet_count = counts[facet_array];
  o.first_edge = edge0, o.edge_count = counts[edge_array];
  o.signed_volume = in.signed_volume;
  o.aligned = in.aligned, o.aligned_by = in.aligned_by;
  o.pose = settings.pose;
  o.alive = true;
  std::copy(in.vertices.begin(), in.vertices.end(), vertices_.begin() + vertex0);
  std::copy(in.planes.begin(), in.planes.end(), planes_.begin() + plane0);
  std::transform(in.edges.begin(), in.edges.end(), edges_.begin() + edge0, [=](const Edge& e) {
    return Edge{e.a + vertex0, e.b + vertex0};
  });
  std::transform(in.corners.begin(), in.corners.end(), corners_.begin() + corner0,
                 [=](const Corner& c) {
                   return Corner{c.vertex + vertex0, c.edge + (edge0 << 1)};
                 });
  for (std::uint32_t f = 0; f < counts[face_array]; ++f) {
    Face& face = faces_[face0 + f] = in.faces[f];
    face.object = index;
    for (std::uint32_t k = face.first_facet; k < face.first_facet + face.facet_count; ++k) {
      const Facet& t = in.facets[k];
      facets_[facet0 + k] = {face0 + f, t.plane + plane0, t.first_corner + corner0, t.corner_count};
    }
    face.first_facet += facet0;
  }
  for (Issue& i : in.issues) {
    i.object = index;
    issues_.push_back(std::move(i));
  }
  slots_[index].source = std::move(with_map);
  touch(index);
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
    admit(index, std::move(source), settings);
  } catch (...) {
    if (fresh) objects_.pop_back(), slots_.pop_back();
    throw;
  }
  if (!fresh) free_objects_.pop_back();
  return object_id(index);
}

template <class Id, class Slots, class Alive>
Edit Scene::locate(Id id, const Slots& slots, const Alive& alive) const {
  if (id.scene != tag_ || id.index >= slots.size()) return Edit::foreign;
  return alive(id.index) && slots[id.index].generation == id.generation ? Edit::done : Edit::stale;
}
Edit Scene::locate(ObjectId id) const {
  return locate(id, slots_, [this](std::uint32_t i) { return objects_[i].alive; });
}
Edit Scene::locate(LightId id) const {
  return locate(id, light_slots_, [this](std::uint32_t i) { return light_slots_[i].alive; });
}

Edit Scene::remove(ObjectId id) {
  if (const Edit e = locate(id); e != Edit::done) return e;
  Slot& slot = slots_[id.index];
  free_rooms_.emplace(rooms_[slot.room].count[corner_array], slot.room);
  clear_room(id.index);
  rooms_[slot.room].owner = none;
  slot.room = none;
  slot.source.reset();
  ++slot.generation;
  Object dead{};
  dead.alive = false;
  objects_[id.index] = std::move(dead);
  free_objects_.push_back(id.index);
  touch(id.index);
  return Edit::done;
}

Edit Scene::set_pose(ObjectId id, const Pose& pose) {
  if (const Edit e = locate(id); e != Edit::done) return e;
  Object& o = objects_[id.index];
  check_pose(pose, o.name);
  const std::shared_ptr<const Source> source = slots_[id.index].source;
  const std::uint32_t first_plane = rooms_[slots_[id.index].room].first[plane_array];
  const Tolerances tolerances{flatness_tolerance, coplanarity_tolerance};
  if (Carried carried; carry(source->mesh, source->vertex_of, source->origins, pose, tolerances,
                             *this, o, first_plane, carried)) {
    std::copy(carried.vertices.begin(), carried.vertices.end(), vertices_.begin() + o.first_vertex);
    std::copy(carried.planes.begin(), carried.planes.end(), planes_.begin() + first_plane);
    for (std::uint32_t f = 0; f < o.face_count; ++f)
      faces_[o.first_face + f].area = carried.areas[f];
    o.pose = pose;
    touch(id.index);
  } else {
    admit(id.index, source, {o.name, pose, source->sides, o.casts, o.receives, o.moves});
  }
  return Edit::done;
}

Edit Scene::set_vertices(ObjectId id, std::span<const Vec3> local) {
  if (const Edit e = locate(id); e != Edit::done) return e;
  const Object& o = objects_[id.index];
  const Source& old = *slots_[id.index].source;
  if (local.size() != old.mesh.vertices.size()) {
    throw Error("object '" + o.name + "': its mesh has " +
                std::to_string(old.mesh.vertices.size()) + " vertices, and " +
                std::to_string(local.size()) + " were given");
  }
  Source changed{old.mesh, old.sides, {}, {}};
  changed.mesh.vertices.assign(local.begin(), local.end());
  admit(id.index, std::make_shared<const Source>(std::move(changed)),
        {o.name, o.pose, old.sides, o.casts, o.receives, o.moves});
  return Edit::done;
}

Edit Scene::set_casts(ObjectId id, bool casts) {
  if (const Edit e = locate(id); e != Edit::done) return e;
  objects_[id.index].casts = casts;
  touch(id.index);
  return Edit::done;
}

Edit Scene::set_receives(ObjectId id, bool receives) {
  if (const Edit e = locate(id); e != Edit::done) return e;
  objects_[id.index].receives = receives;
  touch(id.index);
  return Edit::done;
}

LightId Scene::add(const Light& light) {
  const bool fresh = free_lights_.empty();
  const std::uint32_t index = fresh ? count_of(lights_) : free_lights_.back();
  check(light,
        light.name.empty() ? "light " + std::to_string(index) : "light '" + light.name + "'");
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

Edit Scene::remove(LightId id) {
  if (const Edit e = locate(id); e != Edit::done) return e;
  LightSlot& slot = light_slots_[id.index];
  slot.alive = false;
  ++slot.generation;
  slot.revision = ++revision_;
  free_lights_.push_back(id.index);
  return Edit::done;
}

Edit Scene::set_light(LightId id, const Light& light) {
  if (const Edit e = locate(id); e != Edit::done) return e;
  check(light,
        light.name.empty() ? "light " + std::to_string(id.index) : "light '" + light.name + "'");
  lights_[id.index] = Light(light);  // copied before anything changes
  light_slots_[id.index].revision = ++revision_;
  return Edit::done;
}

void Scene::replace_lights(std::span<const Light> lights) {
  const std::vector<Light> fresh(lights.begin(), lights.end());  // they may be our own
  for (std::size_t i = 0; i < fresh.size(); ++i)
    check(fresh[i],
          fresh[i].name.empty() ? "light " + std::to_string(i) : "light '" + fresh[i].name + "'");
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    if (light_slots_[i].alive) static_cast<void>(remove(light_id(i)));
  }
  std::sort(free_lights_.rbegin(), free_lights_.rend());
  for (const Light& light : fresh) add(light);
}

const Object* Scene::find(ObjectId id) const {
  return locate(id) == Edit::done ? &objects_[id.index] : nullptr;
}
const Light* Scene::find(LightId id) const {
  return locate(id) == Edit::done ? &lights_[id.index] : nullptr;
}

std::optional<std::pair<Mesh, ObjectSettings>> Scene::given(ObjectId id) const {
  const Object* o = find(id);
  if (o == nullptr) return std::nullopt;
  const Source& source = *slots_[id.index].source;
  return std::pair(source.mesh,
                   ObjectSettings{o->name, o->pose, source.sides, o->casts, o->receives, o->moves});
}

ObjectId Scene::object_id(std::size_t index) const {
  if (index >= objects_.size() || !objects_[index].alive) return {};
  return {static_cast<std::uint32_t>(index), slots_[index].generation, tag_};
}
LightId Scene::light_id(std::size_t index) const {
  if (index >= lights_.size() || !light_slots_[index].alive) return {};
  return {static_cast<std::uint32_t>(index), light_slots_[index].generation, tag_};
}

std::uint32_t Scene::room_taken_by(const Scene& other, std::uint32_t index) const {
  const std::uint32_t room = index < other.slots_.size() ? other.slots_[index].room : none;
  return room < rooms_.size() ? rooms_[room].owner : none;
}

void Scene::copy_objects(const Scene& from, std::span<const std::uint32_t> indices) {
  if (objects_.size() < from.objects_.size()) {
    Object empty{};
    empty.alive = false;
    for (std::uint32_t i = count_of(objects_); i < from.objects_.size(); ++i)
      free_objects_.push_back(i);
    objects_.resize(from.objects_.size(), empty);
    slots_.resize(from.slots_.size());
  }
  for (std::size_t r = rooms_.size(); r < from.rooms_.size(); ++r) {
    rooms_.push_back(from.rooms_[r]);
    rooms_.back().owner = none;
    grow_to(rooms_.back());
    free_rooms_.emplace(rooms_.back().count[corner_array], static_cast<std::uint32_t>(r));
  }
  for (const std::uint32_t i : indices) {
    const std::uint32_t room = slots_[i].room;
    if (room == none) continue;
    clear_room(i);
    rooms_[room].owner = none;
    free_rooms_.emplace(rooms_[room].count[corner_array], room);
  }
  for (const std::uint32_t i : indices) {
    const Slot& slot = from.slots_[i];
    if (objects_[i].alive != from.objects_[i].alive) {
      if (from.objects_[i].alive) {
        std::erase(free_objects_, i);
      } else {
        free_objects_.push_back(i);
      }
    }
    objects_[i] = from.objects_[i];
    slots_[i].room = slot.room;
    slots_[i].generation = slot.generation;
    slots_[i].revision = slot.revision;
    slots_[i].source = slot.source;
    revision_ = std::max(revision_, slot.revision);
    make_newest(i);
    if (slot.room == none) continue;
    Room& room = rooms_[slot.room];
    room.owner = i;
    const auto [first, last] = free_rooms_.equal_range(room.count[corner_array]);
    free_rooms_.erase(
        std::find_if(first, last, [&slot](const auto& r) { return r.second == slot.room; }));
    const auto copy = [&room](auto& to, const auto& source, Array a) {
      std::copy_n(source.begin() + room.first[a], room.count[a], to.begin() + room.first[a]);
    };
    copy(vertices_, from.vertices_, vertex_array);
    copy(edges_, from.edges_, edge_array);
    copy(planes_, from.planes_, plane_array);
    copy(facets_, from.facets_, facet_array);
    copy(corners_, from.corners_, corner_array);
    copy(faces_, from.faces_, face_array);
  }
  for (const Issue& i : from.issues_) {
    if (std::find(indices.begin(), indices.end(), i.object) != indices.end()) issues_.push_back(i);
  }
}

void Scene::copy_light(const Scene& from, std::uint32_t index) {
  while (lights_.size() < from.lights_.size()) {
    free_lights_.push_back(count_of(lights_));
    lights_.emplace_back();
    light_slots_.emplace_back();
  }
  if (light_slots_[index].alive && !from.light_slots_[index].alive) free_lights_.push_back(index);
  if (!light_slots_[index].alive && from.light_slots_[index].alive) std::erase(free_lights_, index);
  lights_[index] = from.lights_[index];
  light_slots_[index] = from.light_slots_[index];
  revision_ = std::max(revision_, light_slots_[index].revision);
}

}  // namespace shadowcut
