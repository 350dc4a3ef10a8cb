// The invariants of the tree, checked. Every one is stated where it is tested.

#include <cmath>

#include "light_tree.hpp"

namespace shadowcut {
namespace {

std::string say(const char* what, std::size_t which) { return std::string(what) + " (" + std::to_string(which) + ")"; }

double bound_for(float n_error, float cone_error) { return static_cast<double>(n_error) + static_cast<double>(cone_error) + sign_slack; }

}  // namespace

std::string CellTree::validate() const {
  // 1. Nodes form a tree: each is reached exactly once, parents come before children, and links lead back.
  std::vector<std::uint8_t> is_pp(nodes_.size(), 0), reached(nodes_.size(), 0);
  std::vector<std::uint8_t> held(pieces_.size(), 0);
  std::vector<std::uint32_t> pending{root_place};
  while (!pending.empty()) {
    const std::uint32_t place = pending.back();
    pending.pop_back();
    const Child here = child_at(place);
    if (here.is_out()) {
      // 2. What rests at a leaf does not cast, and knows its leaf.
      for (std::uint32_t p = here.first_piece() == Child::nothing ? none : here.first_piece(); p != none; p = pieces_[p].next) {
        if (p >= pieces_.size() || held[p]++) return say("a leaf's list is broken", place);
        if (pieces_[p].kind != Piece::Kind::at_leaf || pieces_[p].place != place) return say("a piece at a leaf does not know it", p);
        if (tables_->casts(pieces_[p].facet)) return say("a casting piece rests at a leaf without a shadow volume", p);
      }
      continue;
    }
    const std::uint32_t node = here.node();
    if (node >= nodes_.size() || reached[node]++) return say("a node is missing or reached twice", node);
    if (links_[node].parent != place) return say("a node's link does not lead back", node);
    if (place != root_place && (place >> 1) >= node) return say("a child comes before its parent", node);
    is_pp[node] = here.is_pp();
    pending.push_back(node * 2);
    if (here.is_sp()) pending.push_back(node * 2 + 1);
    if (!here.is_pp()) continue;
    // 3. A PP-node has an owner that casts, and a list of pieces behind it or coplanar with it; each knows the node.
    const std::uint32_t owner = nodes_[node].id;
    if (owner >= pieces_.size() || held[owner]++) return say("a PP-node's owner is missing or owns twice", node);
    if (pieces_[owner].kind != Piece::Kind::owner || pieces_[owner].place != node) return say("a PP-node's owner does not know it", node);
    if (!tables_->casts(pieces_[owner].facet)) return say("a PP-node's owner does not cast", node);
    for (std::uint32_t p = links_[node].owner; p != none; p = pieces_[p].next) {
      if (p >= pieces_.size() || held[p]++) return say("a PP-node's list is broken", node);
      if (pieces_[p].kind != Piece::Kind::behind && pieces_[p].kind != Piece::Kind::coplanar)
        return say("a piece in a list is of the wrong kind", p);
      if (pieces_[p].place != node) return say("a piece in a list does not know its PP-node", p);
    }
  }
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (!reached[i]) return say("a node is not reached", i);
  }
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (!held[i]) return say("a piece is nowhere in the tree", i);
  }

  ConePool pool;
  std::vector<std::int8_t> spill;
  for (std::uint32_t p = 0; p < pieces_.size(); ++p) {
    const Piece& piece = pieces_[p];
    Cone* cone = cone_of(piece, pool);
    std::vector<std::uint8_t> edge_bounded(cone->count, 0);
    const std::uint32_t from = piece.kind == Piece::Kind::at_leaf ? piece.place : links_[piece.place].parent;
    for (std::uint32_t place = from; place != root_place; place = links_[place >> 1].parent) {
      const Node& node = nodes_[place >> 1];
      if (is_pp[place >> 1]) {
        // 4. What stands in the front subtree of a PP-node is nowhere certainly behind its plane.
        const PlaneRay& own = tables_->planes[tables_->facets[piece.facet].plane];
        const double d[3] = {own.q[0] - node.n[0], own.q[1] - node.n[1], own.q[2] - node.n[2]};
        const double size = std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2]);
        const double bound = static_cast<double>(own.error) + static_cast<double>(node.error) +
                             size * (static_cast<double>(cone->error) + 6 * unit_roundoff);
        if (Signs(*cone, d, bound, spill).negative()) return say("a piece in front of a PP-node reaches behind it", p);
        continue;
      }
      // 5. A piece lies on its cell's side of every SP-node above it.
      const Signs signs(*cone, node.n, bound_for(node.error, cone->error), spill);
      const int wrong = place & 1 ? 1 : -1;
      for (std::uint32_t i = 0; i < cone->count; ++i) {
        if (signs[i] == wrong) return say("a piece reaches out of its cell", p);
        const std::uint32_t j = i + 1 == cone->count ? 0 : i + 1;
        if (cone->corners()[i].edge.line() == node.id || (signs[i] == 0 && signs[j] == 0)) edge_bounded[i] = 1;
      }
    }
    // 6. An owner's piece fills its PP-node's cell: an SP-node, of its own or another's, stands at every edge. (Edges that a plane of the
    // prefix bounds are marked.)
    if (piece.kind == Piece::Kind::owner) {
      for (std::uint32_t i = 0; i < cone->count; ++i) {
        if (!edge_bounded[i] && !cone->corners()[i].edge.bounded()) return say("an edge of a PP-node's owner has no SP-node", p);
      }
    } else if (piece.kind != Piece::Kind::at_leaf) {
      // 7. What is in a PP-node's list is nowhere certainly in front of its plane, and what is coplanar nowhere certainly off it.
      const Node& node = nodes_[piece.place];
      const PlaneRay& own = tables_->planes[tables_->facets[piece.facet].plane];
      if (tables_->facets[pieces_[node.id].facet].plane != tables_->facets[piece.facet].plane) {
        const double d[3] = {own.q[0] - node.n[0], own.q[1] - node.n[1], own.q[2] - node.n[2]};
        const double size = std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2]);
        const double bound = static_cast<double>(own.error) + static_cast<double>(node.error) +
                             size * (static_cast<double>(cone->error) + 6 * unit_roundoff);
        const Signs signs(*cone, d, bound, spill);
        if (signs.positive() || (signs.negative() && piece.kind == Piece::Kind::coplanar))
          return say("a piece behind a PP-node reaches in front of it", p);
      }
    }
    pool.give_back(cone);
  }
  return {};
}

