// See edit_scripts.hpp.
#include "edit_scripts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <ostream>
#include <stdexcept>

#include "light_vector.hpp"
#include "random_scenes.hpp"
#include "text.hpp"

namespace shadowcut::testing {
namespace {

using scenes::Random;
using scenes::SceneData;

template <Kind kind>
SceneData of_kind(std::uint64_t seed) {
  return random_scene(kind, 90000 + seed);
}

SceneData some_room(std::uint64_t seed) {
  return seed % 4 == 3 ? scenes::room(2) : scenes::room(1);
}
SceneData some_city(std::uint64_t seed) {
  return scenes::city(static_cast<std::uint32_t>(4 + seed % 5));
}
SceneData some_spheres(std::uint64_t seed) {
  return scenes::spheres(static_cast<std::uint32_t>(3 + seed % 3), 8, 5);
}
SceneData some_triangles(std::uint64_t seed) {
  return scenes::triangles(static_cast<std::uint32_t>(20 + seed % 41));
}

void add(SceneData& data, Mesh mesh, const char* what) {
  ObjectSettings settings;
  settings.name = std::string(what) + "." + std::to_string(data.objects.size());
  data.objects.emplace_back(std::move(mesh), std::move(settings));
}

double half_steps(Random& random, int lo, int hi) {
  return lo +
         0.5 * static_cast<double>(random.below(static_cast<std::uint64_t>(2 * (hi - lo) + 1)));
}

// Sheets in few planes, many upon each other, and piles of boxes with sides flush. Everything in
// half units.
SceneData stacks(std::uint64_t seed) {
  SceneData data;
  data.name = "stacks, seed " + std::to_string(seed);
  Random random(31 * seed + 5);
  add(data, scenes::rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}), "ground");
  add(data, scenes::rectangle({-4, 4, 0}, {8, 0, 0}, {0, 0, 4}), "wall");
  for (std::uint64_t k = 2 + random.below(4); k > 0; --k) {  // upon ground and wall
    const double x = half_steps(random, -3, 2), y = half_steps(random, -3, 2),
                 w = half_steps(random, 1, 2), d = half_steps(random, 1, 2);
    if (random.below(2) == 0) add(data, scenes::rectangle({x, y, 0}, {w, 0, 0}, {0, d, 0}), "mat");
    else add(data, scenes::rectangle({x, 4, 0.5}, {w, 0, 0}, {0, 0, d}), "poster");
  }
  for (std::uint64_t k = 1 + random.below(3); k > 0; --k) {  // sheets of one level
    const double z = half_steps(random, 1, 2);
    for (std::uint64_t i = 1 + random.below(3); i > 0; --i) {
      const double x = half_steps(random, -2, 1), y = half_steps(random, -2, 1),
                   w = half_steps(random, 1, 2), d = half_steps(random, 1, 2);
      add(data, scenes::rectangle({x, y, z}, {w, 0, 0}, {0, d, 0}), "sheet");
    }
  }
  const double x = half_steps(random, -2, 1), y = half_steps(random, -2, 1);
  double z = 0;
  for (std::uint64_t k = 1 + random.below(4); k > 0; --k) {
    const double top = z + 0.5;
    add(data, scenes::box({x, y, z}, {x + half_steps(random, 1, 2), y + 1, top}), "box");
    z = top;
  }
  data.light = random.below(3) == 0
                   ? Light::directional({half_steps(random, -1, 1), half_steps(random, -1, 1), -1})
                   : Light::point({half_steps(random, -3, 3), half_steps(random, -3, 3),
                                   half_steps(random, 2, 6)});
  return data;
}

