// Edits of a finished light tree: objects out, objects in, and what that changed.

#include <algorithm>
#include <cmath>

#include "light_tree.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {
namespace {

constexpr double growth_allowed = 1.1;      // of a cell, by edits
constexpr double growth_borne = 1.75;       // with patience
constexpr std::uint64_t edits_allowed = 4;  // for each entry of a cell
constexpr std::size_t most_movers = 4;      // that a cell keeps in mind
constexpr std::uint32_t most_patience = 6;
constexpr std::size_t worth_threads = 128;  // facets, or parts of them, that an edit has to do with

// A ray less certain than this has come too near to a far light for the numbers of its frame.
constexpr float largest_ray_error = static_cast<float>(256 * unit_roundoff);

bool differ(const FaceArea& a, const FaceArea& b) {
  return a.facing != b.facing || a.area != b.area || a.lit != b.lit || a.shadowed != b.shadowed ||
         a.dropped != b.dropped;
}

}  // namespace

// After a build: what edits keep books of.
void LightTree::start_edits() {
  sums_.resize(cells_.size());
  fresh_.assign(cells_.size(), {});
  cells_built_again_.assign(cells_.size(), 0);
  for (std::uint32_t c = 0; c < cells_.size(); ++c) {
    sums_[c] = sums_of(c);
    note_fresh(c);
  }
  touched_in_.assign(cells_.size(), 0);
  touched_.clear();
  noted_in_.resize(scene_.faces().size(), 0);
  line_blocks_.clear();
  free_blocks_.clear();
  block_of_object_.assign(scene_.objects().size(), none);
  block_of_line_.assign(tables_.lines.size(), none);
  for (std::uint32_t o = 0; o < scene_.objects().size(); ++o) {
    const Object& object = scene_.objects()[o];
    if (!object.alive) continue;
    block_of_object_[o] = static_cast<std::uint32_t>(line_blocks_.size());
    std::fill_n(block_of_line_.begin() + object.first_edge, object.edge_count, block_of_object_[o]);
    line_blocks_.push_back({object.first_edge, object.edge_count, 0, false});
  }
  for (std::uint32_t o = 0; o < scene_.objects().size(); ++o) note_location_list(o);
}

void LightTree::note_location_list(std::uint32_t object) {
  std::uint64_t length = 0;
  for (Location l = locations_[object]; l.cell != none;) {
    const Entry& e = cells_[l.cell].entries()[l.entry];
    length += e.pieces;
    l = e.next;
  }
  shadows_.stats.longest_location_list = std::max(shadows_.stats.longest_location_list, length);
}

void LightTree::emit_live() {
  live_.clear();
  live_.reserve(cells_.size());
  for (std::uint32_t c = 0; c < cells_.size(); ++c)
    live_.emplace_back(c, options_.form != Form::pieces);
  shadows_.blocks.resize(cells_.size() + 1);
  const EmitTarget to = target();
  parallel_for(cells_.size(), 1, [&](std::size_t c) {
    live_[c].start(cells_[c], to, workspaces_.local(), shadows_.blocks[c], update_);
    cells_[c].set_live(&live_[c]);
  });
  shadows_.blocks.back() = {};
  away_.assign(scene_.facets().size(), none);
  away_born_.assign(scene_.facets().size(), update_);
  CellOutput out;
  emit_all_away(out);
  for (std::uint32_t i = 0; i < out.block.fragments.size(); ++i)
    away_[out.block.fragments[i].facet] = i;
  shadows_.blocks.back() = std::move(out.block);
  away_corners_.clear();
}

void LightTree::begin_update() {
  ++update_;
  rebuilt_ = edited_ = false;
  touched_.clear();
  batch_.clear();
  gone_.clear();
  away_added_.clear();
  noted_.clear();
  before_.clear();
}

void LightTree::note_first(std::uint32_t face) {
  if (noted_in_.size() < scene_.faces().size()) noted_in_.resize(scene_.faces().size(), 0);
  noted_in_[face] = update_;
  noted_.push_back({face, face < shadows_.areas.size() ? shadows_.areas[face] : FaceArea{}});
}

