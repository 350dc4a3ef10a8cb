// Meshes for the tests of mesh import, and what is asked of the scene that they make.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <shadowcut/scene.hpp>
#include <vector>

namespace shadowcut::testing {

Mesh polygon(std::initializer_list<Vec3> points);
void add_hole(Mesh& mesh, std::initializer_list<Vec3> points);

// A scene whose second object is `mesh`, so that an issue must count objects.
Scene second(const Mesh& mesh, Sides sides = Sides::automatic);

// The mesh's face `bad` has this one issue; the other faces are kept.
void expect_issue(const Mesh& mesh, std::uint32_t bad, Reason reason);

// A good face, then `points` in the same vertices, then a good face.
Mesh between_good(const std::vector<Vec3>& points);

// The face's facets are convex, and together the face.
void expect_facets_tile(const Scene& scene, std::uint32_t face_index, double area);

}  // namespace shadowcut::testing