std::string LightTree::validate() const {
  std::size_t pieces = 0;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    if (std::string what = cells_[c].validate(); !what.empty()) return "cell " + std::to_string(c) + ": " + what;
    pieces += cells_[c].pieces().size();
  }
  // 8. Location lists hold every piece once, under its own facet.
  std::size_t listed = 0;
  for (std::size_t f = 0; f < locations_.size(); ++f) {
    for (Location l = locations_[f]; l.cell != none; l = cells_[l.cell].pieces()[l.piece].location) {
      if (l.cell >= cells_.size() || l.piece >= cells_[l.cell].pieces().size()) return say("a location leads nowhere", f);
      if (cells_[l.cell].pieces()[l.piece].facet != f) return say("a location leads to another facet's piece", f);
      if (++listed > pieces) return say("location lists run in a circle", f);
    }
    if (enters_[f] != (locations_[f].cell != none)) return say("a facet that entered has no location, or one that did not has", f);
  }
  if (listed != pieces) return "a piece is in no location list";
  // 9. A face's fragments add up to its area, as far as corners that carry a rounding of their distance from the light, and of their own
  // coordinates, can say: for a needle far away that is more than a share of its area.
  for (std::size_t f = 0; f < shadows_.areas.size(); ++f) {
    const FaceArea& a = shadows_.areas[f];
    if (a.facing == Facing::ignored || a.facing == Facing::refused) continue;
    Eigen::AlignedBox3d box;
    const Face& face = scene_.faces()[f];
    for (const Facet& facet : scene_.facets().subspan(face.first_facet, face.facet_count)) {
      for (const Corner& c : scene_.corners_of(facet)) box.extend(scene_.vertices()[c.vertex]);
    }
    const double reach = space_.reach(box) + box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).norm();
    if (!(std::abs(a.lit + a.shadowed - a.area) <= 1e-9 * a.area + 64 * unit_roundoff * reach * box.diagonal().norm())) {
      return say("a face's lit and shadowed areas do not add up to its area", f);
    }
  }
  return {};
}

}  // namespace shadowcut
