// Messages of invariant checks.
#pragma once

#include <cstddef>
#include <string>

namespace shadowcut {

inline std::string message(const char* what, std::size_t which) {
  return std::string(what) + " (" + std::to_string(which) + ")";
}

}  // namespace shadowcut
