#include "tree.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "live.hpp"
#include "smallest_feature.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {

void CellTree::clear() {
  live_ = nullptr;
  root_ = Child::out();
  nodes_.clear(), links_.clear(), pieces_.clear(), entries_.clear(), corners_.clear(),
      local_lines_.clear();
  free_corners_.clear();
  free_nodes_.clear(), free_pieces_.clear(), free_entries_.clear(), free_lines_.clear(),
      idle_lines_.clear();
  pp_nodes_ = marked_nodes_ = 0;
  counts_ = {};
}

void CellTree::start_again(std::vector<std::uint32_t>& given_up) {
  for (std::size_t node = 0; node < nodes_.size(); ++node) {
    if (links_[node].owner == marked && links_[node].first == line_reported)
      given_up.push_back(nodes_[node].id);
  }
  root_ = Child::out();
  nodes_.clear(), links_.clear(), pieces_.clear(), corners_.clear(), local_lines_.clear();
  free_corners_.clear();
  free_nodes_.clear(), free_pieces_.clear(), free_lines_.clear(), idle_lines_.clear();
  pp_nodes_ = marked_nodes_ = 0;
  for (Entry& e : entries_) e.first = none, e.pieces = 0;
}

void CellTree::insert_again(std::uint32_t entry, Cone* cone, Workspace& w) {
  cone->entry = entry;
  insert_at(cone, root_place, w);
}

std::uint32_t CellTree::insert(Cone* cone, Workspace& w) {
  std::uint32_t entry;
  if (free_entries_.empty()) {
    entry = static_cast<std::uint32_t>(entries_.size());
    entries_.emplace_back();
  } else {
    entry = free_entries_.take();
  }
  entries_[entry] = {cone->facet, none, 0, {}};
  cone->entry = entry;
  insert_at(cone, root_place, w);
  return entry;
}

void CellTree::insert_at(Cone* cone, std::uint32_t place, Workspace& w) {
  cone->at = place;
  w.pending.push_back(cone);
  while (!w.pending.empty()) {
    Cone* next = w.pending.back();
    w.pending.pop_back();
    filter(next, next->at, w);
  }
}

// One cone, down to where it comes to rest; the parts cut off on the way are left in w.pending with
// the place they go on from.
void CellTree::filter(Cone* cone, std::uint32_t place, Workspace& w) {
  const Facet& facet = tables_->facets[cone->facet];
  for (;;) {
    const Child here = child_at(place);
    if (here.is_sp()) {
      const Node& node = nodes_[here.node()];
      // A node of another object may go while this face stays: it serves as an end only where it
      // cuts the face itself.
      const auto bounds = [&](EdgeRef) {
        if (!tables_->edits) return true;
        const std::uint32_t owner = links_[here.node()].owner;
        return owner != marked &&
               tables_->object_of(pieces_[owner].facet) == tables_->faces[facet.face].object;
      };
      counts_.predicates += cone->count;
      Cone* cut_off;
      place = here.node() * 2 + sift(cone, node.n, node.error, node.id, lines(), bounds, w.pool,
                                     w.spill, cut_off, counts_.signs);
      if (cut_off && drop_smallest(cone, cut_off, node.id, w) && !cone) {
        cone = std::exchange(cut_off, nullptr);
        place = here.node() * 2 + 1;
      }
      if (cut_off) {
        cut_off->at = here.node() * 2 + 1;
        w.pending.push_back(cut_off);
      }
      continue;
    }

    if (here.is_out()) {
      if (!tables_->casts(cone->facet)) {
        rest_at_leaf(store(*cone, Piece::Kind::at_leaf, place), place);
        break;
      }
      // What rested here without casting goes on from here, below the new shadow volume.
      for (std::uint32_t p = here.is_empty() ? none : here.first_piece(); p != none;) {
        const std::uint32_t next = pieces_[p].next;
        w.pending.push_back(cone_of(pieces_[p], w.pool));
        w.pending.back()->at = place;
        unlink(p);
        release_piece(p);
        p = next;
      }
      attach(*cone, place);
      break;
    }

    const std::uint32_t pp = here.node();
    const Node& node = nodes_[pp];
    const std::uint32_t other = tables_->facets[pieces_[node.id].facet].plane;
    if (other == facet.plane) {  // two facets of one face
      add_to_list(store(*cone, Piece::Kind::coplanar, pp), pp);
      break;
    }
    const PlaneDifference nearer(tables_->planes[facet.plane], node.n, node.error);
    Signs signs(*cone, nearer.d, nearer.bound(*cone), w.spill);
    if (tables_->exact) {
      signs.settle([&](std::uint32_t i) {
        return lines().nearer(cone->span(), i, cone->facet, other, counts_.signs);
      });
    }
    counts_.predicates += cone->count;
    counts_.signs.on += signs.on();
    if (signs.positive() && signs.negative()) {
      const Plane &p = tables_->scene_planes[facet.plane], &q = tables_->scene_planes[other];
      const std::uint32_t cut =
          add_local_line(nearer.line(), {true, {p.exact_normal, p.point, q.exact_normal, q.point}});
      Cone *front, *behind;
      split(*cone, signs, line(cut).n, line(cut).error, cut, false, lines(), w.pool, front, behind);
      w.pool.give_back(cone);
      drop_smallest(front, behind, cut, w);
      if (behind) {
        add_to_list(store(*behind, Piece::Kind::behind, pp), pp);
        w.pool.give_back(behind);
      }
      if (!front) return;
      cone = front;
      place = pp * 2;
      continue;
    }
    if (signs.positive()) {
      place = pp * 2;
      continue;
    }
    add_to_list(store(*cone, signs.negative() ? Piece::Kind::behind : Piece::Kind::coplanar, pp),
                pp);
    break;
  }
  w.pool.give_back(cone);
}

