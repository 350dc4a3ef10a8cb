// The range and the spot cone of a point light.
#pragma once

#include <shadowcut/scene.hpp>

namespace shadowcut {

// Whether some part of the face is within the light's range, and some part within its spot cone.
bool within_range(const Scene& scene, const Face& face, const Light& light);

}  // namespace shadowcut
