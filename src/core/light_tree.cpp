#include "light_tree.hpp"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <numeric>

#include "conform.hpp"
#include "id_table.hpp"

namespace shadowcut {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) { return std::chrono::duration<double, std::milli>(Clock::now() - start).count(); }

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

// Calls the user's progress function, from one thread at a time, when at least a percent has been added.
class Progress {
 public:
  Progress(const std::function<void(double)>& report, double begin, double end, std::size_t steps)
      : report_(report), begin_(begin), end_(end), steps_(static_cast<double>(std::max<std::size_t>(steps, 1))) {}
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

template <class Body>
void parallel(std::size_t count, std::size_t grain, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const tbb::blocked_range<std::size_t>& r) {
    for (std::size_t i = r.begin(); i != r.end(); ++i) body(i);
  });
}

}  // namespace

LightTree::LightTree(const Scene& scene, const Light& light, const Options& options)
    : scene_(scene), options_(options), light_(light), space_(light, box_of(scene)) {
  build_all();
}

void LightTree::rebuild(const Light& light) {
  light_ = light;
  space_ = LightSpace(light, box_of(scene_));
  shadows_ = {};
  build_all();
}

void LightTree::build_all() {
  const auto start = Clock::now();
  tables_.facets = scene_.facets();
  tables_.objects = scene_.objects();
  tables_.faces = scene_.faces();
  face_the_light();
  fill_tables();
  std::vector<Vec3> centers;
  const std::vector<std::uint32_t> order = insertion_order(centers);
  prefix_ = std::make_unique<Prefix>(std::move(centers), space_.far(), options_.facets_per_cell, tables_.lines);
  build(order);
  shadows_.stats.build_ms = ms_since(start);
  const auto built = Clock::now();
  emit();
  sum_up();
  shadows_.stats.emit_ms = ms_since(built);
}

// Which facets enter the tree, and how every facet stands to the light.
void LightTree::face_the_light() {
  const auto facets = scene_.facets();
  turned_.resize(facets.size());
  facing_.assign(facets.size(), Facing::away);
  enters_.assign(facets.size(), 0);
  tables_.blocks_only.assign(facets.size(), 0);
  std::vector<std::uint8_t> holds_light(scene_.objects().size(), 0);
  if (light_.kind == Light::Kind::point) {
    parallel(holds_light.size(), 16, [&](std::size_t o) {
      const Object& object = scene_.objects()[o];
      holds_light[o] = object.sides == Sides::closed && in_or_on_solid(scene_, object, light_.at);
    });
  }
  std::vector<std::uint8_t> unreached;  // by face: a face that is partly within reach is treated whole
  if (light_.kind == Light::Kind::point && (std::isfinite(light_.range) || light_.spot)) {
    unreached.resize(scene_.faces().size(), 1);
    parallel(unreached.size(), 256, [&](std::size_t f) {
      const Face& face = scene_.faces()[f];
      for (const Facet& facet : facets.subspan(face.first_facet, face.facet_count)) {
        if (within_reach(scene_, facet, light_)) unreached[f] = 0;
      }
    });
  }
  parallel(facets.size(), 1024, [&](std::size_t i) {
    const Facet& facet = facets[i];
    if (facet.corner_count == 0) return;  // nobody's
    const std::uint32_t o = scene_.faces()[facet.face].object;
    const Object& object = scene_.objects()[o];
    turned_[i] = space_.turned(scene_.planes()[facet.plane]);
    if (!object.receives) facing_[i] = Facing::ignored;
    if (!unreached.empty() && unreached[facet.face]) {
      if (object.receives) facing_[i] = Facing::out_of_reach;
      return;
    }
    if (turned_[i] == Turned::edge_on || (!object.casts && !object.receives)) return;
    const bool turned_off = turned_[i] == Turned::away && object.sides == Sides::closed;
    if (turned_off && !(holds_light[o] && object.casts)) return;
    enters_[i] = 1;
    tables_.blocks_only[i] = turned_off;
    if (!turned_off && object.receives) facing_[i] = Facing::toward;
  });
}

