// Loops of facets as the light sees them, exactly (FacetVisibility::check_loops).

#include <algorithm>

#include "facets/facet_visibility.hpp"

namespace shadowcut {
namespace {

std::uint32_t next(const Cone& cone, std::uint32_t i) { return i + 1 == cone.count ? 0 : i + 1; }
std::uint32_t previous(const Cone& cone, std::uint32_t i) { return (i == 0 ? cone.count : i) - 1; }

void erase_corner(Cone& cone, std::uint32_t i) {
  ConeCorner* c = cone.corners();
  std::copy(c + i + 1, c + cone.count, c + i);
  --cone.count;
}

// Edges whose ends the light sees in one place: the corner behind such an edge goes.
void drop_null_edges(Cone& cone, const CellPredicates& l, const ExactPredicates& exact) {
  ConeCorner* c = cone.corners();
  for (std::uint32_t k = 0; k < cone.count;) {
    if (l.line(c[k].edge.line()).error <= 0x1p-20f || !exact.is_null(l.exact(c[k].edge.line()))) {
      ++k;
      continue;
    }
    const std::uint32_t behind = next(cone, k);
    c[k].edge = c[behind].edge;
    erase_corner(cone, behind);
    if (behind < k) --k;
  }
}

struct Turns {
  bool any = false;                     // the loop has an area
  std::uint32_t wrong = invalid_index;  // the edge behind which it turns outward
};

Turns turns_of(const Cone& cone, const CellPredicates& l, SignCounts& counts) {
  Turns out;
  for (std::uint32_t k = 0; k < cone.count && cone.count >= 3; ++k) {
    const EdgeRef edge = cone.corners()[k].edge;
    const int turn = (edge.negative() ? -1 : 1) * l.side(cone.span(), next(cone, next(cone, k)),
                                                         cone.facet, edge.line(), counts);
    out.any = out.any || turn != 0;
    if (turn < 0) out.wrong = k;
  }
  return out;
}

// On which sides of an edge's line the corners lie, for a cut that goes on from the edge's end,
// where the loop turns away: corners before that, on the line as well, stay with what is before.
std::vector<int> sides_of(const Cone& cone, std::uint32_t edge, const CellPredicates& l,
                          SignCounts& counts) {
  std::vector<int> sides(cone.count);
  for (std::uint32_t i = 0; i < cone.count; ++i)
    sides[i] = l.side(cone.span(), i, cone.facet, cone.corners()[edge].edge.line(), counts);
  const std::uint32_t end = next(cone, edge);
  std::uint32_t before = edge;
  while (sides[before] == 0 && before != end) before = previous(cone, before);
  const int side_before = sides[before];
  if (side_before != -sides[next(cone, end)]) return sides;
  for (std::uint32_t i = edge; i != before; i = previous(cone, i)) sides[i] = side_before;
  return sides;
}

// How often the loop goes from one side to the other.
std::uint32_t crossings(const std::vector<int>& sides) {
  std::uint32_t changes = 0;
  int last = 0;
  // the first round only finds the side to begin with
  for (std::size_t i = 0; i < 2 * sides.size(); ++i) {
    const int s = sides[i % sides.size()];
    if (s == 0) continue;
    changes += i >= sides.size() && s != last;
    last = s;
  }
  return changes;
}

// One side of a cut along an edge's own line.
void tidy(Cone& half, const CellPredicates& l) {
  // Out and back along the cut, where the edge itself lies.
  ConeCorner* c = half.corners();
  for (std::uint32_t i = 0; i < half.count; ++i) {
    const EdgeRef in = incoming(half.span(), i), out = c[i].edge;
    if (in.line() != out.line() || in.negative() == out.negative()) continue;
    erase_corner(half, i);
    break;
  }
  // Where the cut ends at a corner of the facet, it is that corner.
  for (std::uint32_t i = 0; i < half.count; ++i) {
    if (c[i].vertex == invalid_index)
      c[i].vertex = l.shared_vertex(incoming(half.span(), i), c[i].edge);
  }
}

}  // namespace

// How far the corner behind an edge's end lies on the edge's inside, as the numbers have it.
double FacetVisibility::turn_behind(const Cone& cone, std::uint32_t k) const {
  const EdgeRef edge = cone.corners()[k].edge;
  const Line& l = tables_.lines[edge.line()];
  const double* r = cone.corners()[next(cone, next(cone, k))].r;
  const double s = dot(l.n, r);
  return edge.negative() ? -s : s;
}

void FacetVisibility::check_loops() {
  loops_.assign(scene_.facets().size(), loop_is_convex);
  parallel_for(loops_.size(), 1, [this](std::size_t i) { check_loop(FacetId(i)); });
}

void FacetVisibility::check_loop(FacetId facet) {
  const std::uint32_t i = facet.value();
  SHADOWCUT_ASSERT(tables_.is_exact() && i < loops_.size());
  if (!enters_[i]) return;
  loops_[i] = loop_is_convex;
  Workspace& w = workspaces_.local();
  Cone* cone = cone_of(facet, w.pool);
  bool sure = true;
  for (std::uint32_t k = 0; k < cone->count && sure; ++k) {
    const float line_error = tables_.lines[cone->corners()[k].edge.line()].error;
    sure = turn_behind(*cone, k) >
           static_cast<double>(line_error) + static_cast<double>(cone->error) + sign_slack;
  }
  if (sure) return w.pool.give_back(cone);
  std::vector<Cone*> parts;
  const std::uint32_t corners = cone->count;
  bool simple = cut_convex(cone, w, parts);
  if (!simple || parts.empty()) {
    // The light may be so near to the plane that the loop runs the other way round than the plane
    // says.
    for (Cone* part : parts) w.pool.give_back(part);
    parts.clear();
    loops_[i] = loop_is_reversed;
    simple = cut_convex(cone_of(facet, w.pool), w, parts);
  }
  if (!simple || parts.empty()) {
    enters_[i] = 0;
    orientation_[i] = Orientation::edge_on;
    if (facing_[i] == Facing::toward) facing_[i] = Facing::away;
  } else if (parts.size() > 1 || parts[0]->count != corners) {
    loops_[i] |= loop_is_cut;
  }
  for (Cone* part : parts) w.pool.give_back(part);
}

// Takes the cone. False: it crosses itself.
bool FacetVisibility::cut_convex(Cone* cone, Workspace& w, std::vector<Cone*>& parts) const {
  const CellPredicates l(tables_, {});
  SHADOWCUT_ASSERT(tables_.is_exact() && parts.empty());
  SignCounts counts;
  drop_null_edges(*cone, l, *tables_.exact);
  std::vector<Cone*> pending{cone};
  bool simple = true;
  for (std::size_t steps = 2 * cone->count; !pending.empty();) {
    Cone* part = pending.back();
    pending.pop_back();
    const Turns turns = turns_of(*part, l, counts);
    if (turns.wrong == invalid_index && turns.any) {
      parts.push_back(part);
      continue;
    }
    if (turns.wrong != invalid_index) {
      simple = simple && steps-- > 0;
      const std::vector<int> sides =
          simple ? sides_of(*part, turns.wrong, l, counts) : std::vector<int>();
      simple = simple && crossings(sides) == 2;
      if (simple) {
        const LineId id = part->corners()[turns.wrong].edge.line();
        const DividingLine line{l.line(id).n, l.line(id).error, id};
        CornerSides by_line(*part, line.n, INFINITY, w.spill);
        by_line.decide([&](std::uint32_t i) { return sides[i]; });
        Cone *positive, *negative;
        split(*part, by_line, line, false, l, w.pool, positive, negative);
        for (Cone* half : {positive, negative}) {
          tidy(*half, l);
          pending.push_back(half);
        }
      }
    }
    w.pool.give_back(part);
  }
  return simple;
}

}  // namespace shadowcut
