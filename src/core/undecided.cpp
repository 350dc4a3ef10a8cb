// What the filter alone cannot vouch for: how much of every face could be in another state than it
// was handed out in.
//
// A sign that the fast kernel takes as "on" may be either. Whatever it decides by that is wrong at
// most where a linear function of light space, the line of an SP-node or the difference of two
// planes, is no larger than the bound of its test. So every fragment is held against all nodes
// above it. Where all its corners are certainly on their side, nothing is in doubt; otherwise a
// share of its area is:
//
//   Seen on the fragment's own plane, the function is linear. Over a convex polygon on which it
//     runs from 0 (or less) to F, the part where
//   it is below b has at most the share 1 - (1 - b/F)^2 < 2 b / F of the area: the worst is a
//     triangle that stands on the line.
//
// A doubt about which of two faces is nearer is one about both, so it is charged to both: to the
// fragment, and to the same cone's area on the plane of the PP-node's owner. Cuts between fragments
// in one state leave no doubt, and are not looked at. Corners are themselves known to some
// roundings only, which moves a fragment's edges; and a face seen edge-on, which the kernel leaves
// out, may be seen after all.
//
// First-order terms only, and twice what they come to.

#include <algorithm>
#include <cmath>

#include "light_tree.hpp"
#include "smallest_feature.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {
namespace {

using Doubts = std::vector<std::pair<std::uint32_t, double>>;  // face, area

struct Polygon {
  double area = 0;      // no less than what is there
  double rounding = 0;  // by which the area of its own corners may be off
};

// Where numbers have left double's range nothing is known.
double no_nan(double x) { return std::isnan(x) ? INFINITY : x; }

class CellDoubts {
 public:
  CellDoubts(const CellTree& tree, const EmitTarget& target, const ExactLight& exact, Workspace& w,
             Doubts& out)
      : tree_(tree),
        target_(target),
        exact_(exact),
        w_(w),
        out_(out),
        lines_(tree.lines()),
        states_(find_states(tree, target.scene)),
        in_doubt_(tree.nodes().size(), 0.0) {}

  void run() {
    for (const Piece& piece : tree_.pieces()) {
      if (piece.kind == Piece::Kind::at_leaf) look(whole(piece), piece.place);
      if (piece.kind == Piece::Kind::behind) look_behind(piece);
      if (piece.kind == Piece::Kind::coplanar && !is_in_plane_of_owner(piece))
        look_at_contact(piece);
      if (piece.kind == Piece::Kind::owner || piece.kind == Piece::Kind::coplanar)
        look_in_front(piece);
    }
    // What lies in one plane with a PP-node's owner is in doubt where the owner is.
    for (const Piece& piece : tree_.pieces()) {
      if (piece.kind != Piece::Kind::coplanar || in_doubt_[piece.place] == 0 ||
          !is_in_plane_of_owner(piece))
        continue;
      Cone* cone = whole(piece);
      doubt(cone->facet, std::min(seen_on(*cone, cone->facet).area, 2 * in_doubt_[piece.place]));
      w_.pool.give_back(cone);
    }
  }

 private:
  std::uint32_t state_of(Child c) const { return SHADOWCUT_NUMBERS::state_of(tree_, states_, c); }
  std::uint32_t plane_index(std::uint32_t facet) const {
    return target_.tables.facets[facet].plane;
  }
  const PlaneRay& plane_of(std::uint32_t facet) const {
    return target_.tables.planes[plane_index(facet)];
  }
  std::uint32_t owner_of(std::uint32_t pp) const {
    return tree_.pieces()[tree_.nodes()[pp].id].facet;
  }

  Cone* whole(const Piece& piece) { return tree_.cone_of(piece, w_.pool); }
  Cone* copied(const Cone& from) {
    Cone* cone = w_.pool.take(from.count + 1);
    cone->facet = from.facet, cone->error = from.error, cone->entry = from.entry;
    cone->assign(from.span());
    return cone;
  }