// Before a rebuild: what there was will be gone.
void LightTree::note_everything() {
  for (std::uint32_t f = 0; f < scene_.faces().size(); ++f) note(f);
  if (shadows_.blocks.empty()) {  // the first build
    rebuilt_ = true;
    return;
  }
  if (is_live()) {
    for (std::size_t c = 0; c < live_.size(); ++c)
      live_[c].list_old(shadows_.blocks[c], update_, gone_);
    for (const Fragment& f : shadows_.blocks.back().fragments) {
      if (away_born_[f.facet] != update_) gone_.push_back(f.id);
    }
  } else if (!rebuilt_) {
    for (const Block& block : edited_ ? before_ : shadows_.blocks) {
      for (const Fragment& f : block.fragments) gone_.push_back(f.id);
    }
  }
  rebuilt_ = true;
  batch_.clear();
}

// Runs edit(cell, index in cells) for every cell; on several threads if the work is worth it.
template <class Edit>
void LightTree::edit_cells(std::span<const std::uint32_t> cells, std::size_t work,
                           const Edit& edit) {
  const auto one = [&](std::size_t i) {
    if (is_live()) live_[cells[i]].begin(shadows_.blocks[cells[i]], update_);
    edit(cells[i], i);
  };
  if (cells.size() > 1 && work >= worth_threads) {
    parallel_for(cells.size(), 1, one);
  } else {
    for (std::size_t i = 0; i < cells.size(); ++i) one(i);
  }
  for (const std::uint32_t c : cells) {
    if (touched_in_[c] == update_) continue;
    touched_in_[c] = update_;
    touched_.push_back(c);
  }
}

void LightTree::remove_objects(std::span<const std::uint32_t> objects) {
  if (!is_live() && !edited_) before_ = shadows_.blocks;
  edited_ = true;
  std::vector<Location> parts;
  for (const std::uint32_t o : objects) {
    if (o >= locations_.size()) continue;
    for (Location l = locations_[o]; l.cell != none; l = cells_[l.cell].entries()[l.entry].next)
      parts.push_back(l);
    locations_[o] = {};
  }
  std::sort(parts.begin(), parts.end(), [](const Location& a, const Location& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.entry < b.entry;
  });
  std::vector<std::uint32_t> cells, entries;
  std::vector<std::size_t> begins;
  for (const Location& l : parts) {
    if (cells.empty() || cells.back() != l.cell)
      cells.push_back(l.cell), begins.push_back(entries.size());
    entries.push_back(l.entry);
  }
  begins.push_back(entries.size());
  std::vector<std::vector<std::uint32_t>> kept(cells.size()), given_up(cells.size());
  edit_cells(cells, parts.size(), [&](std::uint32_t c, std::size_t i) {
    cells_[c].remove(std::span(entries).subspan(begins[i], begins[i + 1] - begins[i]),
                     workspaces_.local(), kept[i], given_up[i]);
    fresh_[c].stirred = fresh_[c].stirred || is_much(c, cells_[c].displaced_last());
  });
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (const std::uint32_t line : kept[i]) count_line(line, true);
    for (const std::uint32_t line : given_up[i]) count_line(line, false);
  }
  absorb(cells);
  batch_.insert(batch_.end(), cells.begin(), cells.end());
  for (const std::uint32_t o : objects) {
    if (o >= block_of_object_.size()) continue;
    leave_lines(o);
    const Object& object = scene_.objects()[o];
    for (std::uint32_t i = object.first_facet; i < object.first_facet + object.facet_count; ++i) {
      shadows_.stats.facets -= enters_[i];
      enters_[i] = 0;
      remove_away(i);
    }
    for (std::uint32_t f = object.first_face; f < object.first_face + object.face_count; ++f) {
      note(f);
      set_area(f, {});
      --shadows_.stats.faces;
    }
  }
}

void LightTree::insert_objects(std::span<const std::uint32_t> objects) {
  refer_to_scene();
  if (!suits_numbers(objects)) return rebuild(Light(light_));
  grow();
  std::vector<std::uint32_t> alive;
  for (const std::uint32_t o : objects) {
    if (scene_.objects()[o].alive) {
      alive.push_back(o);
    } else {
      give_lines_back(o);
    }
  }
  face_objects(alive);
  insert_into_cells(by_object(alive, [this](std::uint32_t i) { return size_in_order(i); }));
  for (const std::uint32_t o : alive) note_location_list(o);
  batch_.clear();
}

