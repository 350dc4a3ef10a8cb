// The output files of a command. A command writes all of them, or none.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace shadowcut::cli {

// Throws Error if the folder of the path does not exist. Called before the work of a command, so
// that a wrong path is reported at once.
void check_folder(const std::string& path);

// Writes files one after the other. If one fails, the files written before it are deleted.
class Outputs {
 public:
  void write(const std::string& path, const std::function<void()>& write);

 private:
  std::vector<std::string> written_;
};

}  // namespace shadowcut::cli
