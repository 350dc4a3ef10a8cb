// Writes a random script of edits for `shadowcut replay`:
//
//   make_edits SCENE SEED COUNT > edits.jsonl
//
// SCENE is a file, or the name of a generated scene (city:100; make_scenes writes its file). The
// same seed gives the same bytes on every machine: the program does not use the distributions or
// the sines of the standard library.
//
// The script has COUNT edits in groups of random size, with an update after each group. Objects are
// chosen evenly among the objects with unique names. Half of the edits are small moves. The other
// edits move an object far, return it exactly to its first position, slide it along an axis (so
// that contact stays contact), move it through a light or into another object, turn it by an angle
// with rational sine and cosine, scale it, remove it or add it again; lights move too.
#include <CLI/CLI.hpp>
#include <charconv>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <shadowcut/io.hpp>

#include "scenes.hpp"

namespace {

using namespace shadowcut;

struct Arguments {
  std::string scene;
  std::uint64_t seed = 0, count = 0;
  std::uint64_t most = 4;                              // edits before an update
  std::vector<std::string> lights;                     // where they are at first
  bool keep = false;                                   // no object is removed
  std::size_t objects = static_cast<std::size_t>(-1);  // only so many of them are ever touched
};

struct Thing {
  std::string name;
  Eigen::AlignedBox3d box;    // at home
  Vec3 shift = Vec3::Zero();  // from home
  bool there = true;
};

std::string digits(double x) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, x).ptr};
}

std::string text_of(const Vec3& v) {
  return "[" + digits(v.x()) + "," + digits(v.y()) + "," + digits(v.z()) + "]";
}

Vec3 to_grid(const Vec3& v) {
  return v.unaryExpr([](double x) { return scenes::to_grid(x); });
}

class Script {
 public:
  Script(const Scene& scene, const Arguments& a) : arguments_(a), random_(a.seed) {
    std::map<std::string, int> names;
    for (const Object& o : scene.objects()) ++names[o.name];
    for (const Object& o : scene.objects()) {
      if (names[o.name] > 1 || o.vertex_count == 0) continue;
      Thing thing{o.name, {}};
      for (std::uint32_t v = 0; v < o.vertex_count; ++v)
        thing.box.extend(scene.vertices()[o.first_vertex + v]);
      world_.extend(thing.box);
      homes_.push_back(o.pose);
      things_.push_back(std::move(thing));
    }
    while (things_.size() > a.objects) drop(random_.below(things_.size()));
    for (const Light& light : scene.lights()) lights_.push_back(light);
  }

  bool is_empty() const { return things_.empty(); }

  void write(std::ostream& out) {
    std::uint64_t left = arguments_.count;
    while (left > 0) {
      const std::uint64_t group = std::min(left, 1 + random_.below(arguments_.most));
      for (std::uint64_t i = 0; i < group; ++i) edit(out);
      out << "{\"op\":\"update\"}\n";
      left -= group;
    }
  }

 private:
  void drop(std::size_t i) {
    things_.erase(things_.begin() + static_cast<std::ptrdiff_t>(i));
    homes_.erase(homes_.begin() + static_cast<std::ptrdiff_t>(i));
  }

  static std::string quoted(const std::string& name) { return nlohmann::json(name).dump(); }

  void edit(std::ostream& out) {
    const std::uint64_t dice = random_.below(100);
    if (dice < 4 && !lights_.empty()) return move_light(out);
    const std::size_t index = random_.below(things_.size());
    Thing& thing = things_[index];
    if (!thing.there) return add(out, thing);
    if (dice < 12 && !arguments_.keep) return remove(out, thing);
    if (dice < 22) return turn(out, thing, index);
    if (dice < 32) return go_home(out, thing, index);
    const Vec3 by = step(thing, dice);
    thing.shift += by;
    out << "{\"op\":\"move\",\"object\":" << quoted(thing.name) << ",\"translate\":" << text_of(by)
        << "}\n";
  }

  Vec3 step(const Thing& thing, std::uint64_t dice) {
    const double size = thing.box.diagonal().norm(), world = world_.diagonal().norm();
    const Vec3 now = thing.box.center() + thing.shift;
    if (dice < 36 && !lights_.empty()) {  // through a light
      const Light& light = lights_[random_.below(lights_.size())];
      if (light.kind == Light::Kind::point)
        return to_grid(light.position + random_.in_ball(1) * (0.3 * size) - now);
    }
    if (dice < 42) {  // to where another thing was at home: standing in it, or just above it
      const Thing& other = things_[random_.below(things_.size())];
      const double up = random_.below(2) == 0 ? 0 : other.box.max().z() - thing.box.min().z();
      const Vec3 flat = other.box.center() - thing.box.center();
      return to_grid(
          Vec3(flat.x() - thing.shift.x(), flat.y() - thing.shift.y(), up - thing.shift.z()));
    }
    // anywhere, also through walls
    if (dice < 50) return to_grid(world_.center() + random_.in_ball(1) * (0.6 * world) - now);
    // along an axis
    if (dice < 65) {
      Vec3 by = Vec3::Zero();
      by[static_cast<Eigen::Index>(random_.below(3))] = random_.in(-size, size);
      return by;
    }
    return to_grid(random_.in_ball(1) * (0.1 * size));
  }