LightTree::Parts LightTree::filter_into_cells(const std::vector<std::uint32_t>& order) {
  std::vector<Parts> chunks = filter_in_chunks(order, worth_threads);
  if (chunks.size() == 1) return std::move(chunks[0]);
  Parts all;
  for (const Parts& chunk : chunks) {
    const auto first = static_cast<std::uint32_t>(all.corners.size());
    all.corners.insert(all.corners.end(), chunk.corners.begin(), chunk.corners.end());
    for (Parts::Part part : chunk.list) {
      part.first_corner += first;
      all.list.push_back(part);
    }
  }
  return all;
}

// Filters facets through the prefix, and inserts their parts into the cells; settles what has been
// changed since objects were removed.
void LightTree::insert_into_cells(const std::vector<std::uint32_t>& order) {
  Parts parts = filter_into_cells(order);
  std::stable_sort(parts.list.begin(), parts.list.end(),
                   [](const Parts::Part& a, const Parts::Part& b) { return a.cell < b.cell; });
  std::vector<std::uint32_t> entries(parts.list.size());
  for (const Parts::Part& part : parts.list) batch_.push_back(part.cell);
  sort_unique(batch_);
  const EmitTarget to = target();
  std::vector<std::vector<std::uint32_t>> given_up(batch_.size());
  edit_cells(batch_, parts.list.size(), [&](std::uint32_t c, std::size_t i) {
    Workspace& w = workspaces_.local();
    auto part =
        std::lower_bound(parts.list.begin(), parts.list.end(), c,
                         [](const Parts::Part& p, std::uint32_t cell) { return p.cell < cell; });
    for (; part != parts.list.end() && part->cell == c; ++part) {
      const std::uint32_t object = tables_.object_of(part->facet);
      note_mover(fresh_[c], object);
      std::uint32_t& entry = entries[static_cast<std::size_t>(part - parts.list.begin())];
      entry = cells_[c].insert(cone_of_part(parts, *part, w.pool), w);
      note_shattered(c, entry, object);
    }
    if (has_grown(c)) {
      build_again(c, given_up[i], w);
    } else if (is_live()) {
      live_[c].settle(cells_[c], to, w);
    }
  });
  for (const auto& lines : given_up) {
    for (const std::uint32_t line : lines) count_line(line, false);
  }
  for (std::size_t i = 0; i < entries.size(); ++i) link_entry(parts.list[i].cell, entries[i]);
  absorb(batch_);
}

// Keeps count of what has been inserted since a cell was built.
void LightTree::note_mover(Fresh& fresh, std::uint32_t object) const {
  ++fresh.edits;
  const auto known = std::find_if(fresh.movers.begin(), fresh.movers.end(),
                                  [object](const auto& m) { return m.object == object; });
  if (known != fresh.movers.end()) {
    known->times += known->update != update_;
    known->update = update_;
    std::rotate(known, known + 1, fresh.movers.end());
    return;
  }
  ++fresh.changes_of_mover;
  if (fresh.movers.size() == most_movers) fresh.movers.erase(fresh.movers.begin());
  fresh.movers.push_back({object, update_, 1});
}

// A large face that comes last is cut by all that was there before it, and one that goes leaves all
// that was behind it to be inserted last: better the cell is built again, with every face where it
// belongs.
bool LightTree::is_much(std::uint32_t c, std::size_t pieces) const {
  return pieces >= 16 && 12 * pieces >= cells_[c].live_pieces();
}

void LightTree::note_shattered(std::uint32_t c, std::uint32_t entry, std::uint32_t object) {
  if (!is_much(c, cells_[c].entries()[entry].pieces)) return;
  fresh_[c].stirred = true;
  for (Fresh::Mover& m : fresh_[c].movers) {
    if (m.object == object) m.times = 0;
  }
}

