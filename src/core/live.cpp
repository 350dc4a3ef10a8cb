#include "live.hpp"

#include <algorithm>
#include <utility>

#include "smallest_feature.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {
namespace {

constexpr std::uint32_t not_yet = 0;  // of an update's number

bool is_pp(const CellTree& tree, std::uint32_t node) {
  return tree.child_at(tree.links()[node].parent).is_pp();
}

bool is_in_front(Piece::Kind kind) {
  return kind == Piece::Kind::owner || kind == Piece::Kind::coplanar;
}

}  // namespace

std::uint32_t LiveCell::state_of(const CellTree& tree, Child c) const {
  return SHADOWCUT_NUMBERS::state_of(tree, states_, c);
}

void LiveCell::make_room(const CellTree& tree) {
  states_.resize(tree.nodes().size(), mixed_state);
  at_place_.resize(2 * tree.nodes().size(), none);
  visit_.resize(2 * tree.nodes().size(), 0);
  of_piece_.resize(tree.pieces().size(), none);
}

void LiveCell::begin(Block& block, std::uint32_t update) {
  block_ = &block;
  if (update_ == update) return;
  update_ = update;
  gone_.clear();
  born_.clear();
}

void LiveCell::start(const CellTree& tree, const EmitTarget& target, Workspace& w, Block& block,
                     std::uint32_t update) {
  block_ = &block;
  update_ = update;
  forget_fragments();
  gone_.clear(), area_changes_.clear();
  block.fragments.reserve(tree.pieces().size() * 3);
  block.corners.reserve(tree.pieces().size() * 14);
  emit_all(tree, target, w);
  born_.clear();
}

void LiveCell::emit_all(const CellTree& tree, const EmitTarget& target, Workspace& w) {
  w.points.clear();
  make_room(tree);
  if (merge_) states_ = find_states(tree, target.scene);
  for (std::uint32_t p = 0; p < tree.pieces().size(); ++p) emit_piece(tree, p, target, w);
}

void LiveCell::start_again(const CellTree& tree, const EmitTarget& target, Workspace& w) {
  for (std::size_t i = 0; i < records_.size(); ++i) {
    const Fragment& f = block_->fragments[i];
    if (records_[i].born != update_) gone_.push_back(f.id);
    area_changes_.push_back({f.face, f.lit, false, f.area});
  }
  forget_fragments();
  emit_all(tree, target, w);
}

// And all that was known of them and of the tree.
void LiveCell::forget_fragments() {
  block_->fragments.clear();
  block_->corners.clear();
  block_->constructions.clear();
  records_.clear(), at_place_.clear(), of_piece_.clear(), states_.clear(), visit_.clear();
  free_corners_.clear();
  changed_.clear(), added_pieces_.clear();
}

// True: it is another one than before.
bool LiveCell::find_state(const CellTree& tree, const EmitTarget& target, std::uint32_t node) {
  const Node& n = tree.nodes()[node];
  const std::uint32_t state =
      joint_state(target.scene, state_of(tree, n.child[0]), state_of(tree, n.child[1]));
  return std::exchange(states_[node], state) != state;
}

