// The invariants of the tree, checked. Every one is stated where it is tested.

#include <cmath>

#include "light_tree.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {
namespace {

std::string say(const char* what, std::size_t which) {
  return std::string(what) + " (" + std::to_string(which) + ")";
}

double bound_for(float n_error, float cone_error) {
  return static_cast<double>(n_error) + static_cast<double>(cone_error) + sign_slack;
}

// A piece may have been cut further since it passed a node. Then its corners lie in what passed,
// but are other numbers: of a true corner the node's function was no more than twice the bound on
// the wrong side, and a number made later differs from that by the bound once more.
constexpr double since_cut = 3;

// A facet's corners are on its plane up to its flatness. The light sees them off by as much over
// their distance, and the loop as convex up to that, so a corner may be on the wrong side of
// another of the facet's edges.
double bend(const LightTables& tables, const Cone& cone) {
  const std::uint32_t plane = tables.facets[cone.facet].plane;
  double nearest = INFINITY;
  for (const ConeCorner& c : cone.span())
    nearest = std::min(
        nearest,
        (tables.space->back(c.r, tables.planes[plane].q) - tables.space->frame().center).norm());
  return 8 * tables.scene_planes[plane].flatness /
         (tables.space->far() ? tables.space->frame().scale : nearest);
}

}  // namespace

