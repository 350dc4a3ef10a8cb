// A script of edits: one JSON object a line.
//
//   {"op":"move","object":NAME,"translate":[x,y,z]}             relative to where it is
//   {"op":"pose","object":NAME,"matrix":[16 numbers, by rows]}  local to world; the last row is 0 0
//     0 1
//   {"op":"remove","object":NAME}
//   {"op":"add","object":NAME}                                  brings a removed object back, as it
//     was
//   {"op":"light","light":INDEX,"position":[x,y,z]}             moves a point light
//   {"op":"light","light":INDEX,"direction":[x,y,z]}            turns a directional light
//     "at" stands for either
//   {"op":"update"}                                             ends a group; one that is not ended
//     is ended by the file's end
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <shadowcut/scene.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace shadowcut::cli {

// One line of a script.
struct Step {
  enum class Op { move, pose, remove, add, light, update } op = Op::update;
  std::size_t line = 0;  // from 1
  std::string object;
  std::size_t light = 0;
  Vec3 vector = Vec3::Zero();  // move: by this; light: to here
  std::string vector_key;      // light: which key gave it
  Pose pose = Pose::Identity();
};

// Blank lines are no steps. Throws Error that begins with FILE:LINE when a line is anything but one
// of the above.
std::vector<Step> parse_edits(std::string_view text, const std::string& file);

// Applies steps to a scene, whose objects and lights they name.
class Player {
 public:
  // `file`: the script's, for messages.
  Player(Scene& scene, std::string file);

  // Any step but an update. Throws Error that begins with FILE:LINE when it cannot be done, and
  // then the scene is as it was.
  void apply(const Step& step);

 private:
  struct Named {
    ObjectId id;
    std::size_t count = 0;                                   // of the objects with this name
    std::optional<std::pair<Mesh, ObjectSettings>> removed;  // what will bring it back
  };

  void do_it(const Step& step);
  Named& named(const std::string& name);
  void bring_back(Named& object, const std::string& name);
  void move_light(const Step& step);

  Scene& scene_;
  std::string file_;
  std::map<std::string, Named> objects_;
};

}  // namespace shadowcut::cli
