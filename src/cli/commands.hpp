// The commands of the program and their arguments.
#pragma once

#include <optional>
#include <shadowcut/io.hpp>
#include <string>
#include <vector>

#include "compare/compare.hpp"

namespace shadowcut::cli {

struct CastArguments {
  std::string scene;
  std::vector<std::string> lights;
  Options options;
  io::ReadOptions reading;
  std::vector<std::string> outputs;
  std::vector<std::string> drawings;  // --svg
  std::string up = "z";
  std::string areas, json;  // empty: none
  bool strict = false, quiet = false;
};

struct InspectArguments {
  std::string scene, json;
  io::ReadOptions reading;
};

struct ReplayArguments {
  std::string scene, edits;
  std::vector<std::string> lights;
  Options options;
  io::ReadOptions reading;
  std::string changes, json;  // empty: none
  bool verify = false, quiet = false;
};

struct CompareArguments {
  std::string scene;
  std::vector<std::string> lights;
  std::string algorithms = "brute,ordered,tiling,unordered";
  shadowcut::compare::Settings settings;
  io::ReadOptions reading;
  std::string json;  // empty: none
  bool quiet = false;
};

struct RenderArguments {
  std::string scene;
  std::vector<std::string> lights;
  std::string technique, camera, output;
  int width = 640, height = 480;
  std::string wind, bias;       // empty: no wind; the default bias
  std::optional<int> map_side;  // nullopt: the default
  io::ReadOptions reading;
  std::string json;  // empty: none
  bool quiet = false;
};

struct ViewArguments {
  std::string scene;  // empty: the furnished room
  std::vector<std::string> lights;
  std::string technique = "fragments", camera;  // empty: a camera is chosen
  int width = 1024, height = 768;
  io::ReadOptions reading;
  bool quiet = false;
};

// All commands throw Error, or another std::exception, and leave no output file behind then.
void cast(const CastArguments& arguments);
void inspect(const InspectArguments& arguments);
void compare_algorithms(const CompareArguments& arguments);
void render_picture(const RenderArguments& arguments);
void view_scene(const ViewArguments& arguments);
// Returns an empty string or, with `verify`, a sentence that names the first update that differs
// from a rebuild.
std::string replay(const ReplayArguments& arguments);

}  // namespace shadowcut::cli
