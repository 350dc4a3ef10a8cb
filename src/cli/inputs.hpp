// Input of every command: a scene, and lights from the scene file or from arguments.
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

// Sets the lights of a scene and returns them: the given lights or, without any, the lights of the
// scene file. Throws Error if there is no light at all.
std::vector<NamedLight> set_lights(Scene& scene, const std::vector<NamedLight>& given,
                                   const std::string& file);

struct Reading {
  std::string file;
  io::ReadOptions options;
  bool strict = false;  // a refused or repaired face is an error
  bool quiet = false;   // refused and repaired faces are not listed
};

// A scene that has at least one usable face.
Scene read(const Reading& reading);

// The number of threads; 0 becomes the number of processors.
unsigned threads_of(unsigned wanted);

}  // namespace shadowcut::cli
