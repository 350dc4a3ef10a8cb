#include "svbsp/cell_grid.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "svbsp/descend.hpp"

namespace shadowcut {
namespace {

// Delivers the parts of a cone to the cells that it meets.
template <class Deliver>
class Delivery : public DescentVisitor {
 public:
  Delivery(const LightTables& tables, const KdTree& kd_tree, const Deliver& deliver)
      : tables_(tables), kd_tree_(kd_tree), deliver_(deliver) {}
  CellPredicates cell_predicates() const { return CellPredicates(tables_, {}); }
  bool stops_at(Place, KdTree::Branch here, std::uint32_t&) const { return here.is_cell(); }
  void arrive(Cone* cone, Place place) { deliver_(kd_tree_.branch(place).cell(), cone); }

 private:
  const LightTables& tables_;
  const KdTree& kd_tree_;
  const Deliver& deliver_;
};

}  // namespace

void FacetParts::append(const FacetParts& other) {
  const auto first = static_cast<std::uint32_t>(corners.size());
  corners.insert(corners.end(), other.corners.begin(), other.corners.end());
  for (Part part : other.list) {
    part.first_corner += first;
    list.push_back(part);
  }
}

void CellGrid::divide(std::vector<Vec3> rays, bool far, std::uint32_t facets_per_cell) {
  kd_tree_ = std::make_unique<KdTree>(std::move(rays), far, facets_per_cell, tables_.lines);
}

// Filters a facet through the k-d tree, and keeps its part in every cell. The corners of a part
// that is the whole facet are not kept: it has all its vertices and no edge is bounded.
void CellGrid::filter_into_cells(FacetId facet, FacetParts& parts, Workspace& w) const {
  const std::size_t corners = tables_.facet(facet).corner_count;
  const auto keep = [&](CellId cell, Cone* part) {
    const std::span<const ConeCorner> span = std::as_const(*part).span();
    const bool is_whole =
        span.size() == corners && std::all_of(span.begin(), span.end(), [](const ConeCorner& k) {
          return k.vertex != invalid_index && !k.edge.bounded();
        });
    const auto first = static_cast<std::uint32_t>(parts.corners.size());
    if (!is_whole) parts.corners.insert(parts.corners.end(), span.begin(), span.end());
    parts.list.push_back({cell, facet, first, is_whole ? 0 : part->count, part->error});
    w.pool.give_back(part);
  };
  Delivery delivery(tables_, *kd_tree_, keep);
  visibility_.for_each_cone_of(
      facet, w, [&](Cone* cone) { descend(*kd_tree_, cone, Place::root(), 0, w, delivery); });
}

Cone* CellGrid::cone_of(const FacetParts& parts, const FacetParts::Part& part,
                        ConePool& pool) const {
  if (part.corner_count == 0) return visibility_.cone_of(part.facet, pool);
  Cone* cone = pool.take(part.corner_count + 1);
  cone->facet = part.facet;
  cone->error = part.error;
  cone->assign(std::span(parts.corners).subspan(part.first_corner, part.corner_count));
  return cone;
}

// Chunks of a fixed size: their parts are the same, in the same order, for any number of threads.
std::vector<FacetParts> CellGrid::filter_in_chunks(std::span<const FacetId> order,
                                                   std::size_t size) {
  std::vector<FacetParts> chunks((order.size() + size - 1) / size);
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

FacetParts CellGrid::filter(std::span<const FacetId> order) {
  std::vector<FacetParts> chunks = filter_in_chunks(order, worth_threads);
  FacetParts all;
  if (chunks.size() == 1) {
    all = std::move(chunks[0]);
  } else {
    for (const FacetParts& chunk : chunks) all.append(chunk);
  }
  std::stable_sort(
      all.list.begin(), all.list.end(),
      [](const FacetParts::Part& a, const FacetParts::Part& b) { return a.cell < b.cell; });
  return all;
}

// Facets are filtered through the k-d tree in chunks, then every cell's tree is built from its
// parts in the order of insertion: a cell sees the same parts in the same order for any number of
// threads.
void CellGrid::build(std::span<const FacetId> order, const std::function<void(double)>& report) {
  const std::size_t cell_count = kd_tree_->cell_count();
  SHADOWCUT_ASSERT(cell_count >= 1);
  cells_.resize(cell_count, SvbspTree(tables_, settings_));
  for (SvbspTree& cell : cells_) cell.clear();
  std::vector<FacetParts> chunks;
  if (cell_count > 1) chunks = filter_in_chunks(order, 2048);
  // Sort the parts by cell, keeping their order.
  struct Ref {
    std::uint32_t chunk, part;
  };
  std::vector<std::size_t> begin(cell_count + 1, 0);
  for (const FacetParts& chunk : chunks) {
    for (const FacetParts::Part& part : chunk.list) ++begin[part.cell.value() + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Ref> refs(begin.back());
  SHADOWCUT_ASSERT(std::is_sorted(begin.begin(), begin.end()));
  std::vector<std::size_t> fill(begin.begin(), begin.end() - 1);
  for (std::uint32_t c = 0; c < chunks.size(); ++c) {
    for (std::uint32_t i = 0; i < chunks[c].list.size(); ++i)
      refs[fill[chunks[c].list[i].cell.value()]++] = {c, i};
  }
  Progress progress(report, 0, 0.8, std::max(order.size(), refs.size()));
  parallel_for(cell_count, 1, [&](std::size_t cell) {
    Workspace& w = workspaces_.local();
    SvbspTree& tree = cells_[cell];
    if (cell_count == 1) {
      tree.reserve(order.size());
      for (const FacetId facet : order) {
        visibility_.for_each_cone_of(facet, w, [&](Cone* cone) { insert(tree, cone, w); });
        progress.step();
      }
      return;
    }
    tree.reserve(begin[cell + 1] - begin[cell]);
    for (std::size_t i = begin[cell]; i < begin[cell + 1]; ++i) {
      const FacetParts& chunk = chunks[refs[i].chunk];
      insert(tree, cone_of(chunk, chunk.list[refs[i].part], w.pool), w);
    }
    progress.step(begin[cell + 1] - begin[cell]);
  });
  if (!settings_.edits) return;
  locations_.assign(scene_.objects().size(), Location{});
  for (std::size_t c = cells_.size(); c-- > 0;) {
    cells_[c].end_rebuild();
    for (std::size_t e = cells_[c].pieces.entries().size(); e-- > 0;)
      add_location(CellId(c), EntryId(e));
  }
}

void CellGrid::rebuild(CellId cell, std::span<const FacetId> order, Workspace& w) {
  SvbspTree& tree = (*this)[cell];
  std::map<FacetId, EntryId> entry_of;
  for (std::size_t e = 0; e < tree.pieces.entries().size(); ++e) {
    const FacetId facet = tree.pieces.entries()[e].facet;
    if (facet.valid()) entry_of.emplace(facet, EntryId(e));
  }
  tree.begin_rebuild();
  for (const FacetId facet : order) {
    const auto entry = entry_of.find(facet);
    if (entry == entry_of.end()) continue;
    visibility_.for_each_cone_of(facet, w, [&](Cone* cone) {
      Cone* part = kd_tree_->part_in(cell, cone, CellPredicates(tables_, {}), w);
      if (!part) return;
      part->entry = entry->second;
      insert_at(tree, part, Place::root(), w);
    });
  }
  tree.end_rebuild();
}

// Puts an entry in front of its object's location list.
void CellGrid::add_location(CellId cell, EntryId entry) {
  Entry& e = (*this)[cell].pieces.entry(entry);
  SHADOWCUT_ASSERT(e.facet.valid() && tables_.object_of(e.facet) < locations_.size());
  Location& head = locations_[tables_.object_of(e.facet)];
  e.next = head;
  head = {cell, entry};
}

std::vector<Location> CellGrid::take_locations(std::span<const std::uint32_t> objects) {
  std::vector<Location> taken;
  for (const std::uint32_t o : objects) {
    if (o >= locations_.size()) continue;
    for (Location l = locations_[o]; l.cell.valid(); l = (*this)[l.cell].pieces.entry(l.entry).next)
      taken.push_back(l);
    locations_[o] = {};
  }
  std::sort(taken.begin(), taken.end(), [](const Location& a, const Location& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.entry < b.entry;
  });
  return taken;
}

std::uint64_t CellGrid::pieces_of(std::uint32_t object) const {
  std::uint64_t length = 0;
  for (Location l = locations_[object]; l.cell.valid();) {
    const Entry& e = (*this)[l.cell].pieces.entry(l.entry);
    length += e.pieces;
    l = e.next;
  }
  return length;
}

}  // namespace shadowcut