void LiveCell::settle(const CellTree& tree, const EmitTarget& target, Workspace& w) {
  w.points.clear();
  make_room(tree);
  sort_unique(changed_);
  sort_unique(added_pieces_);

  // States first, all of them: what is settled is asked of every branch below. Where a state stays,
  // nothing above learns of the change.
  if (merge_) {
    for (std::uint32_t place : changed_) {
      for (; place != root_place && !is_pp(tree, place >> 1);
           place = tree.links()[place >> 1].parent) {
        if (!find_state(tree, target, place >> 1)) break;
      }
    }
  }
  // What has to be handed out again begins at the highest place that was settled or has become so,
  // or else at the change. The way to it from the PP-node is marked, so that pieces there need not
  // be taken elsewhere. Above a marked way no place is settled, or was.
  const std::uint32_t on_the_way = ++visits_ * 2, all_below = on_the_way + 1;
  std::vector<std::uint32_t> pps;
  for (const std::uint32_t change : changed_) {
    std::uint32_t top = change, place = change;
    for (; place != root_place && visit_[place] < on_the_way;
         place = tree.links()[place >> 1].parent) {
      if (at_place_[place] != none || state_of(tree, tree.child_at(place)) != mixed_state)
        top = place;
      if (!is_pp(tree, place >> 1)) continue;
      pps.push_back(place >> 1);
      break;
    }
    // in front of nothing; or handed out again already
    if (place == root_place || visit_[place] == all_below) continue;
    drop_below(tree, top);
    visit_[top] = all_below;
    // to the place in front of the PP-node, or a way already marked
    for (std::uint32_t p = top; p != place;) {
      p = tree.links()[p >> 1].parent;
      visit_[p] = std::max(visit_[p], on_the_way);
    }
  }
  changed_.clear();
  sort_unique(pps);
  const auto is_new = [this](std::uint32_t p) {
    return std::binary_search(added_pieces_.begin(), added_pieces_.end(), p);
  };
  for (const std::uint32_t pp : pps) {
    const std::uint32_t owner = tree.nodes()[pp].id;
    if (!is_new(owner)) emit_in_front(tree, owner, on_the_way, target, w);
    for (std::uint32_t p = tree.links()[pp].first; p != none; p = tree.pieces()[p].next) {
      if (tree.pieces()[p].kind == Piece::Kind::coplanar && !is_new(p))
        emit_in_front(tree, p, on_the_way, target, w);
    }
  }
  for (const std::uint32_t p : added_pieces_) emit_piece(tree, p, target, w);
  added_pieces_.clear();
}

void LiveCell::drop_below(const CellTree& tree, std::uint32_t top) {
  places_.assign(1, top);
  while (!places_.empty()) {
    const std::uint32_t place = places_.back();
    places_.pop_back();
    if (at_place_[place] != none) {  // settled: nothing hangs further down
      while (at_place_[place] != none) drop(at_place_[place]);
      continue;
    }
    const Child here = tree.child_at(place);
    if (!here.is_sp()) continue;
    places_.push_back(here.node() * 2);
    places_.push_back(here.node() * 2 + 1);
  }
}

void LiveCell::drop_piece(std::uint32_t piece) {
  if (piece >= of_piece_.size()) return;
  while (of_piece_[piece] != none) drop(of_piece_[piece]);
}

// A node is going, and its index will name another one.
void LiveCell::drop_places_of(std::uint32_t node) {
  if (node >= states_.size()) return;
  states_[node] = mixed_state;
  for (const std::uint32_t place : {node * 2, node * 2 + 1}) {
    while (at_place_[place] != none) drop(at_place_[place]);
  }
}

void LiveCell::drop(std::uint32_t fragment) {
  auto& fragments = block_->fragments;
  const Fragment f = fragments[fragment];
  const Record r = records_[fragment];
  if (r.born != update_) gone_.push_back(f.id);
  area_changes_.push_back({f.face, f.lit, false, f.area});
  free_corners_.give_back(f.first_corner, f.corner_count);

  if (r.of_piece_next != none) records_[r.of_piece_next].of_piece_previous = r.of_piece_previous;
  (r.of_piece_previous != none ? records_[r.of_piece_previous].of_piece_next
                               : of_piece_[f.id.piece]) = r.of_piece_next;
  if (f.id.place != none) {
    if (r.at_place_next != none) records_[r.at_place_next].at_place_previous = r.at_place_previous;
    (r.at_place_previous != none ? records_[r.at_place_previous].at_place_next
                                 : at_place_[f.id.place]) = r.at_place_next;
  }
  // The last one takes its index.
  const auto last = static_cast<std::uint32_t>(fragments.size() - 1);
  if (fragment != last) {
    fragments[fragment] = fragments[last];
    const Record& moved = records_[fragment] = records_[last];
    const FragmentId& id = fragments[fragment].id;
    if (moved.of_piece_next != none) records_[moved.of_piece_next].of_piece_previous = fragment;
    (moved.of_piece_previous != none ? records_[moved.of_piece_previous].of_piece_next
                                     : of_piece_[id.piece]) = fragment;
    if (id.place != none) {
      if (moved.at_place_next != none) records_[moved.at_place_next].at_place_previous = fragment;
      (moved.at_place_previous != none ? records_[moved.at_place_previous].at_place_next
                                       : at_place_[id.place]) = fragment;
    }
  }
  fragments.pop_back();
  records_.pop_back();
}

