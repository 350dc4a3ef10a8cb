// The program's commands and their arguments.
#pragma once

#include <shadowcut/io.hpp>
#include <string>
#include <vector>

namespace shadowcut::cli {

struct CastArguments {
  std::string scene;
  std::vector<std::string> lights;
  Options options;
  Sides sides = Sides::automatic;
  std::vector<std::string> outputs;
  std::vector<std::string> drawings;  // --svg
  std::string up = "z";
  std::string areas, json;  // empty: none
  bool strict = false, quiet = false;
};

struct InspectArguments {
  std::string scene, json;
  Sides sides = Sides::automatic;
};

// Both throw Error, or another std::exception, and then have left no output behind.
void cast(const CastArguments& arguments);
void inspect(const InspectArguments& arguments);

}  // namespace shadowcut::cli