// Tables upon a floor, boxes upon the tables, tetrahedra and sheets upon the boxes; coordinates are
// multiples of 2^-20, so that what rests touches to the bit.
SceneData resting(std::uint64_t seed) {
  SceneData data;
  data.name = "resting, seed " + std::to_string(seed);
  Random random(57 * seed + 9);
  add(data, scenes::rectangle({-3, -3, 0}, {6, 0, 0}, {0, 6, 0}), "floor");
  for (std::uint64_t k = 1 + random.below(3); k > 0; --k) {
    const double x = random.in(-2, 1), y = random.in(-2, 1), w = random.in(0.5, 1.5),
                 d = random.in(0.5, 1.5), top = random.in(0.5, 1);
    Mesh table = scenes::box({x, y, top - 0.125}, {x + w, y + d, top});
    for (const double u : {x, x + w - 0.125})
      for (const double v : {y, y + d - 0.125})
        scenes::append(table, scenes::box({u, v, 0}, {u + 0.125, v + 0.125, top - 0.125}));
    add(data, std::move(table), "table");
    const double high = random.in(0.1, 0.5);
    if (random.below(4) != 0)
      add(data, scenes::box({x + 0.125, y, top}, {x + w / 2, y + 0.375, top + high}), "box");
    if (random.below(2) == 0)
      add(data, scenes::rectangle({x + 0.125, y, top + high}, {0.25, 0, 0}, {0, 0.25, 0}), "paper");
    if (random.below(2) == 0) {
      Mesh wedge;  // leans on nothing, stands on the table's top
      wedge.vertices = {{x + w / 2, y + 0.375, top},
                        {x + w, y + 0.375, top},
                        {x + w / 2, y + 0.5, top},
                        {x + w / 2, y + 0.375, top + 0.5}};
      for (const auto& t : {std::array{0u, 2u, 1u}, {0u, 1u, 3u}, {1u, 2u, 3u}, {2u, 0u, 3u}})
        wedge.add_face({t[0], t[1], t[2]});
      add(data, std::move(wedge), "wedge");
    }
  }
  data.light = Light::point({random.in(-2, 2), random.in(-2, 2), random.in(2, 5)});
  return data;
}

constexpr std::array<Setting, 14> kSettings{{{"soup", of_kind<Kind::soup>, 0.25},
                                             {"grid_soup", of_kind<Kind::grid_soup>, 1},
                                             {"solids", of_kind<Kind::solids>, 0.25},
                                             {"grid_boxes", of_kind<Kind::grid_boxes>, 1},
                                             {"turned_boxes", of_kind<Kind::turned_boxes>, 0.25},
                                             {"outlines", of_kind<Kind::outlines>, 0.5},
                                             {"tiles", of_kind<Kind::tiles>, 1},
                                             {"furnished_box", of_kind<Kind::room>, 0.1},
                                             {"rooms", some_room, 0.1},
                                             {"city", some_city, 0.125},
                                             {"spheres", some_spheres, 0.25},
                                             {"triangles", some_triangles, 0.125},
                                             {"stacks", stacks, 0.5},
                                             {"resting", resting, 0.125}}};

void require(bool holds, const char* what) {
  if (!holds) throw std::logic_error(what);
}

std::string place(const Vec3& x) { return text("(", x.x(), ", ", x.y(), ", ", x.z(), ")"); }

// Quarter turns, exact in whole numbers.
Eigen::Matrix3d quarter(int axis, std::uint64_t times) {
  Eigen::Matrix3d once = Eigen::Matrix3d::Zero(), all = Eigen::Matrix3d::Identity();
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  once(axis, axis) = 1, once(u, v) = -1, once(v, u) = 1;
  for (; times > 0; --times) all = once * all;
  return all;
}

Pose about(const Vec3& point, const Eigen::Matrix3d& linear, const Pose& pose) {
  Pose out = Pose::Identity();
  out.linear() = linear * pose.linear();
  out.translation() = linear * (pose.translation() - point) + point;
  return out;
}

bool coarse(const Vec3& x) {
  return (8 * x).array().round().matrix() == 8 * x && x.cwiseAbs().maxCoeff() < 512;
}