// Of the two parts of a cut, the smaller if it is smaller than what is to be kept; it becomes null.
// The other one's edge there then relies on nobody's other half: it gets an SP-node of its own, and
// as the node that cut it may go any time, a name of its own for the line.
bool CellTree::drop_smallest(Cone*& a, Cone*& b, std::uint32_t line_id, Workspace& w) {
  Cone* lost = too_small(*tables_, a, b);
  if (!lost) return false;
  w.pool.give_back(lost);
  (lost == a ? a : b) = nullptr;
  if (!tables_->edits) return true;
  Cone& kept = a ? *a : *b;
  const std::uint32_t object = tables_->object_of(kept.facet);
  const bool own = line_id - tables_->objects[object].first_edge - tables_->line_shift[object] <
                   tables_->objects[object].edge_count;
  std::uint32_t name = own || line_id >= first_local_line ? line_id : none;
  for (ConeCorner& c : std::span(kept.corners(), kept.count)) {
    if (c.edge.line() != line_id) continue;
    if (name == none) name = add_local_copy(line_id);
    c.edge = EdgeRef(name, c.edge.negative());
  }
  return true;
}

// Replaces a leaf by the shadow volume of a piece: an SP-node for each edge that the cell does not
// already end at, then its PP-node.
void CellTree::attach(Cone& cone, std::uint32_t place) {
  const std::uint32_t leaf = place;
  const std::uint32_t piece = store(cone, Piece::Kind::owner, place);
  for (std::uint32_t i = 0; i < cone.count; ++i) {
    const EdgeRef e = cone.corners()[i].edge;
    if (e.bounded()) continue;
    const Line& l = line(e.line());
    const std::uint32_t node = add_node(l.n, l.error, e.line(), place, piece);
    count_use(e.line(), true);
    slot(place) = Child::sp(node);
    place = node * 2 + (e.negative() ? 1u : 0u);
  }
  const PlaneRay& q = tables_->planes[tables_->facets[cone.facet].plane];
  const std::uint32_t pp = add_node(q.q, q.error, piece, place, piece);
  slot(place) = Child::pp(pp);
  ++pp_nodes_;
  pieces_[piece].place = pp;
  if (live_) live_->changed(leaf);
}

// A child in its place, and told so.
void CellTree::put(std::uint32_t place, Child child) {
  slot(place) = child;
  if (!child.is_out()) {
    links_[child.node()].parent = place;
  } else if (!child.is_empty()) {
    for (std::uint32_t p = child.first_piece(); p != none; p = pieces_[p].next)
      pieces_[p].place = place;
  }
}

std::uint32_t CellTree::store(const Cone& cone, Piece::Kind kind, std::uint32_t place) {
  std::uint32_t id;
  if (free_pieces_.empty()) {
    id = static_cast<std::uint32_t>(pieces_.size());
    pieces_.emplace_back();
  } else {
    id = free_pieces_.take();
  }
  Entry& entry = entries_[cone.entry];
  pieces_[id] = {cone.facet, 0,          0,           cone.error, place, none,
                 none,       cone.entry, entry.first, none,       kind};
  if (entry.first != none) pieces_[entry.first].before = id;
  entry.first = id;
  ++entry.pieces;
  set_corners(id, cone.span());
  if (live_) live_->piece_added(id);
  return id;
}

void CellTree::set_corners(std::uint32_t piece, std::span<const ConeCorner> corners) {
  Piece& p = pieces_[piece];
  p.corner_count = static_cast<std::uint32_t>(corners.size());
  p.first_corner = free_corners_.take(corners_, p.corner_count);
  std::copy(corners.begin(), corners.end(), corners_.begin() + p.first_corner);
  for (const ConeCorner& c : corners) count_use(c.edge.line(), true);
}

void CellTree::release_corners(const Piece& p) {
  for (const ConeCorner& c : corners(p)) count_use(c.edge.line(), false);
  free_corners_.give_back(p.first_corner, p.corner_count);
}

