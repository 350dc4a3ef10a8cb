// Fragments as a graphics interface wants them: vertex buffers that follow an engine, and what of
// them to upload after an update.
//
//   Engine engine(scene);
//   FragmentBuffers lit(0, {.show = Show::lit});     // of light 0
//   lit.update(engine, engine.update());             // after every update
//   if (lit.grown()) make_room(lit.vertex_capacity());
//   for (const auto& r : lit.changed_vertices()) upload(lit.positions().subspan(3 * r.first, 3 *
//     r.count), r.first);
//   draw_triangles(lit.vertex_count());
//
// Each fragment is a fan of triangles and has a place of its own. What an update takes away leaves
// a hole, drawn as triangles of no extent; what it brings fills holes of its size, or goes to the
// end. Nothing else moves, so what has to be uploaded is in proportion to what has changed.
//
// Units and frame: positions are world coordinates less BufferLayout::origin, subtracted in double:
// a scene far from the world's origin keeps its digits in floats. Thread safety: as of a container.
// No member keeps a reference to an engine or a scene.
#pragma once

#include <cstdint>
#include <shadowcut/shadows.hpp>
#include <span>
#include <vector>

namespace shadowcut {

// Which fragments have places. Of all lights: lit by any.
enum class Show : std::uint8_t { all, lit, shadowed };

// What the buffers hold of every vertex.
struct BufferLayout {
  Vec3 origin = Vec3::Zero();  // finite; in or near the scene, best
  bool doubles = false;        // positions in double instead of float
  // a vertex for each corner of a fragment, and indices; otherwise three vertices for each triangle
  bool indexed = false;
  bool normals = true;   // of the face's front, unit length
  bool faces = true;     // index into Engine::scene().faces(); none in holes
  bool objects = false;  // index into Engine::scene().objects(); none in holes
  bool states = true;    // 1: lit (by any light); 0: shadowed, and in holes
  // mask_words() words: bit k%32 of word k/32 is set iff light k reaches the fragment
  bool masks = false;
  Show show = Show::all;
  // everything is laid out anew when a larger share of the vertices than this is holes
  double hole_share = 0.5;
  // ranges with no more unchanged vertices (and indices) than this between them are handed out as
  // one
  std::uint32_t joined_gap = 16;
};

class FragmentBuffers {
 public:
  static constexpr std::uint32_t all_lights = none;
  struct Range {
    std::uint32_t first, count;
  };

  // For one light, by its index into Scene::lights(), or for the partition by all of them
  // (Engine::combined). Throws Error when the origin is not finite or the share is not between 0
  // and 1.
  explicit FragmentBuffers(std::uint32_t light = all_lights, const BufferLayout& layout = {});

  // Applies what an update of the engine changed. The same engine every time; after an update that
  // was missed, or that threw, everything is filled anew. One light: the cost is in proportion to
  // the fragments that changed (a light that moved: all of its own). All lights: the faces on which
  // any light's fragments changed are cut anew, after one look at every fragment of the first light
  // (some nanoseconds each); a light that came, moved or went costs the whole partition. Throws
  // std::bad_alloc, Error as the engine does, and Error beyond 2^32 vertices; the contents are then
  // nobody's until the next update.
  void update(const Engine& engine, const Changes& changes);
  // Everything anew, at the cost of all fragments; the next update will do so once more. The scene
  // must be the one whose shadows they are. A light that there is not: nothing. Throws Error when
  // shadows of one light are given to buffers of all, or the reverse.
  void fill(const Engine& engine);
  void fill(const Scene& scene, const Shadows& shadows);
  void fill(const Scene& scene, const LightSets& sets);
  // The next update fills everything anew: before another engine is followed, say.
  void forget() { seen_ = 0; }
  // The next update fills everything anew. Throws Error when it is not finite.
  void set_origin(const Vec3& origin);

  std::uint32_t light() const { return light_; }
  const BufferLayout& layout() const { return layout_; }

  // Vertices and indices to draw (holes among them), and the room there is behind the spans below:
  // what is past the count is unspecified.
  std::uint32_t vertex_count() const { return vertex_count_; }
  std::uint32_t vertex_capacity() const { return vertex_capacity_; }
  std::uint32_t index_count() const { return index_count_; }
  std::uint32_t index_capacity() const { return index_capacity_; }
  std::uint32_t fragment_count() const { return fragment_count_; }
  std::uint32_t hole_vertices() const { return hole_vertices_; }
  std::uint32_t mask_words() const { return mask_words_; }

