// The BSP tree of a scene's facets: H. Fuchs, Z. Kedem, B. Naylor, "On visible surface generation
// by a priori tree structures", SIGGRAPH
// 1980. It does not depend on the light: from any light it gives the polygons front to back.
//
// Departures. The root of a subtree is the best of `candidates` polygons, spread evenly over its
// list: the one whose plane splits the fewest others (Fuchs, Abram, Grant 1983, as quoted by Slater
// 1992, section 2); more splits than the best so far end a candidate's count. Polygons in one plane
// share a node, whichever way they face. Lists of work stand in place of recursion: a chain of
// nodes is as deep as the scene is large.
#pragma once

#include <span>

#include "polygon.hpp"

namespace shadowcut::compare {

class SceneBsp {
 public:
  // Of all facets that have corners. Cost: candidates * n log n plane tests for n polygons that
  // split each other little.
  SceneBsp(const Scene& scene, std::uint32_t candidates, double tolerance);

  // The scene's facets, cut by each other's planes.
  std::span<const Polygon> polygons() const { return polygons_; }

  // Calls visit(std::span<const std::uint32_t>) with the polygons of each node, all in one plane,
  // in an order in which none is hidden by a later one. in_front_of(plane) says on which side the
  // viewer is, by its sign; 0 is either.
  template <class InFrontOf, class Visit>
  void front_to_back(const InFrontOf& in_front_of, const Visit& visit) const;

  std::size_t bytes() const;

 private:
  struct Node {
    HalfSpace plane;
    std::uint32_t first = 0, count = 0;  // into in_plane_
    std::uint32_t front = invalid_index, back = invalid_index;
  };
  struct Task {
    std::vector<std::uint32_t> polygons;
    std::uint32_t parent;
    bool in_front;
  };
  // Around a polygon: on which side of a plane most of them lie, one distance tells.
  struct Ball {
    Vec3 centre;
    double radius;
  };
  static Ball ball_of(const Polygon& polygon);
  Side side_of(std::uint32_t polygon, const HalfSpace& plane) const;
  HalfSpace plane_of(std::uint32_t polygon) const;
  std::uint32_t best_root(std::span<const std::uint32_t> list, std::uint32_t candidates) const;
  void divide(Task task, std::uint32_t candidates, std::vector<Task>& tasks);

  const Scene& scene_;
  double tolerance_;
  std::vector<Polygon> polygons_;
  std::vector<Ball> balls_;
  std::vector<Node> nodes_;  // the first is the root
  std::vector<std::uint32_t> in_plane_;
};

template <class InFrontOf, class Visit>
void SceneBsp::front_to_back(const InFrontOf& in_front_of, const Visit& visit) const {
  struct Step {
    std::uint32_t node;
    bool near_done;
  };
  std::vector<Step> steps;
  if (!nodes_.empty()) steps.push_back({0, false});
  while (!steps.empty()) {
    const Step step = steps.back();
    steps.pop_back();
    const Node& node = nodes_[step.node];
    const bool from_front = in_front_of(node.plane) >= 0;
    const std::uint32_t next = step.near_done == from_front ? node.back : node.front;
    if (step.near_done)
      visit(std::span<const std::uint32_t>(in_plane_).subspan(node.first, node.count));
    else steps.push_back({step.node, true});
    if (next != invalid_index) steps.push_back({next, false});
  }
}

}  // namespace shadowcut::compare
