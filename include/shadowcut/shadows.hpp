// Shadows: what the engine makes of a scene and its lights. Every face is cut into convex
// fragments, each wholly lit or wholly shadowed.
//
// A point x of a face is shadowed by a light iff some *other* face that casts has a point strictly
// between x and the light (contact is not occlusion), or x is on a side turned away from the light.
// A face that was not flat is several facets in planes of their own, which may shadow each other.
//
// Source: Y. Chrysanthou, M. Slater, "Shadow Volume BSP Trees for Computation of Shadows in Dynamic
// Scenes", I3D 1995 (CS95). docs/design.md says where the engine departs from it.
//
// Thread safety: functions here use up to Options::threads threads of their own; a const result may
// be read from any thread.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <shadowcut/scene.hpp>
#include <span>
#include <string>
#include <vector>

namespace shadowcut {

enum class Kernel : std::uint8_t {
  // double with a derived forward-error bound; what is within the bound of zero is taken as "on"
  fast,
  // every sign that the tree asks for is that of the real number which the input's doubles define;
  // see Construction
  exact,
};

enum class Form : std::uint8_t {
  pieces,  // as they lie in the tree
  // siblings of one face and one state reunited (Slater 1992, figure 6): both lit, or shadowed by
  // faces of one object
  merged,
  // merged, and every corner of a fragment that lies on an edge of another fragment of its face is
  // a corner there too.
  conforming,
};

// Order of insertion; any order gives the same lit regions, at different cost.
enum class Order : std::uint8_t {
  solid_angle,  // biggest object first, then its biggest face; objects that move come last
  as_given,
  random,  // by Options::seed
};

// A plane through a light, exactly: all doubles taken as they are.
struct LightLine {
  bool crossing = false;
  // An edge's: two points, which it contains as well as the light. Of a crossing: a normal and a
  // point of one plane, then of another; it contains the line in which those two meet.
  std::array<Vec3, 4> v = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
};

// What a corner of a fragment is, exactly: where the plane of its facet (Plane::exact_normal,
// Plane::point) meets two planes through the light; or the ray of a vertex of the scene. The exact
// kernel cuts faces there, and hands out the numbers next to it: within one ulp in each coordinate,
// needles included; but a facet's own vertices are handed out as they are, on the plane or not.
struct Construction {
  // the edges that come to the corner and leave it, in the order of the corners
  LightLine in, out;
  std::uint32_t vertex;  // index into Scene::vertices(); or none, and then `in` and `out` count
};

// The smallest feature kept; 0: everything. Where a cut leaves the smaller of its two parts below
// this, that part is dropped: it neither receives nor casts from there on, and its area is told in
// FaceArea::dropped. A face is never dropped whole; what the prefix cuts off stays.
struct MinFeature {
  double area = 0;         // on the face, in square scene units
  double solid_angle = 0;  // as a point light sees it, in steradians
  bool keeps_all() const { return area == 0 && solid_angle == 0; }
};

struct Options {
  Kernel kernel = Kernel::fast;
  Form form = Form::merged;
  Order order = Order::solid_angle;
  std::uint64_t seed = 0;
  // 0: one for each processor, which is also the most; the result does not depend on it
  unsigned threads = 0;
  // engines and calls throw Error where it is negative, or a solid angle of a directional light
  MinFeature min_feature;
  // the balanced prefix stops dividing light space at about this many; 0: no prefix
  std::uint32_t facets_per_cell = 128;
  // For Engine only.
  // keep what updates need. Without it an engine takes less memory, merges a little better, and
  // builds anew on any edit
  bool edits = true;
  // A plane left behind by a removed face, with something on both sides, goes if the smaller side
  // has no more nodes than this: that side is then inserted into the other. Otherwise it stays, as
  // a plain dividing plane, until a later edit makes a side small.
  std::uint32_t join_threshold = 2;
  // exact kernel, forms pieces and merged: fill Block::constructions
  bool constructions = false;
  // called now and then, from any thread but one at a time, with the share of the work done, 0 to 1
  std::function<void(double)> progress;
};

// Names a place in the tree. It stays the same for as long as the fragment is unchanged.
struct FragmentId {
  std::uint32_t cell, piece, place;
  friend auto operator<=>(const FragmentId&, const FragmentId&) = default;
};

struct Fragment {
  FragmentId id;
  std::uint32_t face;   // index into Scene::faces()
  std::uint32_t facet;  // index into Scene::facets(); a fragment never spans two
  // Lit: none. Shadowed: the face that casts (CS95's: the one whose PP-node it lies behind, or the
  // nearest in front of it); in the merged and conforming forms, where several faces of one object
  // cast on a fragment, one of them. none for a side turned away.
  std::uint32_t caster;
  std::uint32_t first_corner;  // into its block's corners
  std::uint32_t corner_count;
  bool lit;
  double area;
};

// Fragments come in blocks (one for each cell of the balanced prefix, and one for the faces that
// never enter the tree), so that an update can replace one block and leave the others. The order is
// the same for any number of threads.
struct Block {
  std::vector<Fragment> fragments;  // in no order that an update would keep
  // World frame; counter-clockwise seen from the light (for faces turned away: seen from their
  // front). A corner that is a vertex of the scene is that vertex, to the bit; a corner on a cut is
  // the same numbers on both sides of the cut where two lines, or the edges of one vertex, make it.
  // Where more lines happen to meet in one point its last bits may depend on the side; the
  // conforming form makes them one.
  std::vector<Vec3> corners;
  std::vector<Construction> constructions;  // of the corners; empty unless Options::constructions

