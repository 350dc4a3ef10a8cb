/// @file
/// Scene: objects made of flat faces, and lights. All input is checked once, when it enters the
/// scene; everything that reads a scene relies on these checks.
///
/// Units and frame: one right-handed world frame in the user's unit of length (a "scene unit").
/// Areas are in square scene units, angles in radians. All coordinates are double.
///
/// Errors. The library reports problems through four channels:
///
/// | channel                 | used for                            | example                      |
/// |-------------------------|-------------------------------------|------------------------------|
/// | exception Error         | misuse and unusable input           | a pose that is not finite    |
/// | Status (returned)       | ids that may be out of date         | editing a removed object     |
/// | Issue (Scene::issues()) | faces that were refused or repaired | a face without area          |
/// | empty optional, null    | lookups that find nothing           | Scene::find, Engine::find    |
///
/// Besides these, std::bad_alloc when memory runs out; an edit of a scene then has no effect.
///
/// Thread safety: any number of threads may read a const Scene; changing it needs exclusive access.
///
/// Xlib defines the word Status as a macro: include this header before <X11/Xlib.h>.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <initializer_list>
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
/// From an object's local frame to the world frame; rigid or affine, finite and invertible.
using Pose = Eigen::Affine3d;

/// The exception for misuse and for input that cannot be used. what() is one line for a user.
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// In place of an index: no element.
inline constexpr std::uint32_t invalid_index = 0xFFFFFFFFu;

/// Which sides of an object's faces receive light.
enum class Sides : std::uint8_t {
  /// closed, if every edge of every connected part of the mesh is shared by exactly two faces that
  /// run along the edge in opposite directions, and every part encloses a positive volume; open
  /// otherwise. So an inside-out shell, such as a room seen from within, is open.
  automatic,
  /// The faces bound a solid, counter-clockwise seen from outside; only outer sides receive light.
  closed,
  /// Sheets: a face has two sides, and the side that is turned to the light receives it.
  open,
};

/// The faces of one object, as in a file. A face is one outer loop of vertex indices followed by
/// any number of hole loops. Loops may be convex or concave and do not repeat their first corner.
/// The front of a face is the side from which its outer loop runs counter-clockwise; holes may run
/// either way. A mesh may hold faces that are not usable: Scene::add() checks them.
class Mesh {
 public:
  std::vector<Vec3> vertices;  ///< in the local frame

  Mesh() = default;
  /// Vertices and triangles: three vertex indices for each. Throws Error when the number of indices
  /// is not a multiple of three.
  Mesh(std::span<const Vec3> vertices, std::span<const std::uint32_t> triangles);

  /// Appends a face without holes.
  void add_face(std::span<const std::uint32_t> outer);
  void add_face(std::initializer_list<std::uint32_t> outer) {
    add_face(std::span(outer.begin(), outer.size()));
  }
  /// Appends many faces without holes: the corners of all faces one after another, and the number
  /// of corners of each. Throws Error, and changes nothing, when the counts do not add up to the
  /// number of corners.
  void add_faces(std::span<const std::uint32_t> corners, std::span<const std::uint32_t> counts);
  /// Adds a hole to the last face. Throws Error when there is no face.
  void add_hole(std::span<const std::uint32_t> loop);

  std::size_t face_count() const { return face_ends_.size(); }
  /// The number of loops of a face: 1 and the number of its holes.
  std::size_t loop_count(std::size_t face) const;
  /// The vertex indices of a loop; loop 0 is the outer one. Valid until the mesh changes.
  std::span<const std::uint32_t> loop(std::size_t face, std::size_t k) const;

 private:
  std::vector<std::uint32_t> corners_;
  std::vector<std::size_t> loop_ends_;  // into corners_
  std::vector<std::size_t> face_ends_;  // into loop_ends_
};

/// Identifies an object of one scene. `index` is its index into Scene::objects(), which is used
/// again after the object has been removed; the generation distinguishes the two objects. The ids
/// of a scene are valid in its copies.
struct ObjectId {
  std::uint32_t index = invalid_index, generation = 0, scene = 0;
  friend bool operator==(const ObjectId&, const ObjectId&) = default;
};
/// Identifies a light of one scene, in the same way.
struct LightId {
  std::uint32_t index = invalid_index, generation = 0, scene = 0;
  friend bool operator==(const LightId&, const LightId&) = default;
};

