// Ear clipping with exact signs, then Hertel & Mehlhorn's merging.
//
// Why the result can be trusted: every clipped ear is a triangle of positive turn, and the
// triangles' boundaries add up to the outline's; so at every point the number of triangles that
// cover it equals the outline's winding number. An outline that does not cross itself may still run
// round some place twice, by passing through a corner or along an edge of its own; so it is tested
// that no two triangles overlap. Then they tile the figure. A figure for which no such sequence of
// ears is found is refused, never cut wrongly.

#include "scene/convex_decomposition.hpp"

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "support/assert.hpp"

namespace shadowcut {
namespace {

using Rational = boost::multiprecision::cpp_rational;

int exact_turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Rational ax(a.x()), ay(a.y());
  const Rational d = (Rational(b.x()) - ax) * (Rational(c.y()) - ay) -
                     (Rational(b.y()) - ay) * (Rational(c.x()) - ax);
  return d.sign();
}

// p, known to be on the line ab, is between them
bool within(const Vec2& p, const Vec2& a, const Vec2& b) {
  return std::min(a.x(), b.x()) <= p.x() && p.x() <= std::max(a.x(), b.x()) &&
         std::min(a.y(), b.y()) <= p.y() && p.y() <= std::max(a.y(), b.y());
}

bool cross_properly(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  if (std::max(a.x(), b.x()) < std::min(c.x(), d.x()) ||
      std::max(c.x(), d.x()) < std::min(a.x(), b.x()) ||
      std::max(a.y(), b.y()) < std::min(c.y(), d.y()) ||
      std::max(c.y(), d.y()) < std::min(a.y(), b.y())) {
    return false;
  }
  return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
}

bool crosses_itself(std::span<const Vec2> p, const std::vector<Loop>& loops) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const Loop& loop : loops) {
    for (std::size_t i = 0; i < loop.size(); ++i)
      edges.emplace_back(loop[i], loop[(i + 1) % loop.size()]);
  }
  // Sorted by their left ends, an edge meets only those that begin before it ends.
  const auto left = [&](const auto& e) { return std::min(p[e.first].x(), p[e.second].x()); };
  const auto right = [&](const auto& e) { return std::max(p[e.first].x(), p[e.second].x()); };
  std::sort(edges.begin(), edges.end(),
            [&](const auto& e, const auto& f) { return left(e) < left(f); });
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = i + 1; j < edges.size() && left(edges[j]) <= right(edges[i]); ++j) {
      if (cross_properly(p[edges[i].first], p[edges[i].second], p[edges[j].first],
                         p[edges[j].second]))
        return true;
    }
  }
  return false;
}

double doubled_area(std::span<const Vec2> p, std::span<const std::uint32_t> loop) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
    const Vec2 u = p[loop[i]] - p[loop[0]], v = p[loop[i + 1]] - p[loop[0]];
    sum += u.x() * v.y() - u.y() * v.x();
  }
  return sum;
}

// Whether the segment from corner i of the loop leaves into the figure on the loop's left.
bool opens_towards(std::span<const Vec2> p, std::span<const std::uint32_t> loop, std::size_t i,
                   const Vec2& to) {
  const Vec2 &b = p[loop[i]], &a = p[loop[(i + loop.size() - 1) % loop.size()]],
             &c = p[loop[(i + 1) % loop.size()]];
  if (turn(a, b, c) > 0) return turn(a, b, to) > 0 && turn(b, c, to) > 0;
  return turn(a, b, to) > 0 || turn(b, c, to) > 0;
}

// Joins a hole to the loop by a bridge between the two nearest corners that see each other.
bool bridge(std::span<const Vec2> p, Loop& outer, const Loop& hole, const std::vector<Loop>& rest) {
  struct Candidate {
    double distance;
    std::size_t i, j;
  };
  SHADOWCUT_ASSERT(outer.size() >= 3 && hole.size() >= 3);
  std::vector<Candidate> candidates;
  // From the hole's leftmost corner alone a bridge always exists; every other corner would only
  // make it shorter.
  const std::size_t j = static_cast<std::size_t>(
      std::min_element(hole.begin(), hole.end(),
                       [&](auto a, auto b) { return p[a].x() < p[b].x(); }) -
      hole.begin());
  for (std::size_t i = 0; i < outer.size(); ++i)
    candidates.push_back({(p[outer[i]] - p[hole[j]]).squaredNorm(), i, j});
  std::sort(candidates.begin(), candidates.end(),
            [](const auto& a, const auto& b) { return a.distance < b.distance; });
  const auto blocked = [&](const Loop& loop, const Vec2& a, const Vec2& b) {
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const Vec2 &c = p[loop[k]], &d = p[loop[(k + 1) % loop.size()]];
      if (cross_properly(a, b, c, d)) return true;
      // a corner in the way
      if (c != a && c != b && turn(a, b, c) == 0 && within(c, a, b)) return true;
      if (((a != c && a != d && turn(c, d, a) == 0 && within(a, c, d)) ||
           (b != c && b != d && turn(c, d, b) == 0 && within(b, c, d))))
        return true;
    }
    return false;
  };
  for (const Candidate& k : candidates) {
    const Vec2 &a = p[outer[k.i]], &b = p[hole[k.j]];
    if (a != b && !opens_towards(p, outer, k.i, b)) continue;
    if (a != b && (blocked(outer, a, b) || blocked(hole, a, b))) continue;
    if (a != b &&
        std::any_of(rest.begin(), rest.end(), [&](const Loop& l) { return blocked(l, a, b); }))
      continue;
    Loop joined(outer.begin(), outer.begin() + static_cast<std::ptrdiff_t>(k.i) + 1);
    for (std::size_t n = 0; n <= hole.size(); ++n) joined.push_back(hole[(k.j + n) % hole.size()]);
    joined.insert(joined.end(), outer.begin() + static_cast<std::ptrdiff_t>(k.i), outer.end());
    outer = std::move(joined);
    return true;
  }
  return false;
}