void LiveCell::add(const CellTree& tree, std::uint32_t piece, std::uint32_t place,
                   std::uint32_t state, std::span<const ConeCorner> cone, const EmitTarget& target,
                   Workspace& w) {
  const auto index = static_cast<std::uint32_t>(block_->fragments.size());
  const auto count = static_cast<std::uint32_t>(cone.size());
  const std::uint32_t facet = tree.pieces()[piece].facet, face = target.tables.facets[facet].face;
  const std::uint32_t first = free_corners_.take(block_->corners, count);
  const double area =
      place_polygon(target, tree.lines(), facet, cone, w.points, block_->corners.data() + first);
  if (target.constructions) note_constructions(target, tree.lines(), cone, first, *block_);
  const bool lit = state == lit_state;
  const FragmentId id{cell_, piece, place};
  block_->fragments.push_back({id, face, facet, lit ? none : state, first, count, lit, area});
  Record r{none, none, of_piece_[piece], none, update_, not_yet};
  if (r.of_piece_next != none) records_[r.of_piece_next].of_piece_previous = index;
  of_piece_[piece] = index;
  if (place != none) {
    r.at_place_next = at_place_[place];
    if (r.at_place_next != none) records_[r.at_place_next].at_place_previous = index;
    at_place_[place] = index;
  }
  records_.push_back(r);
  born_.push_back(id);
  area_changes_.push_back({face, lit, true, area});
}

// All fragments of a piece.
void LiveCell::emit_piece(const CellTree& tree, std::uint32_t p, const EmitTarget& target,
                          Workspace& w) {
  const Piece& piece = tree.pieces()[p];
  if (!hands_out(target, piece)) return;
  if (!is_in_front(piece.kind)) {
    add(tree, p, none,
        piece.kind == Piece::Kind::at_leaf ? lit_state : owner_face(tree, piece.place),
        tree.corners(piece), target, w);
    return;
  }
  const std::uint32_t front = piece.place * 2;
  const std::uint32_t state = state_of(tree, tree.child_at(front));
  if (state != mixed_state) return add(tree, p, front, state, tree.corners(piece), target, w);
  emit_in_front(tree, p, 0, target, w);
}

// The fragments of a piece at settled places, of those reached by marked ways only (see settle();
// 0: of all).
void LiveCell::emit_in_front(const CellTree& tree, std::uint32_t p, std::uint32_t way,
                             const EmitTarget& target, Workspace& w) {
  const Piece& piece = tree.pieces()[p];
  if (!hands_out(target, piece)) return;
  const auto send = [&w](Cone* cone, std::uint32_t place, std::uint32_t from_here) {
    cone->at = place;
    cone->entry = from_here;  // of no other use here: the way still to be followed
    w.pending.push_back(cone);
  };
  send(tree.cone_of(piece, w.pool), piece.place * 2, way);
  while (!w.pending.empty()) {
    Cone* cone = w.pending.back();
    w.pending.pop_back();
    std::uint32_t place = cone->at, follow = cone->entry;
    for (;;) {
      if (follow != 0) {
        if (visit_[place] < follow) break;
        if (visit_[place] > follow) follow = 0;
      }
      const Child here = tree.child_at(place);
      const std::uint32_t state = state_of(tree, here);
      if (state != mixed_state) {
        if (follow == 0) add(tree, p, place, state, cone->span(), target, w);
        break;
      }
      Cone* cut_off;
      place = step_down(tree, here.node(), true, cone, cut_off, w);
      if (cut_off) send(cut_off, here.node() * 2 + 1, follow);
    }
    w.pool.give_back(cone);
  }
}

