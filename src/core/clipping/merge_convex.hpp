// Merging two convex polygons of one facet across the edge that separates them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "predicates/cell_predicates.hpp"

namespace shadowcut {

inline bool same_ray(const ConeCorner& a, const ConeCorner& b) {
  return a.r[0] == b.r[0] && a.r[1] == b.r[1] && a.r[2] == b.r[2];
}
inline bool same_side(EdgeRef a, EdgeRef b) {
  return a.line() == b.line() && a.negative() == b.negative();
}

// Merges convex polygons of one facet, with the predicates of their cell.
class ConvexMerger {
 public:
  explicit ConvexMerger(const CellPredicates& predicates) : predicates_(predicates) {}

  // True if p and q meet in a whole edge of both and their union is convex; then `out` is the
  // union. Where both continue along one line, the corner between them goes; the remaining edge on
  // that line is q's at the start of p's part and p's at its end. The outlines of one facet's
  // pieces run the same way, so edges on one line that run opposite ways are the two sides of a
  // cut. `across`: the line of the common edge, or an invalid id for any line. Corners with the
  // same numbers may still be two points, a part of an ulp from each other: the exact kernel asks.
  bool merge(std::span<const ConeCorner> p, std::span<const ConeCorner> q, FacetId facet,
             LineId across, std::vector<ConeCorner>& out) const {
    const auto pn = static_cast<std::uint32_t>(p.size()), qn = static_cast<std::uint32_t>(q.size());
    std::uint32_t i = 0, j = 0;
    SHADOWCUT_ASSERT(p.size() >= 3 && q.size() >= 3 && out.data() != p.data() &&
                     out.data() != q.data());
    if (!find_common_edge(p, q, across, i, j)) return false;
    if (!same_ray(p[i], at(q, j + 1)) || !same_ray(at(p, i + 1), q[j])) return false;
    // The union runs round p from behind that edge, then round q.
    const ConeCorner &start = at(p, i + 1), &end = p[i], &into_start = at(q, j + qn - 1),
                     &from_end = at(q, j + 1), &into_end = at(p, i + pn - 1);
    SignCounts counts;
    const auto lies_on = [&](std::uint32_t k, EdgeRef edge) {
      return !predicates_.is_exact() ||
             predicates_.side(p, k < pn ? k : k - pn, facet, edge.line(), counts) == 0;
    };
    const bool start_straight = same_side(into_start.edge, start.edge),
               end_straight = same_side(into_end.edge, from_end.edge);
    if (!start_straight && !(turns_inward(q, j + qn - 1, facet, start.edge, counts) &&
                             lies_on(i + 1, into_start.edge)))
      return false;
    if (!end_straight &&
        !(turns_inward(p, i + pn - 1, facet, from_end.edge, counts) && lies_on(i, from_end.edge)))
      return false;
    out.clear();
    for (std::uint32_t k = start_straight ? 1 : 0; k + 1 < pn; ++k) out.push_back(at(p, i + 1 + k));
    if (!end_straight) {
      out.push_back(end);
      out.back().edge = from_end.edge;
    }
    for (std::uint32_t k = 2; k < qn; ++k) out.push_back(at(q, j + k));
    SHADOWCUT_ASSERT(out.size() <= p.size() + q.size() - 2);
    return out.size() >= 3;
  }

 private:
  static const ConeCorner& at(std::span<const ConeCorner> c, std::uint32_t k) {
    return c[k < c.size() ? k : k - c.size()];
  }

  static bool find_common_edge(std::span<const ConeCorner> p, std::span<const ConeCorner> q,
                               LineId across, std::uint32_t& i, std::uint32_t& j) {
    for (i = 0; i < p.size(); ++i) {
      if (across.valid() && p[i].edge.line() != across) continue;
      for (j = 0; j < q.size(); ++j) {
        if (p[i].edge.line() == q[j].edge.line() && p[i].edge.negative() != q[j].edge.negative())
          return true;
      }
    }
    return false;
  }

  // Whether the turn from corner k, at a corner that leaves along `edge`, is certainly convex: k
  // is inside of that edge's line. The errors of the polygons are not known here. A corner's error
  // is at most twice a line's and a cross product's, and the answer only decides whether to merge.
  bool turns_inward(std::span<const ConeCorner> c, std::uint32_t k, FacetId facet, EdgeRef edge,
                    SignCounts& counts) const {
    k = k < c.size() ? k : k - static_cast<std::uint32_t>(c.size());
    if (predicates_.is_exact())
      return (edge.negative() ? -1 : 1) * predicates_.side(c, k, facet, edge.line(), counts) > 0;
    const Line& line = predicates_.line(edge.line());
    const double s = dot(line.n, c[k].r);
    return (edge.negative() ? -s : s) > 16 * static_cast<double>(line.error) + 16 * sign_slack;
  }

  const CellPredicates& predicates_;
};

}  // namespace shadowcut
