// See front_to_back.hpp.
#include "front_to_back.hpp"

#include <algorithm>

#include "scene_bsp.hpp"
#include "shadow_volumes.hpp"

namespace shadowcut::compare {
namespace {

std::unique_ptr<ShadowVolumes> make_volumes(Algorithm algorithm, const Lighting& lighting,
                                            const Settings& settings) {
  if (algorithm == Algorithm::brute) return make_brute(lighting, settings);
  return algorithm == Algorithm::tiling ? make_tiling(lighting, settings)
                                        : make_ordered(lighting, settings);
}

// Slater's two passes for one light after another.
class FrontToBack {
 public:
  FrontToBack(const Scene& scene, Algorithm algorithm, const Settings& settings)
      : scene_(scene),
        algorithm_(algorithm),
        settings_(settings),
        bsp_(scene, settings.candidates, tolerance_of(scene)),
        parts_(bsp_.polygons().size()) {
    for (std::size_t i = 0; i < parts_.size(); ++i)
      parts_[i].push_back({bsp_.polygons()[i], false});
  }

  Result cast(const Light& light) {
    Clock::time_point start = Clock::now();
    Lighting lighting(scene_, light);
    find_order(lighting);
    Result result;
    result.order_ms = ms_since(start);
    start = Clock::now();
    const auto volumes = make_volumes(algorithm_, lighting, settings_);
    for (std::size_t i = 0; i + 1 < node_ends_.size(); ++i)
      cast_node(std::span<const std::uint32_t>(order_).subspan(node_ends_[i],
                                                               node_ends_[i + 1] - node_ends_[i]),
                lighting, *volumes);
    result.shadow_ms = ms_since(start);
    result.faces_after_bsp = parts_.size();
    result.shadow_polygons = volumes->shadow_polygons();
    result.memory_bytes = volumes->bytes() + bsp_.bytes();
    hand_out(lighting, result);
    return result;
  }

 private:
  // The polygons that receive or cast, front to back, node by node.
  void find_order(const Lighting& lighting) {
    order_.clear();
    node_ends_.assign(1, 0);
    bsp_.front_to_back([&](const HalfSpace& plane) { return lighting.in_front_of(plane); },
                       [&](std::span<const std::uint32_t> node) {
                         for (const std::uint32_t i : node) {
                           const std::uint32_t facet = bsp_.polygons()[i].facet;
                           if (lighting.receives(facet) || lighting.casts(facet))
                             order_.push_back(i);
                         }
                         if (order_.size() > node_ends_.back()) node_ends_.push_back(order_.size());
                       });
  }

  // Polygons of one plane: all are cut before any casts.
  void cast_node(std::span<const std::uint32_t> node, const Lighting& lighting,
                 ShadowVolumes& volumes) {
    const Polygon& first = bsp_.polygons()[node.front()];
    if (node.size() == 1 && first_light_ && lighting.receives(first.facet) &&
        lighting.casts(first.facet)) {
      parts_[node.front()].clear();
      volumes.cut_and_add(first, parts_[node.front()]);
      return;
    }
    for (const std::uint32_t i : node)
      if (lighting.receives(bsp_.polygons()[i].facet)) cut(i, volumes);
    for (const std::uint32_t i : node) {
      const Polygon& polygon = bsp_.polygons()[i];
      if (!lighting.casts(polygon.facet)) continue;
      const bool hidden =
          lighting.receives(polygon.facet) &&
          std::none_of(parts_[i].begin(), parts_[i].end(), [](const Fragment& f) { return f.lit; });
      volumes.add(polygon, !hidden);
    }
  }

  void cut(std::uint32_t i, ShadowVolumes& volumes) {
    before_.swap(parts_[i]);
    parts_[i].clear();
    for (const Fragment& target : before_) volumes.cut(target.polygon, parts_[i]);
  }

  void hand_out(const Lighting& lighting, Result& result) {
    result.areas.resize(scene_.faces().size());
    for (std::uint32_t f = 0; f < scene_.faces().size(); ++f) {
      const double area = scene_.faces()[f].area;
      const bool whole =
          lighting.facing(f) == Facing::away || lighting.facing(f) == Facing::out_of_reach;
      result.areas[f] = {lighting.facing(f), area, 0, whole ? area : 0, 0};
    }
    for (const std::vector<Fragment>& parts : parts_) {
      result.memory_bytes += parts.capacity() * sizeof(Fragment);
      const std::uint32_t facet = parts.front().polygon.facet;
      FaceArea& area = result.areas[scene_.facets()[facet].face];
      if (area.facing != Facing::toward) continue;
      // A facet of a face that is not flat may be turned away while others are not.
      const bool turned = lighting.receives(facet);
      for (const Fragment& part : parts) {
        const bool lit = turned && part.lit;
        (lit ? area.lit : area.shadowed) += area_of(part.polygon);
        result.fragments.push_back({part.polygon, lit});
      }
    }
    first_light_ = false;
  }

  const Scene& scene_;
  const Algorithm algorithm_;
  const Settings settings_;
  SceneBsp bsp_;
  // by polygon of the tree: what the lights so far have cut it into
  std::vector<std::vector<Fragment>> parts_;
  std::vector<Fragment> before_;
  bool first_light_ = true;
  std::vector<std::uint32_t> order_;
  std::vector<std::size_t> node_ends_;  // into order_
};

}  // namespace

std::vector<Result> cast_front_to_back(const Scene& scene, std::span<const Light> lights,
                                       Algorithm algorithm, const Settings& settings) {
  const Clock::time_point start = Clock::now();
  FrontToBack two_passes(scene, algorithm, settings);
  const double bsp_ms = ms_since(start);
  std::vector<Result> results;
  for (const Light& light : lights) results.push_back(two_passes.cast(light));
  if (!results.empty()) results.front().order_ms += bsp_ms;
  return results;
}

}  // namespace shadowcut::compare
