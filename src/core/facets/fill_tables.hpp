// The rays, lines and planes of the facets that enter.
#pragma once

#include "facets/facet_visibility.hpp"

namespace shadowcut {

// Of all facets that enter; then looks at their loops (exact kernel). `visibility` has decided.
void fill_tables(const Scene& scene, const LightSpace& space, FacetVisibility& visibility,
                 LightTables& tables);
// Of one object, whose block of lines has been taken. Thread-safe for different objects.
void fill_tables(const Scene& scene, const LightSpace& space, std::uint32_t object,
                 FacetVisibility& visibility, LightTables& tables);
// Exact kernel: the planes of the k-d tree are doubles in light space; exactly, they go through two
// points with short coordinates.
void set_exact_kd_lines(const LightSpace& space, LightTables& tables);

}  // namespace shadowcut
