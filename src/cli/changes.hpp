// The changes of updates as lines of JSON. The file appears only when it is complete.
//
//   {"update":U,"light":L,"rebuilt":BOOL,"removed":BOOL,
//    "gone":[[cell,piece,place],...],
//    "added":[{"id":[cell,piece,place],"face":F,"object":NAME,"number":N,"lit":BOOL,"caster":F or
//      null,
//              "corners":[[x,y,z],...]},...],
//    "areas":[{"face":F,"lit":A,"shadowed":A,"area":A},...]}
//
// There is one line for each light whose shadows changed. Update 0 is the build: a copy that begins
// empty and applies every line, `gone` first, holds the same fragments as the engine. `face` and
// `caster` are indices of faces of the scene, `number` is the number of the face in its object.
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
