// The shadow volumes of the polygons nearer to the light, which the next polygon is cut by: the one
// thing in which brute force, tiling and the ordered tree differ. Polygons come front to back, so a
// shadow volume needs no plane of its own polygon: whatever comes later is behind it.
#pragma once

#include <memory>

#include "compare.hpp"
#include "lighting.hpp"

namespace shadowcut::compare {

class ShadowVolumes {
 public:
  virtual ~ShadowVolumes() = default;
  // Appends the polygon's lit and shadowed parts.
  virtual void cut(const Polygon& polygon, std::vector<Fragment>& parts) = 0;
  // From now on the polygon casts. `lit`: some of it does, so that its shadow is not all in others'
  // shadow.
  virtual void add(const Polygon& polygon, bool lit) = 0;
  // Both in one go.
  virtual void cut_and_add(const Polygon& polygon, std::vector<Fragment>& parts) {
    const std::size_t before = parts.size();
    cut(polygon, parts);
    bool lit = false;
    for (std::size_t i = before; i < parts.size(); ++i) lit = lit || parts[i].lit;
    add(polygon, lit);
  }
  virtual std::size_t bytes() const = 0;
  std::uint64_t shadow_polygons() const { return shadow_polygons_; }

 protected:
  std::uint64_t shadow_polygons_ = 0;
};

std::unique_ptr<ShadowVolumes> make_brute(const Lighting& lighting, const Settings& settings);
std::unique_ptr<ShadowVolumes> make_tiling(const Lighting& lighting, const Settings& settings);
std::unique_ptr<ShadowVolumes> make_ordered(const Lighting& lighting, const Settings& settings);

// A polygon's planes of light, fronts inside. Empty planes: it casts no more.
using Volume = boost::container::small_vector<HalfSpace, 8>;

// Cuts the lit parts from parts[first] on by one volume: what is inside becomes shadowed. Nothing
// is cut that the volume does not reach. Returns whether it reached any.
bool subtract(const Volume& volume, double tolerance, std::vector<Fragment>& parts,
              std::size_t first);
// Whether some of the polygon is inside.
bool meets(const Volume& volume, const Polygon& polygon, double tolerance);
// Whether all of it is.
bool contains(const Volume& volume, const Polygon& polygon, double tolerance);

}  // namespace shadowcut::compare
