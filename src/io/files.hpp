// Whole files in and out. Output goes to a file beside its target and takes the target's name only
// when complete.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace shadowcut::io {

// Throws Error, with the system's reason, unless path is a file that can be opened.
void check_readable(const std::string& path);

// The bytes of a file; Error when it cannot be read.
std::string read_bytes(const std::string& path);

// The extension in lower case with its dot, or an empty string.
std::string extension_of(const std::string& path);

// A file being written. Until commit() the target is untouched; without commit() nothing stays
// behind.
class PendingFile {
 public:
  explicit PendingFile(const std::string& path);
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  void write(std::string_view bytes);
  void commit();

 private:
  [[noreturn]] void fail() const;

  std::string name_;              // as the user gave it, for messages
  std::filesystem::path target_;  // with symbolic links followed: a link stays a link
  // equal to target_ when the target is a device or a pipe, which must not be replaced
  std::filesystem::path beside_;
  std::ofstream stream_;
};

}  // namespace shadowcut::io
