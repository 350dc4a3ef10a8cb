// Faces of one object that were meant to lie in one plane, and do so but for rounding: they get
// that plane.
#pragma once

#include <shadowcut/scene.hpp>
#include <span>
#include <vector>

#include "support/assert.hpp"

namespace shadowcut {

// Facets, and where their corners are.
struct Figure {
  std::span<const Facet> facets;
  std::span<const Corner> corners;  // by Facet::first_corner
  std::span<const Vec3> positions;  // by Corner::vertex, less first_vertex
  std::uint32_t first_vertex = 0;

  const Vec3& at(const Facet& f, std::uint32_t i) const {
    SHADOWCUT_ASSERT(f.first_corner + f.corner_count <= corners.size());
    return positions[corners[f.first_corner + i % f.corner_count].vertex - first_vertex];
  }
};

// Consecutive facets of a figure in one plane: a flat face, or one facet of a face that is not
// flat.
struct Patch {
  std::uint32_t first_facet, end_facet;
};

// Whose plane a patch has: that of its group's leader, itself when it shares its plane with nobody.
struct Membership {
  std::uint32_t leader;
  bool opposite;  // its front is where the leader's back is
};

// Which patches share a plane. The largest leads, and takes with it those whose corners all lie
// within `tolerance` (a share of the figure's largest coordinate) of its own plane; then the
// largest of what is left leads, and so on: no group reaches farther than its leader's plane. Nor
// does a small patch follow that its corners would turn by more than `most_turn` (radians, about).
// Cost: about n log n; n^1.5 for the patches of one wall if they miss each other's planes by a few
// times the tolerance.
std::vector<Membership> find_groups(const Figure& figure, std::span<const Patch> patches,
                                    double tolerance, double most_turn);

// The patches' planes when every group has one, up to its sign, that of `own[leader]` or one
// through corners far apart. Flatness is the group's, tilt the patch's.
std::vector<Plane> common_planes(const Figure& figure, std::span<const Patch> patches,
                                 std::span<const Plane> own, std::span<const Membership> members);

// Whether two planes are the same set of points, exactly.
bool same_plane(const Plane& p, const Plane& q);
// The largest distance of a patch's corners from a plane.
double distance_from(const Plane& plane, const Figure& figure, const Patch& patch);

}  // namespace shadowcut
