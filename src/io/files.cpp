// Whole files in and out; see files.hpp.
#include "files.hpp"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <iostream>
#include <shadowcut/io.hpp>

namespace shadowcut::io {

namespace fs = std::filesystem;

void check_readable(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) throw Error(path + ": is a directory");
  errno = 0;
  if (!std::ifstream(path, std::ios::binary)) throw Error(path + ": " + std::strerror(errno));
}

std::string read_bytes(const std::string& path) {
  check_readable(path);
  std::ifstream in(path, std::ios::binary);
  std::string bytes;
  std::error_code error;
  const auto size = fs::is_regular_file(path, error) ? fs::file_size(path, error) : 0;
  if (!error) bytes.reserve(size);
  char block[1 << 16];
  while (in.read(block, sizeof block) || in.gcount() > 0)
    bytes.append(block, static_cast<std::size_t>(in.gcount()));
  if (in.bad()) throw Error(path + ": cannot be read");
  return bytes;
}

std::string extension_of(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

PendingFile::PendingFile(const std::string& path) : name_(path) {
  std::error_code error;
  target_ = fs::exists(path, error) ? fs::canonical(path, error) : fs::path(path);
  if (error) target_ = path;
  if (fs::is_directory(target_, error)) throw Error(path + ": is a directory");
  beside_ = target_;
  if (!fs::exists(target_, error) || fs::is_regular_file(target_, error))
    beside_ += ".part" + std::to_string(::getpid());
  errno = 0;
  stream_.open(beside_, std::ios::binary | std::ios::trunc);
  if (!stream_) throw Error(path + ": cannot be written: " + std::strerror(errno));
}

PendingFile::~PendingFile() {
  std::error_code error;
  if (beside_.empty() || beside_ == target_) return;
  stream_.close();
  fs::remove(beside_, error);
}

void PendingFile::write(std::string_view bytes) {
  errno = 0;
  stream_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!stream_) fail();
}

void PendingFile::commit() {
  errno = 0;
  stream_.close();
  if (!stream_) fail();
  std::error_code error;
  if (beside_ != target_) fs::rename(beside_, target_, error);
  if (error) throw Error(name_ + ": cannot be written: " + error.message());
  beside_.clear();
}

void PendingFile::fail() const {
  throw Error(name_ + ": cannot be written" +
              (errno != 0 ? std::string(": ") + std::strerror(errno) : std::string()));
}

void write_text(const std::string& path, std::string_view text) {
  if (path == "-") {
    std::cout.write(text.data(), static_cast<std::streamsize>(text.size())).flush();
    if (!std::cout) throw Error("standard output cannot be written");
    return;
  }
  PendingFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace shadowcut::io
