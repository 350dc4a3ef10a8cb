// The order in which facets enter the trees. Any order gives the same lit regions, at different
// cost.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "facets/facet_visibility.hpp"

namespace shadowcut {

class InsertionOrder {
 public:
  InsertionOrder(const Scene& scene, const LightTables& tables, const FacetVisibility& visibility,
                 Order order, std::uint64_t seed)
      : scene_(scene), tables_(tables), visibility_(visibility), order_(order), seed_(seed) {}

  // All facets that enter.
  std::vector<FacetId> of_scene() const;
  // The facets of some objects that enter: the largest object first, then its largest facet.
  // Objects that move come after the others, and objects that do not cast come last.
  std::vector<FacetId> of_objects(std::span<const std::uint32_t> objects) const;
  // A unit ray through the middle of each facet.
  std::vector<Vec3> middle_rays(std::span<const FacetId> facets) const;

 private:
  double size_of(FacetId facet) const;
  template <class Size>
  std::vector<FacetId> by_object(std::span<const std::uint32_t> objects, const Size& size) const;

  const Scene& scene_;
  const LightTables& tables_;
  const FacetVisibility& visibility_;
  Order order_;
  std::uint64_t seed_;
};

}  // namespace shadowcut
