#include "light_tree.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "conform.hpp"
#include "id_table.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {
namespace {

Eigen::AlignedBox3d box_of(const Scene& scene) {  // of what the light has to do with
  Eigen::AlignedBox3d box;
  for (const Facet& facet : scene.facets()) {
    if (facet.corner_count == 0) continue;
    const Object& object = scene.objects()[scene.faces()[facet.face].object];
    if (!object.casts && !object.receives) continue;
    for (const Corner& c : scene.corners_of(facet)) box.extend(scene.vertices()[c.vertex]);
  }
  return box;
}

// Calls the user's progress function, from one thread at a time, when at least a percent has been
// added.
class Progress {
 public:
  Progress(const std::function<void(double)>& report, double begin, double end, std::size_t steps)
      : report_(report),
        begin_(begin),
        end_(end),
        steps_(static_cast<double>(std::max<std::size_t>(steps, 1))) {}
  void step(std::size_t n = 1) {
    if (!report_) return;
    const std::lock_guard lock(mutex_);
    const double share = begin_ + (end_ - begin_) * static_cast<double>(done_ += n) / steps_;
    if (share < last_ + 0.01) return;
    last_ = share;
    report_(share);
  }

 private:
  const std::function<void(double)>& report_;
  double begin_, end_, steps_, last_ = 0;
  std::size_t done_ = 0;
  std::mutex mutex_;
};

}  // namespace

std::unique_ptr<LightShadows> make_light_shadows(const Scene& scene, const Light& light,
                                                 const Options& options) {
  return std::make_unique<LightTree>(scene, light, options);
}

LightTree::LightTree(const Scene& scene, const Light& light, const Options& options)
    : scene_(scene), options_(options), light_(light), space_(light, {}) {
  tables_.edits = options.edits;
  tables_.join_threshold = options.join_threshold;
  tables_.least = options.min_feature;
  tables_.space = &space_;
  begin_update();
  rebuild(light);
}

void LightTree::rebuild(const Light& light) {
  note_everything();
  light_ = light;
  space_ = LightSpace(light, box_of(scene_));
  tables_.light_at = light.at;
  build_all();
}

void LightTree::build_all() {
  const auto start = Clock::now();
  shadows_.stats = {};
  refer_to_scene();
  if (is_exact()) {
    tables_.exact = std::make_unique<ExactLight>(light_, space_);
    for (const Object& object : scene_.objects()) note_for_exact(object, *tables_.exact);
  }
  face_the_light();
  fill_tables();
  if (is_exact()) face_exactly();
  std::vector<Vec3> centers;
  const std::vector<std::uint32_t> order = insertion_order(centers);
  tables_.first_prefix_line = static_cast<std::uint32_t>(tables_.lines.size());
  prefix_ = std::make_unique<Prefix>(std::move(centers), space_.far(), options_.facets_per_cell,
                                     tables_.lines);
  tables_.prefix_lines =
      static_cast<std::uint32_t>(tables_.lines.size()) - tables_.first_prefix_line;
  if (is_exact()) span_prefix();
  build(order);
  shadows_.stats.build_ms = ms_since(start);
  const auto built = Clock::now();
  if (is_live()) {
    emit_live();
  } else {
    emit();
  }
  sum_up();
  if (options_.edits) start_edits();
  shadows_.stats.emit_ms = ms_since(built);
}

void LightTree::refer_to_scene() {
  tables_.facets = scene_.facets();
  tables_.objects = scene_.objects();
  tables_.faces = scene_.faces();
  tables_.vertices = scene_.vertices();
  tables_.scene_planes = scene_.planes();
}

bool LightTree::holds_light(const Object& object) const {
  return light_.kind == Light::Kind::point && object.sides == Sides::closed &&
         in_or_on_solid(scene_, object, light_.at);
}

// A face that is partly within reach is treated whole.
bool LightTree::reached(std::uint32_t f) const {
  return within_reach(scene_, scene_.faces()[f], light_);
}

