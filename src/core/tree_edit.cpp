// Taking faces out of a cell's tree (CS95, section 3).
//
// (a) What lies behind a PP-node, on it, or at a leaf is only taken out of a list. (b), (c) A
// PP-node gives way to what is in front of it, and the pieces behind it are inserted into that; its
// SP-nodes are marked. A marked node with an empty side gives way to its other side. One with
// something on both sides is removed by inserting the smaller side, if it is small, into the
// larger; otherwise it stays, as a plain dividing plane, until a later edit leaves one side empty
// or small.
//
// Why a marked node with an empty side may go: an edge relies on a node only where the node has cut
// the face, and then the other half of the face is on the node's other side, which is not empty; or
// where node and face are of one object, and then the face is gone too. (Displaced pieces go back
// before any node goes, or their side would look empty.)
//
// What joining has to look after. Faces cut by the node end there on both sides. The halves on the
// small side are at hand; through their entries' lists the halves on the large side are found.
// Where two halves make a whole again under the large side's PP-node, they do; otherwise that
// PP-node gets a copy of the node just above itself.

#include <algorithm>

#include "live.hpp"
#include "tree.hpp"
#include "unite.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {
namespace {

bool has_edge_on(std::span<const ConeCorner> corners, std::uint32_t line) {
  return std::any_of(corners.begin(), corners.end(),
                     [line](const ConeCorner& c) { return c.edge.line() == line; });
}

}  // namespace

void CellTree::remove(std::span<const std::uint32_t> entries, Workspace& w,
                      std::vector<std::uint32_t>& kept, std::vector<std::uint32_t>& given_up) {
  // PP-nodes to go; places below which there is less than there was
  std::vector<std::uint32_t> pps, shrunk;
  for (const std::uint32_t e : entries) {
    for (std::uint32_t p = entries_[e].first; p != none;) {
      const std::uint32_t next = pieces_[p].after;
      if (pieces_[p].kind == Piece::Kind::owner) {
        pps.push_back(pieces_[p].place);
        mark_planes_of(p);
      } else {
        if (pieces_[p].kind == Piece::Kind::at_leaf) shrunk.push_back(pieces_[p].place);
        unlink(p);
        release_piece(p);
      }
      p = next;
    }
  }
  std::vector<Displaced> displaced;
  for (const std::uint32_t pp : pps) {
    take_pp_out(pp, displaced, w);
    shrunk.push_back(pp * 2);
  }
  displaced_last_ = displaced.size();
  for (const std::uint32_t e : entries) {
    entries_[e].facet = none;
    free_entries_.give_back(e);
  }
  insert_displaced(displaced, w);
  for (const std::uint32_t place : shrunk) clear_up(place, false, w);
  if (tables_->join_threshold > 0) {
    for (const std::uint32_t place : shrunk) clear_up(place, true, w);
  }

  for (const std::uint32_t node : new_marks_) {
    if (links_[node].owner != marked) continue;
    ++counts_.deferred;
    if (nodes_[node].id >= first_local_line) continue;
    links_[node].first = line_reported;
    kept.push_back(nodes_[node].id);
  }
  new_marks_.clear();
  given_up.insert(given_up.end(), given_up_lines_.begin(), given_up_lines_.end());
  given_up_lines_.clear();
  if (live_) live_->settle_places([this](std::uint32_t place) { return resolve(place); });
  for (const std::uint32_t node : released_nodes_) free_nodes_.give_back(node);
  released_nodes_.clear();
  for (const std::uint32_t i : idle_lines_) {
    if (local_lines_[i].uses != 0) continue;
    local_lines_[i].uses = none;  // free; it may stand here twice
    free_lines_.give_back(i);
  }
  idle_lines_.clear();
}

// Where a place has come to that may have been below a node no longer there.
std::uint32_t CellTree::resolve(std::uint32_t place) const {
  while (place != root_place && links_[place >> 1].owner == released)
    place = links_[place >> 1].parent;
  return place;
}

// The SP-nodes that a piece attached stand in one row above its PP-node; marked ones may stand
// between them.
void CellTree::mark_planes_of(std::uint32_t piece) {
  for (std::uint32_t place = links_[pieces_[piece].place].parent; place != root_place;
       place = links_[place >> 1].parent) {
    NodeLinks& links = links_[place >> 1];
    if (links.owner == marked) continue;
    if (links.owner != piece) return;
    links.owner = marked;
    ++marked_nodes_;
    new_marks_.push_back(place >> 1);
  }
}

