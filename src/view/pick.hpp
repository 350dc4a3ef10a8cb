// What is under the cursor, and where it goes when the cursor drags it. Knows no window.
#pragma once

#include <optional>

#include "camera.hpp"

namespace shadowcut::view {

// A point and a direction, of any length.
struct Ray {
  Vec3 from, along;
};

// A picture's pixels: x to the right and y down from its upper left corner; the middle of the first
// pixel is (0.5, 0.5).
struct Screen {
  render::Camera camera;
  int width, height;
  double near;  // nothing nearer than this plane is drawn

  // From the eye, long enough to reach the plane at distance 1.
  Ray ray(const Eigen::Vector2d& pixel) const;
  // Nothing for what is not beyond the near plane.
  std::optional<Eigen::Vector2d> pixel(const Vec3& point) const;
  // The part of a line that is beyond the near plane, as drawn.
  std::optional<std::pair<Eigen::Vector2d, Eigen::Vector2d>> line(const Vec3& a,
                                                                  const Vec3& b) const;
};

struct Hit {
  bool is_light = false;
  std::uint32_t index = invalid_index;  // of the object, or of the light
  std::uint32_t facet = invalid_index;  // of an object
  Vec3 at;                     // the point hit; of a light, where its marker is
};

// Where a light is marked: a point light where it is, a directional light where its rays come
// from, outside of everything.
Vec3 marker_of(const Light& light, const Eigen::AlignedBox3d& box);
// The light with its marker at another place.
Light moved_to(const Light& light, const Vec3& marker, const Eigen::AlignedBox3d& box);

// The facet seen at a pixel: the nearest one that the ray meets beyond the near plane, from either
// side, as they are drawn.
std::optional<Hit> pick_facet(const Scene& scene, const Screen& screen,
                              const Eigen::Vector2d& pixel);
// The same, but lights come first: their markers are drawn on top, `radius` pixels wide to each
// side.
std::optional<Hit> pick(const Scene& scene, const Screen& screen, const Eigen::Vector2d& pixel,
                        double radius, const Eigen::AlignedBox3d& box);

// What is not dragged: an object whose box takes up nine tenths of the box of all along two axes or
// more (a floor, a wall, a room), if it is not the only one; and whatever stands around the eye.
bool is_shell(const Scene& scene, std::uint32_t object, const Eigen::AlignedBox3d& all);
bool is_draggable(const Scene& scene, std::uint32_t object, const Eigen::AlignedBox3d& all,
                  const Vec3& eye);
// Whether an object that is open takes up all three axes.
bool is_room(const Scene& scene);

// A point held by the cursor. It moves in a plane, so that it stays under the cursor: parallel to
// the floor, or upright and facing the camera. Where the cursor's ray does not meet that plane,
// nearly misses it, or meets it farther away than `reach`, it stays.
Vec3 dragged(const Vec3& held, const Ray& cursor, const render::Camera& camera, bool upright,
             double reach);

}  // namespace shadowcut::view
