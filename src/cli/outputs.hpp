// The files that a command writes: all of them, or none.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace shadowcut::cli {

// Throws Error unless a file can stand at this path. What can be known to fail before the work is
// done shall fail before the work is done.
void check_folder(const std::string& path);

// Writes one after the other; when one fails, those before it go too.
class Outputs {
 public:
  void write(const std::string& path, const std::function<void()>& write);

 private:
  std::vector<std::string> written_;
};

}  // namespace shadowcut::cli