void CellTree::take_pp_out(std::uint32_t pp, std::vector<Displaced>& displaced, Workspace& w) {
  for (std::uint32_t p = links_[pp].first; p != none;) {
    const std::uint32_t next = pieces_[p].next;
    displace(p, pp * 2, displaced, w);
    p = next;
  }
  const std::uint32_t place = links_[pp].parent;
  put(place, nodes_[pp].child[0]);
  release_piece(nodes_[pp].id);
  release_node(pp, false);
  if (live_) live_->changed(place);
}

void CellTree::displace(std::uint32_t piece, std::uint32_t place, std::vector<Displaced>& displaced,
                        Workspace& w) {
  displaced.push_back({cone_of(pieces_[piece], w.pool), place});
  release_piece(piece);
}

void CellTree::insert_displaced(std::vector<Displaced>& displaced, Workspace& w) {
  std::stable_partition(displaced.begin(), displaced.end(),
                        [this](const Displaced& d) { return tables_->casts(d.cone->facet); });
  for (const Displaced& d : displaced) insert_at(d.cone, resolve(d.place), w);
  displaced.clear();
}

void CellTree::release_node(std::uint32_t node, bool is_sp) {
  if (live_) live_->drop_places_of(node);
  if (is_sp) {
    if (links_[node].owner == marked) {
      --marked_nodes_;
      if (links_[node].first == line_reported) given_up_lines_.push_back(nodes_[node].id);
    }
    count_use(nodes_[node].id, false);
  } else {
    --pp_nodes_;
  }
  links_[node].owner = released;
  released_nodes_.push_back(node);
}

// Goes up from a place through marked nodes and removes those that can go.
void CellTree::clear_up(std::uint32_t place, bool joining, Workspace& w) {
  for (place = resolve(place); place != root_place;) {
    const std::uint32_t node = place >> 1;
    if (links_[node].owner != marked) return;
    const std::uint32_t above = links_[node].parent;
    if (!collapse(node) && joining) join(node, w);
    place = above;
  }
}

bool CellTree::collapse(std::uint32_t node) {
  const Child a = nodes_[node].child[0], b = nodes_[node].child[1];
  if (!a.is_empty() && !b.is_empty()) return false;
  const std::uint32_t place = links_[node].parent;
  put(place, a.is_empty() ? b : a);
  release_node(node, true);
  if (live_) live_->changed(place);
  return true;
}

// The side of an SP-node with fewer nodes below it, if those are no more than `limit`; 2 if both
// sides have more.
std::uint32_t CellTree::smaller_side(std::uint32_t node, std::uint32_t limit) const {
  std::vector<Child> pending[2];
  std::uint32_t nodes = 0;
  for (const int side : {0, 1}) pending[side].push_back(nodes_[node].child[side]);
  for (;;) {
    for (const std::uint32_t side : {0u, 1u}) {
      auto& rest = pending[side];
      while (!rest.empty() && rest.back().is_out()) rest.pop_back();
      if (rest.empty()) return side;
      const Child here = rest.back();
      rest.pop_back();
      rest.push_back(nodes_[here.node()].child[0]);
      if (here.is_sp()) rest.push_back(nodes_[here.node()].child[1]);
    }
    if (++nodes > limit) return 2;
  }
}

// Releases everything below a branch, and leaves the cones of its pieces, the upper ones first.
void CellTree::take_apart(Child side, std::vector<Displaced>& displaced, Workspace& w) {
  std::vector<Child> pending{side};
  const auto displace_list = [&](std::uint32_t p) {
    while (p != none) {
      const std::uint32_t next = pieces_[p].next;
      displace(p, none, displaced, w);
      p = next;
    }
  };
  while (!pending.empty()) {
    const Child here = pending.back();
    pending.pop_back();
    if (here.is_out()) {
      if (!here.is_empty()) displace_list(here.first_piece());
      continue;
    }
    const std::uint32_t node = here.node();
    if (here.is_sp()) {
      pending.push_back(nodes_[node].child[1]);
    } else {
      displace(nodes_[node].id, none, displaced, w);
      displace_list(links_[node].first);
    }
    pending.push_back(nodes_[node].child[0]);
    release_node(node, here.is_sp());
  }
}

