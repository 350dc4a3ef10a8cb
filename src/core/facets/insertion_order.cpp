#include "facets/insertion_order.hpp"

#include <algorithm>
#include <numeric>

#include "support/hash.hpp"

namespace shadowcut {
namespace {

struct Key {
  std::uint64_t group;
  double size;
  std::uint32_t id;
  bool operator<(const Key& o) const {
    return group != o.group ? group < o.group : size != o.size ? size > o.size : id < o.id;
  }
};

Vec3 vector_of(const VertexRay& ray) { return {ray.r[0], ray.r[1], ray.r[2]}; }

}  // namespace

// About the solid angle, by the unit rays of the corners. 0, which leaves the order as given, for
// other orders than Order::solid_angle.
double InsertionOrder::size_of(FacetId facet) const {
  if (order_ != Order::solid_angle) return 0;
  const auto corners = scene_.corners_of(tables_.facet(facet));
  const auto ray = [&](std::size_t k) { return vector_of(tables_.rays[corners[k].vertex]); };
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 1; k + 1 < corners.size(); ++k)
    sum += (ray(k) - ray(0)).cross(ray(k + 1) - ray(0));
  return sum.norm();
}

template <class Size>
std::vector<FacetId> InsertionOrder::by_object(std::span<const std::uint32_t> objects,
                                               const Size& size) const {
  std::vector<Key> sorted, keys;
  for (const std::uint32_t o : objects) {
    const Object& object = scene_.objects()[o];
    double sum = 0;
    SHADOWCUT_ASSERT(object.first_facet + object.facet_count <= scene_.facets().size());
    for (std::uint32_t i = object.first_facet; i < object.first_facet + object.facet_count; ++i)
      sum += visibility_.enters(FacetId(i)) ? size(FacetId(i)) : 0;
    const bool moves_last = object.dynamic && order_ == Order::solid_angle;
    sorted.push_back({object.casts_shadows ? (moves_last ? 1u : 0u) : 2u, sum, o});
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<FacetId> out;
  for (const Key& o : sorted) {
    const Object& object = scene_.objects()[o.id];
    keys.clear();
    for (std::uint32_t i = object.first_facet; i < object.first_facet + object.facet_count; ++i) {
      if (visibility_.enters(FacetId(i))) keys.push_back({0, size(FacetId(i)), i});
    }
    std::sort(keys.begin(), keys.end());
    for (const Key& k : keys) out.push_back(FacetId(k.id));
  }
  return out;
}

std::vector<FacetId> InsertionOrder::of_objects(std::span<const std::uint32_t> objects) const {
  return by_object(objects, [this](FacetId f) { return size_of(f); });
}

std::vector<FacetId> InsertionOrder::of_scene() const {
  const std::size_t facets = scene_.facets().size();
  std::vector<double> sizes(facets, 0.0);
  parallel_for(facets, 1024, [&](std::size_t i) {
    if (visibility_.enters(FacetId(i))) sizes[i] = size_of(FacetId(i));
  });
  std::vector<std::uint32_t> objects(scene_.objects().size());
  std::iota(objects.begin(), objects.end(), 0u);
  std::vector<FacetId> order = by_object(objects, [&](FacetId f) { return sizes[f.value()]; });
  if (order_ != Order::random) return order;
  std::vector<Key> shuffled;
  for (const FacetId f : order) {
    const std::uint64_t last = tables_.casts(f) ? 0 : std::uint64_t{1} << 63;
    shuffled.push_back({mix(seed_ * 0x9E3779B97F4A7C15ull + f.value()) >> 1 | last, 0, f.value()});
  }
  std::sort(shuffled.begin(), shuffled.end());
  std::transform(shuffled.begin(), shuffled.end(), order.begin(),
                 [](const Key& k) { return FacetId(k.id); });
  return order;
}

std::vector<Vec3> InsertionOrder::middle_rays(std::span<const FacetId> facets) const {
  SHADOWCUT_ASSERT(tables_.rays.size() >= scene_.vertices().size());
  std::vector<Vec3> rays(facets.size());
  parallel_for(rays.size(), 1024, [&](std::size_t i) {
    Vec3 sum = Vec3::Zero();
    for (const Corner& c : scene_.corners_of(tables_.facet(facets[i])))
      sum += vector_of(tables_.rays[c.vertex]);
    rays[i] = sum.normalized();
  });
  return rays;
}

}  // namespace shadowcut
