/// @file
/// Shadows: the faces of a scene cut into convex fragments, each wholly lit or wholly shadowed.
///
/// A point x of a face is shadowed by a light iff another casting face has a point strictly between
/// x and the light (contact is not occlusion), or x is on a side that is turned away from the
/// light. A face that is not flat consists of several facets in planes of their own, which may
/// shadow each other.
///
/// Units and frame: those of the scene (scene.hpp). Errors: scene.hpp lists all error channels.
///
/// Source: Y. Chrysanthou, M. Slater, "Shadow Volume BSP Trees for Computation of Shadows in
/// Dynamic Scenes", I3D 1995 (CS95). docs/design.md describes the differences.
///
/// Thread safety: functions use up to Options::threads threads of their own. Any number of threads
/// may read a const result or call const members of one Engine; other members need exclusive
/// access.
#pragma once

#include <array>
#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <memory>
#include <shadowcut/scene.hpp>
#include <span>
#include <string>
#include <vector>

namespace shadowcut {

/// How the tree decides the signs of its predicates.
enum class Kernel : std::uint8_t {
  /// In double, with a derived forward error bound; a sign within the bound is taken as zero.
  fast,
  /// Exactly: every sign is that of the real number which the input's doubles define.
  exact,
};

/// The form in which fragments are emitted.
enum class Form : std::uint8_t {
  pieces,  ///< as stored in the tree
  /// Sibling fragments of one face and one state are merged (Slater 1992, figure 6): both lit, or
  /// both shadowed by faces of one object.
  merged,
  /// Merged, and without T-junctions: a corner that lies on an edge of another fragment of the face
  /// is a corner of that fragment too.
  conforming,
};

/// The order in which facets are inserted into a tree. Every order gives the same lit regions.
enum class Order : std::uint8_t {
  solid_angle,  ///< largest object first, then its largest face; dynamic objects last
  as_given,
  random,  ///< by Options::Tuning::seed
};

/// A plane through the light, defined exactly by doubles of the input.
struct LightLine {
  /// false: the plane through the light and an edge. true: the plane through the light and the line
  /// in which two planes meet.
  bool crossing = false;
  /// Edge: its two end points. Crossing: the normal and a point of one plane, then of the other.
  std::array<Vec3, 4> v = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
};

/// The exact definition of a corner of a fragment: the point where the plane of its facet
/// (Plane::exact_normal, Plane::point) meets two planes through the light, or the ray of a vertex
/// of the scene. The exact kernel cuts faces at exactly this point, and emits its coordinates
/// rounded: within one ulp each, also for needles. A vertex of the facet itself is emitted
/// unchanged.
struct Construction {
  LightLine in, out;  ///< the edges that end and begin at the corner, in the order of the corners
  /// Index into Scene::vertices(); invalid_index: `in` and `out` define the corner.
  std::uint32_t vertex;
};

/// The size of the smallest fragment emitted. Smaller fragments are left out and counted in
/// FaceArea::dropped, but a fragment that is a whole facet is always emitted. The tree, and all
/// other fragments, do not depend on this. 0: all fragments are emitted.
struct MinFeature {
  double area = 0;         ///< on the face, in square scene units
  double solid_angle = 0;  ///< as seen from a point light, in steradians
  bool keeps_all() const { return area == 0 && solid_angle == 0; }
};

/// Options of cast_shadows() and Engine. Options that do not apply are an Error.
struct Options {
  /// Parameters of speed and memory. They do not change the lit regions.
  struct Tuning {
    Order order = Order::solid_angle;
    std::uint64_t seed = 0;  ///< of Order::random
    /// The number of facets at which the k-d tree above the SVBSP trees stops dividing light space;
    /// 0: no k-d tree, one cell.
    std::uint32_t facets_per_cell = 128;
    /// Engine only: keep the data that updates need. An engine without it takes less memory,
    /// emits fewer fragments (by a factor of 1.1 to 2.6, see docs/decisions.md), and rebuilds on
    /// every edit.
    bool incremental = true;
    /// Engine only. The plane of a removed face that still divides other faces is removed as well
    /// if one of its sides has at most this many nodes: that side is inserted into the other. Other
    /// such planes stay until an edit makes a side smaller.
    std::uint32_t join_threshold = 2;
  };

