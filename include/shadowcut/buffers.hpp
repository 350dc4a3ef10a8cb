/// @file
/// Vertex buffers that follow an engine, and the ranges of them that changed with an update.
///
///     Engine engine(scene);
///     FragmentBuffers lit(0, {.show = Show::lit});  // of light 0
///     lit.update(engine, engine.update());          // after every update
///     if (lit.grown()) allocate_on_gpu(lit.vertex_capacity());
///     for (const auto& r : lit.changed_vertices())
///       upload(lit.positions().subspan(3 * r.first, 3 * r.count), r.first);
///     draw_triangles(lit.vertex_count());
///
/// A fragment is a fan of triangles and has a place of its own in the buffers. A fragment that an
/// update removes leaves a hole, drawn as triangles without extent; a new fragment fills a hole of
/// its size, or is appended. No other fragment moves, so the amount to upload is proportional to
/// the amount of change.
///
/// Units and frame: positions are world coordinates minus BufferLayout::origin, subtracted in
/// double: a scene far from the world's origin keeps its precision in floats. Thread safety: that
/// of a standard container. The buffers keep no reference to an engine or a scene.
#pragma once

#include <cstdint>
#include <memory>
#include <shadowcut/shadows.hpp>
#include <span>

namespace shadowcut {

/// Which fragments are in the buffers. With all lights, "lit" means lit by any light.
enum class Show : std::uint8_t { all, lit, shadowed };

/// What the buffers hold for each vertex.
struct BufferLayout {
  Vec3 origin = Vec3::Zero();  ///< finite; best in or near the scene
  bool doubles = false;        ///< positions in double instead of float
  /// A vertex for each corner of a fragment, and indices. Otherwise three vertices for each
  /// triangle.
  bool indexed = false;
  bool normals = true;   ///< of the front of the face, unit length
  bool faces = true;     ///< index into Engine::scene().faces(); invalid_index in holes
  bool objects = false;  ///< index into Engine::scene().objects(); invalid_index in holes
  bool states = true;    ///< 1: lit (by any light); 0: shadowed, and in holes
  /// mask_words() words: bit k%32 of word k/32 is set iff light k reaches the fragment.
  bool masks = false;
  Show show = Show::all;
  /// The buffers are filled again without holes when a larger share of the vertices is in holes; 0
  /// to 1.
  double hole_share = 0.5;
  /// Changed ranges with no more unchanged vertices (and indices) than this between them become one
  /// range.
  std::uint32_t joined_gap = 16;
};

class FragmentBuffers {
 public:
  /// In place of the index of a light: the partition by all lights.
  static constexpr std::uint32_t all_lights = invalid_index;
  struct Range {
    std::uint32_t first, count;
  };

  /// Empty buffers for one light, by its index into Scene::lights(), or for the partition by all
  /// lights (Engine::overlay). Throws Error when the origin is not finite or the share of holes is
  /// not between 0 and 1.
  explicit FragmentBuffers(std::uint32_t light = all_lights, const BufferLayout& layout = {});
  ~FragmentBuffers();
  FragmentBuffers(const FragmentBuffers&);
  FragmentBuffers& operator=(const FragmentBuffers&);
  FragmentBuffers(FragmentBuffers&&) noexcept;
  FragmentBuffers& operator=(FragmentBuffers&&) noexcept;

  /// Applies the changes of an update of the engine, which must be the same engine every time.
  /// After an update that was skipped, or that threw, the buffers are filled again.
  ///
  /// Cost. One light: proportional to the number of changed fragments; all of its fragments if the
  /// light moved. All lights: the faces on which fragments of any light changed are cut again,
  /// after a pass over all fragments of the first light (some nanoseconds each); the whole
  /// partition if a light was added, moved or removed.
  ///
  /// Throws std::bad_alloc, Error as the engine does, and Error beyond 2^32 vertices. The contents
  /// are then unspecified until the next successful update.
  void update(const Engine& engine, const Changes& changes);
  /// Fills the buffers, at the cost of all fragments; the next update will do so once more. The
  /// scene must be the one for which the shadows were computed. Empty when the light does not
  /// exist. Throws Error when shadows of one light are given to buffers of all lights, or the
  /// reverse.
  void fill(const Engine& engine);
  void fill(const Scene& scene, const Shadows& shadows);
  void fill(const Scene& scene, const LightPartition& partition);
  /// The next update fills the buffers again: to be called before another engine is followed.
  void forget();
  /// Sets BufferLayout::origin; the next update fills the buffers again. Throws Error when the
  /// origin is not finite.
  void set_origin(const Vec3& origin);

  std::uint32_t light() const;
  const BufferLayout& layout() const;

  /// The number of vertices and indices to draw, holes included, and the lengths (capacities) of
  /// the arrays below. Elements beyond the count are unspecified.
  std::uint32_t vertex_count() const;
  std::uint32_t vertex_capacity() const;
  std::uint32_t index_count() const;
  std::uint32_t index_capacity() const;
  std::uint32_t fragment_count() const;
  /// The number of vertices in holes.
  std::uint32_t hole_vertices() const;
  /// The number of 32-bit words of a vertex' mask.
  std::uint32_t mask_words() const;

  /// Whether the last update or fill changed a capacity or mask_words(), so that the buffers of the
  /// graphics interface have to be created again. The changed ranges then cover everything.
  bool grown() const;
  /// The ranges changed by the last update or fill, ascending and disjoint.
  std::span<const Range> changed_vertices() const;
  std::span<const Range> changed_indices() const;

  // Arrays by vertex, as long as the capacity; empty where the layout excludes them. Spans are
  // valid until the next call of a member that is not const.
  std::span<const float> positions() const;          ///< 3 for each vertex; unless doubles
  std::span<const double> double_positions() const;  ///< 3 for each vertex; if doubles
  std::span<const float> normals() const;            ///< 3 for each vertex
  std::span<const std::uint32_t> faces() const;
  std::span<const std::uint32_t> objects() const;
  std::span<const std::uint8_t> states() const;
  std::span<const std::uint32_t> masks() const;    ///< mask_words() for each vertex
  std::span<const std::uint32_t> indices() const;  ///< 3 for each triangle; if indexed

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace shadowcut
