// A sign that the fast kernel takes as "on" may be either. Whatever is decided by it is wrong at
// most where a linear function of light space, the line of an SP-node or the difference of two
// planes, is no larger than the bound of its test. So every fragment is held against all nodes
// above it. Where all its corners are certainly on their side nothing is uncertain; otherwise a
// share of its area is:
//
//   Seen on the fragment's own plane, the function is linear. Over a convex polygon on which it
//   runs from 0 (or less) to F, the part where it is below b has at most the share
//   1 - (1 - b/F)^2 < 2 b / F of the area: the worst is a triangle that stands on the line.
//
// If it is uncertain which of two faces is nearer, both are: the area is charged to the fragment,
// and to the owner of the PP-node, as the same cone's area on the owner's plane. Cuts between
// fragments in one state leave no uncertainty, and are not looked at. Corners are themselves known
// to some roundings only, which moves a fragment's edges; and a face seen edge-on, which the kernel
// leaves out, may be seen after all (outline_error.cpp).
//
// First-order terms only, and twice their sum.

#include "fragments/error_bound.hpp"

#include <algorithm>
#include <cmath>

#include "fragments/emission.hpp"
#include "fragments/outline_error.hpp"

namespace shadowcut {
namespace {

using Charges = std::vector<std::pair<FaceId, double>>;  // face, area

struct Polygon {
  double area = 0;      // no less than the true area
  double rounding = 0;  // by which the area of its own corners may be off
};

// Sends a cone down to where stop(branch) says; take(cone, place) takes each part.
template <class Stop, class Take>
struct Walk : DescentVisitor {
  const SvbspTree& tree;
  const Stop& stop;
  const Take& take;
  Walk(const SvbspTree& t, const Stop& s, const Take& k) : tree(t), stop(s), take(k) {}
  CellPredicates cell_predicates() const { return tree.predicates(); }
  bool stops_at(Place, Branch here, std::uint32_t&) const { return stop(here); }
  void arrive(Cone* cone, Place place) const { take(cone, place); }
};

class CellErrorBound {
 public:
  CellErrorBound(const SvbspTree& tree, const EmissionContext& context,
                 const ExactPredicates& exact, Workspace& w, Charges& out)
      : tree_(tree),
        context_(context),
        exact_(exact),
        w_(w),
        out_(out),
        predicates_(tree.predicates()),
        charged_to_owner_(tree.nodes().size(), 0.0) {
    states_.compute(tree, context.scene);
  }

  void run() {
    for (const Piece& piece : tree_.pieces.pieces()) {
      if (piece.kind == Piece::Kind::at_leaf) look_above(whole(piece), piece.leaf());
      if (piece.kind == Piece::Kind::behind) look_behind(piece);
      if (piece.kind == Piece::Kind::coplanar && !is_in_plane_of_owner(piece))
        look_at_contact(piece);
      if (piece.is_in_front()) look_in_front(piece);
    }
    // A facet in one plane with a PP-node's owner is uncertain where the owner is.
    for (const Piece& piece : tree_.pieces.pieces()) {
      if (piece.kind != Piece::Kind::coplanar || charged_to_owner_[piece.node_or_leaf] == 0 ||
          !is_in_plane_of_owner(piece))
        continue;
      Cone* cone = whole(piece);
      charge(cone->facet,
             std::min(seen_on(*cone, cone->facet).area, 2 * charged_to_owner_[piece.node_or_leaf]));
      w_.pool.give_back(cone);
    }
  }

 private:
  Cone* whole(const Piece& piece) { return tree_.cone_of(piece, w_.pool); }
  const PlaneCovector& covector_of(FacetId facet) const {
    return context_.tables.covector_of(facet);
  }
  std::uint32_t plane_index(FacetId facet) const { return context_.tables.plane_index(facet); }
  const Plane& plane_of(FacetId facet) const { return context_.tables.plane_of(facet); }

  void charge(FacetId facet, double area) {
    const bool counts = context_.receives(facet) && !context_.visibility.blocks_only(facet);
    if (counts && area != 0) out_.emplace_back(context_.tables.face_of(facet), no_nan(area));
  }
  void charge_owner(NodeId pp, double area) {
    charged_to_owner_[pp.value()] += no_nan(area);
    charge(tree_.owner_facet(pp), area);
  }