  Kernel kernel = Kernel::fast;
  Form form = Form::merged;
  /// 0: one thread for each processor, which is also the maximum. Results do not depend on it.
  unsigned threads = 0;
  /// Must not be negative. A solid angle needs point lights: with a directional light it is an
  /// Error of cast_shadows() or Engine::update().
  MinFeature min_feature;
  /// Fill Block::constructions. Needs Kernel::exact and Form::pieces or Form::merged.
  bool constructions = false;
  Tuning tuning;
  /// Called from time to time with the completed share of the work, 0 to 1; from any thread, but
  /// never from two threads at once.
  std::function<void(double)> progress;
};

/// Identifies a fragment of one light, until the fragment changes. `cell`: the index of its block
/// in Shadows::blocks. `piece`: its piece in the tree of the cell; in the last block, its facet.
/// `place`: where it is in front of the piece, or invalid_index.
struct FragmentId {
  std::uint32_t cell, piece, place;
  friend auto operator<=>(const FragmentId&, const FragmentId&) = default;
};

/// A convex part of a facet that is wholly lit or wholly shadowed by one light.
struct Fragment {
  FragmentId id;
  std::uint32_t face;   ///< index into Scene::faces()
  std::uint32_t facet;  ///< index into Scene::facets(); a fragment never spans two facets
  /// Of a shadowed fragment: the casting face whose PP-node it lies behind, or the nearest one in
  /// front of it (CS95). In the forms merged and conforming, where several faces of one object may
  /// cast on a fragment, one of them. invalid_index for lit fragments, and on sides turned away.
  std::uint32_t caster;
  std::uint32_t first_corner;  ///< index into the corners of its block
  std::uint32_t corner_count;
  bool lit;
  double area;
};

/// Fragments are stored in blocks, one for each cell of the k-d tree and one for the faces that
/// never enter the tree, so that an update replaces single blocks. The order of the fragments does
/// not depend on the number of threads.
struct Block {
  std::vector<Fragment> fragments;  ///< an update may change their order
  /// World frame, counter-clockwise seen from the light (for faces that are turned away: seen from
  /// their front). A corner that is a vertex of the scene equals that vertex bit by bit. A corner
  /// on a cut has the same bits on both sides of the cut if it is defined by two lines, or by the
  /// edges of one vertex. Where more lines happen to meet in a point, the last bits may differ
  /// between fragments; in the conforming form they do not.
  std::vector<Vec3> corners;
  std::vector<Construction> constructions;  ///< of the corners; empty unless requested

  std::span<const Vec3> corners_of(const Fragment& f) const {
    return std::span(corners).subspan(f.first_corner, f.corner_count);
  }
};

/// A fragment together with its corners. Valid until its Shadows change.
class FragmentView {
 public:
  FragmentView(const Block& block, const Fragment& fragment)
      : block_(&block), fragment_(&fragment) {}
  const Fragment& operator*() const { return *fragment_; }
  const Fragment* operator->() const { return fragment_; }
  /// World frame; see Block::corners.
  std::span<const Vec3> corners() const { return block_->corners_of(*fragment_); }
  const Block& block() const { return *block_; }

 private:
  const Block* block_;
  const Fragment* fragment_;
};

/// The fragments of all blocks, one after another: a range of FragmentView.
class FragmentRange {
 public:
  class iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = FragmentView;
    using difference_type = std::ptrdiff_t;
    using pointer = void;
    using reference = FragmentView;

    iterator() = default;
    FragmentView operator*() const { return {*block_, block_->fragments[index_]}; }
    iterator& operator++() {
      ++index_;
      skip_finished_blocks();
      return *this;
    }
    iterator operator++(int) {
      iterator before = *this;
      ++*this;
      return before;
    }
    friend bool operator==(const iterator& a, const iterator& b) {
      return a.block_ == b.block_ && a.index_ == b.index_;
    }

   private:
    friend class FragmentRange;
    iterator(const Block* block, const Block* end) : block_(block), end_(end) {
      skip_finished_blocks();
    }
    void skip_finished_blocks() {
      while (block_ != end_ && index_ == block_->fragments.size()) ++block_, index_ = 0;
    }
    const Block *block_ = nullptr, *end_ = nullptr;
    std::size_t index_ = 0;
  };

  explicit FragmentRange(std::span<const Block> blocks) : blocks_(blocks) {}
  iterator begin() const { return {blocks_.data(), blocks_.data() + blocks_.size()}; }
  iterator end() const {
    return {blocks_.data() + blocks_.size(), blocks_.data() + blocks_.size()};
  }
  /// The number of fragments. Cost: proportional to the number of blocks.
  std::size_t size() const {
    std::size_t n = 0;
    for (const Block& block : blocks_) n += block.fragments.size();
    return n;
  }

 private:
  std::span<const Block> blocks_;
};

/// How a face stands to a light.
enum class Facing : std::uint8_t {
  refused,       ///< not a usable face; see Scene::issues()
  away,          ///< turned away from the light, or seen edge-on: wholly shadowed
  out_of_reach,  ///< beyond the light's range or outside its spot: wholly shadowed
  ignored,       ///< its object does not receive shadows: no fragments, neither lit nor shadowed
  toward,        ///< turned to the light
};

