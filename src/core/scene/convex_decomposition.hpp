// Cutting an outline with holes into convex parts.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace shadowcut {

using Vec2 = Eigen::Vector2d;

// The exact sign of the turn a -> b -> c: +1 left, -1 right, 0 straight. Coordinates must be
// finite.
int turn(const Vec2& a, const Vec2& b, const Vec2& c);

// One outline of a plane figure, as indices into points.
using Loop = std::vector<std::uint32_t>;

// Whether a loop is convex, counter-clockwise and runs round once. Straight corners are allowed,
// spikes are not.
bool is_convex(std::span<const Vec2> points, std::span<const std::uint32_t> loop);

enum class ConvexResult { ok, self_intersecting };

// Cuts the figure bounded by loops[0] (counter-clockwise) less the holes loops[1..] (either way
// round) into convex counter-clockwise parts, appended to `parts`; no point is added, and every
// part has positive area. The outline may touch itself (an outline joined to its holes by bridges
// is usual), but not cross itself; holes must lie inside. `merge`: join triangles into larger
// convex parts (Hertel & Mehlhorn 1983); otherwise leave triangles. Cost: quadratic in the number
// of corners.
ConvexResult convex_parts(std::span<const Vec2> points, std::vector<Loop> loops, bool merge,
                          std::vector<Loop>& parts);

}  // namespace shadowcut