  // A cone on the plane of a facet, which need not be the cone's own.
  Polygon seen_on(const Cone& cone, FacetId facet) const {
    const Plane& plane = plane_of(facet);
    const PlaneCovector& ray = covector_of(facet);
    const bool by_corners = facet == cone.facet && area_from_corners(context_, facet);
    const auto is_vertex = [by_corners](const ConeCorner& c) {
      return c.vertex != invalid_index && by_corners;
    };
    const auto at = [&](const ConeCorner& c) {
      return is_vertex(c) ? context_.scene.vertices()[c.vertex] : context_.space.back(c.r, ray.q);
    };
    double perimeter = 0, spread = 0, extent = 0, pull = 0;
    bool all_vertices = true;  // of the scene: no rounding has moved them
    AreaSum sum(at(cone.corners()[0]));
    Vec3 last = at(cone.corners()[cone.count - 1]);
    for (const ConeCorner& c : cone.span()) {
      const Vec3 x = at(c);
      sum.add(x);
      perimeter += (x - last).norm();
      last = x;
      spread = std::max(spread, context_.space.spread(x, plane));
      extent = std::max(extent, x.cwiseAbs().maxCoeff());
      pull = std::max(pull, context_.space.pull(c.r, ray.q));
      all_vertices = all_vertices && is_vertex(c);
    }
    const double turned = 2 * spread * (static_cast<double>(cone.error) + sign_slack),
                 pulled = 2 * pull * static_cast<double>(ray.error);
    const double moved = all_vertices ? 0 : no_nan(turned + pulled + 4 * unit_roundoff * extent);
    Polygon out;
    out.area = no_nan(sum.area(plane.normal) + (perimeter + 4 * moved) * moved);
    out.rounding = no_nan(16 * unit_roundoff * out.area + perimeter * moved);
    return out;
  }

  // The share of the cone, seen on plane q, where d.r is below the bound of its test. `side`: the
  // sign that d.r should have.
  double share_below(const Cone& cone, const double d[3], double bound, double side,
                     const double q[3]) const {
    bool certain = true;
    double most = 0, least = 0;
    for (const ConeCorner& c : cone.span()) {
      const double v = side * dot(d, c.r);
      certain = certain && v > 2 * bound;
      const double h = std::abs(context_.space.weight(c.r, q));
      most = std::max(most, v / h), least = std::max(least, bound / h);
    }
    if (certain) return 0;
    const double share = 4 * least / most;
    SHADOWCUT_ASSERT(bound >= 0 || std::isnan(bound));
    return most > 0 && share < 1 ? share : 1;  // 1 too where it is no number
  }

  // The shares of the cone, seen on its own plane and on another facet's plane, that could be on
  // the other side of that plane.
  struct Shares {
    double own, other;
  };
  Shares shares_against(const Cone& cone, FacetId facet, double side) const {
    if (plane_index(facet) == plane_index(cone.facet)) return {0, 0};
    const PlaneCovector &own = covector_of(cone.facet), &other = covector_of(facet);
    const PlaneDifference nearer(own, other.q, other.error);
    const double bound = nearer.bound(cone);
    return {share_below(cone, nearer.d, bound, side, own.q),
            share_below(cone, nearer.d, bound, side, other.q)};
  }
  // Of a PP-node's plane; charged to its owner too.
  double share_against(const Cone& cone, NodeId pp, double side) {
    const FacetId owner = tree_.owner_facet(pp);
    const Shares shares = shares_against(cone, owner, side);
    if (shares.own > 0) charge_owner(pp, shares.other * seen_on(cone, owner).area);
    return shares.own;
  }

  // A cone in a place: held against all nodes above it, up to the root, except one. Takes the cone.
  void look_above(Cone* cone, Place place, NodeId except = NodeId()) {
    const PlaneCovector& own = covector_of(cone->facet);
    double share = 0;
    for (; !place.is_root(); place = tree_.links(place.node()).parent) {
      const NodeId node = place.node();
      if (node == except) continue;
      if (tree_.is_pp(node)) {
        share += share_against(*cone, node, 1);
        continue;
      }
      const DividingLine line = tree_.dividing_line(node);
      const double uncertain =
          share_below(*cone, line.n, line.bound(*cone), place.side() == 1 ? -1 : 1, own.q);
      // The cone may be on the other side.
      if (uncertain == 1) look_at_all_in_front(*cone, place.other_side());
      share += uncertain;
    }
    const Polygon polygon = seen_on(*cone, cone->facet);
    charge(cone->facet, std::min(1.0, share) * polygon.area + polygon.rounding);
    w_.pool.give_back(cone);
  }

  // A piece behind a PP-node could be in front after all.
  void look_behind(const Piece& piece) {
    Cone* cone = whole(piece);
    const double share = share_against(*cone, piece.node(), -1);
    if (share > 0) {
      charge(cone->facet, share * seen_on(*cone, cone->facet).area);
      look_at_all_in_front(*cone, Place(piece.node(), 0));
    }
    look_above(cone, tree_.links(piece.node()).parent);
  }

  template <class Stop, class Take>
  void walk(Cone* cone, Place from, const Stop& stop, const Take& take) {
    Walk<Stop, Take> visitor(tree_, stop, take);
    descend(tree_, cone, from, 0, w_, visitor);
  }

