// The part of the error bound that comes from whole facets: facets left out because they are seen
// edge-on, and corners that are on their plane only up to its flatness.
#pragma once

#include <cmath>
#include <vector>

#include "fragments/polygon.hpp"

namespace shadowcut {

// Where numbers have left double's range nothing is known.
inline double no_nan(double x) { return std::isnan(x) ? INFINITY : x; }

class OutlineError {
 public:
  OutlineError(const EmissionContext& context, const ExactPredicates& exact)
      : context_(context), exact_(exact) {}

  // Adds to the uncertain areas, by face.
  void add(std::vector<double>& uncertain) const;
  // No less than the area of a face.
  double most_area_of_face(std::uint32_t face) const;

 private:
  double most_area(FacetId facet) const;
  double thickness_of(FacetId facet) const;
  double thickness_left_out(std::vector<double>& uncertain) const;
  double kink(const Cone& cone) const;
  double of_facet(FacetId facet, double thickness) const;

  const EmissionContext& context_;
  const ExactPredicates& exact_;
};

}  // namespace shadowcut
