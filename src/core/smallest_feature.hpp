// The smallest feature kept (Options::min_feature): of the two parts of a cut the smaller one goes
// if it is less than that. The larger one stays whatever its size, so nothing vanishes whole.
#pragma once

#include <cmath>

#include "emit.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {

inline Vec3 corner_on_plane(const LightTables& tables, const Cone& cone, std::uint32_t i) {
  return tables.space->back(cone.corners()[i].r, tables.planes[tables.facets[cone.facet].plane].q);
}

inline double area_on_plane(const LightTables& tables, const Cone& cone) {
  AreaSum sum(corner_on_plane(tables, cone, 0));
  for (std::uint32_t i = 1; i < cone.count; ++i) sum.add(corner_on_plane(tables, cone, i));
  return sum.area(tables.scene_planes[tables.facets[cone.facet].plane].normal);
}

// As a point light sees it: triangles by Van Oosterom & Strackee 1983.
inline double solid_angle(const LightTables& tables, const Cone& cone) {
  const auto to = [&](std::uint32_t i) {
    return (corner_on_plane(tables, cone, i) - tables.light_at).stableNormalized().eval();
  };
  const Vec3 a = to(0);
  Vec3 b = to(1);
  double angle = 0;
  for (std::uint32_t i = 2; i < cone.count; ++i) {
    const Vec3 c = to(i);
    angle += 2 * std::atan2(a.dot(b.cross(c)), 1 + a.dot(b) + b.dot(c) + c.dot(a));
    b = c;
  }
  return std::abs(angle);
}

// Which of the two parts of a cut goes; null: neither.
inline Cone* too_small(const LightTables& tables, Cone* a, Cone* b) {
  const MinFeature& least = tables.least;
  if (least.keeps_all()) return nullptr;
  const double area_a = area_on_plane(tables, *a), area_b = area_on_plane(tables, *b);
  Cone* smaller = area_a < area_b ? a : b;
  if ((area_a < area_b ? area_a : area_b) < least.area) return smaller;
  return least.solid_angle > 0 && solid_angle(tables, *smaller) < least.solid_angle ? smaller
                                                                                    : nullptr;
}

// A cone goes past an SP-node: returns the place that it goes on from. What it leaves on the other
// side is cut_off, or null; with `drop`, what is too small goes nowhere.
inline std::uint32_t step_down(const CellTree& tree, std::uint32_t node, bool drop, Cone*& cone,
                               Cone*& cut_off, Workspace& w) {
  const auto any = [](EdgeRef) { return true; };
  SignCounts counts;
  const Node& n = tree.nodes()[node];
  const std::uint32_t side =
      sift(cone, n.n, n.error, n.id, tree.lines(), any, w.pool, w.spill, cut_off, counts);
  Cone* lost = drop && cut_off ? too_small(tree.tables(), cone, cut_off) : nullptr;
  if (!lost) return node * 2 + side;
  const bool is_first = lost == cone;
  if (is_first) cone = cut_off;
  cut_off = nullptr;
  w.pool.give_back(lost);
  return node * 2 + (is_first ? 1 : 0);
}

// Cuts a cone by the SP-nodes below a place, down to where stop(branch) says. Takes the cone;
// take(cone) gets each part, with its place in Cone::at.
template <class Stop, class Take>
void descend(const CellTree& tree, Cone* whole, std::uint32_t from, bool drop, Workspace& w,
             const Stop& stop, const Take& take) {
  const std::size_t bottom = w.pending.size();
  whole->at = from;
  w.pending.push_back(whole);
  while (w.pending.size() > bottom) {
    Cone* cone = w.pending.back();
    w.pending.pop_back();
    std::uint32_t place = cone->at;
    for (Child here = tree.child_at(place); !stop(here); here = tree.child_at(place)) {
      Cone* cut_off;
      place = step_down(tree, here.node(), drop, cone, cut_off, w);
      if (!cut_off) continue;
      cut_off->at = here.node() * 2 + 1;
      w.pending.push_back(cut_off);
    }
    cone->at = place;
    take(cone);
  }
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