  void doubt(std::uint32_t facet, double area) {
    const bool counts = target_.scene.objects()[target_.tables.object_of(facet)].receives &&
                        !target_.tables.blocks_only[facet];
    if (counts && area != 0) out_.emplace_back(target_.tables.facets[facet].face, no_nan(area));
  }
  void doubt_owner(std::uint32_t pp, double area) {
    in_doubt_[pp] += no_nan(area);
    doubt(owner_of(pp), area);
  }

  // On the plane of a facet, which need not be the cone's own.
  Polygon seen_on(const Cone& cone, std::uint32_t facet) const {
    const Plane& plane = target_.scene.planes()[plane_index(facet)];
    const PlaneRay& ray = plane_of(facet);
    const bool by_corners = facet == cone.facet && corners_will_do(target_, facet);
    const auto is_given = [by_corners](const ConeCorner& c) {
      return c.vertex != none && by_corners;
    };
    const auto at = [&](const ConeCorner& c) {
      return is_given(c) ? target_.scene.vertices()[c.vertex] : target_.space.back(c.r, ray.q);
    };
    double perimeter = 0, spread = 0, extent = 0, pull = 0;
    bool all_given = true;  // the scene's own vertices: no rounding has moved them
    AreaSum sum(at(cone.corners()[0]));
    Vec3 last = at(cone.corners()[cone.count - 1]);
    for (const ConeCorner& c : cone.span()) {
      const Vec3 x = at(c);
      sum.add(x);
      perimeter += (x - last).norm();
      last = x;
      spread = std::max(spread, target_.space.spread(x, plane));
      extent = std::max(extent, x.cwiseAbs().maxCoeff());
      pull = std::max(pull, target_.space.pull(c.r, ray.q));
      all_given = all_given && is_given(c);
    }
    const double turned = 2 * spread * (static_cast<double>(cone.error) + sign_slack),
                 pulled = 2 * pull * static_cast<double>(ray.error);
    const double moved = all_given ? 0 : no_nan(turned + pulled + 4 * unit_roundoff * extent);
    Polygon out;
    out.area = no_nan(sum.area(plane.normal) + (perimeter + 4 * moved) * moved);
    out.rounding = no_nan(16 * unit_roundoff * out.area + perimeter * moved);
    return out;
  }

  // Which share of the cone, seen on plane q, lies where d.r is below the bound of its test; side:
  // the sign that it should have.
  double share_below(const Cone& cone, const Real d[3], double bound, double side,
                     const Real q[3]) const {
    bool certain = true;
    double most = 0, least = 0;
    for (const ConeCorner& c : cone.span()) {
      const double v = side * (d[0] * c.r[0] + d[1] * c.r[1] + d[2] * c.r[2]);
      certain = certain && v > 2 * bound;
      const double h = std::abs(target_.space.weight(c.r, q));
      most = std::max(most, v / h), least = std::max(least, bound / h);
    }
    if (certain) return 0;
    const double share = 4 * least / most;
    return most > 0 && share < 1 ? share : 1;  // 1 too where it is no number
  }

  // Which shares of the cone, seen on its own plane and on another facet's, could be on the other
  // side of that one's plane.
  struct Shares {
    double own, other;
  };
  Shares shares_against(const Cone& cone, std::uint32_t facet, double side) const {
    if (plane_index(facet) == plane_index(cone.facet)) return {0, 0};
    const PlaneRay &own = plane_of(cone.facet), &other = plane_of(facet);
    const PlaneDifference nearer(own, other.q, other.error);
    const double bound = nearer.bound(cone);
    return {share_below(cone, nearer.d, bound, side, own.q),
            share_below(cone, nearer.d, bound, side, other.q)};
  }
  // Of a PP-node's plane; charged to its owner too.
  double against(const Cone& cone, std::uint32_t pp, double side) {
    const Shares shares = shares_against(cone, owner_of(pp), side);
    if (shares.own > 0) doubt_owner(pp, shares.other * seen_on(cone, owner_of(pp)).area);
    return shares.own;
  }

