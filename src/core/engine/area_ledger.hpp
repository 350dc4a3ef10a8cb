// Lit and shadowed areas of faces, and their totals, while fragments come and go.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "fragments/fragment_store.hpp"
#include "numbers/exact_sum.hpp"

namespace shadowcut {

class AreaLedger {
 public:
  // Keeps `areas`, by face, and the area totals and fragment counts of `stats`. The references must
  // stay valid.
  AreaLedger(const EmissionContext& context, std::vector<FaceArea>& areas, Stats& stats)
      : context_(context), areas_(areas), stats_(stats) {}

  void begin_update() {
    SHADOWCUT_ASSERT(update_ + 1 != 0);
    ++update_;
    noted_.clear();
  }
  // Keeps what a face was before this update.
  void note(std::uint32_t face) {
    if (face >= noted_in_.size() || noted_in_[face] != update_) note_first(face);
  }
  void note_all();
  // The faces whose facing or areas are not what they were before this update.
  void list_changes(LightChanges& changes) const;

  // After a build, of an incremental store: all faces, without fragments so far. Of another store:
  // all faces, with what it has emitted.
  void start();
  void start(std::span<const FaceArea> emitted, std::span<const Block> blocks);

  void grow(std::size_t faces);
  // A face has no fragments now: its fragments are counted as they come. Thread-safe for different
  // faces.
  void start_face(std::uint32_t face);
  void remove_face(std::uint32_t face);
  void absorb(const FragmentStore::AreaChange& change);
  // Computes the areas of faces noted in this update, or of all faces, and the totals.
  void total_up(bool all);

 private:
  // Areas in whole multiples of a unit of each face, so that adding and subtracting is exact. As
  // many fragments as there may be, each of up to 2^62 units.
  __extension__ using Count = __int128;
  struct Units {
    double unit = 1;
    bool faces_light = false;
    Count lit = 0, shadowed = 0;
  };
  struct Noted {
    std::uint32_t face;
    FaceArea area;
  };

  void note_first(std::uint32_t face);
  FaceArea whole_area(std::uint32_t face) const;
  void set_dropped(FaceArea& area) const;
  void measure(std::uint32_t face);
  void count_face(const FaceArea& before, const FaceArea& now);

  const EmissionContext& context_;
  std::vector<FaceArea>& areas_;
  Stats& stats_;
  std::vector<Units> units_;  // by face
  ExactSum facing_area_, lit_area_, shadowed_area_, dropped_area_;
  std::uint32_t update_ = 0;
  std::vector<Noted> noted_;             // as they were before this update
  std::vector<std::uint32_t> noted_in_;  // by face: the update in which it was noted last
};

}  // namespace shadowcut
