#include "fragments/cell_fragments.hpp"

#include <algorithm>
#include <utility>

namespace shadowcut {
namespace {

constexpr std::uint32_t not_yet = 0;  // of an update's number

}  // namespace

struct CellFragments::Sink {
  CellFragments& fragments;
  const SvbspTree& tree;
  const EmissionContext& context;
  Workspace& w;
  void add(PieceId piece, std::uint32_t place, BranchState state,
           std::span<const ConeCorner> corners) {
    fragments.add(tree, piece, place, state, corners, context, w);
  }
};

void CellFragments::grow(const SvbspTree& tree) {
  states_.grow(tree);
  at_place_.resize(2 * tree.nodes().size(), invalid_index);
  ways_.grow(2 * tree.nodes().size());
  of_piece_.resize(tree.pieces.pieces().size(), invalid_index);
}

void CellFragments::begin(Block& block, std::uint32_t update) {
  block_ = &block;
  if (update_ == update) return;
  SHADOWCUT_ASSERT(update >= update_);
  update_ = update;
  gone_.clear();
  born_.clear();
}

void CellFragments::start(const SvbspTree& tree, const EmissionContext& context, Workspace& w,
                          Block& block, std::uint32_t update) {
  block_ = &block;
  update_ = update;
  forget_fragments();
  gone_.clear(), area_changes_.clear();
  block.fragments.reserve(tree.pieces.pieces().size() * 3);
  block.corners.reserve(tree.pieces.pieces().size() * 14);
  emit_all(tree, context, w);
  born_.clear();
}

void CellFragments::emit_all(const SvbspTree& tree, const EmissionContext& context, Workspace& w) {
  w.points.clear();
  grow(tree);
  if (context.merges()) states_.compute(tree, context.scene);
  Sink sink{*this, tree, context, w};
  FragmentEmitter emitter(tree, states_, context, w, sink);
  for (std::size_t p = 0; p < tree.pieces.pieces().size(); ++p) emitter.emit_piece(PieceId(p));
}

void CellFragments::restart(const SvbspTree& tree, const EmissionContext& context, Workspace& w) {
  for (std::size_t i = 0; i < records_.size(); ++i) {
    const Fragment& f = block_->fragments[i];
    if (records_[i].born != update_) gone_.push_back(f.id);
    area_changes_.push_back({f.face, f.lit, false, f.area});
  }
  forget_fragments();
  emit_all(tree, context, w);
}

// And everything known about the tree.
void CellFragments::forget_fragments() {
  block_->fragments.clear();
  block_->corners.clear();
  block_->constructions.clear();
  records_.clear(), at_place_.clear(), of_piece_.clear(), states_.clear(), ways_.clear();
  free_corners_.clear();
  changed_.clear(), added_pieces_.clear();
}

void CellFragments::apply(const EditLog& log) {
  for (const EditLog::Dropped& d : log.dropped) {
    if (d.kind == EditLog::Dropped::Kind::piece) {
      if (d.index < of_piece_.size()) drop_all_at(of_piece_[d.index]);
    } else if (d.index < states_.size()) {
      // The node's index will name another node.
      states_.forget(NodeId(d.index));
      drop_all_at(at_place_[Place(NodeId(d.index), 0).value()]);
      drop_all_at(at_place_[Place(NodeId(d.index), 1).value()]);
    }
  }
  changed_.insert(changed_.end(), log.places_changed.begin(), log.places_changed.end());
  added_pieces_.insert(added_pieces_.end(), log.pieces_added.begin(), log.pieces_added.end());
}

void CellFragments::emit_changes(const SvbspTree& tree, const EmissionContext& context,
                                 Workspace& w) {
  w.points.clear();
  grow(tree);
  sort_unique(changed_);
  sort_unique(added_pieces_);
  if (context.merges()) update_states(tree, context.scene);
  const std::vector<NodeId> pp_nodes = mark_ways(tree);
  changed_.clear();
  const auto is_new = [this](PieceId p) {
    return std::binary_search(added_pieces_.begin(), added_pieces_.end(), p);
  };
  Sink sink{*this, tree, context, w};
  FragmentEmitter emitter(tree, states_, context, w, sink);
  for (const NodeId pp : pp_nodes) {
    const PieceId owner = tree.node(pp).owner();
    if (!is_new(owner)) emitter.emit_in_front(owner, &ways_);
    for (PieceId p = tree.links(pp).first; p.valid(); p = tree.pieces[p].next) {
      if (tree.pieces[p].kind == Piece::Kind::coplanar && !is_new(p))
        emitter.emit_in_front(p, &ways_);
    }
  }
  for (const PieceId p : added_pieces_) emitter.emit_piece(p);
  added_pieces_.clear();
  SHADOWCUT_ASSERT(changed_.empty() && records_.size() == block_->fragments.size());
}

// All states first: whether a place is uniform is asked of every branch below. Where a state stays,
// nothing above learns of the change.
void CellFragments::update_states(const SvbspTree& tree, const Scene& scene) {
  for (Place place : changed_) {
    for (; !place.is_root() && !tree.is_pp(place.node()); place = tree.links(place.node()).parent) {
      if (!states_.update(tree, scene, place.node())) break;
    }
  }
}

// Fragments have to be emitted again from the highest place down that was uniform or has become so,
// or else from the change. Drops what is there. The way to that place from the PP-node is marked,
// so that pieces need not be taken elsewhere; above a marked way no place is uniform, or was.
// Returns the PP-nodes.
std::vector<NodeId> CellFragments::mark_ways(const SvbspTree& tree) {
  ways_.restart();
  std::vector<NodeId> pp_nodes;
  for (const Place change : changed_) {
    Place top = change, place = change;
    for (; !place.is_root() && !ways_.is_marked(place); place = tree.links(place.node()).parent) {
      if (at_place_[place.value()] != invalid_index ||
          !states_.of(tree, tree.branch(place)).is_mixed())
        top = place;
      if (!tree.is_pp(place.node())) continue;
      pp_nodes.push_back(place.node());
      break;
    }
    if (place.is_root() || ways_.is_all(place)) continue;  // in front of nothing; or done already
    drop_below(tree, top);
    ways_.mark_all(top);
    for (Place p = top; p != place;) {  // to the front of the PP-node, or a way already marked
      p = tree.links(p.node()).parent;
      ways_.mark_way(p);
    }
  }
  sort_unique(pp_nodes);
  return pp_nodes;
}

void CellFragments::drop_below(const SvbspTree& tree, Place top) {
  pending_.assign(1, top);
  SHADOWCUT_ASSERT(!top.is_root());
  while (!pending_.empty()) {
    const Place place = pending_.back();
    pending_.pop_back();
    if (at_place_[place.value()] != invalid_index) {  // uniform: nothing hangs further down
      drop_all_at(at_place_[place.value()]);
      continue;
    }
    const Branch here = tree.branch(place);
    if (!here.is_sp()) continue;
    pending_.push_back(Place(here.node(), 0));
    pending_.push_back(Place(here.node(), 1));
  }
}

// Lists of fragments of a piece and at a place, doubly linked through the records.

void CellFragments::link(std::uint32_t index, const FragmentId& id) {
  SHADOWCUT_ASSERT(index < records_.size() && id.cell == cell_.value() &&
                   id.piece < of_piece_.size());
  Record& r = records_[index];
  r.of_piece_next = of_piece_[id.piece];
  if (r.of_piece_next != invalid_index) records_[r.of_piece_next].of_piece_previous = index;
  of_piece_[id.piece] = index;
  if (id.place == invalid_index) return;
  r.at_place_next = at_place_[id.place];
  if (r.at_place_next != invalid_index) records_[r.at_place_next].at_place_previous = index;
  at_place_[id.place] = index;
}

// A fragment's record has come to another index.
void CellFragments::relink(std::uint32_t index, const FragmentId& id) {
  const Record& r = records_[index];
  SHADOWCUT_ASSERT(id.piece < of_piece_.size());
  if (r.of_piece_next != invalid_index) records_[r.of_piece_next].of_piece_previous = index;
  (r.of_piece_previous != invalid_index ? records_[r.of_piece_previous].of_piece_next
                                        : of_piece_[id.piece]) = index;
  if (id.place == invalid_index) return;
  if (r.at_place_next != invalid_index) records_[r.at_place_next].at_place_previous = index;
  (r.at_place_previous != invalid_index ? records_[r.at_place_previous].at_place_next
                                        : at_place_[id.place]) = index;
}

void CellFragments::drop(std::uint32_t fragment) {
  auto& fragments = block_->fragments;
  SHADOWCUT_ASSERT(fragment < fragments.size() && fragments.size() == records_.size());
  const Fragment f = fragments[fragment];
  const Record r = records_[fragment];
  if (r.born != update_) gone_.push_back(f.id);
  area_changes_.push_back({f.face, f.lit, false, f.area});
  free_corners_.give_back(f.first_corner, f.corner_count);

  if (r.of_piece_next != invalid_index)
    records_[r.of_piece_next].of_piece_previous = r.of_piece_previous;
  (r.of_piece_previous != invalid_index ? records_[r.of_piece_previous].of_piece_next
                                        : of_piece_[f.id.piece]) = r.of_piece_next;
  if (f.id.place != invalid_index) {
    if (r.at_place_next != invalid_index)
      records_[r.at_place_next].at_place_previous = r.at_place_previous;
    (r.at_place_previous != invalid_index ? records_[r.at_place_previous].at_place_next
                                          : at_place_[f.id.place]) = r.at_place_next;
  }
  // The last fragment takes its index.
  const auto last = static_cast<std::uint32_t>(fragments.size() - 1);
  if (fragment != last) {
    fragments[fragment] = fragments[last];
    records_[fragment] = records_[last];
    relink(fragment, fragments[fragment].id);
  }
  fragments.pop_back();
  records_.pop_back();
}

void CellFragments::add(const SvbspTree& tree, PieceId piece, std::uint32_t place,
                        BranchState state, std::span<const ConeCorner> cone,
                        const EmissionContext& context, Workspace& w) {
  const auto count = static_cast<std::uint32_t>(cone.size());
  const FacetId facet = tree.pieces[piece].facet;
  const std::uint32_t face = context.tables.face_of(facet).value();
  const std::uint32_t first = free_corners_.take(block_->corners, count);
  if (context.constructions) block_->constructions.resize(block_->corners.size());
  const std::span<Vec3> corners = std::span(block_->corners).subspan(first, count);
  const double area =
      place_polygon(context, tree.predicates(), facet, cone, w.points, corners.data());
  if (is_below_min_feature(context, facet, cone, corners, area)) {
    free_corners_.give_back(first, count);
    return;
  }
  if (context.constructions) note_constructions(context, tree.predicates(), cone, first, *block_);
  const FragmentId id = fragment_id(cell_, piece, place);
  block_->fragments.push_back(
      {id, face, facet.value(), state.caster(), first, count, state.is_lit(), area});
  records_.push_back(
      {invalid_index, invalid_index, invalid_index, invalid_index, update_, not_yet});
  link(static_cast<std::uint32_t>(records_.size() - 1), id);
  SHADOWCUT_ASSERT(find(id) == records_.size() - 1);
  born_.push_back(id);
  area_changes_.push_back({face, state.is_lit(), true, area});
}

std::uint32_t CellFragments::find(FragmentId id) const {
  if (id.piece >= of_piece_.size()) return invalid_index;
  if (id.place == invalid_index) {
    const std::uint32_t f = of_piece_[id.piece];
    return f != invalid_index && block_->fragments[f].id.place == invalid_index ? f : invalid_index;
  }
  if (id.place >= at_place_.size()) return invalid_index;
  std::uint32_t f = at_place_[id.place];
  while (f != invalid_index && block_->fragments[f].id.piece != id.piece)
    f = records_[f].at_place_next;
  return f;
}

// What was added in this update and is still there.
void CellFragments::list_added(std::vector<LightChanges::Added>& out) {
  for (const FragmentId& id : born_) {
    const std::uint32_t f = find(id);
    if (f == invalid_index || records_[f].born != update_ || records_[f].listed == update_)
      continue;
    SHADOWCUT_ASSERT(block_->fragments[f].id == id);
    records_[f].listed = update_;
    out.push_back({id, f});
  }
}

void CellFragments::list_old(const Block& block, std::uint32_t update,
                             std::vector<FragmentId>& out) const {
  if (update_ == update) out.insert(out.end(), gone_.begin(), gone_.end());
  for (std::size_t i = 0; i < records_.size(); ++i) {
    if (records_[i].born != update) out.push_back(block.fragments[i].id);
  }
}

std::uint64_t CellFragments::bytes() const {
  return records_.size() * sizeof(Record) +
         4 * (at_place_.size() + of_piece_.size() + states_.size() + ways_.size());
}

}  // namespace shadowcut
