// Vertex buffers of c.h.
#include "handles.hpp"

namespace shadowcut::c {
namespace {

BufferLayout layout_of(const shadowcut_buffer_layout* layout) {
  BufferLayout out;
  if (!layout) return out;
  require_size(layout);
  out.doubles = flag(layout->doubles), out.indexed = flag(layout->indexed);
  out.normals = flag(layout->normals), out.faces = flag(layout->faces),
  out.objects = flag(layout->objects);
  out.states = flag(layout->states), out.masks = flag(layout->masks);
  out.show = enum_of(layout->show, Show::shadowed);
  out.origin = Vec3(layout->origin);
  out.hole_share = layout->hole_share, out.joined_gap = layout->joined_gap;
  return out;
}

FragmentBuffers& change(shadowcut_buffers* buffers) {
  require_pointers(buffers);
  return buffers->buffers;
}
const FragmentBuffers& value_of(const shadowcut_buffers* buffers) {
  require_pointers(buffers);
  return buffers->buffers;
}

struct Stream {
  const void* data;
  std::uint32_t bytes_each;
};
template <class T>
Stream stream_of(std::span<const T> values, std::uint32_t width) {
  return {values.data(), static_cast<std::uint32_t>(width * sizeof(T))};
}

Stream stream_of(const FragmentBuffers& b, std::int32_t which) {
  const BufferLayout& layout = b.layout();
  const auto provided = [](bool there, Stream stream) {
    if (!there) fail(SHADOWCUT_NOT_FOUND, "the layout excludes this stream");
    return stream;
  };
  switch (which) {
    case SHADOWCUT_POSITIONS:
      return layout.doubles ? stream_of(b.double_positions(), 3) : stream_of(b.positions(), 3);
    case SHADOWCUT_NORMALS:
      return provided(layout.normals, stream_of(b.normals(), 3));
    case SHADOWCUT_FACES:
      return provided(layout.faces, stream_of(b.faces(), 1));
    case SHADOWCUT_OBJECTS:
      return provided(layout.objects, stream_of(b.objects(), 1));
    case SHADOWCUT_STATES:
      return provided(layout.states, stream_of(b.states(), 1));
    case SHADOWCUT_MASKS:
      return provided(layout.masks, stream_of(b.masks(), b.mask_words()));
    case SHADOWCUT_INDICES:
      return provided(layout.indexed, stream_of(b.indices(), 1));
    default:
      fail(SHADOWCUT_INVALID_ARGUMENT, "invalid enum value");
  }
}

// What buffers look up of a scene for a fragment.
void require_in(const Scene& scene, std::uint32_t face, std::uint32_t facet) {
  if (face < scene.faces().size() && facet < scene.facets().size() &&
      scene.facets()[facet].plane < scene.planes().size())
    return;
  fail(SHADOWCUT_REFUSED, "a fragment does not belong to the scene in its present state");
}

shadowcut_range range_of(const FragmentBuffers::Range& range) { return {range.first, range.count}; }

}  // namespace
}  // namespace shadowcut::c

using namespace shadowcut;
using namespace shadowcut::c;

shadowcut_status shadowcut_buffer_layout_init(shadowcut_buffer_layout* layout) {
  const BufferLayout l;
  shadowcut_buffer_layout out{};
  out.doubles = l.doubles, out.indexed = l.indexed, out.normals = l.normals, out.faces = l.faces;
  out.objects = l.objects, out.states = l.states, out.masks = l.masks;
  out.show = static_cast<std::int32_t>(l.show);
  out.hole_share = l.hole_share, out.joined_gap = l.joined_gap;
  return initialise(layout, out);
}
shadowcut_status shadowcut_buffers_info_init(shadowcut_buffers_info* info) {
  return initialise(info, shadowcut_buffers_info{});
}

shadowcut_status shadowcut_buffers_create(uint32_t light, const shadowcut_buffer_layout* layout,
                                          shadowcut_buffers** buffers) {
  return guarded([&] {
    require_pointers(buffers);
    *buffers = new shadowcut_buffers{FragmentBuffers(light, layout_of(layout))};
  });
}
void shadowcut_buffers_destroy(shadowcut_buffers* buffers) { delete buffers; }

shadowcut_status shadowcut_buffers_update(shadowcut_buffers* buffers,
                                          const shadowcut_engine* engine) {
  return guarded([&] {
    FragmentBuffers& b = change(buffers);
    const Changes& changes = changes_of(engine);
    if (buffers->engine != engine->serial) b.forget();
    buffers->engine = engine->serial;
    b.update(engine->engine, changes);
  });
}
shadowcut_status shadowcut_buffers_fill(shadowcut_buffers* buffers, const shadowcut_scene* scene,
                                        const shadowcut_shadows* shadows) {
  return guarded([&] {
    FragmentBuffers& b = change(buffers);
    const Shadows& s = value_of(shadows);
    if (s.areas.size() != value_of(scene).faces().size())
      fail(SHADOWCUT_REFUSED, "the shadows do not belong to the scene in its present state");
    for (const Block& block : s.blocks) {
      for (const Fragment& f : block.fragments) require_in(*scene->scene, f.face, f.facet);
    }
    b.fill(*scene->scene, s);
  });
}
shadowcut_status shadowcut_buffers_fill_partition(shadowcut_buffers* buffers,
                                                  const shadowcut_scene* scene,
                                                  const shadowcut_light_partition* partition) {
  return guarded([&] {
    FragmentBuffers& b = change(buffers);
    const Scene& s = value_of(scene);
    require_pointers(partition);
    for (const LightPartition::Fragment& f : partition->partition.fragments)
      require_in(s, f.face, f.facet);
    b.fill(s, partition->partition);
  });
}
shadowcut_status shadowcut_buffers_set_origin(shadowcut_buffers* buffers, const double* origin) {
  return guarded([&] {
    require_pointers(origin);
    change(buffers).set_origin(Vec3(origin));
  });
}

shadowcut_status shadowcut_buffers_get_info(const shadowcut_buffers* buffers,
                                            shadowcut_buffers_info* info) {
  return guarded([&] {
    require_size(info);
    const FragmentBuffers& b = value_of(buffers);
    *info = {info->size,
             b.vertex_count(),
             b.vertex_capacity(),
             b.index_count(),
             b.index_capacity(),
             b.fragment_count(),
             b.hole_vertices(),
             b.mask_words(),
             b.grown() ? 1 : 0,
             count_of(b.changed_vertices().size()),
             count_of(b.changed_indices().size())};
  });
}
shadowcut_status shadowcut_buffers_stream(const shadowcut_buffers* buffers, int32_t stream,
                                          const void** data, uint32_t* bytes_each) {
  return guarded([&] {
    require_pointers(data);
    require_pointers(bytes_each);
    const Stream found = stream_of(value_of(buffers), stream);
    *data = found.data, *bytes_each = found.bytes_each;
  });
}
shadowcut_status shadowcut_buffers_changed_vertices(const shadowcut_buffers* buffers,
                                                    uint32_t first, uint32_t count,
                                                    shadowcut_range* ranges) {
  return guarded(
      [&] { copy_out(value_of(buffers).changed_vertices(), first, count, ranges, range_of); });
}
shadowcut_status shadowcut_buffers_changed_indices(const shadowcut_buffers* buffers, uint32_t first,
                                                   uint32_t count, shadowcut_range* ranges) {
  return guarded(
      [&] { copy_out(value_of(buffers).changed_indices(), first, count, ranges, range_of); });
}
