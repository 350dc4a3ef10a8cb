// Output of the rows of a benchmark.
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>
#include <shadowcut/scene.hpp>
#include <string>

namespace shadowcut::bench {

// Throws Error if the file cannot be written. Does nothing without a path.
inline void write_json(const std::string& path, const nlohmann::ordered_json& document) {
  if (path.empty()) return;
  std::ofstream out(path);
  out << document.dump(1) << "\n";
  if (!out.flush()) throw Error(path + ": cannot be written");
}

}  // namespace shadowcut::bench
