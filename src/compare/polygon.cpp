// See polygon.hpp.
#include "polygon.hpp"

namespace shadowcut::compare {

Polygon polygon_of(const Scene& scene, std::uint32_t facet) {
  Polygon polygon;
  polygon.facet = facet;
  std::uint32_t i = 0;
  for (const Corner& corner : scene.corners_of(scene.facets()[facet]))
    polygon.corners.push_back({scene.vertices()[corner.vertex], {Carrier::Kind::edge, i++}});
  return polygon;
}

double area_of(const Polygon& polygon) {
  Vec3 sum = Vec3::Zero();
  const Vec3& first = polygon.corners.front().at;
  for (std::size_t i = 2; i < polygon.corners.size(); ++i)
    sum += (polygon.corners[i - 1].at - first).cross(polygon.corners[i].at - first);
  return sum.norm() / 2;
}

Standing stand(const Polygon& polygon, const HalfSpace& plane, double tolerance) {
  Standing standing;
  bool front = false, back = false;
  for (const PolygonCorner& corner : polygon.corners) {
    double distance = plane.above(corner.at);
    if (std::abs(distance) <= tolerance) distance = 0;
    front |= distance > 0;
    back |= distance < 0;
    standing.distances.push_back(distance);
  }
  standing.side = front && back ? Side::across : front ? Side::front : back ? Side::back : Side::on;
  return standing;
}

Halves split(const Polygon& polygon, const Standing& standing, Carrier cut) {
  Halves halves;
  halves.front.facet = halves.back.facet = polygon.facet;
  for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
    const std::size_t next = i + 1 == polygon.corners.size() ? 0 : i + 1;
    const PolygonCorner& corner = polygon.corners[i];
    const double here = standing.distances[i], there = standing.distances[next];
    // Where the outline comes to the plane the half that it leaves goes on along the cut.
    if (here >= 0)
      halves.front.corners.push_back(here == 0 && there < 0 ? PolygonCorner{corner.at, cut}
                                                            : corner);
    if (here <= 0)
      halves.back.corners.push_back(here == 0 && there > 0 ? PolygonCorner{corner.at, cut}
                                                           : corner);
    if (here * there >= 0) continue;
    const Vec3 at = corner.at + (here / (here - there)) * (polygon.corners[next].at - corner.at);
    halves.front.corners.push_back({at, here > 0 ? cut : corner.edge});
    halves.back.corners.push_back({at, here > 0 ? corner.edge : cut});
  }
  return halves;
}

bool keep_front(Polygon& polygon, const HalfSpace& plane, double tolerance,
                std::vector<Polygon>* rest) {
  const Standing standing = stand(polygon, plane, tolerance);
  if (standing.side != Side::across) return standing.side == Side::front;
  Halves halves = split(polygon, standing, {Carrier::Kind::shadow_plane, 0});
  polygon = std::move(halves.front);
  if (rest) rest->push_back(std::move(halves.back));
  return true;
}

Eigen::AlignedBox3d box_of(const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (const Facet& facet : scene.facets())
    for (const Corner& corner : scene.corners_of(facet))
      box.extend(scene.vertices()[corner.vertex]);
  return box;
}

}  // namespace shadowcut::compare