std::string CellTree::validate() const {
  // 1. Nodes form a tree: each that is not released is reached exactly once, and links lead back.
  std::vector<std::uint8_t> is_pp(nodes_.size(), 0), reached(nodes_.size(), 0);
  std::vector<std::uint8_t> held(pieces_.size(), 0);
  std::vector<std::uint32_t> uses(local_lines_.size(), 0);
  const auto use = [&uses](std::uint32_t line) {
    if (line >= first_local_line) ++uses[line - first_local_line];
  };
  std::size_t marks = 0;
  std::vector<std::uint32_t> pending{root_place};
  while (!pending.empty()) {
    const std::uint32_t place = pending.back();
    pending.pop_back();
    const Child here = child_at(place);
    if (here.is_out()) {
      // 2. What rests at a leaf does not cast, and knows its leaf.
      for (std::uint32_t p = here.first_piece() == Child::nothing ? none : here.first_piece();
           p != none; p = pieces_[p].next) {
        if (p >= pieces_.size() || held[p]++) return say("a leaf's list is broken", place);
        if (pieces_[p].kind != Piece::Kind::at_leaf || pieces_[p].place != place)
          return say("a piece at a leaf does not know it", p);
        if (tables_->casts(pieces_[p].facet))
          return say("a casting piece rests at a leaf without a shadow volume", p);
      }
      continue;
    }
    const std::uint32_t node = here.node();
    if (node >= nodes_.size() || reached[node]++)
      return say("a node is missing or reached twice", node);
    if (links_[node].parent != place) return say("a node's link does not lead back", node);
    is_pp[node] = here.is_pp();
    pending.push_back(node * 2);
    if (here.is_sp()) {
      pending.push_back(node * 2 + 1);
      const std::uint32_t owner = links_[node].owner;
      if (owner == marked) {
        ++marks;
        if (nodes_[node].child[0].is_empty() || nodes_[node].child[1].is_empty())
          return say("a marked node has an empty side", node);
      } else if (owner >= pieces_.size() || pieces_[owner].kind != Piece::Kind::owner) {
        return say("an SP-node's owner owns nothing", node);
      }
      use(nodes_[node].id);
    }
    if (!here.is_pp()) continue;
    // 3. A PP-node has an owner that casts, and a list of pieces behind it or coplanar with it;
    // each knows the node.
    const std::uint32_t owner = nodes_[node].id;
    if (owner >= pieces_.size() || held[owner]++)
      return say("a PP-node's owner is missing or owns twice", node);
    if (pieces_[owner].kind != Piece::Kind::owner || pieces_[owner].place != node)
      return say("a PP-node's owner does not know it", node);
    if (!tables_->casts(pieces_[owner].facet)) return say("a PP-node's owner does not cast", node);
    for (std::uint32_t p = links_[node].first; p != none; p = pieces_[p].next) {
      if (p >= pieces_.size() || held[p]++) return say("a PP-node's list is broken", node);
      if (pieces_[p].kind != Piece::Kind::behind && pieces_[p].kind != Piece::Kind::coplanar)
        return say("a piece in a list is of the wrong kind", p);
      if (pieces_[p].place != node) return say("a piece in a list does not know its PP-node", p);
    }
  }
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (!reached[i] != (links_[i].owner == released))
      return say("a node is not reached, or it is released and is", i);
  }
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (!held[i] != (pieces_[i].kind == Piece::Kind::free))
      return say("a piece is nowhere in the tree, or it is free and is", i);
  }
  if (marks != marked_nodes_) return say("marked nodes are counted wrongly", marks);

  ConePool pool;
  std::vector<std::int8_t> spill;
  for (std::uint32_t p = 0; p < pieces_.size(); ++p) {
    const Piece& piece = pieces_[p];
    if (piece.kind == Piece::Kind::free) continue;
    for (const ConeCorner& c : corners(piece)) use(c.edge.line());
    Cone* cone = cone_of(piece, pool);
    std::vector<std::uint8_t> edge_bounded(cone->count, 0);
    const double bent = bend(*tables_, *cone);
    const std::uint32_t from =
        piece.kind == Piece::Kind::at_leaf ? piece.place : links_[piece.place].parent;
    for (std::uint32_t place = from; place != root_place; place = links_[place >> 1].parent) {
      const Node& node = nodes_[place >> 1];
      if (is_pp[place >> 1]) {
        // 4. What stands in the front subtree of a PP-node is nowhere certainly behind its plane.
        const PlaneRay& own = tables_->planes[tables_->facets[piece.facet].plane];
        const PlaneDifference nearer(own, node.n, node.error);
        if (Signs(*cone, nearer.d, since_cut * nearer.bound(*cone), spill).negative())
          return say("a piece in front of a PP-node reaches behind it", p);
        continue;
      }
      // 5. A piece lies on its cell's side of every SP-node above it.
      const Signs signs(*cone, node.n, since_cut * bound_for(node.error, cone->error) + bent,
                        spill);
      const int wrong = place & 1 ? 1 : -1;
      for (std::uint32_t i = 0; i < cone->count; ++i) {
        if (signs[i] == wrong) return say("a piece reaches out of its cell", p);
        const std::uint32_t j = i + 1 == cone->count ? 0 : i + 1;
        if (cone->corners()[i].edge.line() == node.id || (signs[i] == 0 && signs[j] == 0))
          edge_bounded[i] = 1;
      }
    }
    // 6. An owner's piece fills its PP-node's cell: an SP-node, of its own or another's, or a plane
    // of the prefix stands at every edge.
    for (std::uint32_t l = tables_->first_prefix_line;
         l < tables_->first_prefix_line + tables_->prefix_lines; ++l) {
      const Line& plane = tables_->lines[l];
      const Signs signs(*cone, plane.n, bound_for(plane.error, cone->error), spill);
      signs.for_each_on_edge([&](std::uint32_t i) { edge_bounded[i] = 1; });
    }
    if (piece.kind == Piece::Kind::owner) {
      for (std::uint32_t i = 0; i < cone->count; ++i) {
        if (!edge_bounded[i]) return say("an edge of a PP-node's owner has no SP-node", p);
      }
    } else if (piece.kind != Piece::Kind::at_leaf) {
      // 7. What is in a PP-node's list is nowhere certainly in front of its plane, and what is
      // coplanar nowhere certainly off it.
      const Node& node = nodes_[piece.place];
      const PlaneRay& own = tables_->planes[tables_->facets[piece.facet].plane];
      if (tables_->facets[pieces_[node.id].facet].plane != tables_->facets[piece.facet].plane) {
        const PlaneDifference nearer(own, node.n, node.error);
        const Signs signs(*cone, nearer.d, nearer.bound(*cone), spill);
        if (signs.positive() || (signs.negative() && piece.kind == Piece::Kind::coplanar))
          return say("a piece behind a PP-node reaches in front of it", p);
      }
    }
    pool.give_back(cone);
  }
  // 8. A line of the cell's own is counted as often as nodes and pieces use it.
  for (std::size_t i = 0; i < uses.size(); ++i) {
    if (uses[i] != (local_lines_[i].uses == none ? 0 : local_lines_[i].uses))
      return say("a line's uses are counted wrongly", i);
  }
  // 9. An entry holds its facet's pieces.
  std::size_t listed = 0;
  for (std::uint32_t e = 0; e < entries_.size(); ++e) {
    std::uint32_t count = 0;
    for (std::uint32_t p = entries_[e].facet == none ? none : entries_[e].first; p != none;
         p = pieces_[p].after, ++count) {
      if (count > pieces_.size()) return say("an entry's list runs in a circle", e);
      if (pieces_[p].entry != e || pieces_[p].facet != entries_[e].facet)
        return say("an entry holds another's piece", e);
    }
    if (entries_[e].facet != none && count != entries_[e].pieces)
      return say("an entry's pieces are counted wrongly", e);
    listed += count;
  }
  if (listed != live_pieces()) return "a piece is in no entry";
  return {};
}