bool is_ear(std::span<const Vec2> p, const Loop& loop, std::size_t i) {
  const std::size_t n = loop.size();
  const Vec2 &a = p[loop[(i + n - 1) % n]], &b = p[loop[i]], &c = p[loop[(i + 1) % n]];
  for (std::size_t k = 0; k < n; ++k) {
    const Vec2& q = p[loop[k]];
    if (q == a || q == b || q == c) continue;
    if (turn(a, b, q) >= 0 && turn(b, c, q) >= 0 && turn(c, a, q) >= 0) return false;
  }
  return true;
}

// Corners at which the loop folds back on itself or stands still carry no area.
bool is_spike(std::span<const Vec2> p, const Loop& loop, std::size_t i) {
  const std::size_t n = loop.size();
  return turn(p[loop[(i + n - 1) % n]], p[loop[i]], p[loop[(i + 1) % n]]) == 0;
}

bool clip_ears(std::span<const Vec2> p, Loop loop, std::vector<Loop>& triangles) {
  SHADOWCUT_ASSERT(loop.size() >= 3);
  std::size_t i = 0;
  while (loop.size() > 3) {
    const std::size_t n = loop.size();
    // What is left of a place where the outline touched itself: out and back, or no way at all. No
    // area goes with it.
    std::size_t spent = n;
    for (std::size_t at = 0; at < n && spent == n; ++at) {
      const Vec2& next = p[loop[(at + 1) % n]];
      if (p[loop[at]] == next || p[loop[(at + n - 1) % n]] == next) spent = at;
    }
    if (spent != n) {
      loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(spent));
      continue;
    }
    std::size_t found = n, straight = n;
    for (std::size_t k = 0; k < n && found == n; ++k) {
      const std::size_t at = (i + k) % n;
      const int t = turn(p[loop[(at + n - 1) % n]], p[loop[at]], p[loop[(at + 1) % n]]);
      if (t > 0 && is_ear(p, loop, at)) found = at;
      if (t == 0 && straight == n) straight = at;
    }
    if (found == n && straight == n) return false;
    const std::size_t at = found != n ? found : straight;
    if (found != n) triangles.push_back({loop[(at + n - 1) % n], loop[at], loop[(at + 1) % n]});
    loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(at));
    i = at;  // going on behind the ear keeps the parts round rather than fanned
  }
  if (is_spike(p, loop, 1)) return true;  // no area left
  if (turn(p[loop[0]], p[loop[1]], p[loop[2]]) < 0) return false;
  triangles.push_back(loop);
  return true;
}

// Two triangles are apart when one has an edge with all of the other on its outside, or on it.
bool apart(std::span<const Vec2> p, const Loop& s, const Loop& t) {
  const auto shuts_out = [&](const Loop& a, const Loop& b) {
    for (int i = 0; i < 3; ++i) {
      const Vec2 &from = p[a[static_cast<std::size_t>(i)]],
                 &to = p[a[static_cast<std::size_t>((i + 1) % 3)]];
      if (turn(from, to, p[b[0]]) <= 0 && turn(from, to, p[b[1]]) <= 0 &&
          turn(from, to, p[b[2]]) <= 0)
        return true;
    }
    return false;
  };
  return shuts_out(s, t) || shuts_out(t, s);
}

bool any_overlap(std::span<const Vec2> p, const std::vector<Loop>& triangles) {
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (std::size_t j = i + 1; j < triangles.size(); ++j) {
      if (!apart(p, triangles[i], triangles[j])) return true;
    }
  }
  return false;
}

