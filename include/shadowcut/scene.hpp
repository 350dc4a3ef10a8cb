// Scene: objects made of flat faces, and lights. What enters here is checked once, at the door,
// and everything behind the door may rely on it.
//
// Units and frame: one right-handed world frame in the user's length unit (a "scene unit"); areas are
// scene units squared. Angles are radians. All coordinates are double from here to the fragments.
//
// Errors: a face that cannot be used is refused, never silently: it is listed in Scene::issues()
// and every other face of its object is kept. Misuse of the interface throws shadowcut::Error.
// Thread safety: a const Scene may be read from any number of threads; changing it needs exclusion.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace shadowcut {

using Vec3 = Eigen::Vector3d;
using Pose = Eigen::Affine3d;  // local to world; rigid or affine, finite and invertible

// The one exception the library throws on bad input; what() is one line fit for a user.
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Which sides of an object's faces count.
//   closed: the faces bound a solid, counter-clockwise seen from outside; only outer sides receive light.
//   open:   sheets; every face has two sides, and the one turned to the light receives it.
//   automatic: closed if every edge of every connected part of the mesh is shared by exactly two faces
//              that run along it in opposite directions, and every part encloses a positive volume;
//              open otherwise (so an inside-out shell, such as a room seen from within, is open).
enum class Sides : std::uint8_t { automatic, closed, open };

// The faces of one object as they stand in a file. A face is one outer loop of corner indices followed by any
// number of hole loops; loops may be convex or concave and do not repeat their first corner. The face's
// front is the side from which its outer loop runs counter-clockwise; holes may run either way.
class Mesh {
 public:
  std::vector<Vec3> vertices;  // local frame

  void add_face(std::span<const std::uint32_t> outer);
  void add_face(std::initializer_list<std::uint32_t> outer) { add_face(std::span(outer.begin(), outer.size())); }
  void add_hole(std::span<const std::uint32_t> loop);  // to the face added last

  std::size_t face_count() const { return face_ends_.size(); }
  std::size_t loop_count(std::size_t face) const;
  std::span<const std::uint32_t> loop(std::size_t face, std::size_t k) const;

 private:
  std::vector<std::uint32_t> corners_;
  std::vector<std::size_t> loop_ends_;  // into corners_
  std::vector<std::size_t> face_ends_;  // into loop_ends_
};

struct ObjectSettings {
  std::string name;
  Pose pose = Pose::Identity();
  Sides sides = Sides::automatic;
  bool casts = true;     // its faces stand between light and others
  bool receives = true;  // its faces are cut and handed out
  bool moves = false;    // expected to move: kept at the leaves of the tree, whatever its size
};

// Why a face was refused or repaired.
enum class Reason : std::uint8_t {
  non_finite,          // refused: a coordinate is NaN or infinite
  index_out_of_range,  // refused
  too_few_corners,     // refused: fewer than three distinct corners
  zero_area,           // refused
  self_intersecting,   // refused: the outline crosses itself, or a hole leaves it; touching is allowed, outlines joined to their holes by
                       // bridges are usual
  duplicate,           // refused: the same corners in the same order as an earlier face of the object
  repeated_corner,     // repaired: consecutive equal corners became one
  not_flat,            // repaired: a corner lies off the plane by more than Scene::flatness_tolerance; triangulated
};
const char* describe(Reason);  // a short English phrase
bool refuses(Reason);          // false: repaired

struct Issue {
  std::uint32_t object;  // index into Scene::objects()
  std::uint32_t face;    // number within the object, from 0, as in the file
  Reason reason;
  std::string detail;  // may be empty; otherwise figures, for a user
};

struct Light {
  enum class Kind : std::uint8_t { point, directional };
  struct Spot {
    Vec3 axis;          // direction in which the cone opens; any length but zero
    double half_angle;  // radians, in (0, pi]
  };

  Kind kind = Kind::point;
  Vec3 at = Vec3::Zero();  // point: where it is; directional: the direction in which light travels, any length but zero
  std::string name;
  // Point lights only. A face that is nowhere within the range, or wholly outside the spot's cone, is left out of all work and reported
  // as out_of_reach; a face that is partly inside is treated whole.
  double range = std::numeric_limits<double>::infinity();
  std::optional<Spot> spot;

