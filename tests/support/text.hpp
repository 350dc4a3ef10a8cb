// Messages of tests.
#pragma once

#include <sstream>
#include <string>

namespace shadowcut::testing {

// All parts, one after another; numbers with all their digits.
template <class... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream out;
  out.precision(17);
  (out << ... << parts);
  return out.str();
}

}  // namespace shadowcut::testing
