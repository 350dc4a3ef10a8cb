// Cutting a convex cone along a line.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "clipping/classify.hpp"
#include "clipping/workspace.hpp"
#include "numbers/error_free.hpp"

namespace shadowcut {

// a*b - c*d with an error of about one rounding of the result: Dekker's products (1971) give what
// the plain products drop. Exchanging the products changes the sign and nothing else.
inline double difference_of_products(double a, double b, double c, double d) {
  const TwoDoubles p = two_product(a, b), q = two_product(c, d);
  return (p.high - q.high) + (p.low - q.low);
}

// The cross product of two unit lines. Where the lines are nearly parallel (sine below 1/8) the
// plain product loses the digits that say where along the lines they meet; the corner would then be
// beside both lines, and the areas on the two sides of a T-junction would not add up.
inline void cross(const double a[3], const double b[3], double out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
  if (dot(out, out) >= 0x1p-6) return;
  out[0] = difference_of_products(a[1], b[2], a[2], b[1]);
  out[1] = difference_of_products(a[2], b[0], a[0], b[2]);
  out[2] = difference_of_products(a[0], b[1], a[1], b[0]);
}

// The two cut corners of one cone, where its edges cross a line.
class CrossingCorners {
 public:
  CrossingCorners(const Cone& cone, const DividingLine& line, const CellPredicates& predicates)
      : cone_(cone),
        line_(line),
        predicates_(predicates),
        known_(predicates.line(line.id)),
        error_(cone.error) {}

  // The corner at a change of sides. A corner on the line serves as it is. `downward`: the sign
  // goes from positive to negative, and the cut follows the edge on the positive side; otherwise it
  // comes before. A product changes sign, and nothing else, with the order of its factors: both
  // sides of a cut get the same numbers.
  ConeCorner at(const SideChange& change, bool downward) {
    ConeCorner corner = cone_.corners()[change.corner];
    SHADOWCUT_ASSERT(change.corner < cone_.count);
    if (change.on) return corner;
    const Line& edge = predicates_.line(corner.edge.line());
    corner.vertex = invalid_index;
    if (const std::uint32_t shared = shared_vertex(edge, known_); shared != invalid_index) {
      at_shared_vertex(shared, change, corner);
      return corner;
    }
    cross(edge.n, line_.n, corner.r);
    // Below which square of its length the product is too short against its own error.
    const double too_short = predicates_.is_exact() ? 0x1p-24 : 0x1p-40;
    if (!(dot(corner.r, corner.r) >= too_short)) {
      at_near_parallel(downward, change, corner);
      return corner;
    }
    const double s = corner.edge.negative() == downward ? -1 : 1;
    for (double& c : corner.r) c *= s;
    grow_error(edge.error);
    return corner;
  }

  // A bound for all corners of the parts.
  float error() const { return error_; }

 private:
  const double* from(const SideChange& change) const { return cone_.corners()[change.corner].r; }
  const double* to(const SideChange& change) const {
    const std::uint32_t i = change.corner + 1;
    return cone_.corners()[i == cone_.count ? 0 : i].r;
  }
  void grow_error(float edge_error) {
    error_ = std::max(
        error_, (edge_error + line_.error + static_cast<float>(corner_slack)) * (1 + 0x1p-22f));
  }

  // Two lines of edges that share a vertex meet in that vertex's ray or in its opposite, and get
  // its numbers: the corner is the same to the bit, whichever of the vertex's edges cut it out. The
  // crossing is between the ends of the edge.
  void at_shared_vertex(std::uint32_t shared, const SideChange& change, ConeCorner& corner) {
    const VertexRay& ray = predicates_.rays()[shared];
    const double *a = from(change), *b = to(change);
    const bool opposite = predicates_.is_exact()
                              ? predicates_.ahead(cone_.facet, shared) < 0
                              : dot(ray.r, a) * std::abs(dot(line_.n, b)) +
                                        dot(ray.r, b) * std::abs(dot(line_.n, a)) <
                                    0;
    const double s = opposite ? -1 : 1;
    for (int i = 0; i < 3; ++i) corner.r[i] = s * ray.r[i];
    error_ = std::max(error_, ray.error);
  }

  // Nearly one line: the product is hardly longer than its own error. The exact kernel computes the
  // ray. Otherwise the point between the edge's ends where the line's test vanishes lies on both
  // lines, and is as certain as those ends.
  void at_near_parallel(bool downward, const SideChange& change, ConeCorner& corner) {
    if (predicates_.is_exact()) {
      const EdgeRef inside(line_.id, false);
      const VertexRay ray =
          downward ? predicates_.ray(corner.edge, inside) : predicates_.ray(inside, corner.edge);
      std::copy(ray.r, ray.r + 3, corner.r);
      error_ = std::max(error_, ray.error);
      return;
    }
    const double *a = from(change), *b = to(change);
    const double at_a = std::abs(dot(line_.n, a)), at_b = std::abs(dot(line_.n, b));
    for (int i = 0; i < 3; ++i) corner.r[i] = (a[i] * at_b + b[i] * at_a) / (at_a + at_b);
    grow_error(cone_.error);
  }