  static Light point(Vec3 at) { return {Kind::point, at, {}, std::numeric_limits<double>::infinity(), {}}; }
  static Light directional(Vec3 travel) { return {Kind::directional, travel, {}, std::numeric_limits<double>::infinity(), {}}; }
};

// Throws Error, with `who` for the light, when a coordinate is not finite, a direction is zero, the range is not positive or the spot is
// out of bounds.
void check(const Light& light, const std::string& who);

// Everything below is the scene flattened, in world coordinates, for the engine and for oracles.
// A *face* is what the user gave; a *facet* is one of the convex parts it was cut into (most faces are one facet).

inline constexpr std::uint32_t none = 0xFFFFFFFFu;

struct Plane {
  Vec3 normal;      // unit length, to the front
  Vec3 point;       // a point of the plane
  double flatness;  // the largest distance of the corners from the plane
  double tilt;  // how far, in radians, corners moved by that (or by rounding) could turn the plane; a light nearer to the plane than this
                // sees it edge-on
};

struct Edge {          // an undirected edge of the mesh; its line of light is shared by the facets on both sides
  std::uint32_t a, b;  // vertex indices, a < b
};

struct Facet {
  std::uint32_t face;          // index into Scene::faces()
  std::uint32_t plane;         // index into Scene::planes()
  std::uint32_t first_corner;  // index into Scene::corners()
  std::uint32_t corner_count;  // at least 3; convex, counter-clockwise seen from the front; straight corners are kept
};

struct Corner {
  std::uint32_t vertex;  // index into Scene::vertices()
  std::uint32_t edge;    // (index into Scene::edges() << 1) | 1 when it runs from Edge::b to Edge::a; from this corner to the next
};

struct Face {
  std::uint32_t object;
  std::uint32_t number;       // within its object, from 0, as in the file
  std::uint32_t first_facet;  // facets of a face are consecutive
  std::uint32_t facet_count;  // 0: refused
  double area;                // of the facets, in their planes; 0 when refused
};

struct Object {
  std::string name;
  Sides sides;  // as decided: closed or open
  bool casts, receives, moves;
  std::uint32_t first_face, face_count;
  std::uint32_t first_vertex, vertex_count;  // distinct positions of this object
  double signed_volume;                      // positive for a solid with its faces outward
};

class Scene {
 public:
  // The largest distance of a corner from its face's plane, as a share of the face's diameter, at which the face still counts as flat.
  // Set before objects are added.
  double flatness_tolerance = 1e-6;

  // Adds an object: welds equal positions, checks every face, cuts concave faces into convex facets, decides its sides.
  // Returns its index. Cost: O(corners log corners), quadratic only in the corners of a single concave outline.
  // Throws Error when the pose is not finite and invertible, or when the scene exceeds 2^29 edges.
  std::uint32_t add(const Mesh& mesh, const ObjectSettings& settings);
  // Throws Error as check() does.
  std::uint32_t add(const Light& light);

  std::span<const Object> objects() const { return objects_; }
  std::span<const Light> lights() const { return lights_; }
  std::span<const Face> faces() const { return faces_; }
  std::span<const Facet> facets() const { return facets_; }
  std::span<const Corner> corners() const { return corners_; }
  std::span<const Vec3> vertices() const { return vertices_; }
  std::span<const Edge> edges() const { return edges_; }
  std::span<const Plane> planes() const { return planes_; }
  std::span<const Issue> issues() const { return issues_; }

  std::span<const Corner> corners_of(const Facet& f) const { return std::span(corners_).subspan(f.first_corner, f.corner_count); }

 private:
  std::vector<Object> objects_;
  std::vector<Light> lights_;
  std::vector<Face> faces_;
  std::vector<Facet> facets_;
  std::vector<Corner> corners_;
  std::vector<Vec3> vertices_;
  std::vector<Edge> edges_;
  std::vector<Plane> planes_;
  std::vector<Issue> issues_;
};

}  // namespace shadowcut