  // A cone in a place: held against all nodes above it, up to the root, but for one. Takes the
  // cone.
  void look(Cone* cone, std::uint32_t place, std::uint32_t but = none) {
    const PlaneRay& own = plane_of(cone->facet);
    double share = 0;
    for (; place != root_place; place = tree_.links()[place >> 1].parent) {
      const std::uint32_t node = place >> 1;
      if (node == but) continue;
      if (tree_.child_at(tree_.links()[node].parent).is_pp()) {
        share += against(*cone, node, 1);
        continue;
      }
      const double error = static_cast<double>(tree_.nodes()[node].error);
      const double bound = error + static_cast<double>(cone->error) + sign_slack;
      const double doubtful =
          share_below(*cone, tree_.nodes()[node].n, bound, place & 1 ? -1 : 1, own.q);
      if (doubtful == 1) look_at_all_in_front(*cone, place ^ 1);  // it may be over there
      share += doubtful;
    }
    const Polygon polygon = seen_on(*cone, cone->facet);
    doubt(cone->facet, std::min(1.0, share) * polygon.area + polygon.rounding);
    w_.pool.give_back(cone);
  }

  // It could be in front after all.
  void look_behind(const Piece& piece) {
    Cone* cone = whole(piece);
    const double share = against(*cone, piece.place, -1);
    if (share > 0) {
      doubt(cone->facet, share * seen_on(*cone, cone->facet).area);
      look_at_all_in_front(*cone, piece.place * 2);
    }
    look(cone, tree_.links()[piece.place].parent);
  }

  // An owner, or what is taken as lying in one plane with it, down to places in one state.
  void look_in_front(const Piece& piece) {
    const auto stop = [this](Child here) { return state_of(here) != mixed_state; };
    descend(tree_, whole(piece), piece.place * 2, false, w_, stop,
            [&](Cone* cone) { look(cone, cone->at, piece.place); });
  }

  // Taken as lying in one plane with a PP-node's owner, and not certainly in it: either may be the
  // nearer one.
  void look_at_contact(const Piece& piece) {
    Cone* cone = whole(piece);
    doubt(cone->facet, seen_on(*cone, cone->facet).area);
    doubt_owner(piece.place, seen_on(*cone, owner_of(piece.place)).area);
    look_at_all_in_front(*cone, piece.place * 2);
    w_.pool.give_back(cone);
  }

  // What may be nearer to the light than a PP-node may also be nearer than what stands in front of
  // that; and what may be on the other side of an SP-node may cast on all that is there.
  void look_at_all_in_front(const Cone& from, std::uint32_t front) {
    const auto stop = [](Child here) { return !here.is_sp(); };
    std::vector<Cone*> pending{copied(from)};
    pending.back()->at = front;
    while (!pending.empty()) {
      Cone* next = pending.back();
      pending.pop_back();
      descend(tree_, next, next->at, false, w_, stop, [&](Cone* cone) {
        const Child here = tree_.child_at(cone->at);
        if (here.is_out()) {
          for (std::uint32_t p = here.is_empty() ? none : here.first_piece(); p != none;
               p = tree_.pieces()[p].next)
            look_at_leaf(*cone, tree_.pieces()[p]);
        }
        if (here.is_out() || against(*cone, here.node(), -1) == 0) return w_.pool.give_back(cone);
        cone->at = here.node() * 2;
        pending.push_back(cone);
      });
    }
  }

  // What rests at a leaf fills a part of it only.
  void look_at_leaf(const Cone& from, const Piece& piece) {
    const auto any = [](EdgeRef) { return true; };
    SignCounts counts;
    Cone* cone = copied(from);
    for (const ConeCorner& c : tree_.corners(piece)) {
      const Line& line = lines_(c.edge.line());
      const std::uint32_t inside = c.edge.negative() ? 1 : 0;
      Cone* other;
      const std::uint32_t side = sift(cone, line.n, line.error, c.edge.line(), lines_, any, w_.pool,
                                      w_.spill, other, counts);
      if (side != inside) std::swap(cone, other);
      if (other) w_.pool.give_back(other);
      if (!cone) return;
    }
    if (const double share = shares_against(*cone, piece.facet, -1).other; share > 0)
      doubt(piece.facet, share * seen_on(*cone, piece.facet).area);
    w_.pool.give_back(cone);
  }

