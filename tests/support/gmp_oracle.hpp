// The exact answer for one light: for every facet the region that the light sees and the part of it
// that is lit, in whole numbers of any length, from the definition alone. Nothing of src/ is used,
// and no double is ever rounded.
//
// The definition, on the doubles of Scene::vertices(), Plane::exact_normal, Plane::point and
// Light::at:
//   1. A facet's plane is { x : exact_normal . (x - point) = 0 }. Its front faces a point light iff
//      exact_normal . (light - point) > 0, a directional one iff exact_normal . direction < 0.
//   2. A facet is edge-on, and takes no part, if that number is 0; if some corner x of the facet
//      has another sign of exact_normal . (x - light) than point has, or zero (point lights); or if
//      its corners, seen from the light, are in one line.
//   3. Of closed objects only facets whose front faces the light take part; of open ones both sides
//      do.
//   4. A facet's region is its plane cut by the cone of rays through the loop of its corners. A
//      loop that is not convex as the light sees the loop is the simple polygon as it stands.
//   5. x on one facet is shadowed iff another facet takes part and casts whose cone has the ray to
//      x in its inside, and whose plane meets that ray strictly nearer to the light.
// Outside of the definition (defined() is false) are a loop that crosses or touches itself as the
// light sees it, and a point light in the box of a closed object, or as near to it as `box_margin`
// of the box's coordinates: engines may ask on which side of a solid a light is.
//
// Two ways are gone independently. Regions come from light space: rays, lines and planes are
// triples, and convex parts are cut by signs (exact_region.hpp). Single points (state_at) are
// decided in space, by the signs of planes at the point.
#pragma once

#include <cstdint>
#include <optional>
#include <shadowcut/scene.hpp>
#include <shadowcut/shadows.hpp>
#include <string>
#include <vector>

#include "exact_region.hpp"

namespace shadowcut::testing {

// A point of space, n / (d 2^-unit), d > 0. The unit is the oracle's.
struct Place {
  std::array<Int, 3> n;
  Int d;
};

class GmpOracle {
 public:
  static constexpr double box_margin = 1e-12;

  enum class Role : std::uint8_t {
    absent,     // no face's, or its face was refused
    edge_on,    // (2)
    away,       // of a closed object, its front turned away (3)
    takes_part  // with the side that is turned to the light
  };
  enum class State : std::uint8_t { lit, shadowed, on_boundary };

  // The scene must outlive the oracle, and not change. The light needs neither range nor spot: they
  // are not looked at.
  GmpOracle(const Scene& scene, const Light& light);

  bool defined() const { return undefined_.empty(); }
  const std::string& why_undefined() const { return undefined_; }

  const Scene& scene() const { return scene_; }
  Role role(std::uint32_t facet) const { return seen_[facet].role; }
  bool front(std::uint32_t facet) const { return seen_[facet].front; }  // its front faces the light
  const Region& whole(std::uint32_t facet) const { return seen_[facet].whole; }
  const Region& lit(std::uint32_t facet) const;
  const std::vector<Part>& lit_parts(std::uint32_t facet) const;
  const std::vector<Part>& parts(std::uint32_t facet) const { return seen_[facet].parts; }

  // The area of a region in the facet's plane, projected along the largest component of
  // exact_normal.
  Rational area(std::uint32_t facet, const Region& region) const;
  // That component's index, and what the projected area is to be multiplied by, rounded.
  std::pair<int, double> stretch(std::uint32_t facet) const;

  // Where the ray meets the facet's plane; the ray must be one that does.
  Place place(std::uint32_t facet, const Triple& ray) const;
  // What reaches a place of the facet, which is on the inside of its cone. `by`: the facet's
  // casters there.
  State state_at(std::uint32_t facet, const Place& x,
                 std::vector<std::uint32_t>* by = nullptr) const;

  // Of any numbers: what edits have left behind may have finer digits than the scene.
  Triple ray(const Vec3& x) const;
  Triple line(const LightLine& line) const;                  // zero where it is none
  bool meets(std::uint32_t facet, const Triple& ray) const;  // in front of the light

  // Sign of x - value in one coordinate.
  int compare(const Place& x, int axis, double value) const;
  Vec3 rounded(const Place& x) const;  // toward zero

 private:
  struct Quad {  // a plane in space, n . x + d
    Triple n;
    Int d;
  };
  struct Cone {               // of a convex part, in space
    std::vector<Quad> walls;  // positive inside
  };
  struct Seen {
    Role role = Role::absent;
    bool front = false, casts_shadows = false;
    Triple u;  // the plane: nearness along a ray is u.ray / w, w > 0
    Int w;
    Quad plane;        // in space
    int at_light = 0;  // sign of `plane` at the light
    std::vector<Part> parts;
    std::vector<Cone> cones;  // by part
    Region whole;
  };
  struct Answer {
    bool known = false;
    std::vector<Part> parts;
    Region region;
  };

  void find_unit();
  Int whole_number(double x, int unit) const;
  std::array<Int, 3> position(const Vec3& x) const;    // in units
  static std::array<Int, 3> direction(const Vec3& v);  // any length
  Quad plane(const Vec3& normal, const Vec3& point) const;
  void nearness(const Quad& plane, Triple& u, Int& w) const;  // to a factor of any sign
  Quad wall(const std::array<Int, 3>& a, const std::array<Int, 3>& b) const;
  Cone cone(const std::vector<std::array<Int, 3>>& corners) const;
  void see(std::uint32_t facet);
  void check_boxes();
  std::vector<Part> shadows_on(const Seen& receiver, const Seen& caster) const;

  const Scene& scene_;
  bool point_light_;
  int unit_ = 0;              // lengths are multiples of 2^unit
  std::array<Int, 3> light_;  // position in units, or direction
  // of light space; so that det > 0 is counter-clockwise seen from the light
  std::array<int, 3> axes_{};
  int travel_sign_ = 0;     // directional: of the direction along the last axis
  std::vector<Seen> seen_;  // by facet
  mutable std::vector<Answer> answers_;
  std::string undefined_;
};

}  // namespace shadowcut::testing