// Removes diagonals between parts as long as the union stays convex.
void merge_parts(std::span<const Vec2> p, std::vector<Loop>& parts) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> owner;  // directed edge -> part
  const auto claim = [&](std::size_t part) {
    const Loop& l = parts[part];
    for (std::size_t i = 0; i < l.size(); ++i) owner[{l[i], l[(i + 1) % l.size()]}] = part;
  };
  for (std::size_t i = 0; i < parts.size(); ++i) claim(i);
  const auto diagonals = owner;  // a copy: the map changes as parts merge
  for (const auto& [edge, unused] : diagonals) {
    const auto [a, b] = edge;
    const auto here = owner.find({a, b}), there = owner.find({b, a});
    if (a > b || here == owner.end() || there == owner.end() || here->second == there->second)
      continue;
    const std::size_t keep = here->second, gone = there->second;
    Loop l = parts[keep], m = parts[gone];
    std::rotate(l.begin(), std::find(l.begin(), l.end(), b), l.end());  // b ... a
    std::rotate(m.begin(), std::find(m.begin(), m.end(), a), m.end());  // a ... b
    Loop joined(l.begin(), l.end());
    joined.insert(joined.end(), m.begin() + 1, m.end() - 1);
    SHADOWCUT_ASSERT(joined.size() >= 3);
    if (!is_convex(p, joined)) continue;
    owner.erase({a, b});
    owner.erase({b, a});
    parts[keep] = std::move(joined);
    parts[gone].clear();
    claim(keep);
  }
  std::erase_if(parts, [](const Loop& l) { return l.empty(); });
}

}  // namespace

int turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  const double l = (b.x() - a.x()) * (c.y() - a.y()), r = (b.y() - a.y()) * (c.x() - a.x());
  const double d = l - r;
  // Each factor carries one rounding, each product one more, the difference one: at most 3u(1+u)^2
  // (|l|+|r|) < 4u (|l|+|r|). Products so small that they may have lost bits to underflow, or
  // overflowed, are left to exact arithmetic too.
  const double bound =
      (std::abs(l) + std::abs(r)) * (4 * std::numeric_limits<double>::epsilon() / 2);
  if (std::abs(d) > bound && bound > 1e-290 && bound < 1e290) return d > 0 ? 1 : -1;
  if (a == b || b == c || a == c) return 0;
  return exact_turn(a, b, c);
}

bool is_convex(std::span<const Vec2> p, std::span<const std::uint32_t> loop) {
  const std::size_t n = loop.size();
  int direction_changes = 0, last = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 &a = p[loop[i]], &b = p[loop[(i + 1) % n]], &c = p[loop[(i + 2) % n]];
    const int t = turn(a, b, c);
    if (t < 0) return false;
    if (t == 0 && !(within(b, a, c) && a != c)) return false;  // a spike
    // Round once: along the order of (x, y) the loop turns back exactly twice.
    const int direction = std::pair(a.x(), a.y()) < std::pair(b.x(), b.y()) ? 1 : -1;
    if (last != 0 && direction != last) ++direction_changes;
    last = direction;
  }
  return direction_changes <= 2;
}

ConvexResult convex_parts(std::span<const Vec2> p, std::vector<Loop> loops, bool merge,
                          std::vector<Loop>& parts) {
  SHADOWCUT_ASSERT(!loops.empty() && loops.front().size() >= 3);
  if (crosses_itself(p, loops)) return ConvexResult::self_intersecting;
  Loop outer = std::move(loops.front());
  if (doubled_area(p, outer) <= 0) return ConvexResult::self_intersecting;
  std::vector<Loop> holes(std::make_move_iterator(loops.begin() + 1),
                          std::make_move_iterator(loops.end()));
  for (Loop& hole : holes) {
    if (doubled_area(p, hole) > 0) std::reverse(hole.begin(), hole.end());
  }
  // Holes from left to right: what could stand between a hole's leftmost corner and the outline has
  // then been joined to it.
  const auto leftmost = [&](const Loop& l) {
    double x = std::numeric_limits<double>::infinity();
    for (const auto i : l) x = std::min(x, p[i].x());
    return x;
  };
  std::sort(holes.begin(), holes.end(),
            [&](const Loop& a, const Loop& b) { return leftmost(a) > leftmost(b); });
  while (!holes.empty()) {
    const Loop hole = std::move(holes.back());
    holes.pop_back();
    if (!bridge(p, outer, hole, holes)) return ConvexResult::self_intersecting;
  }
  std::vector<Loop> triangles;
  if (!clip_ears(p, std::move(outer), triangles) || triangles.empty() || any_overlap(p, triangles))
    return ConvexResult::self_intersecting;
  if (merge) merge_parts(p, triangles);
  parts.insert(parts.end(), std::make_move_iterator(triangles.begin()),
               std::make_move_iterator(triangles.end()));
  return ConvexResult::ok;
}

}  // namespace shadowcut