// Edits leave faces cut, and insert them in an order that nobody would choose. A cell that has
// grown by a tenth since it was built is built again; and so is one that several objects have come
// to and left many times over, because what it should have grown to is then no longer known. In the
// long run that costs in proportion to the growth, and to the edits. (An object that goes to and
// fro is no reason.) Where the same objects move that moved before the cell was built, it waits
// until as much has been inserted as a build inserts, and each time twice as long, unless it has
// grown by far: what a desk does to its cell while it is dragged through it, its next step does
// again; but several that take turns cut each other smaller and smaller.
bool LightTree::has_grown(std::uint32_t c) const {
  const Fresh& fresh = fresh_[c];
  const std::size_t entries = cells_[c].live_entries();
  const auto exceeds = [&](double growth) {
    return static_cast<double>(cells_[c].live_nodes()) >
           growth * fresh.nodes_per_entry * static_cast<double>(entries) + 4;
  };
  const std::uint32_t patience = exceeds(growth_borne) ? 0 : fresh.patience;
  if (fresh.changes_of_mover == 0 && fresh.edits < entries << patience) return false;
  return fresh.stirred || exceeds(growth_allowed) ||
         (fresh.edits > edits_allowed * entries + 64 && fresh.changes_of_mover >= most_movers);
}

void LightTree::note_fresh(std::uint32_t c) {
  fresh_[c].nodes_per_entry =
      static_cast<double>(cells_[c].live_nodes()) /
      static_cast<double>(std::max<std::size_t>(cells_[c].live_entries(), 1));
  fresh_[c].edits = fresh_[c].changes_of_mover = 0;
  fresh_[c].stirred = false;
}

// A cell's tree, from its entries in the order of a build.
void LightTree::build_again(std::uint32_t c, std::vector<std::uint32_t>& given_up, Workspace& w) {
  CellTree& tree = cells_[c];
  std::vector<std::uint32_t> objects;
  std::map<std::uint32_t, std::uint32_t> entry_of;  // by facet
  for (std::uint32_t e = 0; e < tree.entries().size(); ++e) {
    const std::uint32_t facet = tree.entries()[e].facet;
    if (facet == none) continue;
    entry_of.emplace(facet, e);
    objects.push_back(tables_.object_of(facet));
  }
  sort_unique(objects);
  tree.set_live(nullptr);
  tree.start_again(given_up);
  const auto insert = [&](std::span<const std::uint32_t> some) {
    for (const std::uint32_t facet :
         by_object(some, [this](std::uint32_t i) { return size_in_order(i); })) {
      const auto entry = entry_of.find(facet);
      if (entry == entry_of.end()) continue;
      for_each_cone_of(facet, w, [&](Cone* cone) {
        Cone* part = prefix_->part_in(c, cone, lines(), w.pool, w.spill);
        if (part) tree.insert_again(entry->second, part, w);
      });
    }
  };
  // What moves again and again, while others do not, stays at the leaves (CS95, section 4). But not
  // so much of the cell that it is no build any more.
  std::vector<std::uint32_t> at_leaves;
  for (const auto& m : fresh_[c].movers) {
    const bool here = std::binary_search(objects.begin(), objects.end(), m.object);
    if (m.times >= 2 * objects.size() && here && tables_.objects[m.object].casts &&
        at_leaves.size() < objects.size() / 4)
      at_leaves.push_back(m.object);
  }
  std::erase_if(objects, [&](std::uint32_t o) {
    return std::find(at_leaves.begin(), at_leaves.end(), o) != at_leaves.end();
  });
  insert(objects);
  for (const std::uint32_t& o : at_leaves) insert({&o, 1});
  if (is_live()) {
    live_[c].start_again(tree, target(), w);
    tree.set_live(&live_[c]);
  }
  fresh_[c].patience =
      fresh_[c].changes_of_mover == 0 ? std::min(fresh_[c].patience + 1, most_patience) : 0;
  note_fresh(c);
  ++cells_built_again_[c];
}

bool LightTree::suits_numbers(std::span<const std::uint32_t> objects) const {
  if (!space_.far()) return true;  // one rounding a coordinate, wherever they are
  for (const std::uint32_t o : objects) {
    const Object& object = scene_.objects()[o];
    if (!object.casts && !object.receives) continue;
    for (const Vec3& v : scene_.vertices().subspan(object.first_vertex, object.vertex_count)) {
      if (space_.ray(v).error > largest_ray_error) return false;
    }
  }
  return true;
}