  bool is_in_plane_of_owner(const Piece& piece) const {
    const std::uint32_t owner = owner_of(piece.place);
    return plane_index(owner) == plane_index(piece.facet) || is_same_plane(piece.facet, owner);
  }

  // Both contain all corners of the facet, exactly.
  bool is_same_plane(std::uint32_t facet, std::uint32_t other) const {
    const Plane &own = target_.scene.planes()[plane_index(facet)],
                &its = target_.scene.planes()[plane_index(other)];
    const auto corners = target_.scene.corners_of(target_.scene.facets()[facet]);
    return std::all_of(corners.begin(), corners.end(), [&](const Corner& c) {
      const Vec3& x = target_.scene.vertices()[c.vertex];
      return exact_.contains(own, x) && exact_.contains(its, x);
    });
  }

  const CellTree& tree_;
  const EmitTarget& target_;
  const ExactLight& exact_;
  Workspace& w_;
  Doubts& out_;
  Lines lines_;
  std::vector<std::uint32_t> states_;
  std::vector<double> in_doubt_;  // by PP-node: of its owner's area
};

}  // namespace

// No less than the area of a facet's region, its plane cut by its cone, as the exact kernel has it,
// and no less than what its corners enclose: with what rounding of coordinates adds. Where some
// corner's ray does not meet the plane there is no region.
double LightTree::most_area(std::uint32_t i, const ExactLight& exact) const {
  const Facet& facet = scene_.facets()[i];
  const Plane& plane = scene_.planes()[facet.plane];
  const int front = exact.turned(plane);
  std::vector<Vec3> points;
  for (const Corner& c : scene_.corners_of(facet)) {
    const Vec3& x = scene_.vertices()[c.vertex];
    points.push_back(front != 0 && exact.ahead(plane, x) > 0
                         ? exact.point(plane, {&x, false, nullptr, nullptr, false, false})
                         : x);
  }
  AreaSum sum(points[0]);
  double perimeter = 0, extent = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Vec3 &x = points[k], &next = points[(k + 1) % points.size()];
    sum.add(next);
    perimeter += (next - x).norm(), extent = std::max(extent, x.cwiseAbs().maxCoeff());
  }
  const double area =
      std::max(sum.area(plane.normal), area_of_facet(target(), i, facing_[i] == Facing::toward));
  return area * (1 + 64 * unit_roundoff) +
         perimeter * (4 * unit_roundoff * extent + 8 * unit_roundoff * perimeter);
}

// How thick a facet seen edge-on may be, in light space. All its edges lie in one great circle as
// seen from the light, up to this; but round a light inside it they run once round the circle, and
// what they bound is half of all directions.
double LightTree::thickness_of(std::uint32_t i) const {
  const auto corners = scene_.corners_of(scene_.facets()[i]);
  const auto at = [&](std::size_t k) -> const Vec3& {
    return scene_.vertices()[corners[k % corners.size()].vertex];
  };
  std::vector<Vec3> rays;
  for (std::size_t k = 0; k < corners.size(); ++k) rays.emplace_back(space_.ray(at(k)).r);
  double thickness = 0;
  Vec3 axis = Vec3::Zero(), turn = Vec3::Zero();
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const LineOf<double> edge = space_.line(at(k), at(k + 1));
    const Vec3 n(edge.n);
    if (!n.allFinite()) return 2;
    double farthest = 0;
    for (const Vec3& ray : rays) farthest = std::max(farthest, std::abs(n.dot(ray)));
    thickness = std::max(thickness, farthest + static_cast<double>(edge.error) + sign_slack);
    if (axis.isZero()) axis = n;
    turn += (n.dot(axis) < 0 ? -1 : 1) *
            std::acos(std::clamp(rays[k].dot(rays[(k + 1) % rays.size()]), -1.0, 1.0)) * axis;
  }
  return turn.norm() > 3 ? 2 : std::min(2 * thickness, 2.0);
}