  // Of the last update or fill: ascending, and apart. grown(): the capacities (or mask_words()) are
  // not what they were, so that buffers of the graphics interface have to be made anew; the ranges
  // are then everything.
  bool grown() const { return grown_; }
  std::span<const Range> changed_vertices() const { return changed_vertices_; }
  std::span<const Range> changed_indices() const { return changed_indices_; }

  // By vertex, up to the capacity; empty where the layout does without. They live until the next
  // call of a member that is not const.
  // 3 a vertex; empty with BufferLayout::doubles
  std::span<const float> positions() const { return positions_; }
  // 3 a vertex; empty without
  std::span<const double> double_positions() const { return double_positions_; }
  std::span<const float> normals() const { return normals_; }  // 3 a vertex
  std::span<const std::uint32_t> faces() const { return faces_; }
  std::span<const std::uint32_t> objects() const { return objects_; }
  std::span<const std::uint8_t> states() const { return states_; }
  std::span<const std::uint32_t> masks() const { return masks_; }  // mask_words() a vertex
  std::span<const std::uint32_t> indices() const { return indices_; }

 private:
  struct Place {  // of a fragment
    std::uint32_t first_vertex, first_index, corners;
  };
  struct Hole {
    Place place;
    std::uint64_t made;  // in which update
  };
  struct Source {  // what all vertices of a fragment have in common
    std::uint32_t face, facet;
    bool lit;
    std::span<const std::uint32_t> mask;
  };
  // by the ids of fragments: a table with open addressing, for a look at it is one at the memory
  class Places {
   public:
    void clear();
    void insert(FragmentId id, const Place& place);  // of an id that is not there
    // out of the table; without corners where there is none
    Place take(FragmentId id);

   private:
    struct Slot {
      FragmentId id;
      Place place;  // without corners: empty
    };
    std::size_t home(FragmentId id) const;
    std::size_t next(std::size_t slot) const { return (slot + 1) & (slots_.size() - 1); }
    std::vector<Slot> slots_;  // as many as a power of two, and half of them empty
    std::size_t count_ = 0;
  };

  std::uint32_t vertices_of(std::uint32_t corners) const {
    return layout_.indexed ? corners : 3 * (corners - 2);
  }
  std::uint32_t indices_of(std::uint32_t corners) const {
    return layout_.indexed ? 3 * (corners - 2) : 0;
  }
  bool shows(bool lit) const {
    return layout_.show == Show::all || lit == (layout_.show == Show::lit);
  }
  void begin();
  void follow(const Engine& engine, const Changes& changes, bool next);
  void refill(const Engine& engine);
  void clear();
  void apply(const Engine& engine, const LightChanges& change);
  bool apply_to_faces(const Engine& engine, const Changes& changes);
  void add_shadows(const Scene& scene, const Shadows& shadows);
  void add_fragment(const Scene& scene, const Block& block, const Fragment& fragment);
  void add_sets(const Scene& scene, const LightSets& sets);
  Place add(const Scene& scene, const Source& source, std::span<const Vec3> corners);
  void remove(const Place& place);
  Place take(std::uint32_t corners);
  void make_room(std::uint64_t vertices, std::uint64_t indices);
  void set_mask_words(std::size_t lights);
  void write_position(std::size_t vertex, const Vec3& position);
  void write_source(std::size_t first, std::size_t count, const Source& source,
                    std::uint32_t object, const Vec3& normal);
  void list_changes();

  std::uint32_t light_;
  BufferLayout layout_;
  std::uint64_t seen_ = 0;  // the update applied last; 0: none that the next could go on from
  std::uint32_t vertex_count_ = 0, vertex_capacity_ = 0, index_count_ = 0, index_capacity_ = 0;
  std::uint32_t fragment_count_ = 0, hole_vertices_ = 0, mask_words_ = 0;
  std::vector<float> positions_, normals_;
  std::vector<double> double_positions_;
  std::vector<std::uint32_t> faces_, objects_, masks_, indices_;
  std::vector<std::uint8_t> states_;

  Places places_;                                   // one light's
  std::vector<std::vector<Place>> places_of_face_;  // all lights'
  std::vector<std::vector<Hole>> holes_;            // by their number of corners
  std::vector<Place> touched_;                      // since the update began
  std::uint64_t updates_ = 0;
  bool anew_ = false, grown_ = false;
  std::vector<Range> changed_vertices_, changed_indices_;
  std::vector<std::uint32_t> mask_;  // of the fragment at hand
  std::vector<Vec3> corners_;        // likewise
};

}  // namespace shadowcut
