// Two convex polygons of one facet made one again, across the edge that parts them.
#pragma once

#include <span>
#include <vector>

#include "lines.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {

inline bool same_ray(const ConeCorner& a, const ConeCorner& b) {
  return a.r[0] == b.r[0] && a.r[1] == b.r[1] && a.r[2] == b.r[2];
}
inline bool same_side(EdgeRef a, EdgeRef b) {
  return a.line() == b.line() && a.negative() == b.negative();
}

// If p and q meet in a whole edge of both and their union is convex, `out` becomes the union, and
// it is true. Where both go on along one line, the corner between them goes; of that line the edge
// is q's at the start of p's part, p's at its end. The outlines of one facet's pieces run the same
// way, so edges on one line that run opposite ways are the two sides of a cut. `across`: that line,
// or none for any. Corners with the same numbers may still be two, a part of an ulp from each
// other; the exact kernel asks.
inline bool unite(std::span<const ConeCorner> p, std::span<const ConeCorner> q, std::uint32_t facet,
                  std::uint32_t across, const Lines& lines, std::vector<ConeCorner>& out) {
  const auto pn = static_cast<std::uint32_t>(p.size()), qn = static_cast<std::uint32_t>(q.size());
  std::uint32_t i = 0, j = 0;
  const auto parted = [&] {
    for (i = 0; i < pn; ++i) {
      if (across != none && p[i].edge.line() != across) continue;
      for (j = 0; j < qn; ++j) {
        if (p[i].edge.line() == q[j].edge.line() && p[i].edge.negative() != q[j].edge.negative())
          return true;
      }
    }
    return false;
  };
  if (!parted()) return false;
  const auto at = [](std::span<const ConeCorner> c, std::uint32_t k) -> const ConeCorner& {
    return c[k < c.size() ? k : k - c.size()];
  };
  if (!same_ray(p[i], at(q, j + 1)) || !same_ray(at(p, i + 1), q[j])) return false;
  // The union runs round p from behind that edge, then round q.
  const ConeCorner &start = at(p, i + 1), &end = p[i], &into_start = at(q, j + qn - 1),
                   &from_end = at(q, j + 1), &into_end = at(p, i + pn - 1);
  // Whether the turn from corner k, at a corner that leaves along `edge`, is certainly convex: k
  // lies inside of that edge's line. The polygons' own errors are not at hand; a corner's is at
  // most twice a line's and a cross product's, and this is only a choice to join or not.
  SignCounts counts;
  const auto turns_inward = [&](std::span<const ConeCorner> c, std::uint32_t k, EdgeRef edge) {
    k = k < c.size() ? k : k - static_cast<std::uint32_t>(c.size());
    if (lines.is_exact())
      return (edge.negative() ? -1 : 1) * lines.side(c, k, facet, edge.line(), counts) > 0;
    const Line& l = lines(edge.line());
    const Real s = l.n[0] * c[k].r[0] + l.n[1] * c[k].r[1] + l.n[2] * c[k].r[2];
    return (edge.negative() ? -s : s) > 16 * static_cast<double>(l.error) + 16 * sign_slack;
  };
  const auto lies_on = [&](std::uint32_t k, EdgeRef edge) {
    return !lines.is_exact() || lines.side(p, k < pn ? k : k - pn, facet, edge.line(), counts) == 0;
  };
  const bool start_straight = same_side(into_start.edge, start.edge),
             end_straight = same_side(into_end.edge, from_end.edge);
  if (!start_straight &&
      !(turns_inward(q, j + qn - 1, start.edge) && lies_on(i + 1, into_start.edge)))
    return false;
  if (!end_straight && !(turns_inward(p, i + pn - 1, from_end.edge) && lies_on(i, from_end.edge)))
    return false;
  out.clear();
  for (std::uint32_t k = start_straight ? 1 : 0; k + 1 < pn; ++k) out.push_back(at(p, i + 1 + k));
  if (!end_straight) {
    out.push_back(end);
    out.back().edge = from_end.edge;
  }
  for (std::uint32_t k = 2; k < qn; ++k) out.push_back(at(q, j + k));
  return out.size() >= 3;
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
