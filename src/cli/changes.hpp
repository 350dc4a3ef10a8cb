// What updates changed, as lines of JSON, in a file that is there only when all of them are.
//
//   {"update":U,"light":L,"rebuilt":BOOL,"removed":BOOL,
//    "gone":[[cell,piece,place],...],
//    "added":[{"id":[cell,piece,place],"face":F,"object":NAME,"number":N,"lit":BOOL,"caster":F or
//      null,
//              "corners":[[x,y,z],...]},...],
//    "areas":[{"face":F,"lit":A,"shadowed":A,"area":A},...]}
//
// A line for each light whose shadows changed. Update 0 is the build: a mirror that begins empty
// and applies every line, `gone` first, holds the fragments that the engine lists. `face` and
// `caster` are numbers of the scene's faces, `number` is the face's within its object.
#pragma once

#include <cstddef>
#include <shadowcut/shadows.hpp>
#include <string>

#include "io/files.hpp"

namespace shadowcut::cli {

class ChangesFile {
 public:
  explicit ChangesFile(const std::string& path) : file_(path) {}
  void write(std::size_t update, const Engine& engine, const Changes& changes);
  void commit() { file_.commit(); }

 private:
  void append_line(std::size_t update, const Engine& engine, const LightChanges& changes);
  void append_added(const Engine& engine, const LightChanges& changes);

  io::PendingFile file_;
  std::string text_;
};

}  // namespace shadowcut::cli