std::uint32_t LiveCell::find(FragmentId id) const {
  if (id.piece >= of_piece_.size()) return none;
  if (id.place == none) {
    const std::uint32_t f = of_piece_[id.piece];
    return f != none && block_->fragments[f].id.place == none ? f : none;
  }
  if (id.place >= at_place_.size()) return none;
  std::uint32_t f = at_place_[id.place];
  while (f != none && block_->fragments[f].id.piece != id.piece) f = records_[f].at_place_next;
  return f;
}

// What was added in this update and is still there.
void LiveCell::list_added(std::vector<LightChanges::Added>& out) {
  for (const FragmentId& id : born_) {
    const std::uint32_t f = find(id);
    if (f == none || records_[f].born != update_ || records_[f].listed == update_) continue;
    records_[f].listed = update_;
    out.push_back({id, f});
  }
}

void LiveCell::list_old(const Block& block, std::uint32_t update,
                        std::vector<FragmentId>& out) const {
  if (update_ == update) out.insert(out.end(), gone_.begin(), gone_.end());
  for (std::size_t i = 0; i < records_.size(); ++i) {
    if (records_[i].born != update) out.push_back(block.fragments[i].id);
  }
}

std::uint64_t LiveCell::bytes() const {
  return records_.size() * sizeof(Record) +
         4 * (at_place_.size() + of_piece_.size() + states_.size() + visit_.size());
}

std::string LiveCell::validate(const CellTree& tree, const EmitTarget& target,
                               const Block& block) const {
  const auto say = [](const char* what, std::size_t which) {
    return std::string(what) + " (" + std::to_string(which) + ")";
  };
  if (records_.size() != block.fragments.size())
    return "fragments and their records differ in number";
  std::size_t corners = free_corners_.unused();
  for (const Fragment& f : block.fragments) corners += f.corner_count;
  if (corners != block.corners.size()) return "corners are lost, or used twice";
  // 10. In front of a PP-node, an SP-node's state is what its sides are in. (Elsewhere nobody
  // asks.)
  std::vector<std::uint8_t> below_pp(tree.nodes().size(), 0);
  std::vector<Child> pending{tree.root()};
  while (!pending.empty() && merge_) {
    const Child here = pending.back();
    pending.pop_back();
    if (here.is_out()) continue;
    const Node& node = tree.nodes()[here.node()];
    for (const Child c : {node.child[0], node.child[1]}) {
      if (c.is_out()) continue;
      below_pp[c.node()] = here.is_pp() || below_pp[here.node()];
      pending.push_back(c);
    }
    if (!here.is_sp() || !below_pp[here.node()]) continue;
    if (states_[here.node()] !=
        joint_state(target.scene, state_of(tree, node.child[0]), state_of(tree, node.child[1])))
      return say("a node's state is not its sides'", here.node());
  }
  // 11. A fragment is found under its id, hangs at a settled place in front of its piece's PP-node,
  // and is in the state of that place.
  for (std::uint32_t i = 0; i < block.fragments.size(); ++i) {
    const Fragment& f = block.fragments[i];
    if (find(f.id) != i) return say("a fragment is not found under its id", i);
    const Piece& piece = tree.pieces()[f.id.piece];
    if (!hands_out(target, piece) || piece.facet != f.facet)
      return say("a fragment's piece is not its own", i);
    std::uint32_t state = lit_state;
    if (is_in_front(piece.kind)) {
      std::uint32_t place = f.id.place;
      state = place == none ? mixed_state : state_of(tree, tree.child_at(place));
      if (state == mixed_state) return say("a fragment's place is not settled", i);
      while (!is_pp(tree, place >> 1)) {
        place = tree.links()[place >> 1].parent;
        if (place == root_place) return say("a fragment's place is in front of nothing", i);
        if (state_of(tree, tree.child_at(place)) != mixed_state)
          return say("a fragment's place is part of a settled one", i);
      }
      if (place >> 1 != piece.place)
        return say("a fragment's place is not in front of its piece", i);
    } else {
      if (f.id.place != none) return say("a fragment away from all PP-nodes has a place", i);
      if (piece.kind == Piece::Kind::behind) state = owner_face(tree, piece.place);
    }
    if (f.lit != (state == lit_state) || (!f.lit && f.caster != state))
      return say("a fragment's state is not its place's", i);
  }
  return {};
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
