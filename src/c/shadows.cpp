// Shadows of one light, and partitions by several, of c.h.
#include "handles.hpp"

namespace shadowcut::c {

const Shadows& value_of(const shadowcut_shadows* shadows) {
  require_pointers(shadows);
  if (!shadows->shadows)
    fail(SHADOWCUT_NOT_FOUND, "there is no such light, or the engine must be compacted");
  return *shadows->shadows;
}

shadowcut_fragment fragment_of(const Fragment& f) {
  return {{f.id.cell, f.id.piece, f.id.place},
          f.face,
          f.facet,
          f.caster,
          f.first_corner,
          f.corner_count,
          f.lit ? 1 : 0,
          f.area};
}
shadowcut_face_area area_of(const FaceArea& a) {
  return {static_cast<std::int32_t>(a.facing), a.area, a.lit, a.shadowed, a.dropped};
}

Options options_of(const shadowcut_options* options) {
  Options out;
  if (!options) return out;
  require_size(options);
  out.kernel = enum_of(options->kernel, Kernel::exact);
  out.form = enum_of(options->form, Form::conforming);
  out.threads = options->threads;
  out.min_feature = {options->min_area, options->min_solid_angle};
  out.constructions = flag(options->constructions);
  const shadowcut_tuning& tuning = options->tuning;
  out.tuning = {enum_of(tuning.order, Order::random), tuning.seed, tuning.facets_per_cell,
                flag(tuning.incremental), tuning.join_threshold};
  return out;
}

namespace {

const Block& block_of(const shadowcut_shadows* shadows, std::uint32_t block) {
  const Shadows& all = value_of(shadows);
  require(block < all.blocks.size(), "there is no such block");
  return all.blocks[block];
}

shadowcut_light_line line_of(const LightLine& line) {
  shadowcut_light_line out{};
  out.crossing = line.crossing;
  for (std::size_t k = 0; k < line.v.size(); ++k) copy(line.v[k], out.v[k]);
  return out;
}

const LightPartition& value_of(const shadowcut_light_partition* partition) {
  require_pointers(partition);
  return partition->partition;
}

}  // namespace
}  // namespace shadowcut::c

using namespace shadowcut;
using namespace shadowcut::c;

shadowcut_status shadowcut_options_init(shadowcut_options* options) {
  const Options o;
  const Options::Tuning& t = o.tuning;
  return initialise(
      options, shadowcut_options{0,
                                 static_cast<std::int32_t>(o.kernel),
                                 static_cast<std::int32_t>(o.form),
                                 o.threads,
                                 o.min_feature.area,
                                 o.min_feature.solid_angle,
                                 o.constructions,
                                 {static_cast<std::int32_t>(t.order), t.seed, t.facets_per_cell,
                                  t.incremental, t.join_threshold}});
}
shadowcut_status shadowcut_stats_init(shadowcut_stats* stats) {
  return initialise(stats, shadowcut_stats{});
}

shadowcut_status shadowcut_cast_shadows(const shadowcut_scene* scene, const shadowcut_light* light,
                                        const shadowcut_options* options,
                                        shadowcut_shadows** shadows) {
  return guarded([&] {
    require_pointers(shadows);
    auto own = std::make_unique<shadowcut_shadows>();
    own->own = cast_shadows(value_of(scene), light_of(light), options_of(options));
    own->shadows = &own->own;
    *shadows = own.release();
  });
}
void shadowcut_shadows_destroy(shadowcut_shadows* shadows) {
  if (shadows && shadows->shadows == &shadows->own) delete shadows;  // an engine's go with it
}

shadowcut_status shadowcut_shadows_block_count(const shadowcut_shadows* shadows,
                                               uint32_t* block_count) {
  return guarded([&] {
    require_pointers(block_count);
    *block_count = count_of(value_of(shadows).blocks.size());
  });
}
shadowcut_status shadowcut_shadows_fragment_count(const shadowcut_shadows* shadows, uint32_t block,
                                                  uint32_t* fragment_count) {
  return guarded([&] {
    require_pointers(fragment_count);
    *fragment_count = count_of(block_of(shadows, block).fragments.size());
  });
}
shadowcut_status shadowcut_shadows_fragments(const shadowcut_shadows* shadows, uint32_t block,
                                             uint32_t first, uint32_t count,
                                             shadowcut_fragment* fragments) {
  return guarded([&] {
    copy_out(std::span(block_of(shadows, block).fragments), first, count, fragments, fragment_of);
  });
}
shadowcut_status shadowcut_shadows_corners(const shadowcut_shadows* shadows, uint32_t block,
                                           const double** xyz, uint32_t* corner_count) {
  return guarded([&] {
    require_pointers(xyz, corner_count);
    const std::vector<Vec3>& corners = block_of(shadows, block).corners;
    *corner_count = count_of(corners.size());
    *xyz = numbers_of(corners);
  });
}