// By coordinates for which doubles are exact: of faces that are square to an axis, or all multiples
// of an eighth.
bool exactly_in_plane(const Scene& scene, const Facet& facet, const Light& light) {
  const bool point = light.kind == Light::Kind::point;
  const auto corners = scene.corners_of(facet);
  const auto at = [&](std::size_t i) -> const Vec3& { return scene.vertices()[corners[i].vertex]; };
  for (int axis = 0; axis < 3; ++axis) {
    const double level = at(0)[axis];
    const auto here = [&](const Corner& c) { return scene.vertices()[c.vertex][axis] == level; };
    if (std::all_of(corners.begin(), corners.end(), here))
      return point ? light.position[axis] == level : light.direction[axis] == 0;
  }
  const auto is_coarse = [&](const Corner& c) { return coarse(scene.vertices()[c.vertex]); };
  if (!coarse(vector_of(light)) || !std::all_of(corners.begin(), corners.end(), is_coarse))
    return false;
  const Vec3 ray = point ? Vec3(light.position - at(0)) : light.direction;
  for (std::size_t i = 2; i < corners.size(); ++i) {
    if ((at(i - 1) - at(0)).cross(at(i) - at(0)).dot(ray) != 0) return false;
  }
  return true;
}

}  // namespace

std::span<const Setting> all_settings() { return kSettings; }
const Setting& setting_named(const std::string& name) {
  const auto it = std::find_if(kSettings.begin(), kSettings.end(),
                               [&](const Setting& s) { return s.name == name; });
  require(it != kSettings.end(), "no such setting");
  return *it;
}
void PrintTo(const Setting& setting, std::ostream* out) { *out << setting.name; }

EditScript::EditScript(const Setting& setting, std::uint64_t seed)
    : random_(seed * 1000003 + 17), grid_(setting.grid) {
  const SceneData data = setting.scene(seed);
  calm_ = random_.below(2) == 0;
  for (const auto& [mesh, settings] : data.objects) {
    Item item{mesh, settings, {}, true, mesh.vertices, settings.pose, settings.pose};
    item.settings.dynamic = random_.below(4) == 0;
    if (random_.below(8) == 0) item.settings.sides = Sides::open;
    if (random_.below(16) == 0) item.settings.casts_shadows = false;
    if (random_.below(16) == 0) item.settings.receives_shadows = false;
    item.id = scene_.add(item.mesh, item.settings);
    items_.push_back(std::move(item));
  }
  Eigen::AlignedBox3d box;
  for (const Vec3& v : scene_.vertices()) box.extend(v);
  middle_ = on_grid(Vec3(box.center()));
  radius_ = scenes::to_grid(0.5 * box.diagonal().norm());
  lights_.push_back(scene_.add(data.light));
  if (random_.below(3) == 0) lights_.push_back(scene_.add(some_light()));
  clear_lights();
}

std::span<const EditScript::Choice> EditScript::choices() {
  using S = EditScript;
  static constexpr std::array<Choice, 27> list{{{14, &S::small_move},
                                                {8, &S::large_move},
                                                {10, &S::move_to_grid},
                                                {10, &S::touch},
                                                {5, &S::quarter_turn},
                                                {5, &S::turn},
                                                {4, &S::move_to_light},
                                                {4, &S::move_into},
                                                {2, &S::leave},
                                                {9, &S::go_home},
                                                {6, &S::go_back},
                                                {2, &S::there_and_back},
                                                {1, &S::stay},
                                                {3, &S::scale},
                                                {6, &S::remove_some},
                                                {8, &S::add_some},
                                                {1, &S::add_copy},
                                                {4, &S::toggle_casts},
                                                {4, &S::toggle_receives},
                                                {4, &S::deform},
                                                {3, &S::undeform},
                                                {2, &S::small_light_move, true},
                                                {2, &S::new_light_place, true},
                                                {2, &S::light_into_scene, true},
                                                {2, &S::light_reach, true},
                                                {1, &S::add_light, true},
                                                {1, &S::remove_light, true}}};
  return list;
}