  const Cone& cone_;
  const DividingLine& line_;
  const CellPredicates& predicates_;
  const Line& known_;  // the dividing line, with the vertices that it goes through
  float error_;
};

// Cuts a cone that has corners on both sides of a line. `bounded`: whether a node of the tree
// stands on the cut. The parts are new cones; the cut cone stays as it was.
inline void split(const Cone& cone, const CornerSides& sides, const DividingLine& line,
                  bool bounded, const CellPredicates& predicates, ConePool& pool, Cone*& positive,
                  Cone*& negative) {
  const std::uint32_t n = cone.count;
  SHADOWCUT_ASSERT(n >= 3 && line.id.valid());
  const auto next = [n](std::uint32_t i) { return i + 1 == n ? 0 : i + 1; };
  SideChange down{}, up{};
  sides.changes(down, up);
  CrossingCorners crossing(cone, line, predicates);
  const ConeCorner p_down = crossing.at(down, true), p_up = crossing.at(up, false);

  // From one change to the other. The corners between are in one run, or in two runs around
  // corner 0.
  const auto part = [&](const SideChange& from, const ConeCorner& p_from, const SideChange& to,
                        const ConeCorner& p_to, EdgeRef closing) {
    Cone* out = pool.take(n + 2);  // at most n + 1 corners, and one more to test in pairs
    ConeCorner* o = out->corners();
    *o++ = p_from;
    const std::uint32_t first = next(from.corner), last = to.on ? to.corner : next(to.corner);
    for (std::uint32_t i = first; i != last; i = next(i)) *o++ = cone.corners()[i];
    *o = p_to;
    o->edge = closing;
    out->count = static_cast<std::uint32_t>(o + 1 - out->corners());
    out->facet = cone.facet;
    out->entry = cone.entry;
    out->error = crossing.error();
    SHADOWCUT_ASSERT(out->count >= 2 && out->count <= n + 1);
    return out;
  };
  EdgeRef inside(line.id, false), outside(line.id, true);
  if (bounded) inside.set_bounded(), outside.set_bounded();
  positive = part(up, p_up, down, p_down, inside);
  negative = part(down, p_down, up, p_up, outside);
  SHADOWCUT_ASSERT(positive->count + negative->count <= n + 4);
}

// Whether the inside of an edge and one side of a dividing line (0 positive, 1 negative) are the
// same half of light space, up to the errors of both. Two ends on the line are not enough: both
// ends of a sliver are on every line that passes near it. Errors so large that the two halves may
// differ visibly elsewhere are not enough either.
inline bool same_half(EdgeRef edge, const Line& own, const DividingLine& line, std::uint32_t side) {
  constexpr float largest_error = static_cast<float>(512 * unit_roundoff);
  const double s = edge.negative() == (side == 1) ? 1 : -1;
  const double apart = std::abs(own.n[0] - s * line.n[0]) + std::abs(own.n[1] - s * line.n[1]) +
                       std::abs(own.n[2] - s * line.n[2]);
  return own.error <= largest_error && apart <= 4 * (static_cast<double>(own.error) +
                                                     static_cast<double>(line.error) + sign_slack);
}

// The edges of a cone that lie on a node's line need no node of their own: marks them as bounded.
// `side`: the side of the line on which the cone is. bounds(edge): whether the node may serve an
// edge as the end of the cell.
template <class Bounds>
void mark_bounded_edges(Cone& cone, const CornerSides& sides, const DividingLine& line,
                        std::uint32_t side, const CellPredicates& predicates,
                        const Bounds& bounds) {
  sides.for_each_on_edge([&](std::uint32_t i) {
    EdgeRef& edge = cone.corners()[i].edge;
    if ((predicates.is_exact() || same_half(edge, predicates.line(edge.line()), line, side)) &&
        bounds(edge))
      edge.set_bounded();
  });
}

// The part of a cone on one side of a line (0 positive, 1 negative); null if there is none. Takes
// the cone. A cone that lies on the line altogether (a sliver that rounding made) is on the
// positive side.
inline Cone* clip(Cone* cone, const DividingLine& line, std::uint32_t side,
                  const CellPredicates& predicates, Workspace& w) {
  SignCounts counts;
  SHADOWCUT_ASSERT(cone && side <= 1);
  const CornerSides sides = sides_of_line(*cone, line, predicates, w.spill, counts);
  if (sides.positive() && sides.negative()) {
    Cone* parts[2];
    split(*cone, sides, line, true, predicates, w.pool, parts[0], parts[1]);
    w.pool.give_back(cone);
    w.pool.give_back(parts[1 - side]);
    return parts[side];
  }
  const std::uint32_t own = sides.negative() ? 1 : 0;
  if (own == side) {
    if (sides.any_on())
      mark_bounded_edges(*cone, sides, line, side, predicates, [](EdgeRef) { return true; });
    return cone;
  }
  w.pool.give_back(cone);
  return nullptr;
}

}  // namespace shadowcut