// Rays, lines and planes of what enters.
void LightTree::fill_tables() {
  const auto facets = scene_.facets();
  std::vector<std::uint8_t> vertex_used(scene_.vertices().size(), 0), edge_used(scene_.edges().size(), 0),
      plane_used(scene_.planes().size(), 0);
  for (std::size_t i = 0; i < facets.size(); ++i) {
    if (!enters_[i]) continue;
    plane_used[facets[i].plane] = 1;
    for (const Corner& c : scene_.corners_of(facets[i])) vertex_used[c.vertex] = 1, edge_used[c.edge >> 1] = 1;
  }
  tables_.rays.resize(vertex_used.size());
  tables_.lines.resize(edge_used.size());
  tables_.planes.resize(plane_used.size());
  const auto vertices = scene_.vertices();
  parallel(vertex_used.size(), 4096, [&](std::size_t i) {
    if (vertex_used[i]) tables_.rays[i] = space_.ray(vertices[i]);
  });
  parallel(edge_used.size(), 4096, [&](std::size_t i) {
    const Edge& e = scene_.edges()[i];
    if (!edge_used[i]) return;
    tables_.lines[i] = space_.line(vertices[e.a], vertices[e.b]);
    tables_.lines[i].a = e.a, tables_.lines[i].b = e.b;
  });
  parallel(plane_used.size(), 4096, [&](std::size_t i) {
    if (plane_used[i]) tables_.planes[i] = space_.plane(scene_.planes()[i]);
  });
}

// The facets that enter, in the order of insertion; and each one's middle ray.
std::vector<std::uint32_t> LightTree::insertion_order(std::vector<Vec3>& centers) const {
  const auto facets = scene_.facets();
  struct Key {
    std::uint64_t group;  // objects that cast and stay, that move, and those that do not cast: in this order
    double size;
    std::uint32_t id;
    bool operator<(const Key& o) const { return group != o.group ? group < o.group : size != o.size ? size > o.size : id < o.id; }
  };
  std::vector<double> sizes(facets.size(), 0.0);
  parallel(facets.size(), 1024, [&](std::size_t i) {
    if (!enters_[i] || options_.order != Order::solid_angle) return;
    const auto corners = scene_.corners_of(facets[i]);
    const auto ray = [&](std::size_t k) { return Vec3(tables_.rays[corners[k].vertex].r); };
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 1; k + 1 < corners.size(); ++k) sum += (ray(k) - ray(0)).cross(ray(k + 1) - ray(0));
    sizes[i] = sum.norm();
  });
  // Facets of an object are consecutive, so the objects' ranges sort apart.
  std::vector<Key> objects;
  for (std::uint32_t o = 0; o < scene_.objects().size(); ++o) {
    const Object& object = scene_.objects()[o];
    double size = 0;
    for (std::uint32_t f = object.first_face; f < object.first_face + object.face_count; ++f) {
      for (std::uint32_t k = 0; k < scene_.faces()[f].facet_count; ++k) size += sizes[scene_.faces()[f].first_facet + k];
    }
    objects.push_back({object.casts ? (object.moves && options_.order == Order::solid_angle ? 1u : 0u) : 2u, size, o});
  }
  std::sort(objects.begin(), objects.end());
  std::vector<std::uint32_t> order;
  std::vector<Key> keys;
  for (const Key& o : objects) {
    const Object& object = scene_.objects()[o.id];
    keys.clear();
    for (std::uint32_t f = object.first_face; f < object.first_face + object.face_count; ++f) {
      const Face& face = scene_.faces()[f];
      for (std::uint32_t i = face.first_facet; i < face.first_facet + face.facet_count; ++i) {
        if (enters_[i]) keys.push_back({0, sizes[i], i});
      }
    }
    std::sort(keys.begin(), keys.end());
    for (const Key& k : keys) order.push_back(k.id);
  }
  if (options_.order == Order::random) {
    std::vector<Key> shuffled;
    for (const std::uint32_t i : order) {
      const bool casts = tables_.casts(i);
      shuffled.push_back({mix(options_.seed * 0x9E3779B97F4A7C15ull + i) >> 1 | (casts ? 0 : std::uint64_t{1} << 63), 0, i});
    }
    std::sort(shuffled.begin(), shuffled.end());
    std::transform(shuffled.begin(), shuffled.end(), order.begin(), [](const Key& k) { return k.id; });
  }
  centers.resize(options_.facets_per_cell ? order.size() : 0);
  parallel(centers.size(), 1024, [&](std::size_t i) {
    Vec3 sum = Vec3::Zero();
    for (const Corner& c : scene_.corners_of(facets[order[i]])) sum += Vec3(tables_.rays[c.vertex].r);
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
  const bool ahead = forward(facet);
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t i = ahead ? k : n - 1 - k;
    const std::uint32_t edge = corners[ahead ? i : i == 0 ? n - 1 : i - 1].edge;  // the one that leaves this corner in this direction
    const VertexRay& ray = tables_.rays[corners[i].vertex];
    cone->corners()[k] = {{ray.r[0], ray.r[1], ray.r[2]}, EdgeRef(edge >> 1, ((edge & 1) != 0) == ahead), corners[i].vertex};
    cone->error = std::max(cone->error, ray.error);
  }
  return cone;
}