std::string EditScript::edit() {
  std::uint64_t sum = 0;
  for (const Choice& c : choices()) sum += c.weight;
  while (true) {
    std::uint64_t at = random_.below(sum);
    const Choice* choice = choices().data();
    for (; at >= choice->weight; ++choice) at -= choice->weight;
    if (calm_ && choice->of_light && random_.below(20) != 0) continue;
    if (std::string done = (this->*choice->edit)(); !done.empty()) return done + clear_lights();
  }
}

std::string EditScript::step() {
  std::string all = edit();
  if (random_.below(4) != 0) return all;
  for (std::uint64_t more = 1 + random_.below(5); more > 0; --more) all += "; " + edit();
  return all;
}

std::string EditScript::move(std::size_t k) {
  Item& item = items_[k];
  if (random_.below(8) == 0) return set_pose(item, Pose(item.pose_at_first), "home: ");
  const Vec3 by = random_.below(2) == 0 ? random_.in_ball(0.1 * radius_)
                                        : on_grid(random_.in_ball(0.25 * radius_));
  Pose pose = item.pose_at_first;
  pose.pretranslate(by);
  return set_pose(item, pose, "") + clear_lights();
}

std::string EditScript::swing(std::size_t k) {
  Item& item = items_[k];
  Pose pose = item.pose_at_first;
  if (item.settings.pose.isApprox(pose, 0)) pose.pretranslate(Vec3(0.0625, 0.03125, 0));
  return set_pose(item, pose, "");
}

// Lights that came too near to the plane of a face, but not into it, step aside.
std::string EditScript::clear_lights() {
  std::string all;
  for (const LightId id : lights_) {
    if (!scene_.find(id)) continue;  // removed by hand
    while (unclear(*scene_.find(id))) {
      Light light = *scene_.find(id);
      vector_of(light) +=
          random_.in_ball(light.kind == Light::Kind::point ? 0.0625 * radius_ : 0.0625);
      if (!vector_of(light).isZero()) all += set_light(id, light, "; aside: ");
    }
  }
  return all;
}

bool EditScript::unclear(const Light& light) const {
  const bool point = light.kind == Light::Kind::point;
  const double far = reach();
  return std::any_of(scene_.facets().begin(), scene_.facets().end(), [&](const Facet& facet) {
    if (facet.corner_count == 0) return false;
    const Plane& plane = scene_.planes()[facet.plane];
    const double height =
        point ? plane.normal.dot(light.position - plane.point) : plane.normal.dot(light.direction);
    return std::abs(height) < 1e-5 * far * (point ? radius_ : light.direction.norm()) &&
           !exactly_in_plane(scene_, facet, light);
  });
}

double EditScript::reach() const {
  double reach = 1;
  for (const Item& item : items_) {
    if (item.present) reach = std::max(reach, (bounds(item).first - middle_).norm() / radius_);
  }
  return reach;
}

bool EditScript::deformed() const {
  return std::any_of(items_.begin(), items_.end(), [](const Item& i) {
    return i.present && i.mesh.vertices != i.vertices_at_first;
  });
}

EditScript::Item* EditScript::any_present() {
  std::vector<Item*> present;
  for (Item& item : items_) {
    if (item.present) present.push_back(&item);
  }
  return present.empty() ? nullptr : present[random_.below(present.size())];
}

std::pair<Vec3, Vec3> EditScript::bounds(const Item& item) const {
  const Object& o = *scene_.find(item.id);
  Eigen::AlignedBox3d box;
  for (const Vec3& v : scene_.vertices().subspan(o.first_vertex, o.vertex_count)) box.extend(v);
  if (box.isEmpty()) box.extend(item.settings.pose.translation());
  return {box.min(), box.max()};
}

double EditScript::on_grid(double x) const { return std::nearbyint(x / grid_) * grid_; }
Vec3 EditScript::on_grid(const Vec3& x) const {
  return {on_grid(x.x()), on_grid(x.y()), on_grid(x.z())};
}

