// What Kernel::exact promises of one light's shadows, held against the exact oracle. Nothing here
// has a tolerance but the one ulp of a corner's coordinates, which is the promise itself.
#pragma once

#include <shadowcut/shadows.hpp>
#include <string>

#include "gmp_oracle.hpp"

namespace shadowcut::testing {

// The shadows were made with Options::constructions. oracle.defined() holds. Returns an empty
// string, or says what is wrong:
//   1. fragments name what they are of, and only facets that take part have lit ones or ones with a
//     caster;
//   2. every fragment, as its constructions have it, is convex, runs counter-clockwise as the light
//     sees it and has an area;
//   3. the fragments of a facet cover its region once, and the lit fragments cover the oracle's lit
//      region once: the same points, and so the same areas, as fractions;
//   4. every corner is within one ulp of the exact corner in every coordinate; a corner on the ray
//      of a vertex of its own facet, however it was made, is that vertex, to the bit;
//   5. in the middle of every fragment, found in space and not in light space, light arrives or not
//     as the fragment says, and its caster is
//      (Form::pieces), or shares its object with (other forms), a face that casts there;
//   6. every face is said to face the light iff it does.
std::string check_exact(const GmpOracle& oracle, const Shadows& shadows, Form form);

// The ray of a fragment's corner as its construction has it; nothing where it has none on that
// facet. The lines `in` and `out` may be any two that cross there: where a corner lies straight on
// an edge they cannot both be the fragment's own.
std::optional<Triple> ray_of(const GmpOracle& oracle, std::uint32_t facet,
                             const Construction& construction);

// A ray of the inside of a convex ring; each attempt gives another one.
Triple middle_of(std::span<const Triple> rays, unsigned attempt);

// Whether value is within one ulp of the place's coordinate.
bool within_one_ulp(const GmpOracle& oracle, const Place& x, int axis, double value);

}  // namespace shadowcut::testing