// Room for what the scene has more of.
void LightTree::grow() {
  const auto to = [](auto& v, std::size_t size, const auto& filler) {
    if (v.size() < size) v.resize(size, filler);
  };
  const std::size_t facets = scene_.facets().size(), faces = scene_.faces().size(),
                    objects = scene_.objects().size();
  to(turned_, facets, Turned::edge_on);
  to(shapes_, facets, std::uint8_t{convex});
  to(facing_, facets, Facing::away);
  to(enters_, facets, std::uint8_t{0});
  to(tables_.blocks_only, facets, std::uint8_t{0});
  to(tables_.grazed, facets, std::uint8_t{0});
  to(away_, facets, none);
  to(away_born_, facets, 0u);
  to(tables_.rays, scene_.vertices().size(), VertexRay{});
  to(tables_.planes, scene_.planes().size(), PlaneRay{});
  to(tables_.line_shift, objects, 0u);
  to(locations_, objects, Location{});
  to(block_of_object_, objects, none);
  to(shadows_.areas, faces, FaceArea{});
  to(units_, faces, Units{});
}

// Everything about objects that does not depend on other objects. What they share is done for one
// after the other.
void LightTree::face_objects(std::span<const std::uint32_t> objects) {
  std::size_t facets = 0;
  for (const std::uint32_t o : objects) {
    const Object& object = scene_.objects()[o];
    facets += object.facet_count;
    if (is_exact()) note_for_exact(object, *tables_.exact);
  }
  const auto for_each = [&](const auto& f) {
    if (facets >= worth_threads)
      return parallel_for(objects.size(), 4, [&](std::size_t i) { f(objects[i]); });
    for (const std::uint32_t o : objects) f(o);
  };
  for_each([this](std::uint32_t o) { face_facets(o); });
  for (const std::uint32_t o : objects) {
    const Object& object = scene_.objects()[o];
    const auto enters = enters_.begin() + object.first_facet;
    if (std::find(enters, enters + object.facet_count, 1) != enters + object.facet_count)
      take_lines(o);
    for (std::uint32_t f = object.first_face; f < object.first_face + object.face_count; ++f)
      note(f);
  }
  for_each([this](std::uint32_t o) { fill_tables(o); });
  for (const std::uint32_t o : objects) {
    const Object& object = scene_.objects()[o];
    shadows_.stats.faces += object.face_count;
    for (std::uint32_t i = object.first_facet; i < object.first_facet + object.facet_count; ++i) {
      shadows_.stats.facets += enters_[i];
      if (stands_away(i)) insert_away(i);
    }
  }
}

void LightTree::face_facets(std::uint32_t o) {
  const Object& object = scene_.objects()[o];
  const bool light_inside = holds_light(object);
  for (std::uint32_t f = object.first_face; f < object.first_face + object.face_count; ++f) {
    const Face& face = scene_.faces()[f];
    const bool is_reached = reached(f);
    for (std::uint32_t i = face.first_facet; i < face.first_facet + face.facet_count; ++i)
      face_facet(i, is_reached, light_inside);
  }
}

// An object's part of the tables, and the whole areas of its faces.
void LightTree::fill_tables(std::uint32_t o) {
  const Object& object = scene_.objects()[o];
  const auto facets_end = object.first_facet + object.facet_count;
  bool any = false;
  for (std::uint32_t i = object.first_facet; i < facets_end; ++i) {
    if (!enters_[i]) continue;
    any = true;
    make_plane(scene_.facets()[i].plane);
  }
  if (any) {
    const std::uint32_t shift = tables_.line_shift[o];
    for (std::uint32_t i = 0; i < object.vertex_count; ++i) make_ray(object.first_vertex + i);
    for (std::uint32_t i = object.first_edge; i < object.first_edge + object.edge_count; ++i)
      make_line(i, i + shift);
    for (std::uint32_t i = object.first_facet; is_exact() && i < facets_end; ++i) face_exactly(i);
  }
  for (std::uint32_t f = object.first_face; f < object.first_face + object.face_count; ++f)
    set_area(f, whole_area(f));
}