// CS95, section 3.2: the smaller side is filtered into the larger, which takes the node's place.
bool CellTree::join(std::uint32_t node, Workspace& w) {
  const std::uint32_t side = smaller_side(node, tables_->join_threshold);
  if (side == 2) return false;
  const std::uint32_t place = links_[node].parent, line_id = nodes_[node].id;
  std::vector<Displaced> halves;
  take_apart(nodes_[node].child[side], halves, w);

  // The node's line, and others that only nodes of the small side stood for, live on under local
  // names.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> names;
  const auto local_name = [&](std::uint32_t id) {
    if (id >= first_local_line) return id;
    for (const auto& [known, name] : names) {
      if (known == id) return name;
    }
    names.emplace_back(id, add_local_copy(id));
    return names.back().second;
  };
  std::vector<std::uint32_t> above;  // lines of the nodes that go on bounding the cell
  for (std::uint32_t p = place; p != root_place; p = links_[p >> 1].parent) {
    const bool is_pp = child_at(links_[p >> 1].parent).is_pp();
    if (!is_pp) above.push_back(nodes_[p >> 1].id);
  }
  const auto is_above = [&](std::uint32_t id) {
    return std::find(above.begin(), above.end(), id) != above.end();
  };

  // Faces cut by the node, on the large side. Where the smallest features are dropped, what is left
  // on the small side need not reach it.
  const bool may_lack_edge = !tables_->least.keeps_all();
  std::vector<std::pair<std::uint32_t, std::uint32_t>> others;  // how deep below the node; piece
  std::vector<std::uint32_t> entries_seen;
  for (const Displaced& h : halves) {
    if (!may_lack_edge && !has_edge_on(h.cone->span(), line_id)) continue;
    if (std::find(entries_seen.begin(), entries_seen.end(), h.cone->entry) != entries_seen.end())
      continue;
    entries_seen.push_back(h.cone->entry);
    for (std::uint32_t p = entries_[h.cone->entry].first; p != none; p = pieces_[p].after) {
      if (!has_edge_on(corners(pieces_[p]), line_id)) continue;
      if (const std::uint32_t depth = depth_below(p, node); depth != none)
        others.emplace_back(depth, p);
    }
  }
  // From above: a piece may grow only as far as what it stands in front of.
  std::sort(others.begin(), others.end());
  for (const Displaced& h : halves) {
    const Object& object = tables_->objects[tables_->object_of(h.cone->facet)];
    const std::uint32_t first_own =
        object.first_edge + tables_->line_shift[tables_->object_of(h.cone->facet)];
    for (std::uint32_t i = 0; i < h.cone->count; ++i) {
      EdgeRef& e = h.cone->corners()[i].edge;
      if (!e.bounded() || is_above(e.line()) || tables_->is_prefix_line(e.line())) continue;
      const bool own = e.line() - first_own < object.edge_count;
      e = EdgeRef(own ? e.line() : local_name(e.line()), e.negative());
    }
  }
  for (const auto& [depth, p] : others) {
    rename_edges(p, line_id, local_name(line_id), pieces_[p].kind == Piece::Kind::owner);
    if (pieces_[p].kind != Piece::Kind::owner || reunite(p, local_name(line_id), node, halves, w))
      continue;
    const auto on = corners(pieces_[p]);
    const auto cut = std::find_if(on.begin(), on.end(), [&](const ConeCorner& c) {
      return c.edge.line() == local_name(line_id);
    });
    add_sp_above(pieces_[p].place, cut->edge, p);
  }
  put(place, nodes_[node].child[1 - side]);
  release_node(node, true);
  if (live_) live_->changed(place);
  ++counts_.joined;
  for (Displaced& h : halves) h.place = place;
  reuniting_ = true;
  insert_displaced(halves, w);
  reuniting_ = false;
  return true;
}

// How many nodes below a node a piece lies; none: not below it.
std::uint32_t CellTree::depth_below(std::uint32_t piece, std::uint32_t node) const {
  const Piece& p = pieces_[piece];
  std::uint32_t depth = 0;
  for (std::uint32_t place = p.kind == Piece::Kind::at_leaf ? p.place : links_[p.place].parent;
       place != root_place; place = links_[place >> 1].parent) {
    if (place >> 1 == node) return depth;
    ++depth;
  }
  return none;
}

void CellTree::rename_edges(std::uint32_t piece, std::uint32_t line, std::uint32_t name,
                            bool bounded) {
  const Piece& p = pieces_[piece];
  for (std::uint32_t i = p.first_corner; i < p.first_corner + p.corner_count; ++i) {
    EdgeRef& e = corners_[i].edge;
    if (e.line() != line) continue;
    count_use(line, false);
    count_use(name, true);
    e = EdgeRef(name, e.negative());
    e.set_bounded(bounded);
  }
}

// An SP-node between a PP-node and what is above it: the PP-node on the inside of the edge.
void CellTree::add_sp_above(std::uint32_t pp, EdgeRef edge, std::uint32_t owner) {
  const std::uint32_t place = links_[pp].parent;
  const Line& l = line(edge.line());
  const std::uint32_t node = add_node(l.n, l.error, edge.line(), place, owner);
  count_use(edge.line(), true);
  slot(place) = Child::sp(node);
  put(node * 2 + (edge.negative() ? 1u : 0u), Child::pp(pp));
  if (live_) live_->changed(place);
}

