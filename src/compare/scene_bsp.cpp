// See scene_bsp.hpp.
#include "scene_bsp.hpp"

#include <algorithm>
#include <numeric>

namespace shadowcut::compare {

SceneBsp::SceneBsp(const Scene& scene, std::uint32_t candidates, double tolerance)
    : scene_(scene), tolerance_(tolerance) {
  for (std::uint32_t i = 0; i < scene.facets().size(); ++i)
    if (scene.facets()[i].corner_count > 0) polygons_.push_back(polygon_of(scene, i));
  for (const Polygon& polygon : polygons_) balls_.push_back(ball_of(polygon));
  std::vector<Task> tasks(1, {std::vector<std::uint32_t>(polygons_.size()), invalid_index, false});
  std::iota(tasks[0].polygons.begin(), tasks[0].polygons.end(), 0u);
  while (!tasks.empty()) {
    Task task = std::move(tasks.back());
    tasks.pop_back();
    if (!task.polygons.empty()) divide(std::move(task), std::max(candidates, 1u), tasks);
  }
}

SceneBsp::Ball SceneBsp::ball_of(const Polygon& polygon) {
  Eigen::AlignedBox3d box;
  for (const PolygonCorner& corner : polygon.corners) box.extend(corner.at);
  return {box.center(), box.diagonal().norm() / 2};
}

Side SceneBsp::side_of(std::uint32_t polygon, const HalfSpace& plane) const {
  const double distance = plane.above(balls_[polygon].centre);
  if (std::abs(distance) > balls_[polygon].radius + 2 * tolerance_)
    return distance > 0 ? Side::front : Side::back;
  return stand(polygons_[polygon], plane, tolerance_).side;
}

HalfSpace SceneBsp::plane_of(std::uint32_t polygon) const {
  const Plane& plane = scene_.planes()[scene_.facets()[polygons_[polygon].facet].plane];
  return {plane.normal, plane.point};
}

std::uint32_t SceneBsp::best_root(std::span<const std::uint32_t> list,
                                  std::uint32_t candidates) const {
  const std::size_t count = std::min<std::size_t>(candidates, list.size());
  std::uint32_t best = list.front();
  std::size_t fewest = list.size();
  for (std::size_t k = 0; k < count && fewest > 0; ++k) {
    const std::uint32_t candidate = list[k * list.size() / count];
    const HalfSpace plane = plane_of(candidate);
    std::size_t splits = 0;
    for (std::size_t i = 0; i < list.size() && splits < fewest; ++i)
      splits += list[i] != candidate && side_of(list[i], plane) == Side::across;
    if (splits < fewest) fewest = splits, best = candidate;
  }
  return best;
}

void SceneBsp::divide(Task task, std::uint32_t candidates, std::vector<Task>& tasks) {
  const std::uint32_t root = best_root(task.polygons, candidates),
                      here = static_cast<std::uint32_t>(nodes_.size());
  const HalfSpace plane = plane_of(root);
  const Carrier cut{Carrier::Kind::plane, scene_.facets()[polygons_[root].facet].plane};
  nodes_.push_back(
      {plane, static_cast<std::uint32_t>(in_plane_.size()), 0, invalid_index, invalid_index});
  if (task.parent != invalid_index)
    (task.in_front ? nodes_[task.parent].front : nodes_[task.parent].back) = here;
  Task front{{}, here, true}, back{{}, here, false};
  for (const std::uint32_t i : task.polygons) {
    // The root is in its own plane, whatever its corners' roundings say.
    const Side side = i == root ? Side::on : side_of(i, plane);
    if (side == Side::on) in_plane_.push_back(i);
    if (side == Side::front) front.polygons.push_back(i);
    if (side == Side::back) back.polygons.push_back(i);
    if (side != Side::across) continue;
    Halves halves = split(polygons_[i], stand(polygons_[i], plane, tolerance_), cut);
    polygons_[i] = std::move(halves.front);
    balls_[i] = ball_of(polygons_[i]);
    balls_.push_back(ball_of(halves.back));
    front.polygons.push_back(i);
    back.polygons.push_back(static_cast<std::uint32_t>(polygons_.size()));
    polygons_.push_back(std::move(halves.back));
  }
  nodes_[here].count = static_cast<std::uint32_t>(in_plane_.size()) - nodes_[here].first;
  tasks.push_back(std::move(front));
  tasks.push_back(std::move(back));
}

std::size_t SceneBsp::bytes() const {
  return polygons_.capacity() * sizeof(Polygon) + balls_.capacity() * sizeof(Ball) +
         nodes_.capacity() * sizeof(Node) + in_plane_.capacity() * sizeof(std::uint32_t);
}

}  // namespace shadowcut::compare
