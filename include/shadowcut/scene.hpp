// Scene: objects made of flat faces, and lights. What enters here is checked once, at the door, and
// everything behind the door may rely on it.
//
// Units and frame: one right-handed world frame in the user's length unit (a "scene unit"); areas
// are scene units squared. Angles are radians. All coordinates are double from here to the
// fragments.
//
// Errors: a face that cannot be used is refused, never silently: it is listed in Scene::issues()
// and every other face of its object is kept. Misuse of the interface throws shadowcut::Error. An
// id that no longer names anything, or names something in another scene, is answered by a value
// (Edit), because it happens in the best of programs. Thread safety: a const Scene may be read from
// any number of threads; changing it needs exclusion.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
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
//   closed: the faces bound a solid, counter-clockwise seen from outside; only outer sides receive
//     light.
//   open:   sheets; every face has two sides, and the one turned to the light receives it.
//   automatic: closed if every edge of every connected part of the mesh is shared by exactly two
//     faces
//              that run along it in opposite directions, and every part encloses a positive volume;
//              open otherwise (so an inside-out shell, such as a room seen from within, is open).
enum class Sides : std::uint8_t { automatic, closed, open };

// The faces of one object as they stand in a file. A face is one outer loop of corner indices
// followed by any number of hole loops; loops may be convex or concave and do not repeat their
// first corner. The face's front is the side from which its outer loop runs counter-clockwise;
// holes may run either way.
class Mesh {
 public:
  std::vector<Vec3> vertices;  // local frame

  void add_face(std::span<const std::uint32_t> outer);
  void add_face(std::initializer_list<std::uint32_t> outer) {
    add_face(std::span(outer.begin(), outer.size()));
  }
  void add_hole(std::span<const std::uint32_t> loop);  // to the face added last

  std::size_t face_count() const { return face_ends_.size(); }
  std::size_t loop_count(std::size_t face) const;
  std::span<const std::uint32_t> loop(std::size_t face, std::size_t k) const;

 private:
  std::vector<std::uint32_t> corners_;
  std::vector<std::size_t> loop_ends_;  // into corners_
  std::vector<std::size_t> face_ends_;  // into loop_ends_
};

// Names an object of one scene. The index is its place in Scene::objects(), and is used again after
// the object is removed; the generation tells the two apart. A copy of a scene knows the ids of the
// original.
struct ObjectId {
  std::uint32_t index = 0xFFFFFFFFu, generation = 0, scene = 0;
  friend bool operator==(const ObjectId&, const ObjectId&) = default;
};
struct LightId {  // likewise, of Scene::lights()
  std::uint32_t index = 0xFFFFFFFFu, generation = 0, scene = 0;
  friend bool operator==(const LightId&, const LightId&) = default;
};

// What became of an edit.
enum class Edit : std::uint8_t {
  done,
  stale,    // nothing was done: what the id named has been removed
  foreign,  // nothing was done: the id is of another scene, or of none
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
  // refused: the outline crosses itself, or a hole leaves it; touching is allowed, outlines joined
  // to their holes by bridges are usual
  self_intersecting,
  // refused: the same corners in the same order as an earlier face of the object
  duplicate,
  repeated_corner,  // repaired: consecutive equal corners became one
  // repaired: a corner lies off the plane by more than Scene::flatness_tolerance; triangulated
  not_flat,
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
  // point: where it is; directional: the direction in which light travels, any length but zero
  Vec3 at = Vec3::Zero();
  std::string name;
  // Point lights only. A face that is nowhere within the range, or wholly outside the spot's cone,
  // is left out of all work and reported as out_of_reach; a face that is partly inside is treated
  // whole.
  double range = std::numeric_limits<double>::infinity();
  std::optional<Spot> spot;

  static Light point(Vec3 at) {
    return {Kind::point, at, {}, std::numeric_limits<double>::infinity(), {}};
  }
  static Light directional(Vec3 travel) {
    return {Kind::directional, travel, {}, std::numeric_limits<double>::infinity(), {}};
  }
};

// Throws Error, with `who` for the light, when a coordinate is not finite, a direction is zero, the
// range is not positive or the spot is out of bounds.
void check(const Light& light, const std::string& who);

// Everything below is the scene flattened, in world coordinates, for the engine and for oracles. A
// *face* is what the user gave; a *facet* is one of the convex parts it was cut into (most faces
// are one facet).

inline constexpr std::uint32_t none = 0xFFFFFFFFu;
inline constexpr double default_coplanarity = 1e-12;  // see Scene::coplanarity_tolerance