/// The result of an edit, or the state of an id.
enum class Status : std::uint8_t {
  ok,       ///< the edit was made; the id is valid
  stale,    ///< nothing was done: the object or light has been removed
  foreign,  ///< nothing was done: the id belongs to another scene, or to no scene
};

/// The properties with which an object is added to a scene.
struct ObjectSettings {
  std::string name;
  Pose pose = Pose::Identity();
  Sides sides = Sides::automatic;
  bool casts_shadows = true;     ///< its faces shadow other faces
  bool receives_shadows = true;  ///< its faces are cut into fragments
  /// Expected to move: inserted into the trees after all other objects, whatever its size.
  bool dynamic = false;
};

/// Why a face was refused or repaired.
enum class Reason : std::uint8_t {
  non_finite,          ///< refused: a coordinate is NaN or infinite
  index_out_of_range,  ///< refused: there is no such vertex
  too_few_corners,     ///< refused: fewer than three distinct corners
  zero_area,           ///< refused
  /// Refused: the outline crosses itself, or a hole leaves it. Outlines that touch themselves are
  /// allowed; they are usual where bridges join an outline to its holes.
  self_intersecting,
  /// Refused: the same corners in the same order as an earlier face of the object.
  duplicate,
  repeated_corner,  ///< repaired: consecutive equal corners were replaced by one
  /// Repaired: a corner is farther from the plane than Scene::flatness_tolerance; triangulated.
  not_flat,
};
/// A short English phrase. Never null.
const char* reason_text(Reason);
/// Whether the face was refused; otherwise it was repaired.
bool is_refusal(Reason);

/// A face that was refused or repaired when its object entered the scene.
struct Issue {
  std::uint32_t object;  ///< index into Scene::objects()
  std::uint32_t face;    ///< number within the object, from 0, as in the mesh
  Reason reason;
  std::string detail;  ///< numbers for a user, or empty

  const char* text() const { return reason_text(reason); }
  bool is_refusal() const { return shadowcut::is_refusal(reason); }
};

/// A point light or a directional light.
struct Light {
  enum class Kind : std::uint8_t { point, directional };
  struct Spot {
    Vec3 axis;          ///< the direction in which the cone opens; any length except zero
    double half_angle;  ///< radians, in (0, pi]
  };

  Kind kind = Kind::point;
  Vec3 position = Vec3::Zero();  ///< of a point light; ignored for a directional light
  /// The direction of the rays of a directional light, away from the light; any length except zero.
  /// Ignored for a point light.
  Vec3 direction = Vec3::Zero();
  std::string name;
  /// Point lights only. A face that is nowhere within the range, or wholly outside the cone of the
  /// spot, is left out of all work and reported as out_of_reach. A face that is partly inside is
  /// treated as wholly inside.
  double range = std::numeric_limits<double>::infinity();
  std::optional<Spot> spot;

  static Light point(const Vec3& position) {
    Light light;
    light.position = position;
    return light;
  }
  static Light directional(const Vec3& direction) {
    Light light;
    light.kind = Kind::directional;
    light.direction = direction;
    return light;
  }

  /// Throws Error, in which `who` names the light, when a coordinate is not finite, the direction
  /// is zero, the range is not positive, the spot is out of bounds, or a directional light has a
  /// range or a spot.
  void check(const std::string& who) const;
};

// ---- The scene as flat arrays, in world coordinates --------------------------------------------
//
// A *face* is a face of a mesh. A *facet* is one of the convex parts into which a face was cut;
// most faces are one facet.

/// Default of Scene::coplanarity_tolerance.
inline constexpr double default_coplanarity = 1e-12;

/// The plane of one or more facets of an object.
struct Plane {
  Vec3 normal;  ///< unit length, to the front
  Vec3 point;   ///< a point of the plane
  /// The normal before it was normalised, for the exact kernel: {x: exact_normal . (x - point) = 0}
  /// is the exact plane of the corners where their differences are short numbers.
  Vec3 exact_normal;
  /// The largest distance of the corners of all facets with this plane from the plane.
  double flatness;
  /// The largest angle, in radians, by which corners that move by `flatness` (or by rounding) could
  /// turn the plane. A light nearer to the plane than this angle sees it edge-on.
  double tilt;
};

