// The independent answer: the exact lit area of a face, and whether a point of it is lit, found
// without light space, trees, or anything of src/. Each face is held against every facet of the
// scene, in CGAL's exact arithmetic.
//
// What is common to engine and oracle is the definition alone (shadows.hpp): x on a face is
// shadowed iff the face is turned away, or some other casting facet has a point strictly between x
// and the light; a facet is its plane (Scene::planes(), its doubles taken as exact) cut by the cone
// of its corners. What differs on purpose: here *all* facets of casting objects cast, also the
// sides of closed solids that are turned away, which the engine leaves out. So a light inside a
// closed solid needs no rule of its own.
//
// Contact. Planes are given by rounded normals, so two tiles that lie in one plane by intention are
// some ulps apart over their whole area, and "strictly between" decided exactly would shadow one of
// them. A part of a caster whose corners all lie within `contact_tolerance` (a share of the largest
// coordinate at hand, 1e-12) of the receiver's plane counts as touching it. A caster that leaves
// the plane at an angle is not affected: only slivers are lost, below 1e-12. Area::least_lit and
// in_contact() say what it would be if what is that near, and not exactly in the plane, cast after
// all: an engine that sees the gap is not wrong.
//
// Facets of one face that lie in one plane do not shadow each other; those of a face that was not
// flat lie in several planes, and do.
#pragma once

#include <memory>
#include <shadowcut/scene.hpp>
#include <shadowcut/shadows.hpp>
#include <vector>

namespace shadowcut::testing {

class CgalOracle {
 public:
  static constexpr double contact_tolerance = 1e-12;

  // The scene must outlive the oracle. With `only_facing`, sides of closed solids turned away do
  // not cast: needed for lights with a range or a cone only, where a solid's front may be out of
  // reach while its back is not.
  CgalOracle(const Scene& scene, const Light& light, bool only_facing = false);
  ~CgalOracle();

  struct Area {
    Facing facing = Facing::refused;
    double area = 0, lit = 0, least_lit = 0;
    // The light is within 1e-9 of the plane, or within what its corners could turn it by
    // (Plane::tilt), or the reach within 1e-9 of the limit: facing may be decided either way.
    bool unsure = false;
  };
  Area area(std::uint32_t face) const;
  std::vector<Area> areas() const;  // of all faces

  // Whether x, a point of `facet` up to rounding, is reached by the light.
  bool lit(std::uint32_t facet, const Vec3& x) const;
  bool unsure(std::uint32_t facet) const;  // see Area::unsure
  // Whether something between x and the light counts as touching the facet, and is not exactly in
  // its plane.
  bool in_contact(std::uint32_t facet, const Vec3& x) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace shadowcut::testing