struct Plane {
  Vec3 normal;  // unit length, to the front
  Vec3 point;   // a point of the plane
  // The normal before it was brought to length one, for the exact kernel: where the corners'
  // differences are short numbers it has no error, and then neither has the plane, {x: exact_normal
  // . (x - point) = 0}.
  Vec3 exact_normal;
  // the largest distance of the corners from the plane, of all faces that share it
  double flatness;
  // how far, in radians, corners moved by that (or by rounding) could turn the plane; a light
  // nearer to the plane than this sees it edge-on
  double tilt;
};

// an undirected edge of the mesh; its line of light is shared by the facets on both sides
struct Edge {
  std::uint32_t a, b;  // vertex indices, a < b
};

struct Facet {
  std::uint32_t face;          // index into Scene::faces()
  std::uint32_t plane;         // index into Scene::planes(); facets of one object may share it
  std::uint32_t first_corner;  // index into Scene::corners()
  // at least 3; convex, counter-clockwise seen from the front; straight corners are kept
  std::uint32_t corner_count;
};

struct Corner {
  std::uint32_t vertex;  // index into Scene::vertices()
  // (index into Scene::edges() << 1) | 1 when it runs from Edge::b to Edge::a; from this corner to
  // the next
  std::uint32_t edge;
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
  Pose pose = Pose::Identity();
  std::uint32_t first_facet = 0, facet_count = 0, first_edge = 0, edge_count = 0;
  bool alive = true;  // false: removed; its counts are 0, and its index waits for the next object
  // Facets that, when the object was added or deformed, were put into a plane that was not to the
  // last digit that of their own corners (see Scene::coplanarity_tolerance); and the largest
  // distance of such a corner from it.
  std::uint32_t aligned = 0;
  double aligned_by = 0;
};

// Removing an object leaves holes in the arrays below, and later objects may fill them: a face
// there that is no object's has `object` none and no facets, a facet that is no face's has no
// corners. Nothing else ever moves: an object's indices stay as long as it lives, unless its mesh
// changes so that it needs more room.
class Scene {
 public:
  Scene();
  Scene(const Scene&) = default;  // knows the ids of the original
  Scene& operator=(const Scene&) = default;
  Scene(Scene&&) = default;
  Scene& operator=(Scene&&) = default;

  // The largest distance of a corner from its face's plane, as a share of the face's diameter, at
  // which the face still counts as flat. Set before objects are added.
  double flatness_tolerance = 1e-6;
  // Faces of one object, or facets of one that is not flat, whose corners lie within this of the
  // plane of a larger one get that plane, on either side of it: they touch, and do not cross each
  // other in slivers. A share of the object's largest coordinate, as its mesh gives it: what some
  // thousand roundings of coordinates come to. Where that would turn a face by more than the square
  // root of this (radians, about), so that its area changes by more than this share, the face keeps
  // its own plane. No motion of the object changes what shares a plane. 0: every face has its own
  // plane. Set before objects are added; Object::aligned says what came of it.
  double coplanarity_tolerance = default_coplanarity;

  // Adds an object: welds equal positions, checks every face, cuts concave faces into convex
  // facets, decides its sides. Cost: O(corners log corners), quadratic only in the corners of a
  // single concave outline. Throws Error when the pose is not finite and invertible, or when the
  // scene exceeds 2^29 edges.
  ObjectId add(const Mesh& mesh, const ObjectSettings& settings);
  [[nodiscard]] Edit remove(ObjectId id);
  // Moves an object. Cost: in proportion to its corners; a pose that is not the old one moved
  // rigidly, or an object with concave faces, goes through all of add()'s checks again. Throws
  // Error, and changes nothing, when the pose is not finite and invertible.
  [[nodiscard]] Edit set_pose(ObjectId id, const Pose& pose);
  // Deforms an object: its mesh's vertices, in the local frame. Throws Error, and changes nothing,
  // when it has another number of them. What was decided automatically (closed or open, flat or
  // not) is decided again.
  [[nodiscard]] Edit set_vertices(ObjectId id, std::span<const Vec3> local);
  [[nodiscard]] Edit set_casts(ObjectId id, bool casts);
  [[nodiscard]] Edit set_receives(ObjectId id, bool receives);

  // Throws Error as check() does, and then changes nothing.
  LightId add(const Light& light);
  [[nodiscard]] Edit remove(LightId id);
  [[nodiscard]] Edit set_light(LightId id, const Light& light);
  // Removes all lights and adds these, at indices 0, 1, ... Throws Error as check() does, and then
  // changes nothing.
  void replace_lights(std::span<const Light> lights);