// Lines. Planes that an object leaves behind in the trees go on using the lines of its edges, so it
// gets others for its next pose.

void LightTree::count_line(std::uint32_t line, bool kept) {
  const std::uint32_t b = block_of_line_[line];
  LineBlock& block = line_blocks_[b];
  if (kept) {
    ++block.kept;
  } else if (--block.kept == 0 && block.orphan) {
    free_blocks_.emplace(block.count, b);
  }
}

// After an object's removal.
void LightTree::leave_lines(std::uint32_t object) {
  const std::uint32_t b = block_of_object_[object];
  if (b == none || line_blocks_[b].kept == 0) return;
  LineBlock& block = line_blocks_[b];
  block.orphan = true;
  for (std::uint32_t id = block.first; id < block.first + block.count; ++id)
    tables_.lines[id].a = tables_.lines[id].b = none;
  block_of_object_[object] = none;
}

void LightTree::give_lines_back(std::uint32_t object) {
  const std::uint32_t b = block_of_object_[object];
  if (b == none) return;
  free_blocks_.emplace(line_blocks_[b].count, b);
  block_of_object_[object] = none;
}

void LightTree::take_lines(std::uint32_t o) {
  const Object& object = scene_.objects()[o];
  if (const std::uint32_t b = block_of_object_[o];
      b != none && line_blocks_[b].count < object.edge_count)
    give_lines_back(o);
  std::uint32_t& b = block_of_object_[o];
  if (b == none) {
    const auto fit = free_blocks_.lower_bound(object.edge_count);
    if (fit != free_blocks_.end()) {
      b = fit->second;
      free_blocks_.erase(fit);
    } else {
      const std::size_t first = tables_.lines.size();
      if (first + object.edge_count > first_local_line) throw std::bad_alloc();
      tables_.lines.resize(first + object.edge_count);
      if (is_exact()) tables_.ends.resize(first + object.edge_count);
      b = static_cast<std::uint32_t>(line_blocks_.size());
      block_of_line_.resize(tables_.lines.size(), b);
      line_blocks_.push_back({static_cast<std::uint32_t>(first), object.edge_count, 0, false});
    }
    line_blocks_[b].orphan = false;
  }
  tables_.line_shift[o] = line_blocks_[b].first - object.first_edge;
}

// Sides turned away: one fragment a facet, in the last block.

void LightTree::insert_away(std::uint32_t facet) {
  if (!is_live()) return;
  Block& block = shadows_.blocks.back();
  const std::uint32_t first =
      away_corners_.take(block.corners, scene_.facets()[facet].corner_count);
  if (target().constructions) block.constructions.resize(block.corners.size());
  const Fragment f = emit_away(facet, first, block);
  away_[facet] = static_cast<std::uint32_t>(block.fragments.size());
  away_born_[facet] = update_;
  block.fragments.push_back(f);
  away_added_.push_back(f.id);
  absorb({f.face, false, true, f.area});
}

void LightTree::remove_away(std::uint32_t facet) {
  if (!is_live() || away_[facet] == none) return;
  Block& block = shadows_.blocks.back();
  const std::uint32_t index = away_[facet];
  const Fragment f = block.fragments[index];
  if (away_born_[facet] != update_) gone_.push_back(f.id);
  away_corners_.give_back(f.first_corner, f.corner_count);
  absorb({f.face, false, false, f.area});
  block.fragments[index] = block.fragments.back();
  away_[block.fragments[index].facet] = index;
  block.fragments.pop_back();
  away_[facet] = none;
}

// Areas.

// A power of two: the face's area is about 2^60 of it.
double LightTree::unit_for(double area) {
  return area > 0 && std::isfinite(area) ? std::ldexp(1.0, std::ilogb(area) - 60) : 1.0;
}