// Whether a facet enters the tree, and how it stands to the light.
void LightTree::face_facet(std::uint32_t i, bool is_reached, bool light_inside) {
  const Facet& facet = scene_.facets()[i];
  const Object& object = scene_.objects()[tables_.object_of(i)];
  const Plane& plane = scene_.planes()[facet.plane];
  turned_[i] = space_.turned(plane);
  tables_.grazed[i] = 0;
  // Seen from afar a plane is all of one piece.
  if (turned_[i] != Turned::edge_on && !space_.far() &&
      !meets_all_corners(scene_, facet, light_.at))
    turned_[i] = Turned::edge_on;
  if (turned_[i] == Turned::edge_on && tables_.exact) {
    // A light this near to the plane may be on different sides of it and of what its corners' rays
    // meet; then there is no region.
    const auto corners = scene_.corners_of(facet);
    const bool all_ahead = std::all_of(corners.begin(), corners.end(), [&](const Corner& c) {
      return tables_.exact->ahead(plane, scene_.vertices()[c.vertex]) > 0;
    });
    const int front = tables_.exact->turned(plane);
    if (front != 0 && all_ahead) turned_[i] = front > 0 ? Turned::toward : Turned::away;
    tables_.grazed[i] = turned_[i] != Turned::edge_on;
  }
  facing_[i] = object.receives ? Facing::away : Facing::ignored;
  enters_[i] = 0;
  tables_.blocks_only[i] = 0;
  if (!is_reached) {
    if (object.receives) facing_[i] = Facing::out_of_reach;
    return;
  }
  if (turned_[i] == Turned::edge_on || (!object.casts && !object.receives)) return;
  const bool turned_off = turned_[i] == Turned::away && object.sides == Sides::closed;
  if (turned_off && !(light_inside && object.casts)) return;
  enters_[i] = 1;
  tables_.blocks_only[i] = turned_off;
  if (!turned_off && object.receives) facing_[i] = Facing::toward;
}

void LightTree::face_the_light() {
  const auto facets = scene_.facets();
  turned_.resize(facets.size());
  facing_.assign(facets.size(), Facing::away);
  enters_.assign(facets.size(), 0);
  tables_.blocks_only.assign(facets.size(), 0);
  tables_.grazed.assign(facets.size(), 0);
  std::vector<std::uint8_t> light_inside(scene_.objects().size(), 0),
      is_reached(scene_.faces().size(), 0);
  parallel_for(light_inside.size(), 16,
               [&](std::size_t o) { light_inside[o] = holds_light(scene_.objects()[o]); });
  parallel_for(is_reached.size(), 256,
               [&](std::size_t f) { is_reached[f] = reached(static_cast<std::uint32_t>(f)); });
  parallel_for(facets.size(), 1024, [&](std::size_t i) {
    if (facets[i].corner_count == 0) return;  // nobody's
    const auto id = static_cast<std::uint32_t>(i);
    face_facet(id, is_reached[facets[i].face], light_inside[tables_.object_of(id)]);
  });
}

void LightTree::make_line(std::uint32_t edge, std::uint32_t id) {
  const Edge& e = scene_.edges()[edge];
  Line& line = tables_.lines[id] =
      rounded(space_.line(scene_.vertices()[e.a], scene_.vertices()[e.b]));
  line.a = e.a, line.b = e.b;
  if (tables_.exact) tables_.ends[id] = {scene_.vertices()[e.a], scene_.vertices()[e.b]};
}

// Rays, lines and planes of what enters. A line's id is its edge's index, until an object moves
// away from planes it leaves behind.
void LightTree::fill_tables() {
  const auto facets = scene_.facets();
  std::vector<std::uint8_t> vertex_used(scene_.vertices().size(), 0),
      edge_used(scene_.edges().size(), 0), plane_used(scene_.planes().size(), 0);
  for (std::size_t i = 0; i < facets.size(); ++i) {
    if (!enters_[i]) continue;
    plane_used[facets[i].plane] = 1;
    for (const Corner& c : scene_.corners_of(facets[i]))
      vertex_used[c.vertex] = 1, edge_used[c.edge >> 1] = 1;
  }
  tables_.rays.resize(vertex_used.size());
  tables_.lines.resize(edge_used.size());
  if (tables_.exact) tables_.ends.resize(edge_used.size());
  tables_.planes.resize(plane_used.size());
  tables_.line_shift.assign(scene_.objects().size(), 0);
  const auto for_used = [](const std::vector<std::uint8_t>& used, const auto& make) {
    parallel_for(used.size(), 4096, [&](std::size_t i) {
      if (used[i]) make(static_cast<std::uint32_t>(i));
    });
  };
  for_used(vertex_used, [this](std::uint32_t i) { make_ray(i); });
  for_used(edge_used, [this](std::uint32_t i) { make_line(i, i); });
  for_used(plane_used, [this](std::uint32_t i) { make_plane(i); });
}

// The exact kernel.

