// See arrangement.hpp.
#include "arrangement.hpp"

#include <algorithm>

namespace shadowcut::view {
namespace {

// All ids here are of things that this class knows to be there.
void require(Status edit) {
  if (edit != Status::ok) throw Error("the scene was changed behind the window's back");
}

template <class Things, class Id>
auto& named(Things& things, const Id& id) {
  const auto place =
      std::find_if(things.begin(), things.end(), [&](const auto& thing) { return thing.id == id; });
  if (place == things.end()) throw Error("the scene was changed behind the window's back");
  return *place;
}

}  // namespace

Arrangement::Arrangement(Scene& scene) : scene_(scene) {
  for (std::size_t k = 0; k < scene.objects().size(); ++k)
    if (scene.objects()[k].alive)
      things_.push_back({scene.object_id(k), scene.objects()[k].pose, {}});
  for (std::size_t k = 0; k < scene.lights().size(); ++k)
    if (scene.light_id(k).index != invalid_index)
      lamps_.push_back({scene.light_id(k), scene.lights()[k], scene.lights()[k]});
}

void Arrangement::set_pose(std::uint32_t object, const Pose& pose) {
  require(scene_.set_pose(scene_.object_id(object), pose));
}

void Arrangement::set_light(std::uint32_t light, const Light& to) {
  require(scene_.set_light(scene_.light_id(light), to));
}

void Arrangement::remove(bool is_light, std::uint32_t index) {
  if (is_light) {
    Lamp& lamp = named(lamps_, scene_.light_id(index));
    lamp.now = scene_.lights()[index];
    lamp.removed = true;
    require(scene_.remove(lamp.id));
    away_.emplace_back(true, static_cast<std::size_t>(&lamp - lamps_.data()));
  } else {
    Thing& thing = named(things_, scene_.object_id(index));
    thing.removed = scene_.source(thing.id);
    require(scene_.remove(thing.id));
    away_.emplace_back(false, static_cast<std::size_t>(&thing - things_.data()));
  }
}

std::string Arrangement::bring_back() {
  if (away_.empty()) return "";
  const auto [is_light, place] = away_.back();
  away_.pop_back();
  if (!is_light) {
    Thing& thing = things_[place];
    thing.id = scene_.add(thing.removed->first, thing.removed->second);
    thing.removed.reset();
    return name_of(scene_, false, thing.id.index);
  }
  Lamp& lamp = lamps_[place];
  lamp.id = scene_.add(lamp.now);
  lamp.removed = false;
  return name_of(scene_, true, lamp.id.index);
}

void Arrangement::reset() {
  while (!away_.empty()) bring_back();
  for (const Thing& thing : things_)
    if (scene_.find(thing.id)->pose.matrix() != thing.home.matrix())
      require(scene_.set_pose(thing.id, thing.home));
  for (const Lamp& lamp : lamps_)
    if (const Light& now = *scene_.find(lamp.id);
        now.position != lamp.home.position || now.direction != lamp.home.direction)
      require(scene_.set_light(lamp.id, lamp.home));
}

std::string name_of(const Scene& scene, bool is_light, std::uint32_t index) {
  const std::string& name = is_light ? scene.lights()[index].name : scene.objects()[index].name;
  if (!name.empty()) return name;
  return (is_light ? "light " : "object ") + std::to_string(index);
}

}  // namespace shadowcut::view
