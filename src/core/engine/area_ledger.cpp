#include "engine/area_ledger.hpp"

#include <algorithm>

namespace shadowcut {
namespace {

bool differ(const FaceArea& a, const FaceArea& b) {
  return a.facing != b.facing || a.area != b.area || a.lit != b.lit || a.shadowed != b.shadowed ||
         a.dropped != b.dropped;
}

// A power of two: the face's area is about 2^60 of it.
double unit_for(double area) {
  return area > 0 && std::isfinite(area) ? std::ldexp(1.0, std::ilogb(area) - 60) : 1.0;
}

}  // namespace

void AreaLedger::note_first(std::uint32_t face) {
  const std::size_t faces = context_.scene.faces().size();
  if (noted_in_.size() < faces) noted_in_.resize(faces, 0);
  SHADOWCUT_ASSERT(face < noted_in_.size());
  noted_in_[face] = update_;
  noted_.push_back({face, face < areas_.size() ? areas_[face] : FaceArea{}});
}

void AreaLedger::note_all() {
  for (std::uint32_t f = 0; f < context_.scene.faces().size(); ++f) note(f);
}

void AreaLedger::list_changes(LightChanges& changes) const {
  changes.areas.reserve(noted_.size());
  for (const Noted& old : noted_) {
    const FaceArea now = old.face < areas_.size() ? areas_[old.face] : FaceArea{};
    if (differ(old.area, now)) changes.areas.push_back({old.face, now});
  }
}

// How a face stands to the light, and its whole area. The area is not the sum of the fragments'
// areas, so that the sum can be checked against it.
FaceArea AreaLedger::whole_area(std::uint32_t f) const {
  const Face& face = context_.scene.faces()[f];
  FaceArea out;
  for (std::uint32_t i = face.first_facet; i < face.first_facet + face.facet_count; ++i) {
    const Facing facing = context_.visibility.facing(FacetId(i));
    out.facing = std::max(out.facing, facing);
    if (facing != Facing::ignored)
      out.area += area_of_facet(context_, FacetId(i), facing == Facing::toward);
  }
  if (out.facing == Facing::ignored) out.area = face.area;
  return out;
}

// Nothing but the smallest features is missing from a face's fragments, and they do not overlap.
void AreaLedger::set_dropped(FaceArea& a) const {
  const bool has_fragments = a.facing != Facing::ignored && a.facing != Facing::refused;
  a.dropped = has_fragments && !context_.min_feature.keeps_all()
                  ? std::max(0.0, a.area - a.lit - a.shadowed)
                  : 0;
}

void AreaLedger::start() {
  areas_.assign(context_.scene.faces().size(), {});
  units_.assign(areas_.size(), {});
  for (std::uint32_t f = 0; f < areas_.size(); ++f) {
    areas_[f] = whole_area(f);
    units_[f] = {unit_for(areas_[f].area), areas_[f].facing == Facing::toward};
  }
}

void AreaLedger::start(std::span<const FaceArea> emitted, std::span<const Block> blocks) {
  areas_.assign(context_.scene.faces().size(), {});
  for (std::uint32_t f = 0; f < areas_.size(); ++f) {
    areas_[f] = whole_area(f);
    areas_[f].lit = emitted[f].lit, areas_[f].shadowed = emitted[f].shadowed;
    set_dropped(areas_[f]);
  }
  for (const Block& block : blocks) {
    for (const Fragment& f : block.fragments) {
      if (areas_[f.face].facing == Facing::toward)
        ++(f.lit ? stats_.lit_fragments : stats_.shadowed_fragments);
    }
  }
  for (const FaceArea& area : areas_) {
    if (area.facing != Facing::toward) continue;
    ++stats_.facing_faces;
    stats_.facing_area += area.area, stats_.lit_area += area.lit;
    stats_.shadowed_area += area.shadowed, stats_.dropped_area += area.dropped;
  }
}

void AreaLedger::grow(std::size_t faces) {
  if (areas_.size() < faces) areas_.resize(faces);
  if (units_.size() < faces) units_.resize(faces);
}

void AreaLedger::start_face(std::uint32_t face) {
  SHADOWCUT_ASSERT(face < areas_.size() && face < units_.size());
  areas_[face] = whole_area(face);
  set_dropped(areas_[face]);
  units_[face] = {unit_for(areas_[face].area), areas_[face].facing == Facing::toward};
}

void AreaLedger::remove_face(std::uint32_t face) {
  SHADOWCUT_ASSERT(units_[face].lit == 0 && units_[face].shadowed == 0);
  areas_[face] = {};
  units_[face] = {};
}

void AreaLedger::absorb(const FragmentStore::AreaChange& change) {
  note(change.face);
  Units& u = units_[change.face];
  SHADOWCUT_ASSERT(change.area >= 0 || std::isnan(change.area));
  constexpr double most = 0x1p62;
  const auto units = static_cast<std::int64_t>(std::min(change.area / u.unit, most));
  (change.lit ? u.lit : u.shadowed) += change.added ? units : -units;
  if (!u.faces_light) return;
  std::uint64_t& fragments = change.lit ? stats_.lit_fragments : stats_.shadowed_fragments;
  SHADOWCUT_ASSERT(change.added || fragments > 0);
  change.added ? ++fragments : --fragments;
}

// A face's areas from its units.
void AreaLedger::measure(std::uint32_t face) {
  SHADOWCUT_ASSERT(units_[face].lit >= 0 && units_[face].shadowed >= 0);
  const auto area = [](Count count, double unit) {
    const auto short_count = static_cast<std::int64_t>(count);  // nearly always the same number
    return (short_count == count ? static_cast<double>(short_count) : static_cast<double>(count)) *
           unit;
  };
  FaceArea& a = areas_[face];
  const Units& u = units_[face];
  a.lit = area(u.lit, u.unit), a.shadowed = area(u.shadowed, u.unit);
  set_dropped(a);
}

void AreaLedger::count_face(const FaceArea& before, const FaceArea& now) {
  const bool was = before.facing == Facing::toward, is = now.facing == Facing::toward;
  SHADOWCUT_ASSERT(stats_.facing_faces + is >= was);
  stats_.facing_faces += is, stats_.facing_faces -= was;
  const auto count = [&](ExactSum& sum, double FaceArea::*area) {
    const double old = was ? before.*area : 0, fresh = is ? now.*area : 0;
    if (old != fresh) sum.add(-old), sum.add(fresh);
  };
  count(facing_area_, &FaceArea::area), count(lit_area_, &FaceArea::lit);
  count(shadowed_area_, &FaceArea::shadowed), count(dropped_area_, &FaceArea::dropped);
}

void AreaLedger::total_up(bool all) {
  if (all) {
    facing_area_ = lit_area_ = shadowed_area_ = dropped_area_ = {};
    stats_.facing_faces = 0;
    for (std::uint32_t f = 0; f < areas_.size(); ++f) {
      measure(f);
      count_face({}, areas_[f]);
    }
  } else {
    for (const Noted& old : noted_) {
      measure(old.face);
      count_face(old.area, areas_[old.face]);
    }
  }
  stats_.facing_area = facing_area_.value(), stats_.lit_area = lit_area_.value();
  stats_.shadowed_area = shadowed_area_.value(), stats_.dropped_area = dropped_area_.value();
}

}  // namespace shadowcut
