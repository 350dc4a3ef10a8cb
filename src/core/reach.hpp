// What a light can reach: range, cone, and the solid it may stand in.
#pragma once

#include <shadowcut/scene.hpp>

namespace shadowcut {

// Whether the face is somewhere within the light's range, and somewhere within its cone.
bool within_reach(const Scene& scene, const Face& face, const Light& light);

// Whether the rays from a point light to all corners of a facet certainly meet its plane. A light
// may be clear of it where it is nearest, and still so near that a corner farther away, which lies
// on the plane up to rounding, is seen from its other side.
bool meets_all_corners(const Scene& scene, const Facet& facet, const Vec3& light);

// Whether a point lies inside the solid that the object's faces bound, or on its surface. In doubt
// it says yes: then far-side faces cast too, which is never wrong, only work.
bool in_or_on_solid(const Scene& scene, const Object& object, const Vec3& point);

}  // namespace shadowcut
