// What Options::min_feature promises, of a result beside the result without the option. Each check
// returns an empty string, or says what is wrong; none looks inside the engine.
#pragma once

#include <shadowcut/scene.hpp>
#include <shadowcut/shadows.hpp>
#include <string>
#include <vector>

namespace shadowcut::testing {

// `full` is without a smallest feature, `kept` with this one; all else is equal. Of any form but
// the conforming one. gone: gets the ids of what is left out.
std::string check_filter(const Scene& scene, const Light& light, const Shadows& full,
                         const Shadows& kept, const MinFeature& least,
                         std::vector<FragmentId>* gone = nullptr);

// The same of the conforming form; `merged` is the merged one with the same smallest feature.
std::string check_conforming_filter(const Scene& scene, const Shadows& full, const Shadows& kept,
                                    const Shadows& merged);

// Of the faces that have an area.
double mean_area(const Scene& scene);

}  // namespace shadowcut::testing