/// An undirected edge of a mesh. The facets on both sides share its plane through a light.
struct Edge {
  std::uint32_t a, b;  ///< indices into Scene::vertices(), a < b
};

struct Facet {
  std::uint32_t face;          ///< index into Scene::faces()
  std::uint32_t plane;         ///< index into Scene::planes(); facets of one object may share it
  std::uint32_t first_corner;  ///< index into Scene::corners()
  /// At least 3; convex, counter-clockwise seen from the front. Straight corners are kept.
  std::uint32_t corner_count;
};

struct Corner {
  std::uint32_t vertex;  ///< index into Scene::vertices()
  /// The edge from this corner to the next: (index into Scene::edges() << 1) | 1 if it runs from
  /// Edge::b to Edge::a.
  std::uint32_t edge;
};

struct Face {
  std::uint32_t object;       ///< index into Scene::objects()
  std::uint32_t number;       ///< within its object, from 0, as in the mesh
  std::uint32_t first_facet;  ///< index into Scene::facets(); the facets of a face are consecutive
  std::uint32_t facet_count;  ///< 0: refused
  double area;                ///< of the facets, in their planes; 0 when refused
};

struct Object {
  std::string name;
  Sides sides;  ///< as decided: closed or open
  bool casts_shadows, receives_shadows, dynamic;
  std::uint32_t first_face, face_count;      ///< a range of Scene::faces()
  std::uint32_t first_vertex, vertex_count;  ///< distinct positions of this object
  double signed_volume;                      ///< positive for a solid whose faces look outward
  Pose pose = Pose::Identity();
  std::uint32_t first_facet = 0, facet_count = 0, first_edge = 0, edge_count = 0;
  /// false: removed. All counts are 0, and the index is free for a later object.
  bool alive = true;
  /// The number of facets that, when the object was added or deformed, were moved into the plane of
  /// another facet (see Scene::coplanarity_tolerance), and the largest distance of one of their
  /// corners from that plane.
  std::uint32_t aligned = 0;
  double aligned_by = 0;
};

/// The arrays of a scene.
struct MeshArrays {
  std::vector<Vec3> vertices;
  std::vector<Edge> edges;
  std::vector<Plane> planes;
  std::vector<Facet> facets;
  std::vector<Corner> corners;
  std::vector<Face> faces;
};

/// Objects and lights.
///
/// Removing an object leaves holes in the arrays, which later objects may fill. A face in a hole
/// has the object invalid_index and no facets; a facet in a hole has no corners. The indices of an
/// object stay the same until it is removed, or until its mesh changes so that it needs more room.
class Scene {
 public:
  Scene();
  ~Scene();
  Scene(const Scene&);  ///< the ids of the original are valid in the copy
  Scene& operator=(const Scene&);
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  /// The largest distance of a corner from the plane of its face, as a share of the diameter of the
  /// face, up to which the face is flat. To be set before objects are added.
  double flatness_tolerance = 1e-6;
  /// Faces of one object (or facets of a face that is not flat) whose corners are all within this
  /// distance of the plane of a larger face get that plane, on either side: such faces touch, and
  /// do not cross each other in slivers. A share of the largest coordinate of the object's mesh;
  /// the default is that of some thousand roundings. A face that this would turn by more than the
  /// square root of the tolerance (in radians, about) keeps its own plane. No motion of the object
  /// changes which faces share a plane. 0: every face keeps its own plane. To be set before objects
  /// are added; Object::aligned tells how many facets were moved.
  double coplanarity_tolerance = default_coplanarity;

