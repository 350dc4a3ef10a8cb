#include "tree.hpp"

#include <algorithm>
#include <cmath>

namespace shadowcut {

void CellTree::insert(Cone* cone, Workspace& w) {
  cone->at = root_place;
  w.pending.push_back(cone);
  while (!w.pending.empty()) {
    Cone* next = w.pending.back();
    w.pending.pop_back();
    filter(next, next->at, w);
  }
}

// One cone, down to where it comes to rest; the parts cut off on the way are left in w.pending with the place they go on from.
void CellTree::filter(Cone* cone, std::uint32_t place, Workspace& w) {
  const Facet& facet = tables_->facets[cone->facet];
  const PlaneRay& own = tables_->planes[facet.plane];
  const auto line_of = [this](std::uint32_t id) -> const Line& { return line(id); };
  for (;;) {
    const Child here = child_at(place);
    if (here.is_sp()) {
      const Node& node = nodes_[here.node()];
      counts_.predicates += cone->count;
      Cone* cut_off;
      place = here.node() * 2 + sift(cone, node.n, node.error, node.id, tables_->rays, line_of, w.pool, w.spill, cut_off, counts_.on);
      if (cut_off) {
        cut_off->at = here.node() * 2 + 1;
        w.pending.push_back(cut_off);
      }
      continue;
    }

    if (here.is_out()) {
      if (tables_->casts(cone->facet)) {
        attach(*cone, place);
      } else {
        const std::uint32_t first = here.first_piece();
        const std::uint32_t piece = store(*cone, Piece::Kind::at_leaf, place);
        pieces_[piece].next = first == Child::nothing ? none : first;
        slot(place) = Child::out(piece);
      }
      break;
    }

    const std::uint32_t pp = here.node();
    const Node& node = nodes_[pp];
    const std::uint32_t other = tables_->facets[pieces_[node.id].facet].plane;
    if (other == facet.plane) {  // two facets of one face
      add_to_list(store(*cone, Piece::Kind::coplanar, pp), pp);
      break;
    }
    const double d[3] = {own.q[0] - node.n[0], own.q[1] - node.n[1], own.q[2] - node.n[2]};
    const double size = std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2]);
    const double d_error = static_cast<double>(own.error) + static_cast<double>(node.error) + 2 * unit_roundoff * size;
    const double bound = d_error + size * (static_cast<double>(cone->error) + sign_slack);
    const Signs signs(*cone, d, bound, w.spill);
    counts_.predicates += cone->count;
    counts_.on += signs.on();
    if (signs.positive() && signs.negative()) {
      const std::uint32_t cut = crossing_line(d, d_error);
      Cone *front, *behind;
      split(*cone, signs, line(cut).n, line(cut).error, cut, false, tables_->rays, line_of, w.pool, front, behind);
      w.pool.give_back(cone);
      add_to_list(store(*behind, Piece::Kind::behind, pp), pp);
      w.pool.give_back(behind);
      cone = front;
      place = pp * 2;
      continue;
    }
    if (signs.positive()) {
      place = pp * 2;
      continue;
    }
    add_to_list(store(*cone, signs.negative() ? Piece::Kind::behind : Piece::Kind::coplanar, pp), pp);
    break;
  }
  w.pool.give_back(cone);
}

// Replaces a leaf by the shadow volume of a piece: an SP-node for each edge that the cell does not already end at, then its PP-node.
void CellTree::attach(Cone& cone, std::uint32_t place) {
  const std::uint32_t piece = store(cone, Piece::Kind::owner, place);
  for (std::uint32_t i = 0; i < cone.count; ++i) {
    const EdgeRef e = cone.corners()[i].edge;
    if (e.bounded()) continue;
    const Line& l = line(e.line());
    const std::uint32_t node = add_node(l.n, l.error, e.line(), place, piece);
    slot(place) = Child::sp(node);
    place = node * 2 + (e.negative() ? 1u : 0u);
  }
  const PlaneRay& q = tables_->planes[tables_->facets[cone.facet].plane];
  const std::uint32_t pp = add_node(q.q, q.error, piece, place, none);
  slot(place) = Child::pp(pp);
  ++pp_nodes_;
  pieces_[piece].place = pp;
}

std::uint32_t CellTree::store(const Cone& cone, Piece::Kind kind, std::uint32_t place) {
  const auto id = static_cast<std::uint32_t>(pieces_.size());
  pieces_.push_back({cone.facet, static_cast<std::uint32_t>(corners_.size()), cone.count, cone.error, place, none, kind, {}});
  corners_.insert(corners_.end(), cone.corners(), cone.corners() + cone.count);
  return id;
}

void CellTree::add_to_list(std::uint32_t piece, std::uint32_t pp) {
  pieces_[piece].next = links_[pp].owner;
  links_[pp].owner = piece;
}

std::uint32_t CellTree::add_node(const double n[3], float error, std::uint32_t id, std::uint32_t parent, std::uint32_t owner) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({{n[0], n[1], n[2]}, error, {Child::out(), Child::out()}, id});
  links_.push_back({parent, owner});
  return index;
}

std::uint32_t CellTree::crossing_line(const double d[3], double error) {
  const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  const double relative = error / length + 2 * unit_roundoff;
  local_lines_.push_back(
      {{d[0] / length, d[1] / length, d[2] / length}, std::nextafter(static_cast<float>(relative), INFINITY), none, none});
  return static_cast<std::uint32_t>(tables_->lines.size() + local_lines_.size() - 1);
}

Cone* CellTree::cone_of(const Piece& piece, ConePool& pool) const {
  Cone* cone = pool.take(piece.corner_count + 1);
  cone->facet = piece.facet;
  cone->error = piece.error;
  cone->assign(corners(piece));
  return cone;
}

void CellTree::link_locations(std::uint32_t cell, std::vector<Location>& heads) {
  for (std::size_t i = pieces_.size(); i-- > 0;) {
    Location& head = heads[pieces_[i].facet];
    pieces_[i].location = head;
    head = {cell, static_cast<std::uint32_t>(i)};
  }
}

// Generous figures: pages that are never written cost nothing, moving a vector does. Scenes that need more get it.
void CellTree::reserve(std::size_t facets) {
  nodes_.reserve(facets * 16);
  links_.reserve(facets * 16);
  pieces_.reserve(facets * 8);
  corners_.reserve(facets * 36);
}

std::uint64_t CellTree::bytes() const {
  return nodes_.size() * sizeof(Node) + links_.size() * sizeof(NodeLinks) + pieces_.size() * sizeof(Piece) +
         corners_.size() * sizeof(ConeCorner) + local_lines_.size() * sizeof(Line);
}

std::uint64_t CellTree::depth() const {
  std::vector<std::uint32_t> depth(nodes_.size());
  std::uint32_t deepest = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {  // parents come before their children
    depth[i] = links_[i].parent == root_place ? 1 : depth[links_[i].parent >> 1] + 1;
    deepest = std::max(deepest, depth[i]);
  }
  return deepest;
}

}  // namespace shadowcut