  std::span<const Vec3> corners_of(const Fragment& f) const {
    return std::span(corners).subspan(f.first_corner, f.corner_count);
  }
};

enum class Facing : std::uint8_t {
  refused,       // not a usable face; see Scene::issues()
  away,          // turned away from the light, or seen edge-on: shadowed whole
  out_of_reach,  // beyond the light's range or outside its cone: shadowed whole
  ignored,       // its object does not receive: neither lit nor shadowed, no fragments
  toward,
};

struct FaceArea {
  Facing facing = Facing::refused;  // of a face in several facets: toward if any facet is
  // lit + shadowed + dropped = area, to rounding; dropped is 0 unless Options::min_feature is set.
  // A face's region is its plane cut by its cone of light; where its corners are flat only up to
  // rounding, that is the area meant here. The area counts one side, also for open sheets.
  double area = 0, lit = 0, shadowed = 0, dropped = 0;
};

struct Stats {
  // facets: that entered the tree
  std::uint64_t faces = 0, facing_faces = 0, facets = 0;
  double facing_area = 0, lit_area = 0, shadowed_area = 0, dropped_area = 0;  // of facing faces
  std::uint64_t lit_fragments = 0, shadowed_fragments = 0;                    // of facing faces
  // nodes: of the cells' trees and of the prefix
  std::uint64_t cells = 0, nodes = 0, sp_nodes = 0, pp_nodes = 0, pieces = 0;
  // cuts along which two faces cross
  std::uint64_t crossing_lines = 0;
  // signs asked for; and those that came out as zero
  std::uint64_t predicates = 0, on = 0;
  // how they were found; fast: the filter's word stands
  std::uint64_t by_identity = 0, by_filter = 0, by_exact = 0;
  // of the deepest leaf, prefix included
  std::uint64_t depth = 0;
  // held by the tree and the fragments
  std::uint64_t bytes = 0;
  // steady clock; of the last build, not of updates
  double build_ms = 0, emit_ms = 0;
  // Of edits. Now: planes left behind, and the longest location list of an object (CS95, section 3:
  // the pieces that it lies in).
  std::uint64_t marked_nodes = 0, longest_location_list = 0;
  std::uint64_t cells_built_again = 0;  // since the build: because of what edits had made of them
  std::uint64_t joined = 0,
                // since the build: planes removed by joining their sides; and left in place because
      // of their size
      deferred = 0;
};

// The shadows of one light.
struct Shadows {
  std::vector<Block> blocks;    // by FragmentId::cell
  std::vector<FaceArea> areas;  // by index into Scene::faces()
  Stats stats;
};

// What an update did to one light's shadows.
struct LightChanges {
  struct Added {
    FragmentId id;
    std::uint32_t index;  // into Shadows::blocks[id.cell].fragments
  };
  struct Area {
    // index into Engine::scene().faces(); the face of a removed object has become `refused`
    std::uint32_t face;
    FaceArea area;
  };
  std::uint32_t light = 0;  // index into Scene::lights()
  // its tree is a new one: the light was added or moved, or an object left the region its numbers
  // are good for
  bool rebuilt = false;
  bool removed = false;  // the light is gone, with all its fragments
  std::vector<FragmentId> gone;
  std::vector<Added> added;  // may use ids that are in `gone`: apply `gone` first
  std::vector<Area> areas;   // of faces whose facing or areas are not what they were
};

struct Changes {
  // counts the engine's updates and compactions, those that failed too, from 1: a mirror sees what
  // it missed
  std::uint64_t update = 0;
  std::vector<LightChanges> lights;  // those whose shadows changed, in the order of their indices
  std::uint32_t applied = 0;         // objects and lights brought up to date
  // false: the budget ran out, and some objects still stand as they stood before
  bool complete = true;
  double ms = 0;  // steady clock
};

// The shadows of several lights at once: fragments cut so finely that each is wholly lit or
// shadowed by every light.
struct LightSets {
  struct Fragment {
    std::uint32_t face, facet;
    std::uint32_t first_corner, corner_count;
  };
  std::vector<Fragment> fragments;
  std::vector<Vec3> corners;
  std::size_t words = 1;  // 64-bit words of a light set
  // fragment i is reached by light k iff bit k%64 of lights[i*words + k/64] is set
  std::vector<std::uint64_t> lights;