void LightTree::note_for_exact(const Object& object, ExactLight& exact) const {
  for (const Vec3& v : scene_.vertices().subspan(object.first_vertex, object.vertex_count))
    exact.note_position(v);
  for (const Facet& f : scene_.facets().subspan(object.first_facet, object.facet_count)) {
    if (f.corner_count != 0) exact.note_normal(scene_.planes()[f.plane].exact_normal);
  }
}

// The prefix's planes are doubles in the light space; exactly, they go through two points.
void LightTree::span_prefix() {
  tables_.ends.resize(tables_.lines.size());
  for (std::uint32_t id = tables_.first_prefix_line; id < tables_.lines.size(); ++id) {
    const auto [a, b] = tables_.ends[id] =
        space_.span({tables_.lines[id].n[0], tables_.lines[id].n[1], tables_.lines[id].n[2]});
    tables_.lines[id] = rounded(space_.line(a, b));
    tables_.exact->note_position(a);
    tables_.exact->note_position(b);
  }
}

double LightTree::solid_angle(std::uint32_t facet) const {
  const auto corners = scene_.corners_of(scene_.facets()[facet]);
  const auto ray = [&](std::size_t k) {
    const auto& r = tables_.rays[corners[k].vertex].r;
    return Vec3(r[0], r[1], r[2]);
  };
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 1; k + 1 < corners.size(); ++k)
    sum += (ray(k) - ray(0)).cross(ray(k + 1) - ray(0));
  return sum.norm();
}

namespace {

struct Key {
  // objects that cast and stay, that move, and those that do not cast: in this order
  std::uint64_t group;
  double size;
  std::uint32_t id;
  bool operator<(const Key& o) const {
    return group != o.group ? group < o.group : size != o.size ? size > o.size : id < o.id;
  }
};

}  // namespace

// The objects' facets that enter: the largest object first, then its largest facet (sizes of 0
// leave the order as given).
std::vector<std::uint32_t> LightTree::by_object(
    std::span<const std::uint32_t> objects,
    const std::function<double(std::uint32_t)>& size_of) const {
  std::vector<Key> sorted, keys;
  for (const std::uint32_t o : objects) {
    const Object& object = scene_.objects()[o];
    double size = 0;
    for (std::uint32_t i = object.first_facet; i < object.first_facet + object.facet_count; ++i)
      size += enters_[i] ? size_of(i) : 0;
    sorted.push_back(
        {object.casts ? (object.moves && options_.order == Order::solid_angle ? 1u : 0u) : 2u, size,
         o});
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::uint32_t> order;
  for (const Key& o : sorted) {
    const Object& object = scene_.objects()[o.id];
    keys.clear();
    for (std::uint32_t i = object.first_facet; i < object.first_facet + object.facet_count; ++i) {
      if (enters_[i]) keys.push_back({0, size_of(i), i});
    }
    std::sort(keys.begin(), keys.end());
    for (const Key& k : keys) order.push_back(k.id);
  }
  return order;
}

// The facets that enter, in the order of insertion; and each one's middle ray.
std::vector<std::uint32_t> LightTree::insertion_order(std::vector<Vec3>& centers) const {
  const auto facets = scene_.facets();
  std::vector<double> sizes(facets.size(), 0.0);
  parallel_for(facets.size(), 1024, [&](std::size_t i) {
    if (enters_[i] && options_.order == Order::solid_angle)
      sizes[i] = solid_angle(static_cast<std::uint32_t>(i));
  });
  std::vector<std::uint32_t> objects(scene_.objects().size());
  std::iota(objects.begin(), objects.end(), 0u);
  std::vector<std::uint32_t> order = by_object(objects, [&](std::uint32_t i) { return sizes[i]; });
  if (options_.order == Order::random) {
    std::vector<Key> shuffled;
    for (const std::uint32_t i : order) {
      const bool casts = tables_.casts(i);
      shuffled.push_back({mix(options_.seed * 0x9E3779B97F4A7C15ull + i) >> 1 |
                              (casts ? 0 : std::uint64_t{1} << 63),
                          0, i});
    }
    std::sort(shuffled.begin(), shuffled.end());
    std::transform(shuffled.begin(), shuffled.end(), order.begin(),
                   [](const Key& k) { return k.id; });
  }
  centers.resize(options_.facets_per_cell ? order.size() : 0);
  parallel_for(centers.size(), 1024, [&](std::size_t i) {
    Vec3 sum = Vec3::Zero();
    for (const Corner& c : scene_.corners_of(facets[order[i]])) {
      const auto& r = tables_.rays[c.vertex].r;
      sum += Vec3(r[0], r[1], r[2]);
    }
    centers[i] = sum.normalized();
  });
  return order;
}

Cone* LightTree::cone_of_facet(std::uint32_t facet, ConePool& pool) const {
  const auto corners = scene_.corners_of(scene_.facets()[facet]);
  const auto n = static_cast<std::uint32_t>(corners.size());
  Cone* cone = pool.take(n + 1);
  cone->count = n;
  cone->facet = facet;
  cone->error = 0;
  const std::uint32_t shift = tables_.line_shift[tables_.object_of(facet)];
  const bool ahead = forward(facet);
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t i = ahead ? k : n - 1 - k;
    // the one that leaves this corner in this direction
    const std::uint32_t edge = corners[ahead ? i : i == 0 ? n - 1 : i - 1].edge;
    const VertexRay& ray = tables_.rays[corners[i].vertex];
    cone->corners()[k] = {{ray.r[0], ray.r[1], ray.r[2]},
                          EdgeRef((edge >> 1) + shift, ((edge & 1) != 0) == ahead),
                          corners[i].vertex};
    cone->error = std::max(cone->error, ray.error);
  }
  return cone;
}