// Around the middle, often on the grid.
Vec3 EditScript::some_place() {
  const Vec3 at = middle_ + random_.in_ball(radius_);
  return random_.below(2) == 0 ? on_grid(at) : at;
}

std::string EditScript::set_pose(Item& item, const Pose& pose, const char* how) {
  require(scene_.set_pose(item.id, pose) == shadowcut::Status::ok, "set_pose");
  item.pose_before = item.settings.pose;
  item.settings.pose = pose;
  return text(how, item.settings.name, " to ", place(pose.translation()));
}

std::string EditScript::shift(Item& item, const Vec3& by, const char* how) {
  Pose pose = item.settings.pose;
  pose.pretranslate(by);
  return set_pose(item, pose, how);
}

std::string EditScript::small_move() {
  Item* item = any_present();
  if (!item) return {};
  const double reach = radius_ * (random_.below(2) == 0 ? 0.01 : 0.1);
  if (random_.below(3) == 0) return shift(*item, on_grid(random_.in_ball(2 * grid_)), "a step: ");
  if (random_.below(3) != 0) return shift(*item, random_.in_ball(reach), "small move: ");
  return shift(*item,
               reach * Vec3{random_.unit() - 0.5, 0.25 * random_.unit(), random_.unit() - 0.5},
               "small uneven move: ");
}

std::string EditScript::large_move() {
  Item* item = any_present();
  return item ? shift(*item, random_.in_ball(radius_), "large move: ") : std::string();
}

std::string EditScript::move_to_grid() {
  Item* item = any_present();
  if (!item) return {};
  const Vec3 lo = bounds(*item).first;
  const Vec3 by = on_grid(random_.below(2) == 0 ? lo : Vec3(lo + random_.in_ball(2 * grid_))) - lo;
  return shift(*item, by, "to the grid: ");
}

// Two objects come to touch, or to have sides in one plane.
std::string EditScript::touch() {
  Item *item = any_present(), *other = any_present();
  if (!item || item == other) return {};
  const auto [other_lo, other_hi] = bounds(*other);
  const int axis = static_cast<int>(random_.below(3));
  const std::uint64_t own_side = random_.below(2), other_side = random_.below(2);
  const auto gap = [&, from = own_side == 0,
                    to = other_side == 0 ? other_lo[axis] : other_hi[axis]] {
    const auto [lo, hi] = bounds(*item);
    return to - (from ? lo : hi)[axis];
  };
  Vec3 by = gap() * Vec3::Unit(axis);
  if (random_.below(2) == 0) {  // one above the other
    const Vec3 lo = bounds(*item).first;
    for (const int k : {(axis + 1) % 3, (axis + 2) % 3})
      by[k] = on_grid(random_.in(other_lo[k], other_hi[k]) - lo[k]);
  }
  std::string done = shift(*item, by, ("beside " + other->settings.name + ": ").c_str());
  // What rounding has left of the gap: touching to the last bit, or nearly, is a contact for
  // everybody; some ulps more is one for the oracle.
  if (const double rest = gap(); rest != 0) done += shift(*item, rest * Vec3::Unit(axis), ", and ");
  return done;
}

std::string EditScript::quarter_turn() {
  Item* item = any_present();
  if (!item) return {};
  const auto [lo, hi] = bounds(*item);
  const Vec3 point = on_grid(Vec3(0.5 * (lo + hi)));
  const int axis = random_.below(2) == 0 ? 2 : static_cast<int>(random_.below(3));
  return set_pose(*item, about(point, quarter(axis, 1 + random_.below(3)), item->settings.pose),
                  "quarter turn: ");
}

std::string EditScript::turn() {
  Item* item = any_present();
  if (!item) return {};
  const auto [lo, hi] = bounds(*item);
  const Vec3 axis = random_.below(2) == 0
                        ? Vec3(0, 0, 1)
                        : Vec3((random_.in_ball(1) + Vec3(0, 0, 1.5)).normalized());
  const Eigen::Matrix3d linear =
      Eigen::AngleAxisd(2 * std::numbers::pi * random_.unit(), axis).toRotationMatrix();
  return set_pose(*item, about(0.5 * (lo + hi), linear, item->settings.pose), "turn: ");
}