// How thick those faces are that are not there because they are seen edge-on, and exactly are not:
// all together. They themselves are undecided whole. A face that is not quite convex is in the tree
// as if it were: that moves its edges by its kink.
double LightTree::thickness_left_out(const ExactLight& exact,
                                     std::vector<double>& undecided) const {
  double thickness = 0;
  ConePool pool;
  for (std::uint32_t i = 0; i < scene_.facets().size(); ++i) {
    const Facet& facet = scene_.facets()[i];
    if (facet.corner_count == 0 || facing_[i] == Facing::out_of_reach) continue;
    const Object& object = scene_.objects()[tables_.object_of(i)];
    if (enters_[i]) {
      Cone* cone = cone_of_facet(i, pool);
      thickness += 2 * kink(*cone);
      pool.give_back(cone);
    }
    if (turned_[i] != Turned::edge_on) continue;
    const int front = exact.turned(scene_.planes()[facet.plane]);
    if (front == 0 || (front < 0 && object.sides == Sides::closed && !holds_light(object)))
      continue;
    if (object.receives) undecided[facet.face] += most_area(i, exact);
    if (object.casts) thickness += thickness_of(i);
  }
  return thickness;
}

// By how much the loop is not convex as the light sees it.
double LightTree::kink(const Cone& cone) const {
  double deepest = 0;
  for (std::uint32_t k = 0; k < cone.count; ++k) deepest = std::max(deepest, -turn_behind(cone, k));
  return deepest;
}

// What is in doubt of a facet as a whole: where faces that were left out may shadow it, and where
// its edges are, as its corners are on its plane up to its flatness only.
double LightTree::doubt_of_outline(std::uint32_t i, double thickness) const {
  const Facet& facet = scene_.facets()[i];
  const Plane& plane = scene_.planes()[facet.plane];
  const auto corners = scene_.corners_of(facet);
  double spread = 0, slide = 0, perimeter = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec3 &x = scene_.vertices()[corners[k].vertex],
               &next = scene_.vertices()[corners[(k + 1) % corners.size()].vertex];
    perimeter += (next - x).norm();
    spread = std::max(spread, space_.spread(x, plane)),
    slide = std::max(slide, space_.slide(x, plane));
  }
  return perimeter *
         (thickness * spread + slide * (2 * plane.flatness + 8 * unit_roundoff * perimeter));
}

std::vector<double> LightTree::undecided() const {
  std::vector<double> out(scene_.faces().size(), 0.0);
  if (is_exact()) return out;
  ExactLight exact(light_, space_);
  for (const Object& object : scene_.objects()) note_for_exact(object, exact);
  PerThread<Workspace> workspaces;
  std::vector<Doubts> doubts(cells_.size());
  const EmitTarget to = target();
  parallel_for(cells_.size(), 1, [&](std::size_t c) {
    CellDoubts(cells_[c], to, exact, workspaces.local(), doubts[c]).run();
  });
  for (const Doubts& of_cell : doubts) {
    for (const auto& [face, area] : of_cell) out[face] += area;
  }
  const double thickness = thickness_left_out(exact, out);
  for (std::uint32_t i = 0; i < facing_.size(); ++i) {
    if (facing_[i] == Facing::toward)
      out[scene_.facets()[i].face] += doubt_of_outline(i, thickness);
  }
  // Neither what is lit nor what was said to be is more than all there is.
  for (std::uint32_t f = 0; f < out.size(); ++f) {
    const FaceArea& said = shadows_.areas[f];
    if (out[f] <= said.area / 2) continue;
    const Face& face = scene_.faces()[f];
    double most = 0;
    for (std::uint32_t i = face.first_facet; i < face.first_facet + face.facet_count; ++i)
      most += most_area(i, exact);
    out[f] = std::min(no_nan(out[f]), std::max({most, said.lit, said.shadowed}));
  }
  return out;
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