// Facets are filtered through the prefix in chunks of a fixed size, then every cell's tree is built from its parts in the order of
// insertion: whatever the number of threads, a cell sees the same parts in the same order.
void LightTree::build(const std::vector<std::uint32_t>& order) {
  constexpr std::size_t chunk_size = 2048;
  struct Part {
    std::uint32_t cell;
    std::uint32_t facet;
    std::uint32_t first_corner, corner_count;  // 0: the whole facet
    float error;
  };
  struct Chunk {
    std::vector<Part> parts;
    std::vector<ConeCorner> corners;
  };
  const std::size_t cell_count = prefix_->cell_count();
  cells_.assign(cell_count, CellTree(tables_));
  std::vector<Chunk> chunks((order.size() + chunk_size - 1) / chunk_size);
  tbb::enumerable_thread_specific<Workspace> workspaces;
  const auto line_of = [this](std::uint32_t id) -> const Line& { return tables_.lines[id]; };

  if (cell_count > 1) {
    parallel(chunks.size(), 1, [&](std::size_t c) {
      Workspace& w = workspaces.local();
      Chunk& chunk = chunks[c];
      for (std::size_t i = c * chunk_size; i < std::min(order.size(), (c + 1) * chunk_size); ++i) {
        Cone* whole = cone_of_facet(order[i], w.pool);
        prefix_->filter(whole, tables_.rays, line_of, w.pool, w.spill, w.pending, [&](std::uint32_t cell, Cone* part) {
          const auto first = static_cast<std::uint32_t>(chunk.corners.size());
          // A part never pushed apart from the facet it came from is told by its edges: no cut, no mark.
          bool is_whole = part->count == scene_.facets()[part->facet].corner_count;
          for (const ConeCorner& k : part->span()) is_whole = is_whole && k.vertex != none && !k.edge.bounded();
          if (!is_whole) chunk.corners.insert(chunk.corners.end(), part->corners(), part->corners() + part->count);
          chunk.parts.push_back({cell, part->facet, first, is_whole ? 0 : part->count, part->error});
          w.pool.give_back(part);
        });
      }
    });
  }
  // Sort the parts by cell, keeping their order.
  struct Ref {
    std::uint32_t chunk, part;
  };
  std::vector<std::size_t> begin(cell_count + 1, 0);
  for (const Chunk& chunk : chunks) {
    for (const Part& part : chunk.parts) ++begin[part.cell + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Ref> refs(begin.back());
  {
    std::vector<std::size_t> fill(begin.begin(), begin.end() - 1);
    for (std::uint32_t c = 0; c < chunks.size(); ++c) {
      for (std::uint32_t i = 0; i < chunks[c].parts.size(); ++i) refs[fill[chunks[c].parts[i].cell]++] = {c, i};
    }
  }
  Progress progress(options_.progress, 0, 0.8, std::max(order.size(), refs.size()));
  parallel(cell_count, 1, [&](std::size_t cell) {
    Workspace& w = workspaces.local();
    CellTree& tree = cells_[cell];
    if (cell_count == 1) {
      tree.reserve(order.size());
      for (const std::uint32_t facet : order) {
        tree.insert(cone_of_facet(facet, w.pool), w);
        progress.step();
      }
      return;
    }
    tree.reserve(begin[cell + 1] - begin[cell]);
    for (std::size_t i = begin[cell]; i < begin[cell + 1]; ++i) {
      const Chunk& chunk = chunks[refs[i].chunk];
      const Part& part = chunk.parts[refs[i].part];
      if (part.corner_count == 0) {
        tree.insert(cone_of_facet(part.facet, w.pool), w);
        continue;
      }
      Cone* cone = w.pool.take(part.corner_count + 1);
      cone->facet = part.facet;
      cone->error = part.error;
      cone->assign(std::span(chunk.corners).subspan(part.first_corner, part.corner_count));
      tree.insert(cone, w);
    }
    progress.step(begin[cell + 1] - begin[cell]);
  });
  locations_.assign(scene_.facets().size(), Location{});
  for (std::size_t c = cells_.size(); c-- > 0;) cells_[c].link_locations(static_cast<std::uint32_t>(c), locations_);
}

void LightTree::emit() {
  const bool conforming = options_.form == Form::conforming;
  const EmitTarget target{scene_, space_, tables_, conforming};
  std::vector<CellOutput> outputs(cells_.size() + 1);
  tbb::enumerable_thread_specific<Workspace> workspaces;
  Progress progress(options_.progress, 0.8, 1, cells_.size());
  parallel(cells_.size(), 1, [&](std::size_t cell) {
    emit_cell(cells_[cell], static_cast<std::uint32_t>(cell), options_.form != Form::pieces, target, workspaces.local(), outputs[cell]);
    progress.step();
  });
  // Sides turned away never entered: one shadowed fragment a facet, in a block of their own.
  CellOutput& away = outputs.back();
  for (std::uint32_t i = 0; i < scene_.facets().size(); ++i) {
    const Facet& facet = scene_.facets()[i];
    if (facet.corner_count == 0 || (facing_[i] != Facing::away && facing_[i] != Facing::out_of_reach)) continue;
    const auto first = static_cast<std::uint32_t>(away.block.corners.size());
    for (const Corner& c : scene_.corners_of(facet)) {
      away.block.corners.push_back(scene_.vertices()[c.vertex]);
      if (conforming) away.edge_lines.push_back(c.edge >> 1);
    }
    const FragmentId id{static_cast<std::uint32_t>(cells_.size()), i, none};
    away.block.fragments.push_back({id, facet.face, i, none, first, facet.corner_count, false, area_of_facet(target, i, false)});
  }
  // Areas first: conforming moves corners by their last bits, and leaves out slivers that are nothing but those.
  shadows_.areas.assign(scene_.faces().size(), {});
  for (const CellOutput& o : outputs) {
    for (const Fragment& f : o.block.fragments) (f.lit ? shadows_.areas[f.face].lit : shadows_.areas[f.face].shadowed) += f.area;
  }
  if (conforming) make_conforming(scene_, outputs);
  shadows_.blocks.reserve(outputs.size());
  for (CellOutput& o : outputs) shadows_.blocks.push_back(std::move(o.block));
}

void LightTree::sum_up() {
  Stats& s = shadows_.stats;
  auto& areas = shadows_.areas;
  for (std::size_t i = 0; i < facing_.size(); ++i) {
    if (scene_.facets()[i].corner_count == 0) continue;
    areas[scene_.facets()[i].face].facing = std::max(areas[scene_.facets()[i].face].facing, facing_[i]);
  }
  for (std::size_t f = 0; f < areas.size(); ++f) {
    if (areas[f].facing == Facing::ignored) areas[f].area = scene_.faces()[f].area;
  }
  for (const Block& block : shadows_.blocks) {
    s.bytes += block.fragments.size() * sizeof(Fragment) + block.corners.size() * sizeof(Vec3);
    for (const Fragment& f : block.fragments) {
      if (areas[f.face].facing == Facing::toward) ++(f.lit ? s.lit_fragments : s.shadowed_fragments);
    }
  }
  // A face's area is not taken from its fragments, so that their sum can be held against it.
  const EmitTarget target{scene_, space_, tables_, false};
  for (std::uint32_t i = 0; i < facing_.size(); ++i) {
    if (facing_[i] == Facing::ignored || scene_.facets()[i].corner_count == 0) continue;
    areas[scene_.facets()[i].face].area += area_of_facet(target, i, facing_[i] == Facing::toward);
  }
  for (const FaceArea& a : areas) {
    ++s.faces;
    if (a.facing != Facing::toward) continue;
    ++s.facing_faces;
    s.facing_area += a.area, s.lit_area += a.lit, s.shadowed_area += a.shadowed;
  }
  s.facets = static_cast<std::uint64_t>(std::count(enters_.begin(), enters_.end(), 1));
  s.cells = cells_.size();
  s.nodes = prefix_->nodes().size();
  s.sp_nodes = s.nodes;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const CellTree& tree = cells_[c];
    s.nodes += tree.nodes().size();
    s.sp_nodes += tree.nodes().size() - tree.pp_nodes();
    s.pp_nodes += tree.pp_nodes();
    s.pieces += tree.pieces().size();
    s.crossing_lines += tree.local_lines();
    s.predicates += tree.counts().predicates;
    s.on += tree.counts().on;
    s.depth = std::max(s.depth, prefix_->depth_of(static_cast<std::uint32_t>(c)) + tree.depth());
    s.bytes += tree.bytes();
  }
  s.bytes += tables_.lines.size() * sizeof(Line) + tables_.rays.size() * sizeof(VertexRay) + tables_.planes.size() * sizeof(PlaneRay);
}

}  // namespace shadowcut