// The light in the middle of it, at a corner of it, or in the plane of a side of its box.
std::string EditScript::move_to_light() {
  Item* item = any_present();
  const LightId id = any_light();
  if (!item || id.index == invalid_index || scene_.find(id)->kind != Light::Kind::point) return {};
  const Vec3 at = scene_.find(id)->position;
  const auto [lo, hi] = bounds(*item);
  const int axis = static_cast<int>(random_.below(3));
  switch (random_.below(4)) {
    case 0:
      return shift(*item, at - scenes::to_grid(0.5) * (lo + hi), "around the light: ");
    case 1: {
      const Object& o = *scene_.find(item->id);
      if (o.vertex_count == 0) return {};
      return shift(*item, at - scene_.vertices()[o.first_vertex + random_.below(o.vertex_count)],
                   "a corner to the light: ");
    }
    case 2:
      return shift(*item, at - 0.5 * (lo + hi) + random_.in_ball(0.1 * radius_),
                   "near the light: ");
    default:
      return shift(*item, (at[axis] - (random_.below(2) == 0 ? lo : hi)[axis]) * Vec3::Unit(axis),
                   "a side beside the light: ");
  }
}

// Its middle to a corner of another one: they cross.
std::string EditScript::move_into() {
  Item *item = any_present(), *other = any_present();
  if (!item || item == other) return {};
  const Object& o = *scene_.find(other->id);
  if (o.vertex_count < 2) return {};
  const auto [lo, hi] = bounds(*item);
  const Vec3 a = scene_.vertices()[o.first_vertex + random_.below(o.vertex_count)],
             b = scene_.vertices()[o.first_vertex + random_.below(o.vertex_count)];
  return shift(*item, 0.5 * (a + b) - 0.5 * (lo + hi),
               ("into " + other->settings.name + ": ").c_str());
}

// Out of every range, and out of the region that a light's numbers were made for.
std::string EditScript::leave() {
  Item* item = any_present();
  if (!item) return {};
  const double far = std::ceil(radius_) * (random_.below(3) == 0 ? 64 : 16);
  const auto axis = random_.below(6);
  return shift(*item, (axis < 3 ? far : -far) * Vec3::Unit(static_cast<int>(axis % 3)),
               "far away: ");
}

std::string EditScript::go_home() {
  Item* item = any_present();
  for (Item& i : items_) {  // who went far comes back soon
    if (i.present && (i.settings.pose.translation() - middle_).norm() > 8 * radius_) item = &i;
  }
  return item ? set_pose(*item, item->pose_at_first, "home: ") : std::string();
}

std::string EditScript::go_back() {
  Item* item = any_present();
  return item ? set_pose(*item, Pose(item->pose_before), "back: ") : std::string();
}

std::string EditScript::there_and_back() {
  Item* item = any_present();
  if (!item) return {};
  const Pose pose = item->settings.pose;
  const std::string there = shift(*item, random_.in_ball(radius_), "there ");
  return there + set_pose(*item, pose, " and back ");
}

std::string EditScript::stay() {
  Item* item = any_present();
  return item ? set_pose(*item, Pose(item->settings.pose), "stay: ") : std::string();
}

// By halves and doubles, also of one axis or mirrored.
std::string EditScript::scale() {
  Item* item = any_present();
  if (!item) return {};
  Vec3 factor = Vec3::Constant(random_.below(2) == 0 ? 0.5 : 2);
  if (random_.below(3) == 0) factor = {1, random_.below(2) == 0 ? 0.5 : 2.0, 1};
  if (random_.below(6) == 0) factor = {-1, 1, 1};
  const auto [lo, hi] = bounds(*item);
  const Pose pose = about(on_grid(Vec3(0.5 * (lo + hi))), factor.asDiagonal(), item->settings.pose);
  const double ratio =
      std::abs(pose.linear().determinant() / item->pose_at_first.linear().determinant());
  if (ratio > 65 || ratio < 1 / 65.0) return {};
  return set_pose(*item, pose, "scale: ");
}