void LightTree::count_face(const FaceArea& before, const FaceArea& now) {
  const bool was = before.facing == Facing::toward, is = now.facing == Facing::toward;
  shadows_.stats.facing_faces += is, shadows_.stats.facing_faces -= was;
  const auto count = [&](Sum& sum, double FaceArea::*area) {
    const double old = was ? before.*area : 0, fresh = is ? now.*area : 0;
    if (old != fresh) sum.add(-old), sum.add(fresh);
  };
  count(facing_area_, &FaceArea::area), count(lit_area_, &FaceArea::lit),
      count(shadowed_area_, &FaceArea::shadowed);
  count(dropped_area_, &FaceArea::dropped);
}

// The areas of faces, and the statistics': of those that may have changed, or all.
void LightTree::total_up() {
  Stats& s = shadows_.stats;
  if (rebuilt_) {
    facing_area_ = lit_area_ = shadowed_area_ = dropped_area_ = {};
    s.facing_faces = 0;
    for (std::uint32_t f = 0; f < shadows_.areas.size(); ++f) {
      measure(f);
      count_face({}, shadows_.areas[f]);
    }
  } else {
    for (const Old& old : noted_) {
      measure(old.face);
      count_face(old.area, shadows_.areas[old.face]);
    }
  }
  s.facing_area = facing_area_.value(), s.lit_area = lit_area_.value(),
  s.shadowed_area = shadowed_area_.value();
  s.dropped_area = dropped_area_.value();
}

// A face has no fragments now; what it will have is counted as they come, and measured when all
// have.
void LightTree::set_area(std::uint32_t face, const FaceArea& area) {
  if (!is_live()) return;
  shadows_.areas[face] = area;
  set_dropped(shadows_.areas[face]);
  units_[face] = {unit_for(area.area), area.facing == Facing::toward};
}

void LightTree::absorb(const LiveCell::AreaChange& change) {
  note(change.face);
  Units& u = units_[change.face];
  constexpr double most = 0x1p62;
  const auto units = static_cast<std::int64_t>(std::min(change.area / u.unit, most));
  (change.lit ? u.lit : u.shadowed) += change.added ? units : -units;
  if (!u.faces_light) return;
  std::uint64_t& fragments =
      change.lit ? shadows_.stats.lit_fragments : shadows_.stats.shadowed_fragments;
  change.added ? ++fragments : --fragments;
}

// A face's areas from its units.
void LightTree::measure(std::uint32_t face) {
  const auto area = [](Count count, double unit) {
    const auto short_count = static_cast<std::int64_t>(count);  // nearly always
    return (short_count == count ? static_cast<double>(short_count) : static_cast<double>(count)) *
           unit;
  };
  FaceArea& a = shadows_.areas[face];
  const Units& u = units_[face];
  a.lit = area(u.lit, u.unit), a.shadowed = area(u.shadowed, u.unit);
  set_dropped(a);
}

void LightTree::absorb(std::span<const std::uint32_t> cells) {
  for (const std::uint32_t c : cells) {
    if (is_live()) {
      for (const LiveCell::AreaChange& change : live_[c].area_changes()) absorb(change);
      live_[c].area_changes().clear();
    }
    add_sums(sums_[c], false);
    sums_[c] = sums_of(c);
    add_sums(sums_[c], true);
  }
}

// What has changed.

void LightTree::finish_update(LightChanges& changes) {
  if (edited_ && is_live()) total_up();
  if (edited_ && !rebuilt_ && !is_live()) emit_again();
  changes.rebuilt = rebuilt_;
  changes.gone = std::move(gone_);
  gone_.clear();
  if (rebuilt_) {
    list_all(changes);
  } else if (is_live()) {
    list_changes(changes);
  } else if (edited_) {
    list_differences(changes);
  }
  changes.areas.reserve(noted_.size());
  for (const Old& old : noted_) {
    const FaceArea now = old.face < shadows_.areas.size() ? shadows_.areas[old.face] : FaceArea{};
    if (differ(old.area, now)) changes.areas.push_back({old.face, now});
  }
}

void LightTree::rebuild_to_nothing(LightChanges& changes) {
  note_everything();
  changes.removed = true;
  changes.gone = std::move(gone_);
  for (const Old& old : noted_) {
    if (differ(old.area, {})) changes.areas.push_back({old.face, {}});
  }
}

