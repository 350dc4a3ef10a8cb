// Brute force: every polygon against the shadow volume of every polygon before it. M. Slater, "A
// comparison of three shadow volume algorithms", 1992, section 3 (definition 3.1).
//
// Departures. Slater paints overlapping shadows over the polygon; here each volume is cut from what
// is still lit, so that the parts do not overlap and have areas (his section 8 suggests as much). A
// polygon gets no volume if nothing of it is lit, where his must lie in a single one; and its
// volume takes the place of those that lie in it and cut it.
#include <algorithm>

#include "shadow_volumes.hpp"

namespace shadowcut::compare {
namespace {

// Whether a single plane has the polygon outside; most pairs end here.
bool parted(const Volume& volume, const Polygon& polygon, double tolerance) {
  return volume.empty() || std::any_of(volume.begin(), volume.end(), [&](const HalfSpace& plane) {
           return std::none_of(
               polygon.corners.begin(), polygon.corners.end(),
               [&](const PolygonCorner& c) { return plane.above(c.at) > tolerance; });
         });
}

// Leaves the part inside all planes, if any; the parts outside go to `outside`, if that is asked
// for.
bool inside(const Volume& volume, double tolerance, Polygon& polygon,
            std::vector<Polygon>* outside) {
  return std::all_of(volume.begin(), volume.end(), [&](const HalfSpace& plane) {
    return keep_front(polygon, plane, tolerance, outside);
  });
}

class Brute : public ShadowVolumes {
 public:
  Brute(const Lighting& lighting, const Settings& settings)
      : lighting_(lighting), counts_(settings.count_shadow_polygons) {}

  void cut(const Polygon& polygon, std::vector<Fragment>& parts) override {
    const std::size_t first = parts.size();
    parts.push_back({polygon, true});
    cutting_.clear();
    for (std::size_t i = 0; i < volumes_.size(); ++i) {
      if (counts_ && meets(volumes_[i].planes, polygon, lighting_.tolerance())) ++shadow_polygons_;
      if (subtract(volumes_[i].planes, lighting_.tolerance(), parts, first)) cutting_.push_back(i);
    }
  }

  void add(const Polygon& polygon, bool lit) override {
    if (!lit) return;
    Caster caster{polygon, {}};
    lighting_.shadow_planes(polygon, caster.planes);
    discard_those_in(caster.planes);
    volumes_.push_back(std::move(caster));
  }

  std::size_t bytes() const override { return volumes_.capacity() * sizeof(Caster); }

 private:
  struct Caster {
    Polygon polygon;
    Volume planes;
  };

  // Of the volumes that cut the polygon (others cannot lie in its shadow).
  void discard_those_in(const Volume& volume) {
    for (auto i = cutting_.rbegin(); i != cutting_.rend(); ++i) {
      if (contains(volume, volumes_[*i].polygon, lighting_.tolerance()))
        volumes_.erase(volumes_.begin() + static_cast<std::ptrdiff_t>(*i));
    }
    cutting_.clear();
  }

  const Lighting& lighting_;
  const bool counts_;
  std::vector<Caster> volumes_;
  std::vector<std::size_t> cutting_;  // those that cut the last polygon, by index, ascending
};

}  // namespace

bool subtract(const Volume& volume, double tolerance, std::vector<Fragment>& parts,
              std::size_t first) {
  bool reached = false;
  std::vector<Polygon> outside;
  for (std::size_t i = first, end = parts.size(); i < end; ++i) {
    if (!parts[i].lit || parted(volume, parts[i].polygon, tolerance)) continue;
    outside.clear();
    Polygon rest = parts[i].polygon;
    if (!inside(volume, tolerance, rest, &outside)) continue;
    reached = true;
    parts[i] = {std::move(rest), false};
    for (Polygon& polygon : outside) parts.push_back({std::move(polygon), true});
  }
  return reached;
}

bool meets(const Volume& volume, const Polygon& polygon, double tolerance) {
  if (parted(volume, polygon, tolerance)) return false;
  Polygon rest = polygon;
  return inside(volume, tolerance, rest, nullptr);
}

bool contains(const Volume& volume, const Polygon& polygon, double tolerance) {
  return std::all_of(volume.begin(), volume.end(), [&](const HalfSpace& plane) {
    return std::all_of(polygon.corners.begin(), polygon.corners.end(),
                       [&](const PolygonCorner& c) { return plane.above(c.at) >= -tolerance; });
  });
}

std::unique_ptr<ShadowVolumes> make_brute(const Lighting& lighting, const Settings& settings) {
  return std::make_unique<Brute>(lighting, settings);
}

}  // namespace shadowcut::compare
