// Whether a light reaches a point of a face.
#pragma once

#include "fragments/light_view.hpp"

namespace shadowcut {

// One descent of the ray through the point: down the k-d tree, then down the tree of one cell. The
// point is taken as on the plane of the face; `face` is an index into the faces of the light's
// scene. Cost: the depth of the trees, and the corners of a face of several facets.
bool is_lit(const LightView& light, std::uint32_t face, const Vec3& point);

}  // namespace shadowcut
