#include "facets/facet_visibility.hpp"

#include <algorithm>

#include "facets/light_position.hpp"
#include "light_space/light_range.hpp"

namespace shadowcut {

bool FacetVisibility::light_is_inside(const Object& object, const Light& light) const {
  return light.kind == Light::Kind::point && object.sides == Sides::closed &&
         in_or_on_solid(scene_, object, light.position);
}

bool FacetVisibility::forward(FacetId f) const {
  const bool ahead =
      orientation(f) == Orientation::toward ? space_.handedness() > 0 : space_.handedness() < 0;
  return ahead != (tables_.is_exact() && (loops_[f.value()] & loop_is_reversed));
}

std::size_t FacetVisibility::entered() const {
  return static_cast<std::size_t>(std::count(enters_.begin(), enters_.end(), 1));
}

void FacetVisibility::decide(FacetId id, bool in_range, bool light_inside, const Light& light) {
  const std::uint32_t i = id.value();
  SHADOWCUT_ASSERT(i < facing_.size() && tables_.facet(id).corner_count >= 3);
  const Facet& facet = tables_.facet(id);
  const Object& object = scene_.objects()[tables_.object_of(id)];
  const Plane& plane = scene_.planes()[facet.plane];
  Orientation& orientation = orientation_[i];
  orientation = space_.orientation(plane);
  grazed_[i] = 0;
  // A plane seen from afar is all of one piece.
  if (orientation != Orientation::edge_on && !space_.far() &&
      !meets_all_corners(scene_, facet, light.position))
    orientation = Orientation::edge_on;
  if (orientation == Orientation::edge_on && tables_.is_exact()) {
    // A light this near to the plane may be on different sides of the plane and of what the rays
    // of its corners meet; then there is no region.
    const ExactPredicates& exact = *tables_.exact;
    const auto corners = scene_.corners_of(facet);
    const bool all_ahead = std::all_of(corners.begin(), corners.end(), [&](const Corner& c) {
      return exact.ahead(plane, scene_.vertices()[c.vertex]) > 0;
    });
    const int front = exact.orientation(plane);
    if (front != 0 && all_ahead) orientation = front > 0 ? Orientation::toward : Orientation::away;
    grazed_[i] = orientation != Orientation::edge_on;
  }
  facing_[i] = object.receives_shadows ? Facing::away : Facing::ignored;
  enters_[i] = 0;
  blocks_only_[i] = 0;
  if (!in_range) {
    if (object.receives_shadows) facing_[i] = Facing::out_of_reach;
    return;
  }
  if (orientation == Orientation::edge_on || (!object.casts_shadows && !object.receives_shadows))
    return;
  const bool turned_off = orientation == Orientation::away && object.sides == Sides::closed;
  if (turned_off && !(light_inside && object.casts_shadows)) return;
  SHADOWCUT_ASSERT(orientation != Orientation::edge_on);
  enters_[i] = 1;
  blocks_only_[i] = turned_off;
  if (!turned_off && object.receives_shadows) facing_[i] = Facing::toward;
}

void FacetVisibility::decide_all(const Light& light) {
  const auto facets = scene_.facets();
  orientation_.resize(facets.size());
  facing_.assign(facets.size(), Facing::away);
  enters_.assign(facets.size(), 0);
  blocks_only_.assign(facets.size(), 0);
  grazed_.assign(facets.size(), 0);
  std::vector<std::uint8_t> light_inside(scene_.objects().size(), 0),
      in_range(scene_.faces().size(), 0);
  parallel_for(light_inside.size(), 16, [&](std::size_t o) {
    light_inside[o] = light_is_inside(scene_.objects()[o], light);
  });
  parallel_for(in_range.size(), 256, [&](std::size_t f) {
    in_range[f] = within_range(scene_, scene_.faces()[f], light);
  });
  parallel_for(facets.size(), 1024, [&](std::size_t i) {
    if (facets[i].corner_count == 0) return;  // of no face
    const FacetId id(i);
    decide(id, in_range[facets[i].face], light_inside[tables_.object_of(id)], light);
  });
}

void FacetVisibility::decide(std::uint32_t o, const Light& light) {
  const Object& object = scene_.objects()[o];
  const bool light_inside = light_is_inside(object, light);
  for (std::uint32_t f = object.first_face; f < object.first_face + object.face_count; ++f) {
    const Face& face = scene_.faces()[f];
    // A face that is partly in range is treated whole.
    const bool in_range = within_range(scene_, face, light);
    for (std::uint32_t i = face.first_facet; i < face.first_facet + face.facet_count; ++i)
      decide(FacetId(i), in_range, light_inside, light);
  }
}

void FacetVisibility::leave(std::uint32_t o) {
  const Object& object = scene_.objects()[o];
  SHADOWCUT_ASSERT(object.first_facet + object.facet_count <= enters_.size());
  std::fill_n(enters_.begin() + object.first_facet, object.facet_count, std::uint8_t{0});
}

void FacetVisibility::grow() {
  const std::size_t facets = scene_.facets().size();
  if (facets <= facing_.size()) return;
  orientation_.resize(facets, Orientation::edge_on);
  facing_.resize(facets, Facing::away);
  enters_.resize(facets, 0), blocks_only_.resize(facets, 0), grazed_.resize(facets, 0);
  if (tables_.is_exact()) loops_.resize(facets, loop_is_convex);
}

Cone* FacetVisibility::cone_of(FacetId facet, ConePool& pool) const {
  const auto corners = scene_.corners_of(tables_.facet(facet));
  const auto n = static_cast<std::uint32_t>(corners.size());
  Cone* cone = pool.take(n + 1);
  cone->count = n;
  cone->facet = facet;
  cone->error = 0;
  const std::uint32_t object = tables_.object_of(facet);
  SHADOWCUT_ASSERT(enters(facet));
  const bool ahead = forward(facet);
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t i = ahead ? k : n - 1 - k;
    // The edge that leaves this corner in this direction.
    const std::uint32_t edge = corners[ahead ? i : i == 0 ? n - 1 : i - 1].edge;
    const VertexRay& ray = tables_.rays[corners[i].vertex];
    cone->corners()[k] = {
        {ray.r[0], ray.r[1], ray.r[2]},
        EdgeRef(tables_.lines.of_edge(object, edge >> 1), ((edge & 1) != 0) == ahead),
        corners[i].vertex};
    cone->error = std::max(cone->error, ray.error);
  }
  SHADOWCUT_ASSERT(n >= 3);
  return cone;
}

}  // namespace shadowcut