/// The areas of one face, in square scene units. An area counts one side, also for open sheets.
struct FaceArea {
  Facing facing = Facing::refused;  ///< of a face in several facets: toward if any facet is
  /// lit + shadowed + dropped = area, up to rounding; dropped is 0 unless Options::min_feature is
  /// set. The region of a face is its plane cut by the cone of its corners: where the corners are
  /// flat only up to rounding, these are areas of that region.
  double area = 0, lit = 0, shadowed = 0, dropped = 0;
};

/// Statistics of the shadows of one light.
struct Stats {
  /// `facets`: the number of facets in the tree. `facing`: of faces turned to the light.
  std::uint64_t faces = 0, facing_faces = 0, facets = 0;
  double facing_area = 0, lit_area = 0, shadowed_area = 0, dropped_area = 0;  ///< of facing faces
  std::uint64_t lit_fragments = 0, shadowed_fragments = 0;                    ///< of facing faces
  /// `nodes`: of the trees of all cells and of the k-d tree.
  std::uint64_t cells = 0, nodes = 0, sp_nodes = 0, pp_nodes = 0, pieces = 0;
  /// The number of cuts along which two faces cross.
  std::uint64_t crossing_lines = 0;
  /// The number of signs computed, and the number of these that are zero.
  std::uint64_t predicates = 0, on = 0;
  /// How the signs were decided. Fast kernel: by the filter alone.
  std::uint64_t by_identity = 0, by_filter = 0, by_exact = 0;
  /// The depth of the deepest leaf, k-d tree included.
  std::uint64_t depth = 0;
  /// Memory of the trees and the fragments.
  std::uint64_t bytes = 0;
  /// Time of the last build, by a steady clock; updates are not counted.
  double build_ms = 0, emit_ms = 0;
  /// At present: planes of removed faces that are still in the tree, and the length of the longest
  /// location list of an object (CS95, section 3: the pieces of the object).
  std::uint64_t marked_nodes = 0, longest_location_list = 0;
  /// Since the last build: cells rebuilt because edits had degraded them.
  std::uint64_t cells_rebuilt = 0;
  /// Since the last build: planes of removed faces that were removed by joining their sides, and
  /// those that were kept because both sides were too large.
  std::uint64_t joined = 0, deferred = 0;
};

/// The shadows of one light.
struct Shadows {
  std::vector<Block> blocks;    ///< by FragmentId::cell
  std::vector<FaceArea> areas;  ///< by index into Scene::faces()
  Stats stats;

  /// All fragments:
  ///
  ///     for (const auto f : shadows.fragments()) draw(f.corners(), f->lit);
  FragmentRange fragments() const& { return FragmentRange(blocks); }
  FragmentRange fragments() const&& = delete;  // the range would outlive the fragments
};

/// The changes that an update made to the shadows of one light.
struct LightChanges {
  struct Added {
    FragmentId id;
    std::uint32_t index;  ///< into Shadows::blocks[id.cell].fragments
  };
  struct Area {
    /// Index into Engine::scene().faces(). The facing of a face of a removed object is `refused`.
    std::uint32_t face;
    FaceArea area;
  };
  std::uint32_t light = 0;  ///< index into Scene::lights()
  /// The light has a new tree: it was added or moved, or an object left the region for which the
  /// tree's numbers are valid.
  bool rebuilt = false;
  bool removed = false;  ///< the light and all of its fragments have been removed
  std::vector<FragmentId> gone;
  std::vector<Added> added;  ///< may use ids that are in `gone`: apply `gone` first
  std::vector<Area> areas;   ///< of all faces whose facing or areas changed
};

/// The changes that an update made.
struct Changes {
  /// The number of updates and compactions begun by the engine, failed ones included, from 1: a
  /// mirror of the fragments can tell whether it missed one.
  std::uint64_t update = 0;
  std::vector<LightChanges> lights;  ///< the lights whose shadows changed, by ascending index
  std::uint32_t applied = 0;         ///< number of objects and lights brought up to date
  /// false: the time budget ran out, and some objects are still as they were before.
  bool complete = true;
  double ms = 0;  ///< duration, by a steady clock
};

/// The shadows of several lights at once: fragments so small that each of them is wholly lit or
/// wholly shadowed by every light.
struct LightPartition {
  struct Fragment {
    std::uint32_t face, facet;                 ///< indices into Scene::faces(), Scene::facets()
    std::uint32_t first_corner, corner_count;  ///< a range of `corners`
  };
  std::vector<Fragment> fragments;
  std::vector<Vec3> corners;  ///< world frame
  std::size_t words = 1;      ///< number of 64-bit words of a set of lights
  /// Light k reaches fragment i iff bit k%64 of lights[i*words + k/64] is set.
  std::vector<std::uint64_t> lights;

