// What every command reads: a scene, and lights from its file or from arguments.
#pragma once

#include <shadowcut/io.hpp>
#include <string>
#include <vector>

namespace shadowcut::cli {

struct NamedLight {
  Light light;
  std::string spec;  // as given
};

// From --light.
std::vector<NamedLight> parse_lights(const std::vector<std::string>& specs);

// Gives a scene its lights, and returns them: those given, or, when there are none, the file's own.
// Throws Error when that has none either.
std::vector<NamedLight> set_lights(Scene& scene, const std::vector<NamedLight>& given,
                                   const std::string& file);

struct Reading {
  std::string file;
  io::ReadOptions options;
  bool strict = false;  // refuses a scene with refused or repaired faces
  bool quiet = false;   // does not list them
};

// A scene that has at least one usable face.
Scene read(const Reading& reading);

// 0 is one for each processor.
unsigned threads_of(unsigned wanted);

}  // namespace shadowcut::cli