shadowcut_status shadowcut_shadows_construction_count(const shadowcut_shadows* shadows,
                                                      uint32_t block, uint32_t* count) {
  return guarded([&] {
    require_pointers(count);
    *count = count_of(block_of(shadows, block).constructions.size());
  });
}
shadowcut_status shadowcut_shadows_constructions(const shadowcut_shadows* shadows, uint32_t block,
                                                 uint32_t first, uint32_t count,
                                                 shadowcut_construction* constructions) {
  return guarded([&] {
    copy_out(std::span(block_of(shadows, block).constructions), first, count, constructions,
             [](const Construction& x) {
               return shadowcut_construction{line_of(x.in), line_of(x.out), x.vertex};
             });
  });
}

shadowcut_status shadowcut_shadows_area_count(const shadowcut_shadows* shadows,
                                              uint32_t* face_count) {
  return guarded([&] {
    require_pointers(face_count);
    *face_count = count_of(value_of(shadows).areas.size());
  });
}
shadowcut_status shadowcut_shadows_areas(const shadowcut_shadows* shadows, uint32_t first,
                                         uint32_t count, shadowcut_face_area* areas) {
  return guarded(
      [&] { copy_out(std::span(value_of(shadows).areas), first, count, areas, area_of); });
}

shadowcut_status shadowcut_shadows_stats(const shadowcut_shadows* shadows, shadowcut_stats* stats) {
  return guarded([&] {
    require_size(stats);
    const Stats& s = value_of(shadows).stats;
    *stats = {stats->size,
              s.faces,
              s.facing_faces,
              s.facets,
              s.facing_area,
              s.lit_area,
              s.shadowed_area,
              s.dropped_area,
              s.lit_fragments,
              s.shadowed_fragments,
              s.cells,
              s.nodes,
              s.sp_nodes,
              s.pp_nodes,
              s.pieces,
              s.crossing_lines,
              s.predicates,
              s.on,
              s.by_identity,
              s.by_filter,
              s.by_exact,
              s.depth,
              s.bytes,
              s.build_ms,
              s.emit_ms,
              s.marked_nodes,
              s.longest_location_list,
              s.cells_rebuilt,
              s.joined,
              s.deferred};
  });
}

void shadowcut_light_partition_destroy(shadowcut_light_partition* partition) { delete partition; }

shadowcut_status shadowcut_light_partition_count(const shadowcut_light_partition* partition,
                                                 uint32_t* fragment_count, uint32_t* mask_words) {
  return guarded([&] {
    require_pointers(fragment_count, mask_words);
    const LightPartition& s = value_of(partition);
    *fragment_count = count_of(s.fragments.size()), *mask_words = count_of(s.words);
  });
}
shadowcut_status shadowcut_light_partition_fragments(const shadowcut_light_partition* partition,
                                                     uint32_t first, uint32_t count,
                                                     shadowcut_partition_fragment* fragments) {
  return guarded([&] {
    copy_out(std::span(value_of(partition).fragments), first, count, fragments,
             [](const LightPartition::Fragment& f) {
               return shadowcut_partition_fragment{f.face, f.facet, f.first_corner, f.corner_count};
             });
  });
}
shadowcut_status shadowcut_light_partition_masks(const shadowcut_light_partition* partition,
                                                 const uint64_t** masks) {
  return guarded([&] {
    require_pointers(masks);
    *masks = value_of(partition).lights.data();
  });
}
shadowcut_status shadowcut_light_partition_corners(const shadowcut_light_partition* partition,
                                                   const double** xyz, uint32_t* corner_count) {
  return guarded([&] {
    require_pointers(xyz, corner_count);
    *corner_count = count_of(value_of(partition).corners.size());
    *xyz = numbers_of(partition->partition.corners);
  });
}
