// How a light's position stands to a facet and to a solid.
#pragma once

#include <shadowcut/scene.hpp>

namespace shadowcut {

// Whether the rays from a point light to all corners of a facet certainly meet its plane. A light
// may be clear of the plane where the plane is nearest, and still be so near to it that a corner
// farther away, which is on the plane up to rounding, is seen from its other side.
bool meets_all_corners(const Scene& scene, const Facet& facet, const Vec3& light);

// Whether a point is inside the solid that the object's faces bound, or on its surface. In doubt
// the answer is yes: then far-side faces cast too, which costs work and changes no shadow.
bool in_or_on_solid(const Scene& scene, const Object& object, const Vec3& point);

}  // namespace shadowcut
