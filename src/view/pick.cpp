// See pick.hpp.
#include "pick.hpp"

#include <cmath>
#include <limits>

#include "walk.hpp"

namespace shadowcut::view {
namespace {

// Where the ray meets the facet's plane within its edges, as a multiple of the ray; infinity if
// nowhere. Told by on which side of each edge the ray passes, so that a ray between two facets that
// share an edge does not slip through.
double meets(const Scene& scene, const Facet& facet, const Ray& ray) {
  constexpr double nowhere = std::numeric_limits<double>::infinity();
  const auto corners = scene.corners_of(facet);
  bool left = false, right = false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    std::uint32_t a = corners[i].vertex, b = corners[(i + 1) % corners.size()].vertex;
    const bool turned = a > b;  // the same product for both facets of an edge
    if (turned) std::swap(a, b);
    const double side =
        ray.along.dot((scene.vertices()[a] - ray.from).cross(scene.vertices()[b] - ray.from));
    (side > 0) == turned ? left = true : right = true;
    if (left && right) return nowhere;
  }
  const Plane& plane = scene.planes()[facet.plane];
  const double t = plane.normal.dot(plane.point - ray.from) / plane.normal.dot(ray.along);
  return std::isfinite(t) ? t : nowhere;
}

Eigen::AlignedBox3d box_of(const Scene& scene, std::uint32_t index) {
  const Object& object = scene.objects()[index];
  Eigen::AlignedBox3d box;
  for (std::uint32_t v = object.first_vertex; v < object.first_vertex + object.vertex_count; ++v)
    box.extend(scene.vertices()[v]);
  return box;
}

int axes_filled(const Scene& scene, std::uint32_t object, const Eigen::AlignedBox3d& all) {
  const Eigen::AlignedBox3d box = box_of(scene, object);
  if (box.isEmpty() || all.isEmpty()) return 0;
  return static_cast<int>((box.sizes().array() >= 0.9 * all.sizes().array()).count());
}

}  // namespace

Ray Screen::ray(const Eigen::Vector2d& pixel) const {
  const double high = std::tan(camera.fov / 2), wide = high * width / height;
  const Vec3 ahead(wide * (2 * pixel.x() / width - 1), high * (1 - 2 * pixel.y() / height), -1);
  return {camera.eye, camera.view().linear().transpose() * ahead};
}

std::optional<Eigen::Vector2d> Screen::pixel(const Vec3& point) const {
  const Vec3 p = camera.view() * point;
  if (-p.z() < near) return std::nullopt;
  const double scale = height / (2 * std::tan(camera.fov / 2)) / -p.z();
  return Eigen::Vector2d(width / 2.0 + scale * p.x(), height / 2.0 - scale * p.y());
}

std::optional<std::pair<Eigen::Vector2d, Eigen::Vector2d>> Screen::line(const Vec3& a,
                                                                        const Vec3& b) const {
  const Pose view = camera.view();
  // what is clipped here is beyond the plane, whatever the rounding
  const double limit = near * (1 + 1e-9);
  const double depth_a = -(view * a).z(), depth_b = -(view * b).z();
  if (depth_a < limit && depth_b < limit) return std::nullopt;
  const auto end = [&](const Vec3& p, double depth) -> Vec3 {
    return depth >= limit ? p : Vec3(a + (limit - depth_a) / (depth_b - depth_a) * (b - a));
  };
  const auto from = pixel(end(a, depth_a)), to = pixel(end(b, depth_b));
  if (!from || !to) return std::nullopt;
  return std::pair(*from, *to);
}

Vec3 marker_of(const Light& light, const Eigen::AlignedBox3d& box) {
  if (light.kind == Light::Kind::point) return light.position;
  return box.center() - 0.75 * box.diagonal().norm() * light.direction.stableNormalized();
}

Light moved_to(const Light& light, const Vec3& marker, const Eigen::AlignedBox3d& box) {
  Light moved = light;
  if (light.kind == Light::Kind::point) moved.position = marker;
  else moved.direction = box.center() - marker;
  return moved;
}

std::optional<Hit> pick_facet(const Scene& scene, const Screen& screen,
                              const Eigen::Vector2d& pixel) {
  const Ray ray = screen.ray(pixel);
  double nearest = std::numeric_limits<double>::infinity();
  Hit hit;
  for (std::uint32_t f = 0; f < scene.facets().size(); ++f) {
    const Facet& facet = scene.facets()[f];
    if (facet.corner_count == 0) continue;
    const double t = meets(scene, facet, ray);
    if (t < screen.near || t >= nearest) continue;
    nearest = t;
    hit.facet = f;
  }
  if (hit.facet == invalid_index) return std::nullopt;
  hit.index = scene.faces()[scene.facets()[hit.facet].face].object;
  hit.at = ray.from + nearest * ray.along;
  return hit;
}

std::optional<Hit> pick(const Scene& scene, const Screen& screen, const Eigen::Vector2d& pixel,
                        double radius, const Eigen::AlignedBox3d& box) {
  double nearest = radius;
  std::optional<Hit> hit;
  for (std::uint32_t k = 0; k < scene.lights().size(); ++k) {
    if (scene.light_id(k).index == invalid_index) continue;
    const Vec3 at = marker_of(scene.lights()[k], box);
    const auto marker = screen.pixel(at);
    if (!marker || (*marker - pixel).norm() > nearest) continue;
    nearest = (*marker - pixel).norm();
    hit = Hit{true, k, invalid_index, at};
  }
  return hit ? hit : pick_facet(scene, screen, pixel);
}

bool is_shell(const Scene& scene, std::uint32_t object, const Eigen::AlignedBox3d& all) {
  const auto alive = std::count_if(scene.objects().begin(), scene.objects().end(),
                                   [](const Object& o) { return o.alive; });
  return alive > 1 && axes_filled(scene, object, all) >= 2;
}

bool is_draggable(const Scene& scene, std::uint32_t object, const Eigen::AlignedBox3d& all,
                  const Vec3& eye) {
  return !is_shell(scene, object, all) && !box_of(scene, object).contains(eye);
}

bool is_room(const Scene& scene) {
  const Eigen::AlignedBox3d all = view::box_of(scene);
  for (std::uint32_t k = 0; k < scene.objects().size(); ++k)
    if (scene.objects()[k].sides == Sides::open && axes_filled(scene, k, all) == 3) return true;
  return false;
}

Vec3 dragged(const Vec3& held, const Ray& cursor, const render::Camera& camera, bool upright,
             double reach) {
  // sine of the angle at which the cursor's ray must meet the plane
  constexpr double flattest = 0.02;
  Vec3 normal = Vec3::UnitZ();
  if (upright) {
    const Vec3 right = camera.view().linear().row(0);
    normal = Vec3(-right.y(), right.x(), 0).normalized();
  }
  const double toward = normal.dot(cursor.along);
  if (std::abs(toward) < flattest * cursor.along.norm()) return held;
  const double t = normal.dot(held - cursor.from) / toward;
  if (!(t > 0) || t * cursor.along.norm() > reach) return held;
  return cursor.from + t * cursor.along;
}

}  // namespace shadowcut::view
