// What a light makes of a scene's facets before any shadow: which receive it, which cast, and the
// shadow planes of their edges. The rules are the engine's (shadows.hpp): solids receive and cast
// with the sides turned to the light, sheets with either, and a side seen edge-on does neither; the
// sides of a solid that are turned away cast too where the light is inside.
#pragma once

#include <shadowcut/shadows.hpp>

#include "polygon.hpp"

namespace shadowcut {
class LightSpace;
}

namespace shadowcut::compare {

// Nearer to a plane than this share of the scene's largest coordinate counts as on it: contact,
// which casts no shadow. It is what some thousand roundings come to.
inline constexpr double tolerance_share = 1e-12;

class Lighting {
 public:
  // Both must outlive it.
  Lighting(const Scene& scene, const Light& light);

  bool receives(std::uint32_t facet) const { return roles_[facet].receives; }
  bool casts(std::uint32_t facet) const { return roles_[facet].casts; }
  // How a face stands to the light, with no areas yet.
  Facing facing(std::uint32_t face) const { return facing_[face]; }

  // In front of this plane the light is nearer than behind it: positive, negative, or 0 where it is
  // in the plane, or parallel to it.
  double in_front_of(const HalfSpace& plane) const;
  // The planes of light through the polygon's edges, their fronts inside, in the polygon's order;
  // none for edges that earlier shadow planes cut, which those bound already. Slater 1992, section
  // 3.
  void shadow_planes(const Polygon& polygon,
                     boost::container::small_vector<HalfSpace, 8>& planes) const;

  const Scene& scene() const { return scene_; }
  const Light& light() const { return light_; }
  double tolerance() const { return tolerance_; }

 private:
  struct Role {
    bool receives = false, casts = false;
  };
  Role role_of(std::uint32_t facet, bool light_inside, const LightSpace& space) const;
  Vec3 normal_of_edge(const Polygon& polygon, std::size_t i) const;
  Vec3 direction_at(const Vec3& x) const;  // of the rays at x

  const Scene& scene_;
  const Light& light_;
  double tolerance_;
  std::vector<Role> roles_;
  std::vector<Facing> facing_;
};

// The share above of the scene's largest coordinate.
double tolerance_of(const Scene& scene);

}  // namespace shadowcut::compare
