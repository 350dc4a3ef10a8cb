// Scripts of edits; see edits.hpp.
#include "edits.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "io/text.hpp"

namespace shadowcut::cli {

namespace {

using nlohmann::json;
using Op = Step::Op;

struct Form {
  const char* word;
  Op op;
  std::vector<const char*> keys;         // besides "op"; all of them, and no others
  std::vector<const char*> one_of = {};  // and exactly one of these, unless there are none
};

// "at": the position or the direction, whichever the light has.
const std::vector<const char*> light_keys{"at", "position", "direction"};

const std::vector<Form>& forms() {
  static const std::vector<Form> all{
      {"move", Op::move, {"object", "translate"}}, {"pose", Op::pose, {"object", "matrix"}},
      {"remove", Op::remove, {"object"}},          {"add", Op::add, {"object"}},
      {"light", Op::light, {"light"}, light_keys}, {"update", Op::update, {}}};
  return all;
}

std::string quoted(const std::string& word) { return "'" + io::printable(word) + "'"; }

// nlohmann::json keeps the last of several values of one key and reports no error.
json parse_line(std::string_view line) {
  std::set<std::string> keys;
  const auto see = [&keys](int depth, json::parse_event_t event, json& value) {
    if (event == json::parse_event_t::key && depth == 1 &&
        !keys.insert(value.get<std::string>()).second)
      throw Error("the key " + quoted(value.get<std::string>()) + " occurs twice");
    return true;
  };
  try {
    return json::parse(line, see);
  } catch (const json::parse_error& error) {
    throw Error("invalid JSON at column " + std::to_string(error.byte));
  } catch (const json::out_of_range&) {
    throw Error("invalid JSON: a number is out of range");
  }
}

const Form& form_of(const json& object) {
  const auto op = object.find("op");
  if (op == object.end()) throw Error("the key \"op\" is missing");
  if (!op->is_string()) throw Error("\"op\" is not a string");
  for (const Form& form : forms())
    if (*op == form.word) return form;
  throw Error("unknown op " + quoted(op->get<std::string>()) +
              "; it must be move, pose, remove, add, light or update");
}

// The one of these keys that the object has. Throws Error unless there is exactly one.
const char* key_among(const json& object, const std::vector<const char*>& keys,
                      const std::string& op) {
  const auto has = [&object](const char* key) { return object.contains(key); };
  const auto first = std::find_if(keys.begin(), keys.end(), has);
  if (first != keys.end() && std::count_if(keys.begin(), keys.end(), has) == 1) return *first;
  std::string list;
  for (const char* key : keys) {
    if (!list.empty()) list += key == keys.back() ? " or " : ", ";
    list += '"' + std::string(key) + '"';
  }
  throw Error("the op " + op + " needs " + (first == keys.end() ? "" : "only one of ") + list);
}

void check_keys(const json& object, const Form& form) {
  for (const char* key : form.keys)
    if (!object.contains(key))
      throw Error(std::string("the op ") + form.word + " needs \"" + key + "\"");
  if (!form.one_of.empty()) key_among(object, form.one_of, form.word);
  for (const auto& item : object.items()) {
    bool known = item.key() == "op";
    for (const char* key : form.keys) known = known || item.key() == key;
    for (const char* key : form.one_of) known = known || item.key() == key;
    if (!known)
      throw Error(std::string("the op ") + form.word + " has no key " + quoted(item.key()));
  }
}

std::vector<double> numbers_of(const json& object, const std::string& key, std::size_t count) {
  const json& list = object[key];
  bool good = list.is_array() && list.size() == count;
  std::vector<double> numbers;
  for (std::size_t i = 0; good && i < count; ++i) {
    good = list[i].is_number() && std::isfinite(list[i].get<double>());
    if (good) numbers.push_back(list[i].get<double>());
  }
  if (!good)
    throw Error("\"" + key + "\" is not a list of " + std::to_string(count) + " finite numbers");
  return numbers;
}

Vec3 vector_of(const json& object, const std::string& key) {
  const std::vector<double> n = numbers_of(object, key, 3);
  return {n[0], n[1], n[2]};
}

Pose pose_of(const json& object) {
  const std::vector<double> n = numbers_of(object, "matrix", 16);
  if (n[12] != 0 || n[13] != 0 || n[14] != 0 || n[15] != 1)
    throw Error("the last row of \"matrix\" is not 0, 0, 0, 1");
  Pose pose = Pose::Identity();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      pose(row, column) = n[static_cast<std::size_t>(4 * row + column)];
  return pose;
}

Step step_of(std::string_view line) {
  const json object = parse_line(line);
  if (!object.is_object()) throw Error("not a JSON object");
  const Form& form = form_of(object);
  check_keys(object, form);
  Step step;
  step.op = form.op;
  if (object.contains("object")) {
    if (!object["object"].is_string()) throw Error("\"object\" is not a string");
    step.object = object["object"].get<std::string>();
  }
  if (step.op == Op::move) step.vector = vector_of(object, "translate");
  if (step.op == Op::pose) step.pose = pose_of(object);
  if (step.op == Op::light) {
    if (!object["light"].is_number_unsigned()) throw Error("\"light\" is not the index of a light");
    step.light = object["light"].get<std::size_t>();
    step.vector_key = key_among(object, light_keys, "light");
    step.vector = vector_of(object, step.vector_key);
  }
  return step;
}

std::string place_of(const std::string& file, std::size_t line) {
  return file + ":" + std::to_string(line) + ": ";
}

}  // namespace

std::vector<Step> parse_edits(std::string_view text, const std::string& file) {
  std::vector<Step> steps;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = io::take_line(text);
    if (io::trimmed(line).empty()) continue;
    try {
      steps.push_back(step_of(line));
    } catch (const Error& error) {
      throw Error(place_of(file, number) + error.what());
    }
    steps.back().line = number;
  }
  return steps;
}

