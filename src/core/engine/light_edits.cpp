// Edits of the state of one light: objects out, objects in, and what that changed.

#include <algorithm>

#include "engine/light_state.hpp"
#include "facets/fill_tables.hpp"

namespace shadowcut {
namespace {

// A ray less certain than this has come too near to a far light for the numbers of its frame.
constexpr float largest_ray_error = static_cast<float>(256 * unit_roundoff);

}  // namespace

// After a build.
void LightState::start_edits() {
  for (std::size_t c = 0; c < grid_.size(); ++c) policy_.note_built(CellId(c), grid_[CellId(c)]);
  touched_in_.assign(grid_.size(), 0);
  touched_.clear();
  tables_.lines.start_blocks(scene_.objects());
  for (std::uint32_t o = 0; o < scene_.objects().size(); ++o) note_location_list(o);
}

void LightState::note_location_list(std::uint32_t object) {
  std::uint64_t& longest = shadows_.stats.longest_location_list;
  longest = std::max(longest, grid_.pieces_of(object));
}

// Runs edit(cell, index in cells) for every cell, on several threads if the work is worth it.
template <class Edit>
void LightState::edit_cells(std::span<const CellId> cells, std::size_t work, const Edit& edit) {
  const auto one = [&](std::size_t i) {
    fragments_.begin(cells[i], update_);
    edit(cells[i], i);
  };
  if (cells.size() > 1 && work >= worth_threads) {
    parallel_for(cells.size(), 1, one);
  } else {
    for (std::size_t i = 0; i < cells.size(); ++i) one(i);
  }
  for (const CellId c : cells) {
    if (touched_in_[c.value()] == update_) continue;
    touched_in_[c.value()] = update_;
    touched_.push_back(c);
  }
}

// What edited cells share: planes left behind, areas, statistics.
void LightState::finish_edit(std::span<const CellId> cells) {
  for (const CellId c : cells) {
    EditLog& log = grid_[c].log;
    SHADOWCUT_ASSERT(touched_in_[c.value()] == update_);
    for (const LineId line : log.lines_kept) tables_.lines.count_plane(line, true);
    for (const LineId line : log.lines_released) tables_.lines.count_plane(line, false);
    log.clear();
  }
  for (const CellId c : cells) {
    fragments_.take_area_changes(
        c, [this](const FragmentStore::AreaChange& change) { areas_.absorb(change); });
    statistics_.update(c);
  }
}

void LightState::absorb_away(FacetId facet, bool added) {
  FragmentStore::AreaChange change;
  if (added ? fragments_.add_away(facet, update_, change)
            : fragments_.remove_away(facet, update_, change))
    areas_.absorb(change);
}

void LightState::remove_objects(std::span<const std::uint32_t> objects) {
  if (!edited_) fragments_.keep_before();
  edited_ = true;
  const std::vector<Location> locations = grid_.take_locations(objects);
  std::vector<CellId> cells;
  std::vector<EntryId> entries;
  std::vector<std::size_t> begins;
  for (const Location& l : locations) {
    if (cells.empty() || cells.back() != l.cell)
      cells.push_back(l.cell), begins.push_back(entries.size());
    entries.push_back(l.entry);
  }
  SHADOWCUT_ASSERT(std::is_sorted(cells.begin(), cells.end()));
  begins.push_back(entries.size());
  edit_cells(cells, entries.size(), [&](CellId c, std::size_t i) {
    SvbspTree& tree = grid_[c];
    const std::span own = std::span(entries).subspan(begins[i], begins[i + 1] - begins[i]);
    const std::size_t displaced = remove(tree, own, workspaces_.local());
    fragments_.apply(c);
    policy_.note_removal(c, tree, displaced);
  });
  finish_edit(cells);
  batch_.insert(batch_.end(), cells.begin(), cells.end());
  for (const std::uint32_t o : objects) {
    if (o >= scene_.objects().size()) continue;
    tables_.lines.leave_block(o);
    const Object& object = scene_.objects()[o];
    for (std::uint32_t i = object.first_facet; i < object.first_facet + object.facet_count; ++i) {
      shadows_.stats.facets -= visibility_.enters(FacetId(i));
      absorb_away(FacetId(i), false);
    }
    visibility_.leave(o);
    for (std::uint32_t f = object.first_face; f < object.first_face + object.face_count; ++f) {
      areas_.note(f);
      if (fragments_.is_incremental()) areas_.remove_face(f);
      --shadows_.stats.faces;
    }
  }
}

void LightState::insert_objects(std::span<const std::uint32_t> objects) {
  tables_.refer_to(scene_);
  SHADOWCUT_ASSERT(edited_);
  if (!suits_light_space(objects)) return rebuild(Light(light_));
  grow();
  std::vector<std::uint32_t> alive;
  for (const std::uint32_t o : objects) {
    if (scene_.objects()[o].alive) {
      alive.push_back(o);
    } else {
      tables_.lines.give_block_back(o);
    }
  }
  prepare_objects(alive);
  insert_into_cells(order_.of_objects(alive));
  for (const std::uint32_t o : alive) note_location_list(o);
  batch_.clear();
}

// A near light loses one rounding a coordinate, wherever objects are.
bool LightState::suits_light_space(std::span<const std::uint32_t> objects) const {
  if (!space_.far()) return true;
  for (const std::uint32_t o : objects) {
    const Object& object = scene_.objects()[o];
    if (!object.casts_shadows && !object.receives_shadows) continue;
    for (const Vec3& v : scene_.vertices().subspan(object.first_vertex, object.vertex_count)) {
      if (space_.ray(v).error > largest_ray_error) return false;
    }
  }
  return true;
}

// To the size of the scene.
void LightState::grow() {
  visibility_.grow();
  fragments_.grow(scene_.facets().size());
  if (tables_.rays.size() < scene_.vertices().size()) tables_.rays.resize(scene_.vertices().size());
  if (tables_.planes.size() < scene_.planes().size()) tables_.planes.resize(scene_.planes().size());
  tables_.lines.grow(scene_.objects().size());
  grid_.grow(scene_.objects().size());
  areas_.grow(scene_.faces().size());
}

// Everything about objects that does not depend on other objects. What they share is done for one
// object after the other.
void LightState::prepare_objects(std::span<const std::uint32_t> objects) {
  std::size_t facets = 0;
  for (const std::uint32_t o : objects) {
    const Object& object = scene_.objects()[o];
    facets += object.facet_count;
    if (is_exact()) tables_.exact->note_object(scene_, object);
  }
  const auto for_each = [&](const auto& f) {
    if (facets >= worth_threads)
      return parallel_for(objects.size(), 4, [&](std::size_t i) { f(objects[i]); });
    for (const std::uint32_t o : objects) f(o);
  };
  for_each([this](std::uint32_t o) { visibility_.decide(o, light_); });
  for (const std::uint32_t o : objects) {
    const Object& object = scene_.objects()[o];
    bool any = false;
    for (std::uint32_t i = object.first_facet; i < object.first_facet + object.facet_count; ++i)
      any = any || visibility_.enters(FacetId(i));
    if (any) tables_.lines.take_block(o, object);
    for (std::uint32_t f = object.first_face; f < object.first_face + object.face_count; ++f)
      areas_.note(f);
  }
  for_each([this](std::uint32_t o) {
    fill_tables(scene_, space_, o, visibility_, tables_);
    const Object& object = scene_.objects()[o];
    if (!fragments_.is_incremental()) return;
    for (std::uint32_t f = object.first_face; f < object.first_face + object.face_count; ++f)
      areas_.start_face(f);
  });
  for (const std::uint32_t o : objects) {
    const Object& object = scene_.objects()[o];
    shadows_.stats.faces += object.face_count;
    for (std::uint32_t i = object.first_facet; i < object.first_facet + object.facet_count; ++i) {
      shadows_.stats.facets += visibility_.enters(FacetId(i));
      if (visibility_.is_away(FacetId(i))) absorb_away(FacetId(i), true);
    }
  }
}

// Inserts parts of facets into the cells, and emits what has changed since objects were removed.
void LightState::insert_into_cells(std::span<const FacetId> order) {
  const FacetParts parts = grid_.filter(order);
  SHADOWCUT_ASSERT(parts.list.size() >= order.size());
  std::vector<EntryId> entries(parts.list.size());
  for (const FacetParts::Part& part : parts.list) batch_.push_back(part.cell);
  sort_unique(batch_);
  SHADOWCUT_ASSERT(std::is_sorted(batch_.begin(), batch_.end()));
  edit_cells(batch_, parts.list.size(), [&](CellId c, std::size_t) {
    Workspace& w = workspaces_.local();
    SvbspTree& tree = grid_[c];
    auto part =
        std::lower_bound(parts.list.begin(), parts.list.end(), c,
                         [](const FacetParts::Part& p, CellId cell) { return p.cell < cell; });
    for (; part != parts.list.end() && part->cell == c; ++part) {
      const std::uint32_t object = tables_.object_of(part->facet);
      policy_.note_mover(c, object, update_);
      EntryId& entry = entries[static_cast<std::size_t>(part - parts.list.begin())];
      entry = insert(tree, grid_.cone_of(parts, *part, w.pool), w);
      policy_.note_insertion(c, tree, entry, object);
    }
    fragments_.apply(c);
    if (policy_.should_rebuild(c, tree)) {
      rebuild_cell(c);
    } else {
      fragments_.emit_changes(c);
    }
  });
  for (std::size_t i = 0; i < entries.size(); ++i)
    grid_.add_location(parts.list[i].cell, entries[i]);
  finish_edit(batch_);
}

// A cell's tree, from its entries in the order of a build; what moves again and again comes last.
void LightState::rebuild_cell(CellId c) {
  const SvbspTree& tree = grid_[c];
  std::vector<std::uint32_t> objects;
  for (const Entry& e : tree.pieces.entries()) {
    if (e.facet.valid()) objects.push_back(tables_.object_of(e.facet));
  }
  sort_unique(objects);
  const std::vector<std::uint32_t> last = policy_.movers_at_leaves(c, tree, objects);
  std::erase_if(objects, [&](std::uint32_t o) {
    return std::find(last.begin(), last.end(), o) != last.end();
  });
  std::vector<FacetId> order = order_.of_objects(objects);
  for (const std::uint32_t& o : last) {
    const std::vector<FacetId> facets = order_.of_objects({&o, 1});
    order.insert(order.end(), facets.begin(), facets.end());
  }
  SHADOWCUT_ASSERT(!order.empty() || tree.pieces.entry_count() == 0);
  grid_.rebuild(c, order, workspaces_.local());
  fragments_.restart(c);
  policy_.note_rebuilt(c, tree);
}

void LightState::finish_update(LightChanges& changes) {
  if (edited_ && fragments_.is_incremental()) areas_.total_up(rebuilt_);
  if (edited_ && !rebuilt_ && !fragments_.is_incremental()) emit_again();
  changes.rebuilt = rebuilt_;
  if (rebuilt_) {
    fragments_.list_all(changes);
  } else if (fragments_.is_incremental()) {
    fragments_.list_changes(touched_, changes);
  } else if (edited_) {
    fragments_.list_differences(changes);
  }
  areas_.list_changes(changes);
  SHADOWCUT_ASSERT(validate_touched().empty());
}

// Fragments that do not know their places are all emitted again.
void LightState::emit_again() {
  areas_.note_all();
  const Stats old = std::exchange(shadows_.stats, {});
  fragments_.emit_all(update_, options_.progress);
  sum_up();
  Stats& s = shadows_.stats;
  s.build_ms = old.build_ms, s.emit_ms = old.emit_ms;
  s.longest_location_list = old.longest_location_list;
}

void LightState::remove_light(LightChanges& changes) {
  note_all_gone();
  fragments_.list_gone(changes);
  changes.removed = true;
  shadows_.areas.clear();
  areas_.list_changes(changes);
}

}  // namespace shadowcut