// Makes an owner's piece, which ends at the node on this line, and its other half one again, where
// they lie. Takes the half out of `halves`.
bool CellTree::reunite(std::uint32_t piece, std::uint32_t line_id, std::uint32_t node,
                       std::vector<Displaced>& halves, Workspace& w) {
  const std::uint32_t pp = pieces_[piece].place;
  std::vector<ConeCorner> whole;
  for (auto h = halves.begin(); h != halves.end(); ++h) {
    Cone& half = *h->cone;
    if (half.entry != pieces_[piece].entry ||
        !unite(corners(pieces_[piece]), half.span(), half.facet, line_id, lines(), whole))
      continue;
    if (!fits_below(half, links_[pp].parent, node, w)) continue;
    // Edges of the half that neither it nor the piece ends at already.
    std::vector<EdgeRef> open;
    bool sure = true;
    for (const ConeCorner& c : half.span()) {
      if (c.edge.bounded() || !std::any_of(whole.begin(), whole.end(), [&](const ConeCorner& k) {
            return same_side(k.edge, c.edge);
          }))
        continue;
      const auto mine = corners(pieces_[piece]);
      const auto known = std::find_if(
          mine.begin(), mine.end(), [&](const ConeCorner& k) { return same_side(k.edge, c.edge); });
      if (known == mine.end()) {
        open.push_back(c.edge);
      } else if (known->edge.bounded()) {
        // the node that bounds the piece there may lie on its edge and not on the half's
        sure = false;
      }
    }
    if (!sure) continue;
    if (live_) live_->drop_piece(piece);
    release_corners(pieces_[piece]);
    set_corners(piece, whole);
    pieces_[piece].error = std::max(pieces_[piece].error, half.error);
    if (live_) live_->piece_added(piece);
    for (const EdgeRef e : open) add_sp_above(pp, e, piece);
    w.pool.give_back(h->cone);
    halves.erase(h);
    return true;
  }
  return false;
}

// Whether a cone lies on the way's side of every node from a place up to, and without, `node`.
bool CellTree::fits_below(Cone& cone, std::uint32_t place, std::uint32_t node, Workspace& w) const {
  const std::uint32_t own = tables_->facets[cone.facet].plane;
  SignCounts counts;
  for (; place >> 1 != node; place = links_[place >> 1].parent) {
    const Node& here = nodes_[place >> 1];
    if (child_at(links_[place >> 1].parent).is_pp()) {
      const PlaneDifference nearer(tables_->planes[own], here.n, here.error);
      Signs signs(cone, nearer.d, nearer.bound(cone), w.spill);
      const std::uint32_t other = tables_->facets[pieces_[here.id].facet].plane;
      if (tables_->exact && other != own) {
        signs.settle([&](std::uint32_t i) {
          return lines().nearer(cone.span(), i, cone.facet, other, counts);
        });
      }
      if (signs.negative()) return false;
      continue;
    }
    Signs signs(cone, here.n,
                static_cast<double>(here.error) + static_cast<double>(cone.error) + sign_slack,
                w.spill);
    if (tables_->exact)
      signs.settle([&](std::uint32_t i) {
        return lines().side(cone.span(), i, cone.facet, here.id, counts);
      });
    if (place & 1 ? signs.positive() : signs.negative()) return false;
  }
  return true;
}

// Joins a piece that has come to a PP-node's list with pieces of its facet already there.
void CellTree::reunite_in_list(std::uint32_t piece, std::uint32_t pp) {
  std::vector<ConeCorner> whole;
  for (std::uint32_t p = links_[pp].first; p != none;) {
    const std::uint32_t next = pieces_[p].next;
    if (p != piece && pieces_[p].entry == pieces_[piece].entry &&
        pieces_[p].kind == pieces_[piece].kind &&
        unite(corners(pieces_[piece]), corners(pieces_[p]), pieces_[p].facet, none, lines(),
              whole)) {
      const float error = pieces_[p].error;
      unlink(p);
      release_piece(p);
      if (live_) live_->drop_piece(piece);
      release_corners(pieces_[piece]);
      set_corners(piece, whole);
      pieces_[piece].error = std::max(pieces_[piece].error, error);
      if (live_) live_->piece_added(piece);
      p = links_[pp].first;  // the larger one may fit with what was passed over
      continue;
    }
    p = next;
  }
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
