// What a person has moved and removed of a scene, and the way back.
#pragma once

#include <optional>
#include <shadowcut/scene.hpp>
#include <string>
#include <utility>
#include <vector>

namespace shadowcut::view {

class Arrangement {
 public:
  // The scene, which must outlive this, and which nothing else may change, as it stands is what
  // everything goes back to.
  explicit Arrangement(Scene& scene);

  void set_pose(std::uint32_t object, const Pose& pose);
  void set_light(std::uint32_t light, const Light& to);
  // By index into the scene's objects or lights.
  void remove(bool is_light, std::uint32_t index);
  // Brings back what was removed last, where it stood, and returns its name; empty when nothing is
  // away.
  std::string bring_back();
  // Everything as it was at first.
  void reset();
  std::size_t away() const { return away_.size(); }

 private:
  struct Thing {
    ObjectId id;
    Pose home;
    std::optional<std::pair<Mesh, ObjectSettings>> removed;
  };
  struct Lamp {
    LightId id;
    Light home, now;
    bool removed = false;
  };

  Scene& scene_;
  std::vector<Thing> things_;
  std::vector<Lamp> lamps_;
  // a lamp or not, and which; in the order of going
  std::vector<std::pair<bool, std::size_t>> away_;
};

// What to call it: its name, or its number when it has none.
std::string name_of(const Scene& scene, bool is_light, std::uint32_t index);

}  // namespace shadowcut::view