Player::Player(Scene& scene, std::string file) : scene_(scene), file_(std::move(file)) {
  for (std::size_t i = 0; i < scene.objects().size(); ++i) {
    if (!scene.objects()[i].alive) continue;
    Named& object = objects_[scene.objects()[i].name];
    object.id = scene.object_id(i);
    ++object.count;
  }
}

void Player::apply(const Step& step) {
  try {
    do_it(step);
  } catch (const Error& error) {
    throw Error(place_of(file_, step.line) + error.what());
  }
}

void Player::do_it(const Step& step) {
  if (step.op == Op::light) return move_light(step);
  Named& object = named(step.object);
  if (step.op == Op::add) return bring_back(object, step.object);
  const Object* there = scene_.find(object.id);
  if (there == nullptr) throw Error("object " + quoted(step.object) + " has been removed");
  if (step.op == Op::remove) {
    object.removed = scene_.source(object.id);
    static_cast<void>(scene_.remove(object.id));  // it is there
  } else {
    Pose pose = step.pose;
    if (step.op == Op::move) pose = Eigen::Translation3d(step.vector) * there->pose;
    static_cast<void>(scene_.set_pose(object.id, pose));
  }
}

Player::Named& Player::named(const std::string& name) {
  const auto place = objects_.find(name);
  if (place == objects_.end()) throw Error("the scene has no object " + quoted(name));
  const std::size_t count = place->second.count;
  if (count > 1)
    throw Error("object " + quoted(name) + " is ambiguous: " + std::to_string(count) +
                " objects of the scene have that name");
  return place->second;
}

void Player::bring_back(Named& object, const std::string& name) {
  if (!object.removed) throw Error("object " + quoted(name) + " is already in the scene");
  object.id = scene_.add(object.removed->first, object.removed->second);
  object.removed.reset();
}

void Player::move_light(const Step& step) {
  const LightId id = scene_.light_id(step.light);
  const Light* there = scene_.find(id);
  if (there == nullptr) throw Error("the scene has no light " + std::to_string(step.light));
  Light light = *there;
  const bool point = light.kind == Light::Kind::point;
  if (step.vector_key == (point ? "direction" : "position"))
    throw Error("light " + std::to_string(step.light) + " is " +
                (point ? "a point light: it has a position, no direction"
                       : "directional: it has a direction, no position"));
  (point ? light.position : light.direction) = step.vector;
  static_cast<void>(scene_.set_light(id, light));
}

}  // namespace shadowcut::cli