  /// Adds an object: welds equal positions, checks every face, cuts concave faces into convex
  /// facets, and decides between open and closed. Cost: O(n log n) for n corners; quadratic only in
  /// the corners of one concave outline. Throws Error when the pose is not finite and invertible,
  /// or when the scene exceeds 2^29 edges.
  ObjectId add(const Mesh& mesh, const ObjectSettings& settings = {});
  [[nodiscard]] Status remove(ObjectId id);
  /// Moves an object. Cost: proportional to its corners. The checks of add() are repeated for a
  /// pose that is not a rigid motion of the present one, and for an object with concave faces.
  /// Throws Error, and changes nothing, when the pose is not finite and invertible.
  [[nodiscard]] Status set_pose(ObjectId id, const Pose& pose);
  /// Deforms an object: new positions of its mesh's vertices, in the local frame. Everything that
  /// is automatic (closed or open, flat or not) is decided again. Cost: that of add(). Throws
  /// Error, and changes nothing, when the number of vertices differs.
  [[nodiscard]] Status set_vertices(ObjectId id, std::span<const Vec3> local);
  [[nodiscard]] Status set_casts_shadows(ObjectId id, bool casts_shadows);
  [[nodiscard]] Status set_receives_shadows(ObjectId id, bool receives_shadows);

  /// Adds a light. Throws Error, and changes nothing, as Light::check() does.
  LightId add(const Light& light);
  [[nodiscard]] Status remove(LightId id);
  [[nodiscard]] Status set_light(LightId id, const Light& light);
  /// Removes all lights and adds these, at the indices 0, 1, ... Throws Error, and changes nothing,
  /// as Light::check() does.
  void replace_lights(std::span<const Light> lights);

  /// Whether an id is valid in this scene.
  Status status(ObjectId id) const;
  Status status(LightId id) const;
  /// The object or light of an id; null when the id is not valid. Valid until the scene changes.
  const Object* find(ObjectId id) const;
  const Light* find(LightId id) const;
  /// The arguments of add() that recreate an object in its present state: its mesh, with the last
  /// vertices set, and its settings. Empty when the id is not valid. Cost: a copy of the mesh.
  std::optional<std::pair<Mesh, ObjectSettings>> source(ObjectId id) const;
  /// The id of the object or light at an index. An id of no scene when the index is free.
  ObjectId object_id(std::size_t index) const;
  LightId light_id(std::size_t index) const;

  // The arrays. Spans are valid until the scene changes.
  std::span<const Object> objects() const { return objects_; }
  std::span<const Light> lights() const { return lights_; }
  std::span<const Face> faces() const { return arrays_.faces; }
  std::span<const Facet> facets() const { return arrays_.facets; }
  std::span<const Corner> corners() const { return arrays_.corners; }
  std::span<const Vec3> vertices() const { return arrays_.vertices; }
  std::span<const Edge> edges() const { return arrays_.edges; }
  std::span<const Plane> planes() const { return arrays_.planes; }
  std::span<const Issue> issues() const { return issues_; }

  std::span<const Corner> corners_of(const Facet& f) const {
    return std::span(arrays_.corners).subspan(f.first_corner, f.corner_count);
  }

 private:
  friend class SceneAccess;  // for engines, which follow a scene
  struct Source;             // an object as it was added
  struct Allocation;         // a range of every array, owned by one object at a time
  struct Slot;               // the private part of an object
  struct LightSlot;          // the private part of a light

  template <class Id, class Slots, class Alive>
  Status status(Id id, const Slots& slots, const Alive& alive) const;
  void import_object(std::uint32_t index, std::shared_ptr<const Source> source,
                     const ObjectSettings& settings);
  void allocate(std::uint32_t index, const std::array<std::uint32_t, 6>& counts);
  void release_copy(std::uint32_t index);
  void take_copy(const Scene& from, std::uint32_t index);
  void touch(std::uint32_t index);
  void make_newest(std::uint32_t index);

  std::uint32_t tag_;  // of this scene and its copies
  std::uint64_t revision_ = 0;
  std::uint32_t newest_ = invalid_index;  // the object changed last
  std::vector<Object> objects_;
  std::vector<Light> lights_;
  MeshArrays arrays_;
  std::vector<Issue> issues_;
  std::vector<Slot> slots_;  // by object
  std::vector<LightSlot> light_slots_;
  std::vector<std::uint32_t> free_objects_, free_lights_;
  std::vector<Allocation> allocations_;
  std::multimap<std::uint32_t, std::uint32_t> free_allocations_;  // by their number of corners
};

}  // namespace shadowcut