void CellTree::add_to_list(std::uint32_t piece, std::uint32_t pp) {
  std::uint32_t& first = links_[pp].first;
  pieces_[piece].next = first;
  if (first != none) pieces_[first].previous = piece;
  first = piece;
  if (reuniting_) reunite_in_list(piece, pp);
}

void CellTree::rest_at_leaf(std::uint32_t piece, std::uint32_t place) {
  const Child leaf = child_at(place);
  if (!leaf.is_empty()) {
    pieces_[piece].next = leaf.first_piece();
    pieces_[leaf.first_piece()].previous = piece;
  }
  slot(place) = Child::out(piece);
}

// Out of the list of the piece's place. Owners are in none.
void CellTree::unlink(std::uint32_t piece) {
  const Piece& p = pieces_[piece];
  if (p.next != none) pieces_[p.next].previous = p.previous;
  if (p.previous != none) {
    pieces_[p.previous].next = p.next;
  } else if (p.kind == Piece::Kind::at_leaf) {
    slot(p.place) = p.next == none ? Child::out() : Child::out(p.next);
  } else {
    links_[p.place].first = p.next;
  }
}

// Out of its entry, with its fragments; it has been taken out of its place.
void CellTree::release_piece(std::uint32_t piece) {
  if (live_) live_->drop_piece(piece);
  Piece& p = pieces_[piece];
  Entry& entry = entries_[p.entry];
  (p.before == none ? entry.first : pieces_[p.before].after) = p.after;
  if (p.after != none) pieces_[p.after].before = p.before;
  --entry.pieces;
  release_corners(p);
  p.kind = Piece::Kind::free;
  free_pieces_.give_back(piece);
}

std::uint32_t CellTree::add_node(const Real n[3], float error, std::uint32_t id,
                                 std::uint32_t parent, std::uint32_t owner) {
  const Node node{{n[0], n[1], n[2]}, error, {Child::out(), Child::out()}, id};
  const NodeLinks links{parent, owner, none};
  if (free_nodes_.empty()) {
    nodes_.push_back(node);
    links_.push_back(links);
    return static_cast<std::uint32_t>(nodes_.size() - 1);
  }
  const std::uint32_t index = free_nodes_.take();
  nodes_[index] = node;
  links_[index] = links;
  return index;
}

std::uint32_t CellTree::add_local_line(const Line& line, const LightLine& exact) {
  std::uint32_t index;
  if (free_lines_.empty()) {
    index = static_cast<std::uint32_t>(local_lines_.size());
    local_lines_.push_back({line, 0, exact});
  } else {
    index = free_lines_.take();
    local_lines_[index] = {line, 0, exact};
  }
  return first_local_line + index;
}

// For what goes on after the line's object, or its node, has gone. It is idle unless something will
// be stored with it.
std::uint32_t CellTree::add_local_copy(std::uint32_t id) {
  Line copy = line(id);
  copy.a = copy.b = none;
  const std::uint32_t name = add_local_line(copy, tables_->exact ? lines().exact(id) : LightLine{});
  idle_lines_.push_back(name - first_local_line);
  return name;
}

void CellTree::count_use(std::uint32_t line, bool more) {
  if (line < first_local_line) return;
  std::uint32_t& uses = local_lines_[line - first_local_line].uses;
  if (more) {
    ++uses;
  } else if (--uses == 0) {
    idle_lines_.push_back(line - first_local_line);
  }
}

Cone* CellTree::cone_of(const Piece& piece, ConePool& pool) const {
  Cone* cone = pool.take(piece.corner_count + 1);
  cone->facet = piece.facet;
  cone->entry = piece.entry;
  cone->error = piece.error;
  cone->assign(corners(piece));
  return cone;
}

// Generous figures: pages that are never written cost nothing, moving a vector does. Scenes that
// need more get it.
void CellTree::reserve(std::size_t facets) {
  nodes_.reserve(facets * 16);
  links_.reserve(facets * 16);
  pieces_.reserve(facets * 8);
  entries_.reserve(facets);
  corners_.reserve(facets * 36);
}

std::uint64_t CellTree::bytes() const {
  return nodes_.size() * sizeof(Node) + links_.size() * sizeof(NodeLinks) +
         pieces_.size() * sizeof(Piece) + entries_.size() * sizeof(Entry) +
         corners_.size() * sizeof(ConeCorner) + local_lines_.size() * sizeof(LocalLine);
}

std::uint64_t CellTree::depth() const {
  std::uint64_t deepest = 0;
  std::vector<std::pair<Child, std::uint64_t>> pending{{root_, 0}};
  while (!pending.empty()) {
    const auto [here, above] = pending.back();
    pending.pop_back();
    deepest = std::max(deepest, above);
    if (here.is_out()) continue;
    const Node& node = nodes_[here.node()];
    pending.emplace_back(node.child[0], above + 1);
    if (here.is_sp()) pending.emplace_back(node.child[1], above + 1);
  }
  return deepest;
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