std::string LightTree::validate() const {
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    std::string what = cells_[c].validate();
    if (what.empty() && is_live())
      what = live_[c].validate(cells_[c], target(), shadows_.blocks[c]);
    if (!what.empty()) return "cell " + std::to_string(c) + ": " + what;
  }
  if (options_.edits) {
    if (std::string what = validate_books(); !what.empty()) return what;
  }
  // 14. A face's fragments, and what was dropped, add up to its area, as far as corners that carry
  // a rounding of their distance from the light, and of their own coordinates, can say: for a
  // needle far away, or a face seen at a grazing angle, which prolongs it, that is more than a
  // share of its area.
  for (std::size_t f = 0; f < shadows_.areas.size(); ++f) {
    const FaceArea& a = shadows_.areas[f];
    if (a.facing == Facing::ignored || a.facing == Facing::refused) continue;
    Eigen::AlignedBox3d box;
    double spread = 0;
    const Face& face = scene_.faces()[f];
    for (const Facet& facet : scene_.facets().subspan(face.first_facet, face.facet_count)) {
      for (const Corner& c : scene_.corners_of(facet)) {
        box.extend(scene_.vertices()[c.vertex]);
        if (a.facing == Facing::toward)
          spread = std::max(
              spread, space_.spread(scene_.vertices()[c.vertex], scene_.planes()[facet.plane]));
      }
    }
    const double reach =
        space_.reach(box) + box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).norm();
    if (!(std::abs(a.lit + a.shadowed + a.dropped - a.area) <=
          1e-9 * a.area + (64 * reach + 8 * spread) * roundoff * box.diagonal().norm())) {
      return say("a face's lit and shadowed areas do not add up to its area", f);
    }
  }
  return {};
}

std::string LightTree::validate_books() const {
  // 12. Location lists hold every entry once, under its own object; a facet that enters has one,
  // and no other has.
  std::size_t listed = 0, entries = 0;
  std::vector<std::uint8_t> entered(enters_.size(), 0);
  for (const CellTree& cell : cells_) {
    for (const Entry& e : cell.entries()) entries += e.facet != none;
  }
  for (std::size_t o = 0; o < locations_.size(); ++o) {
    for (Location l = locations_[o]; l.cell != none; l = cells_[l.cell].entries()[l.entry].next) {
      if (l.cell >= cells_.size() || l.entry >= cells_[l.cell].entries().size())
        return say("a location leads nowhere", o);
      const std::uint32_t facet = cells_[l.cell].entries()[l.entry].facet;
      if (facet == none || tables_.object_of(facet) != o)
        return say("a location leads to another object's entry", o);
      entered[facet] = 1;
      if (++listed > entries) return say("location lists run in a circle", o);
    }
  }
  if (listed != entries) return "an entry is in no location list";
  for (std::size_t f = 0; f < enters_.size(); ++f) {
    if (enters_[f] != entered[f])
      return say("a facet that entered has no location, or one that did not has", f);
  }
  // 13. A marked node's line, if it is not the cell's own, lies in a block that has been left and
  // counts it; other nodes' lines are those of their objects as they stand.
  std::vector<std::uint32_t> kept(line_blocks_.size(), 0);
  for (const CellTree& cell : cells_) {
    std::vector<Child> pending{cell.root()};
    while (!pending.empty()) {
      const Child here = pending.back();
      pending.pop_back();
      if (here.is_out()) continue;
      const Node& node = cell.nodes()[here.node()];
      pending.push_back(node.child[0]);
      if (!here.is_sp()) continue;
      pending.push_back(node.child[1]);
      if (node.id >= first_local_line) continue;
      const Line& l = tables_.lines[node.id];
      if (!std::equal(l.n, l.n + 3, node.n)) return say("a node's line has changed", here.node());
      const std::uint32_t owner = cell.links()[here.node()].owner, b = block_of_line_[node.id];
      if (owner == marked) {
        ++kept[b];
      } else if (b != block_of_object_[tables_.object_of(cell.pieces()[owner].facet)]) {
        return say("a node's line is another object's", here.node());
      }
    }
  }
  for (std::size_t b = 0; b < kept.size(); ++b) {
    if (kept[b] != line_blocks_[b].kept) return say("planes left behind are counted wrongly", b);
    if (kept[b] != 0 && !line_blocks_[b].orphan)
      return say("an object shares lines with planes left behind", b);
  }
  return {};
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
