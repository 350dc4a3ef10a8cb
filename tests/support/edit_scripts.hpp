// Random edits on scenes of every kind, one after another. A setting and a seed give the same
// history everywhere.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scenes.hpp"

namespace shadowcut::testing {

// A kind of scene to be edited, and the spacing of the grid on which its objects touch, line up and
// share planes.
struct Setting {
  const char* name;
  scenes::SceneData (*scene)(std::uint64_t seed);
  double grid;
};
// All kinds of random_scenes.hpp, and: rooms, cities, spheres, triangles, stacks of coplanar sheets
// and boxes, things resting on each other.
std::span<const Setting> all_settings();
const Setting& setting_named(const std::string& name);
void PrintTo(const Setting& setting, std::ostream* out);  // for GoogleTest

// Edits a scene of its own. Every function that edits says what it did, for a failure's message.
//
// A light stands in a face's plane exactly, where the coordinates allow that, or clear of it by a
// share of 1e-5 of the scene: between the two, what is lit depends on the last bits of corners, and
// no two ways to compute it need agree.
class EditScript {
 public:
  EditScript(const Setting& setting, std::uint64_t seed);
  EditScript(const EditScript&) = delete;  // engines follow the scene
  EditScript& operator=(const EditScript&) = delete;

  Scene& scene() { return scene_; }

  std::string edit();  // one edit of any kind
  std::string step();  // one or several: what one update has to apply
  // An object moves somewhere near where it was at first, and nothing else changes: for long runs.
  std::string move(std::size_t item);
  // Sends an object to and fro, so that the scene is the same after every second call.
  std::string swing(std::size_t item);

  std::size_t size() const { return items_.size(); }  // objects, removed ones included
  // whether a mesh is not what it was at first: closed ones may cut through themselves, and bound
  // no solid
  bool deformed() const;
  // how far objects are from the middle, as a multiple of the scene's radius at first
  double reach() const;
  // An object with all it takes to add it again.
  struct Item {
    Mesh mesh;                // with its vertices as they are
    ObjectSettings settings;  // as they are
    ObjectId id;
    bool present = true;
    std::vector<Vec3> vertices_at_first;
    Pose pose_at_first, pose_before;
  };
  const Item& item(std::size_t k) const { return items_[k]; }
  void remove(std::size_t k);
  void add_back(std::size_t k);

 private:
  using Edit = std::string (EditScript::*)();  // an empty string: does not apply here
  struct Choice {
    std::uint64_t weight;
    Edit edit;
    bool of_light = false;
  };
  static std::span<const Choice> choices();

  std::string small_move();
  std::string large_move();
  std::string move_to_grid();
  std::string touch();
  std::string quarter_turn();
  std::string turn();
  std::string move_to_light();
  std::string move_into();
  std::string leave();
  std::string go_home();
  std::string go_back();
  std::string there_and_back();
  std::string stay();
  std::string scale();
  std::string remove_some();
  std::string add_some();
  std::string add_copy();
  std::string toggle_casts();
  std::string toggle_receives();
  std::string deform();
  std::string undeform();
  std::string small_light_move();
  std::string new_light_place();
  std::string light_into_scene();
  std::string light_reach();
  std::string add_light();
  std::string remove_light();

  std::string clear_lights();
  bool flat_by_tolerance(const Item& item) const;
  bool unclear(const Light& light) const;
  Item* any_present();
  std::string set_pose(Item& item, const Pose& pose, const char* how);
  std::string shift(Item& item, const Vec3& by, const char* how);
  std::string set_vertices(Item& item, std::vector<Vec3> local, const char* how);
  std::string set_light(LightId id, const Light& light, const char* how);
  std::pair<Vec3, Vec3> bounds(const Item& item) const;  // in the world
  double on_grid(double x) const;
  Vec3 on_grid(const Vec3& x) const;
  Vec3 some_place();
  Light some_light();
  LightId any_light();

  scenes::Random random_;
  double grid_;
  Scene scene_;
  std::vector<Item> items_;
  std::vector<LightId> lights_;
  Vec3 middle_ = Vec3::Zero();
  double radius_ = 1;  // of the scene as it was at first
  bool calm_ = false;  // lights change seldom: their trees grow old
};

}  // namespace shadowcut::testing