// Filters a facet through the prefix, and keeps what comes to each cell. A part that is the whole
// facet is not written down: it is told by its edges, no cut, no mark.
void LightTree::filter_into_cells(std::uint32_t facet, Parts& parts, Workspace& w) const {
  const std::size_t corners = scene_.facets()[facet].corner_count;
  const auto keep = [&](std::uint32_t cell, Cone* part) {
    const auto span = part->span();
    const bool is_whole =
        span.size() == corners && std::all_of(span.begin(), span.end(), [](const ConeCorner& k) {
          return k.vertex != none && !k.edge.bounded();
        });
    const auto first = static_cast<std::uint32_t>(parts.corners.size());
    if (!is_whole) parts.corners.insert(parts.corners.end(), span.begin(), span.end());
    parts.list.push_back({cell, facet, first, is_whole ? 0 : part->count, part->error});
    w.pool.give_back(part);
  };
  for_each_cone_of(facet, w, [&](Cone* cone) {
    prefix_->filter(cone, lines(), w.pool, w.spill, w.pending, keep);
  });
}

Cone* LightTree::cone_of_part(const Parts& parts, const Parts::Part& part, ConePool& pool) const {
  if (part.corner_count == 0) return cone_of_facet(part.facet, pool);
  Cone* cone = pool.take(part.corner_count + 1);
  cone->facet = part.facet;
  cone->error = part.error;
  cone->assign(std::span(parts.corners).subspan(part.first_corner, part.corner_count));
  return cone;
}

// Chunks of a fixed size: their parts are the same, in the same order, whatever the number of
// threads.
std::vector<LightTree::Parts> LightTree::filter_in_chunks(const std::vector<std::uint32_t>& order,
                                                          std::size_t size) {
  std::vector<Parts> chunks((order.size() + size - 1) / size);
  const auto filter = [&](std::size_t c) {
    Workspace& w = workspaces_.local();
    for (std::size_t i = c * size; i < std::min(order.size(), (c + 1) * size); ++i)
      filter_into_cells(order[i], chunks[c], w);
  };
  if (chunks.size() > 1) {
    parallel_for(chunks.size(), 1, filter);
  } else if (!chunks.empty()) {
    filter(0);
  }
  return chunks;
}

