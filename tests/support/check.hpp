// What every test of shadows asks of a result. Each check returns an empty string, or says what is
// wrong; none looks inside the engine.
#pragma once

#include <cstdint>
#include <shadowcut/scene.hpp>
#include <shadowcut/shadows.hpp>
#include <string>

#include "cgal_oracle.hpp"

namespace shadowcut::testing {

// Lit areas agree to this share of a face's area.
inline constexpr double kAreaTolerance = 1e-9;

// The area that the fast kernel may leave open, by face (Engine::uncertain_area). Where it is
// given, contact within the oracle's tolerance may also be seen as what it exactly is.
using UncertainArea = std::vector<double>;

// What an engine made for the scene as it stands, with this light alone, has for it.
struct Alone {
  Shadows shadows;
  UncertainArea uncertain;
};
Alone cast_alone(const Scene& scene, const Light& light, const Options& options);

// Facing, area and lit area of every face against the oracle.
std::string check_areas(const Scene& scene, const Shadows& shadows, const CgalOracle& oracle,
                        const UncertainArea* uncertain = nullptr);
std::string check_areas(const Scene& scene, const Shadows& shadows,
                        const std::vector<CgalOracle::Area>& wanted,
                        const UncertainArea* uncertain = nullptr);

// Every face's lit area in two results of one scene. The scene's facing may not differ either.
std::string check_same_areas(const Scene& scene, const Shadows& a, const Shadows& b,
                             double tolerance = kAreaTolerance,
                             const UncertainArea* uncertain = nullptr);

// Every face's lit region in two results of one scene, whatever the fragments are: where one is lit
// and the other is not, by clipping every fragment against those of the other state. The tolerance
// is that of areas, and what rounding of the fragments' corners makes.
std::string check_same_regions(const Scene& scene, const Light& light, const Shadows& a,
                               const Shadows& b, const UncertainArea* uncertain = nullptr);

// The fragments: they name their faces, are convex and run counter-clockwise seen from the light,
// lie in their planes, add up to the faces' areas, have unique ids, name a caster that casts iff
// they are shadowed; every vertex of a facet is a corner of one of its fragments, to the bit
// (conforming: of the face's; a facet's sliver that is nothing but rounding may be gone); the
// statistics add up.
std::string check_fragments(const Scene& scene, const Light& light, const Shadows& shadows,
                            double tolerance = kAreaTolerance, Form form = Form::merged);

// Random points well inside fragments against the oracle's ray through every facet.
std::string check_points(const Scene& scene, const Shadows& shadows, const CgalOracle& oracle,
                         std::uint64_t seed, int count, bool contact_may_cast = false);
std::string check_points(const Scene& scene, const LightPartition& sets, std::size_t light,
                         const CgalOracle& oracle, std::uint64_t seed, int count);

// Engine::is_lit at random points well inside fragments, against the fragments of this light and,
// where it is given, against the oracle.
std::string check_point_queries(const Engine& engine, std::size_t light, const CgalOracle* oracle,
                                std::uint64_t seed, int count);

// Every edge of a fragment that is not on its face's outline is, to the bit and the other way
// round, an edge of another fragment: no T-junction, no crack.
std::string check_conforming(const Scene& scene, const Shadows& shadows);

// Corners of one face that are equal up to rounding are equal to the bit. For scenes in general
// position only: where three lines meet in a point by construction, it may be computed from either
// two of them.
std::string check_shared_corners(const Scene& scene, const Shadows& shadows);

// Areas of a partition by several lights: of each face, the part light k reaches.
std::vector<double> lit_areas(const Scene& scene, const LightPartition& sets, std::size_t light);

// Equal to the bit, statistics of time aside.
std::string check_identical(const Shadows& a, const Shadows& b);

double polygon_area(std::span<const Vec3> corners);

}  // namespace shadowcut::testing
