// Generated scenes for tests and benchmarks. They are the same bits on every machine, because the
// code does not use the distributions of the standard library or the last bit of its sines. z is
// up; lengths are roughly metres.
//
// The scenes are degenerate on purpose: desks stand on floors and against walls, legs are flush
// with desk tops, facades are coplanar, posters lie in their walls. The rooms follow Chrysanthou &
// Slater 1995 (I3D), section 6: "a room, which contained bookcases with two books, and desks with
// computers on top", with 133, 211, 313 and 745 polygons.
#pragma once

#include <cstdint>
#include <shadowcut/scene.hpp>
#include <string>
#include <utility>
#include <vector>

namespace shadowcut::scenes {

struct SceneData {
  std::string name;
  std::vector<std::pair<Mesh, ObjectSettings>> objects;
  Light light;
};

// The scene with every object added and its light.
Scene build(const SceneData& data);

// All polygons of all objects.
std::size_t polygon_count(const SceneData& data);

// Splitmix64 (Steele, Lea, Flood 2014). Not for cryptography.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();
  std::uint64_t below(std::uint64_t n) { return next() % n; }
  double unit();                       // [0, 1), a multiple of 2^-53
  double in(double lo, double hi);     // rounded to a multiple of 2^-20
  Vec3 in_cube(double lo, double hi);  // each coordinate as above
  Vec3 in_ball(double radius);         // each coordinate a multiple of 2^-20

 private:
  std::uint64_t state_;
};

double to_grid(double x);  // rounded to a multiple of 2^-20

// Meshes.
Mesh box(const Vec3& lo, const Vec3& hi);  // six quads, outward
// base counter-clockwise seen from outside, below
Mesh prism(const std::vector<Vec3>& base, const Vec3& along);
Mesh rectangle(const Vec3& corner, const Vec3& u, const Vec3& v);  // front along u x v
// 2*segments*(rings-1) triangles
Mesh uv_sphere(const Vec3& centre, double radius, std::uint32_t segments, std::uint32_t rings);
// adds the faces of `other` as a further part
void append(Mesh& mesh, const Mesh& other);

// A room of the paper: level 1 to 4 gives 133, 211, 313, 745 polygons. One wall has a doorway, a
// concave outline. The light hangs in the room.
SceneData room(int level);
// Slater 1992, table 1: ten rooms with 138 to 318 polygons, from one bookcase and one desk with a
// computer to three of each. The numbers are his; what the polygons are is known only roughly (a
// room, a desk, a computer, a bookcase: 36 and 54 for each further one).
SceneData slater_room(int number);
// His second light: outside, shining through the doorway.
Light light_at_the_door();
// A room with chairs, a window (a wall with a hole) and 344 faces toward the light.
SceneData furnished_room();
// A tetrahedron replaced by four of half its size at its corners, `depth` times, over a ground
// face: 4^depth*4 + 1 polygons.
SceneData tetrahedron(int depth);
// n*n boxes of six faces on a ground face. The light stands above the streets, outside every box;
// 100 gives 29 989 facing faces.
SceneData city(std::uint32_t n);
// Spheres of 2*segments*(rings-1) triangles each above a ground face. (100, 64, 33) gives about 200
// 000 faces toward the light.
SceneData spheres(std::uint32_t count, std::uint32_t segments, std::uint32_t rings);
// n triangles in a unit cube, each an open object, some of them crossing, above a ground face.
SceneData triangles(std::uint32_t n);
// A twig: hexagonal prisms that grow out of one another (their faces cross), with folded two-sided
// leaves.
SceneData branch(int levels);

// The scenes of Batagelo & Costa 1999, figures 4 to 8, with their numbers of polygons: 256, 96,
// 752, 752 and 1502, the ground among them. What the polygons are is not printed: here a sphere,
// nine solids, a recursive tetrahedron a third of whose parts are divided once more (its ground
// below it, or above all but its top: which is all that is said of their two scenes), and five by
// five by five cubes.
SceneData sphere256();
SceneData solids96();
SceneData tetrahedra752(int number);  // 1, 2
SceneData cubes1502();
// Kolic et al. 2004, figure 5: a branch of 2 878 triangles, open prisms of wood and folded leaves,
// and a ground face.
SceneData branch2878();
// Oh & Shin 2005, section 4: spheres of 2 037 vertices each (4 070 triangles) above a ground face.
SceneData spheres2037(std::uint32_t count);
// The scenes above of those three papers, by name.
const std::vector<std::string>& image_space_scenes();

// One of the above by its name: room:4, slater:10, furnished_room, tetrahedron:3, city:100,
// spheres:25 (or spheres:5,12,8), triangles:1000, branch:3, sphere256, solids96, tetrahedra752:1,
// cubes1502, branch2878, spheres2037:100. Throws Error when there is none.
SceneData named(const std::string& name);

}  // namespace shadowcut::scenes