void EditScript::remove(std::size_t k) {
  require(scene_.remove(items_[k].id) == shadowcut::Status::ok, "remove");
  items_[k].present = false;
}

void EditScript::add_back(std::size_t k) {
  items_[k].id = scene_.add(items_[k].mesh, items_[k].settings);
  items_[k].present = true;
}

std::string EditScript::remove_some() {
  const Item* item = any_present();
  if (!item) return {};
  remove(static_cast<std::size_t>(item - items_.data()));
  return "remove " + item->settings.name;
}

std::string EditScript::add_some() {
  const std::size_t start = random_.below(items_.size());
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const std::size_t k = (start + i) % items_.size();
    if (items_[k].present) continue;
    add_back(k);
    return "add back " + items_[k].settings.name;
  }
  return {};
}

// One more of a kind, a few times.
std::string EditScript::add_copy() {
  const Item* item = any_present();
  if (!item || items_.size() > 90) return {};
  Item copy = *item;
  copy.settings.name += "'";
  copy.settings.pose.pretranslate(on_grid(random_.in_ball(0.5 * radius_)));
  copy.settings.dynamic = random_.below(2) == 0;
  copy.pose_before = copy.settings.pose;
  copy.id = scene_.add(copy.mesh, copy.settings);
  items_.push_back(std::move(copy));
  return "add " + items_.back().settings.name;
}

std::string EditScript::toggle_casts() {
  Item* item = any_present();
  if (!item) return {};
  // also to what it is
  item->settings.casts_shadows =
      random_.below(4) == 0 ? item->settings.casts_shadows : !item->settings.casts_shadows;
  require(scene_.set_casts_shadows(item->id, item->settings.casts_shadows) == shadowcut::Status::ok,
          "set_casts");
  return item->settings.name + (item->settings.casts_shadows ? " casts" : " does not cast");
}

std::string EditScript::toggle_receives() {
  Item* item = any_present();
  if (!item) return {};
  item->settings.receives_shadows = !item->settings.receives_shadows;
  require(scene_.set_receives_shadows(item->id, item->settings.receives_shadows) ==
              shadowcut::Status::ok,
          "set_receives");
  return item->settings.name +
         (item->settings.receives_shadows ? " receives" : " does not receive");
}

// A face that is flat only within Scene::flatness_tolerance touches whatever comes as near to it as
// that, so its areas are not defined to kAreaTolerance.
bool EditScript::flat_by_tolerance(const Item& item) const {
  const Object& o = *scene_.find(item.id);
  const auto facets = scene_.facets().subspan(o.first_facet, o.facet_count);
  return std::any_of(facets.begin(), facets.end(), [this](const Facet& f) {
    return scene_.planes()[f.plane].flatness > 1e-9 * radius_;
  });
}

std::string EditScript::set_vertices(Item& item, std::vector<Vec3> local, const char* how) {
  require(scene_.set_vertices(item.id, local) == shadowcut::Status::ok, "set_vertices");
  if (flat_by_tolerance(item)) {
    require(scene_.set_vertices(item.id, item.mesh.vertices) == shadowcut::Status::ok,
            "set_vertices");
    return {};
  }
  item.mesh.vertices = std::move(local);
  return how + item.settings.name;
}

// Some corners move: faces fold, and may come to be refused, which takes another room in the scene.
std::string EditScript::deform() {
  Item* item = any_present();
  if (!item) return {};
  std::vector<Vec3> local = item->mesh.vertices;
  for (std::uint64_t k = 1 + random_.below(2); k > 0; --k) {
    Vec3& v = local[random_.below(local.size())];
    if (random_.below(2) == 0) v += grid_ * Vec3::Unit(static_cast<int>(random_.below(3)));
    else v += random_.in_ball(0.05 * radius_);
  }
  return set_vertices(*item, std::move(local), "deform ");
}