  std::span<const Vec3> corners_of(const Fragment& f) const {
    return std::span(corners).subspan(f.first_corner, f.corner_count);
  }
  bool reaches(std::size_t fragment, std::size_t light) const {
    return lights[fragment * words + light / 64] >> (light % 64) & 1;
  }
};

/// Computes the shadows of one light once. Cost: about O(n log n) for n facets if shadows overlap
/// little; otherwise proportional to the number of fragments. Throws Error when the light is not
/// usable (Light::check()) or an option does not apply, and std::bad_alloc.
Shadows cast_shadows(const Scene& scene, const Light& light, const Options& options = {});

/// Keeps the shadows of all lights of a scene up to date while the scene is edited: one tree for
/// each light. The scene must outlive the engine, and must not change during a call.
///
///     Scene scene = ...;
///     Engine engine(scene);
///     engine.update();                      // the first update builds
///     scene.set_pose(desk, pose);
///     const Changes& c = engine.update();   // the changes, and nothing else
///
/// All indices of faces, facets and objects handed out refer to scene(): the engine's own copy, for
/// which the shadows are. After a complete update it equals the scene that the engine follows.
///
/// Spans and references handed out (Shadows, Changes, scene()) are valid until the next call of a
/// member that is not const. After std::bad_alloc from update() or compact(), every member except
/// compact() and the destructor throws Error until compact() has rebuilt everything.
class Engine {
 public:
  /// Builds nothing yet. Throws Error when an option does not apply.
  explicit Engine(const Scene& scene, Options options = {});
  explicit Engine(const Scene&& scene, Options options = {}) = delete;  // a temporary
  ~Engine();
  Engine(Engine&&) noexcept;
  Engine& operator=(Engine&&) noexcept;

  /// Applies all edits made to the scene since the last update; the first update builds. Cost: for
  /// a moved object, the nodes and fragments that it touches (CS95, sections 3 and 4); for a moved
  /// light, a build; with Form::conforming a comparison of all fragments in addition. Throws
  /// std::bad_alloc, and Error, before anything changes, when Options::min_feature does not apply
  /// to a light.
  const Changes& update();
  /// The same, but stops between two objects when the time is over. Every call brings at least one
  /// object up to date. The result is correct for a scene in which the other objects are still as
  /// they were; the next call continues.
  const Changes& update(std::chrono::nanoseconds budget);

  /// Rebuilds every tree, with a new k-d tree and order of insertion: for a scene that has changed
  /// beyond recognition. All fragments are gone and added.
  const Changes& compact();

  /// The engine's copy of the scene.
  const Scene& scene() const;
  /// The number of scene().lights(), removed lights included.
  std::size_t light_count() const;
  /// The shadows of a light, by its index. Throws Error when there is no such light, or it has been
  /// removed.
  const Shadows& shadows(std::size_t light) const;
  /// The fragment of an id; null when there is none at present. Cost: constant if
  /// Options::Tuning::incremental, otherwise proportional to its block. Throws Error as shadows().
  const Fragment* find(std::size_t light, FragmentId id) const;

  /// For each face (index into scene().faces()) an upper bound on the area whose state, lit or
  /// shadowed, may be wrong: because the kernel took signs as zero that need not be, and because of
  /// rounding of the areas. The true error is never larger, to first order (docs/design.md, section
  /// 3). With the exact kernel only the rounding remains. Cost: about that of handing out all
  /// fragments. Throws Error as shadows().
  std::vector<double> uncertain_area(std::size_t light) const;

  /// Whether a light reaches a point of a face (index into scene().faces()). The point is taken as
  /// on the plane of the face: where the ray from the light through the point meets the plane.
  /// Contact is not occlusion. Not lit are sides that are turned away or out of range, refused
  /// faces, and faces of objects that do not receive shadows. Within rounding of a boundary between
  /// lit and shadowed either answer may be given. Options::min_feature has no influence.
  ///
  /// Cost: one descent of the trees, proportional to their depth; for a face of several facets also
  /// the corners of these. Throws Error as shadows(), when there is no such face, and when the
  /// point is not finite.
  bool is_lit(std::size_t light, std::uint32_t face, const Vec3& point) const;

  /// One partition of all faces for all lights (CS95, section 4: the fragments of the first light
  /// are the input for the second light, and so on).
  LightPartition overlay() const;
  /// The part of the partition on these faces (indices into scene().faces(); others are ignored).
  /// It stays the same on a face until the fragments of some light on that face change. Cost: that
  /// of cutting the fragments of these faces, and a pass over all fragments of the first light.
  LightPartition overlay(std::span<const std::uint32_t> faces) const;

  /// Checks every invariant of every tree. Returns an empty string, or a sentence about the first
  /// one that does not hold. For tests: it takes many times as long as a build.
  std::string validate() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace shadowcut
