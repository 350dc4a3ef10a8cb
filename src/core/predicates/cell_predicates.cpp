#include "predicates/cell_predicates.hpp"

namespace shadowcut {
namespace {

// Points in one line along an axis.
bool in_line(const Vec3& a, const Vec3& b, const Vec3& c) {
  int common = 0;
  for (int i = 0; i < 3; ++i) common += a[i] == b[i] && b[i] == c[i];
  return common >= 2;
}

}  // namespace

LightLine CellPredicates::exact(LineId id) const {
  SHADOWCUT_ASSERT(is_exact() && id.valid());
  if (is_local(id)) return local_[id.value() - first_local_line].exact;
  const auto& [a, b] = tables_.lines.ends(id);
  return {false, {a, b, Vec3::Zero(), Vec3::Zero()}};
}

std::uint32_t CellPredicates::shared_vertex(EdgeRef a, EdgeRef b) const {
  return a.line() == b.line() ? invalid_index
                              : shadowcut::shared_vertex(line(a.line()), line(b.line()));
}

void CellPredicates::hold(std::span<const ConeCorner> cone, std::uint32_t i, FacetId facet,
                          HeldCorner& held) const {
  SHADOWCUT_ASSERT(i < cone.size());
  const EdgeRef in = incoming(cone, i), out = cone[i].edge;
  held.corner = {nullptr, false, &held.in, &held.out, in.negative(), out.negative()};
  if (cone[i].vertex != invalid_index) {
    held.corner.vertex = &tables_.vertices[cone[i].vertex];
    return;
  }
  // Two edges of one vertex meet in its ray, or in the opposite one: where the facet's plane is.
  if (const std::uint32_t v = shared_vertex(in, out); v != invalid_index) {
    held.corner.vertex = &tables_.vertices[v];
    held.corner.opposite = ahead(facet, v) < 0;
    return;
  }
  held.in = exact(in.line()), held.out = exact(out.line());
}

int CellPredicates::side(std::span<const ConeCorner> cone, std::uint32_t i, FacetId facet,
                         LineId line, SignCounts& counts) const {
  const EdgeRef in = incoming(cone, i), out = cone[i].edge;
  const Line& l = this->line(line);
  const std::uint32_t vertex =
      cone[i].vertex != invalid_index ? cone[i].vertex : shared_vertex(in, out);
  if (in.line() == line || out.line() == line ||
      (vertex != invalid_index && (l.a == vertex || l.b == vertex))) {
    ++counts.by_identity;
    return 0;
  }
  HeldCorner held;
  hold(cone, i, facet, held);
  const LightLine tested = exact(line);
  // Two edges in one line, or a vertex in line with one.
  const auto is_along = [&](const LightLine& m) {
    return !m.crossing && in_line(tested.v[0], tested.v[1], m.v[0]) &&
           in_line(tested.v[0], tested.v[1], m.v[1]);
  };
  const Vec3* x = held.corner.vertex;
  if (!tested.crossing &&
      (x ? in_line(tested.v[0], tested.v[1], *x) : is_along(held.in) || is_along(held.out))) {
    ++counts.by_identity;
    return 0;
  }
  ++counts.by_exact;
  return exact_->side(tested, held.corner);
}

int CellPredicates::nearer(std::span<const ConeCorner> cone, std::uint32_t i, FacetId facet,
                           std::uint32_t other_plane, SignCounts& counts) const {
  const Plane &p = tables_.plane_of(facet), &q = tables_.scene_planes[other_plane];
  // one plane, recorded twice
  if (p.point == q.point &&
      (p.exact_normal == q.exact_normal || p.exact_normal == -q.exact_normal)) {
    ++counts.by_identity;
    return 0;
  }
  ++counts.by_exact;
  HeldCorner held;
  hold(cone, i, facet, held);
  // An edge in both planes.
  const auto is_common = [&](const LightLine& l) {
    return !l.crossing && exact_->contains(p, l.v[0]) && exact_->contains(q, l.v[0]) &&
           exact_->contains(p, l.v[1]) && exact_->contains(q, l.v[1]);
  };
  if (!held.corner.vertex && (is_common(held.in) || is_common(held.out))) return 0;
  return exact_->nearer(p, q, held.corner);
}

int CellPredicates::ahead(FacetId facet, std::uint32_t vertex) const {
  SHADOWCUT_ASSERT(is_exact() && vertex < tables_.vertices.size());
  return exact_->ahead(tables_.plane_of(facet), tables_.vertices[vertex]);
}

VertexRay CellPredicates::ray(EdgeRef in, EdgeRef out) const {
  const LightLine a = exact(in.line()), b = exact(out.line());
  return exact_->ray({nullptr, false, &a, &b, in.negative(), out.negative()});
}

Vec3 CellPredicates::point(std::span<const ConeCorner> cone, std::uint32_t i, FacetId facet,
                           PointCache& cache) const {
  const std::uint32_t plane = tables_.plane_index(facet);
  const auto make = [&] {
    HeldCorner held;
    hold(cone, i, facet, held);
    return exact_->point(tables_.scene_planes[plane], held.corner);
  };
  return cone[i].vertex != invalid_index ? make()
                                         : cache.get(plane, incoming(cone, i).line().value(),
                                                     cone[i].edge.line().value(), make);
}

Construction CellPredicates::construction(std::span<const ConeCorner> cone, std::uint32_t i) const {
  return {exact(incoming(cone, i).line()), exact(cone[i].edge.line()), cone[i].vertex};
}

}  // namespace shadowcut