  std::span<const Vec3> corners_of(const Fragment& f) const {
    return std::span(corners).subspan(f.first_corner, f.corner_count);
  }
  bool reaches(std::size_t fragment, std::size_t light) const {
    return lights[fragment * words + light / 64] >> (light % 64) & 1;
  }
};

// The one-off call. Cost: about n log n for n facets where shadows overlap little, and in
// proportion to the fragments made otherwise. Throws Error when the light is not usable (see
// check()), and std::bad_alloc when memory runs out.
Shadows cast_shadows(const Scene& scene, const Light& light, const Options& options = {});

// The engine that remembers: one tree for each light of a scene, kept right while the scene is
// edited. The scene must outlive it, and must not change during a call.
//
//   Scene scene = ...;  Engine engine(scene);  engine.update();          // the first update builds
//   scene.set_pose(desk, pose);  const Changes& c = engine.update();     // what changed, and
//     nothing else
//
// Indices of faces, facets, objects in everything it hands out are those of scene(): the engine's
// own copy, which is what the shadows are of. After a complete update it is equal to the scene
// followed.
//
// Views (spans and references to Shadows, Changes, scene()) live until the next call of a member
// that is not const. After std::bad_alloc from update() or compact() nothing is answered wrongly:
// every member but compact() and the destructor throws Error until compact() has built everything
// anew.
class Engine {
 public:
  explicit Engine(const Scene& scene, Options options = {});
  ~Engine();
  Engine(Engine&&) noexcept;
  Engine& operator=(Engine&&) noexcept;

  // Applies all edits since the last update. Cost: of a moved object, the nodes and fragments that
  // it touches (CS95, sections 3 and 4); of a moved light, a build. Form::conforming costs a
  // comparison of all fragments besides. Throws std::bad_alloc when memory runs out.
  const Changes& update();
  // The same, but stops between objects once the time is up; at least one object is brought up to
  // date in each call. What has been applied is a correct scene, in which some objects stand as
  // they stood before; the next call goes on.
  const Changes& update(std::chrono::nanoseconds budget);

  // Builds every tree anew, with a fresh prefix and order: for a scene that has changed beyond
  // recognition. Everything is gone and added.
  const Changes& compact();

  const Scene& scene() const;
  std::size_t light_count() const;  // of scene().lights(), removed ones included
  // Throws Error when there is no such light, or it has been removed.
  const Shadows& shadows(std::size_t light) const;
  // Null when there is no such fragment (now). Cost: constant with Options::edits, otherwise in
  // proportion to its block.
  const Fragment* find(std::size_t light, FragmentId id) const;

  // By index into scene().faces(): a bound of the area that is lit and was handed out as shadowed,
  // or the reverse, because the kernel took signs as zero that need not be; and of what rounding
  // made of the areas. The true error is never more (to first order; docs/design.md, section 3,
  // says what is counted). The exact kernel leaves nothing undecided. Cost: about that of handing
  // out all fragments. Throws Error as shadows() does.
  std::vector<double> undecided(std::size_t light) const;

  // One partition for all lights (CS95, section 4: a second light's input is the first one's
  // output).
  LightSets combined() const;
  // The part of it on these faces (indices into scene().faces(); others are passed over). Where no
  // light's fragments on a face have changed, neither has what it would give. Cost: that of cutting
  // these faces' fragments, and one look at every fragment of the first light.
  LightSets combined(std::span<const std::uint32_t> faces) const;

  // Checks every invariant of every tree. Returns an empty string, or a sentence that says which
  // one does not hold. For tests: it takes many times a build.
  std::string validate() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace shadowcut