  // Done: the id names something here. Otherwise, why it does not.
  Edit locate(ObjectId id) const;
  Edit locate(LightId id) const;
  // Null when the id does not name anything here. The pointer lives until the scene changes.
  const Object* find(ObjectId id) const;
  const Light* find(LightId id) const;
  // What add() takes to make the object again, as it stands: its mesh, with the vertices set last,
  // and its settings. Nothing when the id does not name anything here. Cost: a copy of the mesh.
  std::optional<std::pair<Mesh, ObjectSettings>> given(ObjectId id) const;
  // The id of what stands at an index; one that names nothing when the index is free.
  ObjectId object_id(std::size_t index) const;
  LightId light_id(std::size_t index) const;

  std::span<const Object> objects() const { return objects_; }
  std::span<const Light> lights() const { return lights_; }
  std::span<const Face> faces() const { return faces_; }
  std::span<const Facet> facets() const { return facets_; }
  std::span<const Corner> corners() const { return corners_; }
  std::span<const Vec3> vertices() const { return vertices_; }
  std::span<const Edge> edges() const { return edges_; }
  std::span<const Plane> planes() const { return planes_; }
  std::span<const Issue> issues() const { return issues_; }

  std::span<const Corner> corners_of(const Facet& f) const {
    return std::span(corners_).subspan(f.first_corner, f.corner_count);
  }

  // For engines, which follow a scene: how often it has been changed; and the objects changed after
  // a given revision, the one changed longest ago first. Cost: in proportion to those.
  std::uint64_t revision() const { return revision_; }
  std::vector<std::uint32_t> changed_since(std::uint64_t revision) const;
  std::uint64_t object_revision(std::size_t index) const { return slots_[index].revision; }
  std::uint64_t light_revision(std::size_t index) const { return light_slots_[index].revision; }
  // For engines: makes these objects what they are in the other scene, at the same indices
  // everywhere. Between them they must hold all the room that they take up there (room_taken_by).
  void copy_objects(const Scene& from, std::span<const std::uint32_t> indices);
  void copy_light(const Scene& from, std::uint32_t index);
  // The object of this scene that lives in the room in which the object lives in the other scene;
  // none if that is free here.
  std::uint32_t room_taken_by(const Scene& other, std::uint32_t index) const;

 private:
  struct Source;  // an object as it was given
  struct Room {   // a stretch of every array, given to one object at a time
    std::uint32_t first[6], count[6];
    std::uint32_t owner;  // index of an object, or none
  };
  struct Slot {  // what is private of an object
    std::uint32_t generation = 0;
    std::uint32_t room = none;
    std::uint64_t revision = 0;
    std::uint32_t older = none, newer = none;  // the objects in the order of their last change
    std::shared_ptr<const Source> source;
  };
  struct LightSlot {
    std::uint32_t generation = 0;
    bool alive = false;
    std::uint64_t revision = 0;
  };

  template <class Id, class Slots, class Alive>
  Edit locate(Id id, const Slots& slots, const Alive& alive) const;
  void admit(std::uint32_t index, std::shared_ptr<const Source> source,
             const ObjectSettings& settings);
  void take_room(std::uint32_t index, const std::uint32_t (&counts)[6]);
  void clear_room(std::uint32_t index);
  void reserve_room(const std::uint32_t (&counts)[6]);
  void grow_to(const Room& room);
  void touch(std::uint32_t index);
  void make_newest(std::uint32_t index);
  void set_settings(std::uint32_t index, bool casts, bool receives);

  std::uint32_t tag_;  // of this scene and its copies
  std::uint64_t revision_ = 0;
  std::uint32_t newest_ = none;  // the object changed last
  std::vector<Object> objects_;
  std::vector<Light> lights_;
  std::vector<Face> faces_;
  std::vector<Facet> facets_;
  std::vector<Corner> corners_;
  std::vector<Vec3> vertices_;
  std::vector<Edge> edges_;
  std::vector<Plane> planes_;
  std::vector<Issue> issues_;
  std::vector<Slot> slots_;  // by object
  std::vector<LightSlot> light_slots_;
  std::vector<std::uint32_t> free_objects_, free_lights_;
  std::vector<Room> rooms_;
  std::multimap<std::uint32_t, std::uint32_t> free_rooms_;  // by their number of corners
};

}  // namespace shadowcut