  // An owner, or a piece taken as coplanar with it, down to places in one state.
  void look_in_front(const Piece& piece) {
    const auto stop = [this](Branch here) { return !states_.of(tree_, here).is_mixed(); };
    walk(whole(piece), Place(piece.node(), 0), stop,
         [&](Cone* cone, Place place) { look_above(cone, place, piece.node()); });
  }

  // A piece taken as coplanar with a PP-node's owner, and not certainly coplanar: either may be the
  // nearer one.
  void look_at_contact(const Piece& piece) {
    Cone* cone = whole(piece);
    charge(cone->facet, seen_on(*cone, cone->facet).area);
    charge_owner(piece.node(), seen_on(*cone, tree_.owner_facet(piece.node())).area);
    look_at_all_in_front(*cone, Place(piece.node(), 0));
    w_.pool.give_back(cone);
  }

  // A cone that may be nearer to the light than a PP-node may also be nearer than what is in front
  // of that node; and a cone that may be on the other side of an SP-node may cast on everything
  // there.
  void look_at_all_in_front(const Cone& from, Place front) {
    const auto stop = [](Branch here) { return !here.is_sp(); };
    std::vector<std::pair<Cone*, Place>> pending{{w_.pool.copy(from), front}};
    while (!pending.empty()) {
      const auto [next, at] = pending.back();
      pending.pop_back();
      walk(next, at, stop, [&](Cone* cone, Place place) {
        const Branch here = tree_.branch(place);
        if (here.is_out()) {
          for (PieceId p = here.first_piece(); p.valid(); p = tree_.pieces[p].next)
            look_at_leaf(*cone, tree_.pieces[p]);
        }
        if (here.is_out() || share_against(*cone, here.node(), -1) == 0)
          return w_.pool.give_back(cone);
        pending.emplace_back(cone, Place(here.node(), 0));
      });
    }
  }

  // A piece that rests at a leaf fills only a part of it.
  void look_at_leaf(const Cone& from, const Piece& piece) {
    Cone* cone = w_.pool.copy(from);
    for (const ConeCorner& c : tree_.pieces.corners(piece)) {
      const Line& line = predicates_.line(c.edge.line());
      cone = clip(cone, {line.n, line.error, c.edge.line()}, c.edge.negative() ? 1 : 0, predicates_,
                  w_);
      if (!cone) return;
    }
    if (const double share = shares_against(*cone, piece.facet, -1).other; share > 0)
      charge(piece.facet, share * seen_on(*cone, piece.facet).area);
    w_.pool.give_back(cone);
  }

  bool is_in_plane_of_owner(const Piece& piece) const {
    const FacetId owner = tree_.owner_facet(piece.node());
    return plane_index(owner) == plane_index(piece.facet) || is_same_plane(piece.facet, owner);
  }

  // Both planes contain all corners of the facet, exactly.
  bool is_same_plane(FacetId facet, FacetId other) const {
    const auto corners = context_.scene.corners_of(context_.tables.facet(facet));
    return std::all_of(corners.begin(), corners.end(), [&](const Corner& c) {
      const Vec3& x = context_.scene.vertices()[c.vertex];
      return exact_.contains(plane_of(facet), x) && exact_.contains(plane_of(other), x);
    });
  }

  const SvbspTree& tree_;
  const EmissionContext& context_;
  const ExactPredicates& exact_;
  Workspace& w_;
  Charges& out_;
  CellPredicates predicates_;
  BranchStates states_;
  std::vector<double> charged_to_owner_;  // by PP-node: area
};

}  // namespace

std::vector<double> error_bound(const LightView& light) {
  const EmissionContext& context = light.context;
  const Scene& scene = context.scene;
  std::vector<double> out(scene.faces().size(), 0.0);
  ExactPredicates exact(context.light, context.space);
  for (const Object& object : scene.objects()) exact.note_object(scene, object);
  PerThread<Workspace> workspaces;
  std::vector<Charges> charges(light.grid.size());
  parallel_for(light.grid.size(), 1, [&](std::size_t c) {
    CellErrorBound(light.grid[CellId(c)], context, exact, workspaces.local(), charges[c]).run();
  });
  for (const Charges& of_cell : charges) {
    for (const auto& [face, area] : of_cell) out[face.value()] += area;
  }
  OutlineError(context, exact).add(out);
  // Neither the true lit area nor the emitted lit area is more than the whole area.
  for (std::uint32_t f = 0; f < out.size(); ++f) {
    const FaceArea& emitted = light.shadows.areas[f];
    if (out[f] <= emitted.area / 2) continue;
    const double most = OutlineError(context, exact).most_area_of_face(f);
    out[f] = std::min(no_nan(out[f]), std::max({most, emitted.lit, emitted.shadowed}));
  }
  return out;
}

}  // namespace shadowcut