std::string EditScript::undeform() {
  Item* item = any_present();
  if (!item || item->mesh.vertices == item->vertices_at_first) return {};
  return set_vertices(*item, item->vertices_at_first, "restore ");
}

LightId EditScript::any_light() {
  return lights_.empty() ? LightId{} : lights_[random_.below(lights_.size())];
}

Light EditScript::some_light() {
  Light light = Light::point(some_place() + Vec3(0, 0, on_grid(0.5 * radius_)));
  if (random_.below(4) == 0) {
    light = Light::directional(random_.in_ball(1) - Vec3(0, 0, 1.25));
    if (random_.below(2) == 0)
      light.direction = {static_cast<double>(random_.below(3)) - 1,
                         static_cast<double>(random_.below(3)) - 1, -1};
  }
  return light;
}

std::string EditScript::set_light(LightId id, const Light& light, const char* how) {
  require(scene_.set_light(id, light) == shadowcut::Status::ok, "set_light");
  return text(how, "light ", id.index, " to ", place(vector_of(light)), ", range ", light.range,
              light.spot ? ", a spot" : "");
}

std::string EditScript::small_light_move() {
  const LightId id = any_light();
  if (id.index == invalid_index) return {};
  Light light = *scene_.find(id);
  vector_of(light) += random_.in_ball(light.kind == Light::Kind::point ? 0.05 * radius_ : 0.125);
  return set_light(id, light, "small move: ");
}

std::string EditScript::new_light_place() {
  const LightId id = any_light();
  return id.index == invalid_index ? std::string() : set_light(id, some_light(), "");
}

// To a corner of an object, the middle between two, or a point of the grid among them.
std::string EditScript::light_into_scene() {
  const LightId id = any_light();
  const Item* item = any_present();
  if (id.index == invalid_index || !item) return {};
  const Object& o = *scene_.find(item->id);
  if (o.vertex_count == 0) return {};
  const auto corner = [&] {
    return scene_.vertices()[o.first_vertex + random_.below(o.vertex_count)];
  };
  const Vec3 a = corner(), b = corner();
  switch (random_.below(3)) {
    case 0:
      return set_light(id, Light::point(a), "into a corner: ");
    case 1:
      return set_light(id, Light::point(0.5 * (a + b)), "between two corners: ");
    default:
      return set_light(id, Light::point(on_grid(a)), "onto the grid: ");
  }
}

std::string EditScript::light_reach() {
  const LightId id = any_light();
  if (id.index == invalid_index || scene_.find(id)->kind != Light::Kind::point) return {};
  Light light = *scene_.find(id);
  light.range = random_.below(3) == 0 ? std::numeric_limits<double>::infinity()
                                      : random_.in(0.25, 2) * radius_;
  light.spot.reset();
  if (random_.below(3) == 0)
    light.spot = Light::Spot{random_.in_ball(1) - Vec3(0, 0, 1.25), random_.in(0.125, 3)};
  return set_light(id, light, "reach: ");
}

std::string EditScript::add_light() {
  if (lights_.size() >= 3) return {};
  lights_.push_back(scene_.add(some_light()));
  return text("add light ", lights_.back().index, " at ",
              place(vector_of(*scene_.find(lights_.back()))));
}

std::string EditScript::remove_light() {
  if (lights_.empty() || (lights_.size() == 1 && random_.below(4) != 0)) return {};
  const auto it = lights_.begin() + static_cast<std::ptrdiff_t>(random_.below(lights_.size()));
  const std::uint32_t index = it->index;
  require(scene_.remove(*it) == shadowcut::Status::ok, "remove light");
  lights_.erase(it);
  return text("remove light ", index);
}

}  // namespace shadowcut::testing