// The fragments do not know their places: all are handed out again.
void LightTree::emit_again() {
  for (std::uint32_t f = 0; f < scene_.faces().size(); ++f) note(f);
  const Stats old = std::exchange(shadows_.stats, {});
  emit();
  sum_up();
  Stats& s = shadows_.stats;
  s.build_ms = old.build_ms, s.emit_ms = old.emit_ms,
  s.longest_location_list = old.longest_location_list;
}

void LightTree::list_all(LightChanges& changes) const {
  for (const Block& block : shadows_.blocks) {
    for (std::uint32_t i = 0; i < block.fragments.size(); ++i)
      changes.added.push_back({block.fragments[i].id, i});
  }
}

void LightTree::list_changes(LightChanges& changes) {
  std::size_t gone = changes.gone.size(), added = away_added_.size();
  for (const std::uint32_t c : touched_)
    gone += live_[c].gone().size(), added += live_[c].most_added();
  changes.gone.reserve(gone);
  changes.added.reserve(added);
  for (const std::uint32_t c : touched_) {
    changes.gone.insert(changes.gone.end(), live_[c].gone().begin(), live_[c].gone().end());
    live_[c].list_added(changes.added);
  }
  sort_unique(away_added_);
  for (const FragmentId& id : away_added_) {
    if (away_[id.piece] != none) changes.added.push_back({id, away_[id.piece]});
  }
}

// Against before_: equal fragments, to the bit, have not changed.
void LightTree::list_differences(LightChanges& changes) const {
  struct At {
    const Block* block;
    const Fragment* fragment;
  };
  const auto sorted = [](const std::vector<Block>& blocks) {
    std::vector<At> all;
    for (const Block& block : blocks) {
      for (const Fragment& f : block.fragments) all.push_back({&block, &f});
    }
    std::sort(all.begin(), all.end(),
              [](const At& a, const At& b) { return a.fragment->id < b.fragment->id; });
    return all;
  };
  // 0 and -0 are different: a mirror of the fragments holds either
  const auto same_bits = [](const Vec3& x, const Vec3& y) {
    return std::equal(x.begin(), x.end(), y.begin(), [](double c, double d) {
      return c == d && std::signbit(c) == std::signbit(d);
    });
  };
  const auto same = [&](const At& a, const At& b) {
    const Fragment &f = *a.fragment, &g = *b.fragment;
    const auto x = a.block->corners_of(f), y = b.block->corners_of(g);
    return f.face == g.face && f.facet == g.facet && f.caster == g.caster && f.lit == g.lit &&
           f.area == g.area && std::equal(x.begin(), x.end(), y.begin(), y.end(), same_bits);
  };
  const std::vector<At> before = sorted(before_), now = sorted(shadows_.blocks);
  const auto lost = [&](const At& a) { changes.gone.push_back(a.fragment->id); };
  const auto found = [&](const At& a) {
    changes.added.push_back(
        {a.fragment->id, static_cast<std::uint32_t>(a.fragment - a.block->fragments.data())});
  };
  auto b = before.begin();
  auto n = now.begin();
  while (b != before.end() || n != now.end()) {
    if (n == now.end() || (b != before.end() && b->fragment->id < n->fragment->id)) {
      lost(*b++);
    } else if (b == before.end() || n->fragment->id < b->fragment->id) {
      found(*n++);
    } else {
      if (!same(*b, *n)) lost(*b), found(*n);
      ++b, ++n;
    }
  }
}

const Fragment* LightTree::find(FragmentId id) const {
  if (id.cell >= shadows_.blocks.size()) return nullptr;
  const auto& fragments = shadows_.blocks[id.cell].fragments;
  if (is_live()) {
    const bool in_cell = id.cell < live_.size();
    const std::uint32_t i = in_cell                                       ? live_[id.cell].find(id)
                            : id.place == none && id.piece < away_.size() ? away_[id.piece]
                                                                          : none;
    return i == none ? nullptr : &fragments[i];
  }
  const auto f = std::find_if(fragments.begin(), fragments.end(),
                              [&](const Fragment& g) { return g.id == id; });
  return f == fragments.end() ? nullptr : &*f;
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
