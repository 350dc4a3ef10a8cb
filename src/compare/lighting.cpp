// See lighting.hpp.
#include "lighting.hpp"

#include <algorithm>

#include "light_space/light_space.hpp"
#include "facets/light_position.hpp"
#include "light_space/light_range.hpp"

namespace shadowcut::compare {

double tolerance_of(const Scene& scene) {
  const Eigen::AlignedBox3d box = box_of(scene);
  return box.isEmpty()
             ? 0
             : tolerance_share * box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
}

Lighting::Lighting(const Scene& scene, const Light& light)
    : scene_(scene),
      light_(light),
      tolerance_(tolerance_of(scene)),
      roles_(scene.facets().size()),
      facing_(scene.faces().size(), Facing::refused) {
  light.check("light");
  const LightSpace space(light, box_of(scene));
  std::vector<std::uint8_t> light_inside;
  for (const Object& object : scene.objects()) {
    const bool solid = light.kind == Light::Kind::point && object.sides == Sides::closed;
    light_inside.push_back(solid && in_or_on_solid(scene, object, light.position));
  }
  for (std::uint32_t f = 0; f < scene.faces().size(); ++f) {
    const Face& face = scene.faces()[f];
    if (face.facet_count == 0) continue;
    const bool reached = within_range(scene, face, light);
    const bool looks = scene.objects()[face.object].receives_shadows;
    facing_[f] = !looks ? Facing::ignored : reached ? Facing::away : Facing::out_of_reach;
    if (!reached) continue;
    for (std::uint32_t i = face.first_facet; i < face.first_facet + face.facet_count; ++i) {
      roles_[i] = role_of(i, light_inside[face.object] != 0, space);
      if (roles_[i].receives) facing_[f] = Facing::toward;
    }
  }
}

Lighting::Role Lighting::role_of(std::uint32_t i, bool light_inside,
                                 const LightSpace& space) const {
  const Facet& facet = scene_.facets()[i];
  const Object& object = scene_.objects()[scene_.faces()[facet.face].object];
  const Orientation turned = space.orientation(scene_.planes()[facet.plane]);
  if (turned == Orientation::edge_on) return {};
  const bool lightless = turned == Orientation::away && object.sides == Sides::closed;
  return {object.receives_shadows && !lightless,
          object.casts_shadows && (!lightless || light_inside)};
}

Vec3 Lighting::direction_at(const Vec3& x) const {
  return light_.kind == Light::Kind::point ? Vec3(x - light_.position)
                                           : light_.direction.stableNormalized().eval();
}

double Lighting::in_front_of(const HalfSpace& plane) const {
  return -plane.normal.dot(direction_at(plane.point));
}

// The plane through the light and the line in which the polygon's plane F meets another one, P: a
// combination of both that vanishes at the light, f(light) p(x) - p(light) f(x), with f and p the
// distances from the planes.
Vec3 Lighting::normal_of_edge(const Polygon& polygon, std::size_t i) const {
  const Facet& facet = scene_.facets()[polygon.facet];
  const Carrier carrier = polygon.corners[i].edge;
  if (carrier.kind == Carrier::Kind::edge) {
    const auto corners = scene_.corners_of(facet);
    const Vec3 &a = scene_.vertices()[corners[carrier.index].vertex],
               &b = scene_.vertices()[corners[(carrier.index + 1) % corners.size()].vertex];
    return (b - a).cross(direction_at(a));
  }
  const Plane &own = scene_.planes()[facet.plane], &other = scene_.planes()[carrier.index];
  const double f = own.normal.dot(direction_at(own.point)),
               p = other.normal.dot(direction_at(other.point));
  return f * other.normal - p * own.normal;
}

void Lighting::shadow_planes(const Polygon& polygon,
                             boost::container::small_vector<HalfSpace, 8>& planes) const {
  planes.clear();
  for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
    if (polygon.corners[i].edge.kind == Carrier::Kind::shadow_plane) continue;
    HalfSpace plane{normal_of_edge(polygon, i), polygon.corners[i].at};
    const double length = plane.normal.norm();
    if (length == 0) continue;
    plane.normal /= length;
    double farthest = 0;
    for (const PolygonCorner& corner : polygon.corners) {
      const double distance = plane.above(corner.at);
      if (std::abs(distance) > std::abs(farthest)) farthest = distance;
    }
    if (farthest < 0) plane.normal = -plane.normal;
    planes.push_back(plane);
  }
}

}  // namespace shadowcut::compare