  void remove(std::ostream& out, Thing& thing) {
    thing.there = false;
    out << "{\"op\":\"remove\",\"object\":" << quoted(thing.name) << "}\n";
  }

  void add(std::ostream& out, Thing& thing) {
    thing.there = true;
    out << "{\"op\":\"add\",\"object\":" << quoted(thing.name) << "}\n";
  }

  void go_home(std::ostream& out, Thing& thing, std::size_t index) {
    thing.shift = Vec3::Zero();
    write_pose(out, thing, homes_[index]);
  }

  // Turns about the centre of the object by an angle with rational sine and cosine, sometimes with
  // a change of size.
  void turn(std::ostream& out, Thing& thing, std::size_t index) {
    static constexpr double angles[][2] = {
        {0, 1}, {-1, 0}, {0.8, 0.6}, {0.28, 0.96}, {0.96, -0.28}};
    const auto axis = static_cast<Eigen::Index>(random_.below(4) == 0 ? random_.below(3) : 2);
    const auto& [c, s] = angles[random_.below(5)];
    const double scale = random_.below(5) == 0 ? random_.in(0.5, 1.5) : 1;
    Pose turned = Pose::Identity();
    const Eigen::Index a = (axis + 1) % 3, b = (axis + 2) % 3;
    turned(a, a) = scale * c, turned(a, b) = -scale * s, turned(b, a) = scale * s,
              turned(b, b) = scale * c;
    turned(axis, axis) = scale;
    const Vec3 middle = to_grid(Vec3(thing.box.center()));
    const Pose pose = Eigen::Translation3d(middle + thing.shift) * turned *
                      Eigen::Translation3d(-middle) * homes_[index];
    write_pose(out, thing, pose);
  }

  void write_pose(std::ostream& out, const Thing& thing, const Pose& pose) {
    out << "{\"op\":\"pose\",\"object\":" << quoted(thing.name) << ",\"matrix\":[";
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) out << digits(pose(row, column)) << ",";
    out << "0,0,0,1]}\n";
  }

  void move_light(std::ostream& out) {
    const std::size_t k = random_.below(lights_.size());
    Light& light = lights_[k];
    const bool point = light.kind == Light::Kind::point;
    if (point) light.position += to_grid(random_.in_ball(1) * (0.02 * world_.diagonal().norm()));
    else light.direction = to_grid(Vec3(light.direction.normalized() + random_.in_ball(0.25)));
    out << "{\"op\":\"light\",\"light\":" << k
        << ",\"at\":" << text_of(point ? light.position : light.direction) << "}\n";
  }

  const Arguments& arguments_;
  scenes::Random random_;
  std::vector<Thing> things_;
  std::vector<Pose> homes_;  // by thing
  std::vector<Light> lights_;
  Eigen::AlignedBox3d world_;
};

Scene scene_of(const std::string& name) {
  const bool is_made = name.find('.') == std::string::npos;
  return is_made ? scenes::build(scenes::named(name)) : io::read_scene(name);
}

// x,y,z of a point light.
Light light_of(const std::string& text) {
  std::vector<double> numbers;
  const char *at = text.data(), *const end = at + text.size();
  while (at != end && numbers.size() < 4) {
    double x = 0;
    const auto [rest, error] = std::from_chars(at, end, x);
    if (error != std::errc() || (rest != end && *rest != ',')) break;
    numbers.push_back(x);
    at = rest == end ? end : rest + 1;
  }
  if (at != end || numbers.size() != 3) throw Error("--light: '" + text + "' is not x,y,z");
  return Light::point({numbers[0], numbers[1], numbers[2]});
}

void run(const Arguments& a) {
  Scene scene = scene_of(a.scene);
  if (!a.lights.empty()) {
    std::vector<Light> lights;
    for (const std::string& text : a.lights) lights.push_back(light_of(text));
    scene.replace_lights(lights);
  }
  Script script(scene, a);
  if (script.is_empty()) throw Error(a.scene + ": no object has a unique name");
  script.write(std::cout);
  if (!std::cout.flush()) throw Error("standard output cannot be written");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Writes a random script of edits", "make_edits");
  Arguments a;
  app.add_option("SCENE", a.scene, "Scene file, or the name of a generated scene such as city:100")
      ->required();
  app.add_option("SEED", a.seed)->required();
  app.add_option("COUNT", a.count, "Number of edits")->required();
  app.add_option("--per-update", a.most, "Largest number of edits before an update (4)")
      ->check(CLI::PositiveNumber);
  app.add_option("--light", a.lights,
                 "First position x,y,z of a point light; without it the lights of the scene file")
      ->type_size(1)
      ->allow_extra_args(false);
  app.add_option("--objects", a.objects, "Edit only this number of objects")
      ->check(CLI::PositiveNumber);
  app.add_flag("--keep", a.keep, "Remove no object");
  CLI11_PARSE(app, argc, argv);
  try {
    run(a);
  } catch (const Error& error) {
    std::cerr << "make_edits: " << error.what() << "\n";
    return 2;
  }
}