// Facets are filtered through the prefix in chunks, then every cell's tree is built from its parts
// in the order of insertion: whatever the number of threads, a cell sees the same parts in the same
// order.
void LightTree::build(const std::vector<std::uint32_t>& order) {
  const std::size_t cell_count = prefix_->cell_count();
  cells_.resize(cell_count, CellTree(tables_));
  for (CellTree& cell : cells_) cell.clear();
  std::vector<Parts> chunks;
  if (cell_count > 1) chunks = filter_in_chunks(order, 2048);
  // Sort the parts by cell, keeping their order.
  struct Ref {
    std::uint32_t chunk, part;
  };
  std::vector<std::size_t> begin(cell_count + 1, 0);
  for (const Parts& chunk : chunks) {
    for (const Parts::Part& part : chunk.list) ++begin[part.cell + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Ref> refs(begin.back());
  {
    std::vector<std::size_t> fill(begin.begin(), begin.end() - 1);
    for (std::uint32_t c = 0; c < chunks.size(); ++c) {
      for (std::uint32_t i = 0; i < chunks[c].list.size(); ++i)
        refs[fill[chunks[c].list[i].cell]++] = {c, i};
    }
  }
  Progress progress(options_.progress, 0, 0.8, std::max(order.size(), refs.size()));
  parallel_for(cell_count, 1, [&](std::size_t cell) {
    Workspace& w = workspaces_.local();
    CellTree& tree = cells_[cell];
    if (cell_count == 1) {
      tree.reserve(order.size());
      for (const std::uint32_t facet : order) {
        for_each_cone_of(facet, w, [&](Cone* cone) { tree.insert(cone, w); });
        progress.step();
      }
      return;
    }
    tree.reserve(begin[cell + 1] - begin[cell]);
    for (std::size_t i = begin[cell]; i < begin[cell + 1]; ++i) {
      const Parts& chunk = chunks[refs[i].chunk];
      tree.insert(cone_of_part(chunk, chunk.list[refs[i].part], w.pool), w);
    }
    progress.step(begin[cell + 1] - begin[cell]);
  });
  if (!options_.edits) return;
  locations_.assign(scene_.objects().size(), Location{});
  for (std::size_t c = cells_.size(); c-- > 0;) {
    for (std::size_t e = cells_[c].entries().size(); e-- > 0;)
      link_entry(static_cast<std::uint32_t>(c), static_cast<std::uint32_t>(e));
  }
}

// Puts an entry in front of its object's location list.
void LightTree::link_entry(std::uint32_t cell, std::uint32_t entry) {
  Entry& e = cells_[cell].entries()[entry];
  Location& head = locations_[tables_.object_of(e.facet)];
  e.next = head;
  head = {cell, entry};
}

// Sides turned away never entered: one shadowed fragment a facet, in a block of their own, which
// has room for its corners.
Fragment LightTree::emit_away(std::uint32_t i, std::uint32_t first_corner, Block& away) const {
  const Facet& facet = scene_.facets()[i];
  std::uint32_t at = first_corner;
  for (const Corner& c : scene_.corners_of(facet)) {
    away.corners[at] = scene_.vertices()[c.vertex];
    if (target().constructions) away.constructions[at] = {{}, {}, c.vertex};
    ++at;
  }
  const FragmentId id{static_cast<std::uint32_t>(cells_.size()), i, none};
  return {id,           facet.face,         i,     none,
          first_corner, facet.corner_count, false, area_of_facet(target(), i, false)};
}

void LightTree::emit_all_away(CellOutput& away) const {
  Block& block = away.block;
  for (std::uint32_t i = 0; i < scene_.facets().size(); ++i) {
    if (!stands_away(i)) continue;
    const auto first = static_cast<std::uint32_t>(block.corners.size());
    const auto corners = scene_.corners_of(scene_.facets()[i]);
    block.corners.resize(first + corners.size());
    if (target().constructions) block.constructions.resize(block.corners.size());
    block.fragments.push_back(emit_away(i, first, block));
    if (!target().keep_lines) continue;
    for (const Corner& c : corners) away.edge_lines.push_back(c.edge >> 1);
  }
}

void LightTree::emit() {
  const EmitTarget to = target();
  std::vector<CellOutput> outputs(cells_.size() + 1);
  Progress progress(options_.progress, 0.8, 1, cells_.size());
  parallel_for(cells_.size(), 1, [&](std::size_t cell) {
    emit_cell(cells_[cell], static_cast<std::uint32_t>(cell), options_.form != Form::pieces, to,
              workspaces_.local(), outputs[cell]);
    progress.step();
  });
  emit_all_away(outputs.back());
  // Areas first: conforming moves corners by their last bits, and leaves out slivers that are
  // nothing but those.
  fragment_areas_.assign(scene_.faces().size(), {});
  for (const CellOutput& o : outputs) {
    for (const Fragment& f : o.block.fragments)
      (f.lit ? fragment_areas_[f.face].lit : fragment_areas_[f.face].shadowed) += f.area;
  }
  if (options_.form == Form::conforming) make_conforming(scene_, outputs);
  shadows_.blocks.clear();
  shadows_.blocks.reserve(outputs.size());
  for (CellOutput& o : outputs) shadows_.blocks.push_back(std::move(o.block));
}

// How a face stands to the light, and its whole area, which is not taken from its fragments, so
// that their sum can be held against it.
FaceArea LightTree::whole_area(std::uint32_t f) const {
  const Face& face = scene_.faces()[f];
  FaceArea out;
  for (std::uint32_t i = face.first_facet; i < face.first_facet + face.facet_count; ++i) {
    out.facing = std::max(out.facing, facing_[i]);
    if (facing_[i] != Facing::ignored)
      out.area += area_of_facet(target(), i, facing_[i] == Facing::toward);
  }
  if (out.facing == Facing::ignored) out.area = face.area;
  return out;
}

void LightTree::sum_up() {
  Stats& s = shadows_.stats;
  auto& areas = shadows_.areas;
  areas.assign(scene_.faces().size(), {});
  for (std::uint32_t f = 0; f < areas.size(); ++f) areas[f] = whole_area(f);
  if (is_live()) {
    units_.assign(areas.size(), {});
    for (std::uint32_t f = 0; f < areas.size(); ++f) {
      s.faces += scene_.faces()[f].object != none;
      units_[f] = {unit_for(areas[f].area), areas[f].facing == Facing::toward};
    }
    for (LiveCell& cell : live_) {
      for (const LiveCell::AreaChange& change : cell.area_changes()) absorb(change);
      cell.area_changes().clear();
    }
    for (const Fragment& f : shadows_.blocks.back().fragments)
      absorb({f.face, f.lit, true, f.area});
    total_up();
  } else {
    for (std::size_t f = 0; f < areas.size(); ++f) {
      areas[f].lit = fragment_areas_[f].lit, areas[f].shadowed = fragment_areas_[f].shadowed;
      set_dropped(areas[f]);
    }
    for (const Block& block : shadows_.blocks) {
      for (const Fragment& f : block.fragments) {
        if (areas[f.face].facing == Facing::toward)
          ++(f.lit ? s.lit_fragments : s.shadowed_fragments);
      }
    }
    for (std::uint32_t f = 0; f < areas.size(); ++f) {
      s.faces += scene_.faces()[f].object != none;
      if (areas[f].facing != Facing::toward) continue;
      ++s.facing_faces;
      s.facing_area += areas[f].area, s.lit_area += areas[f].lit,
          s.shadowed_area += areas[f].shadowed;
      s.dropped_area += areas[f].dropped;
    }
  }
  s.facets = static_cast<std::uint64_t>(std::count(enters_.begin(), enters_.end(), 1));
  s.cells = cells_.size();
  s.nodes = s.sp_nodes = prefix_->nodes().size();
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    add_sums(sums_of(c), true);
    s.depth =
        std::max(s.depth, prefix_->depth_of(static_cast<std::uint32_t>(c)) + cells_[c].depth());
  }
  s.bytes += tables_.lines.size() * sizeof(Line) + tables_.rays.size() * sizeof(VertexRay) +
             tables_.planes.size() * sizeof(PlaneRay);
}

LightTree::CellSums LightTree::sums_of(std::size_t c) const {
  const CellTree& tree = cells_[c];
  const Block& block = shadows_.blocks[c];
  const TreeCounts& n = tree.counts();
  return {tree.live_nodes(),
          tree.pp_nodes(),
          tree.live_pieces(),
          tree.local_lines(),
          n.predicates,
          n.signs.on,
          n.signs.by_identity,
          n.signs.by_exact,
          tree.marked_nodes(),
          n.joined,
          n.deferred,
          c < cells_built_again_.size() ? cells_built_again_[c] : 0,
          tree.bytes() + block.fragments.size() * sizeof(Fragment) +
              block.corners.size() * sizeof(Vec3) + (c < live_.size() ? live_[c].bytes() : 0)};
}

void LightTree::add_sums(const CellSums& n, bool more) {
  Stats& s = shadows_.stats;
  const auto add = [more](std::uint64_t& sum, std::uint64_t k) { more ? sum += k : sum -= k; };
  add(s.nodes, n.nodes), add(s.sp_nodes, n.nodes - n.pp_nodes), add(s.pp_nodes, n.pp_nodes),
      add(s.pieces, n.pieces);
  add(s.crossing_lines, n.crossing_lines), add(s.predicates, n.predicates), add(s.on, n.on),
      add(s.marked_nodes, n.marked);
  add(s.by_identity, n.by_identity), add(s.by_exact, n.by_exact);
  s.by_filter = s.predicates - s.by_identity - s.by_exact;
  add(s.joined, n.joined), add(s.deferred, n.deferred), add(s.cells_built_again, n.built_again),
      add(s.bytes, n.bytes);
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
