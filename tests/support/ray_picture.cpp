// See ray_picture.hpp.
#include "ray_picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "light_vector.hpp"
#include "text.hpp"

namespace shadowcut::testing {
namespace {

constexpr int kMapSide = render::MapSettings{}.side;

std::vector<Seen> facets_seen_from(const Scene& scene, const Light& viewer, bool casting) {
  std::vector<Seen> all;
  for (std::uint32_t f = 0; f < scene.facets().size(); ++f) {
    const Object& object = scene.objects()[scene.faces()[scene.facets()[f].face].object];
    const Plane& plane = scene.planes()[scene.facets()[f].plane];
    const auto ray = [&](const Vec3& x) {
      return viewer.kind == Light::Kind::point ? Vec3(x - viewer.position) : viewer.direction;
    };
    const double away = plane.normal.dot(ray(plane.point));
    if (casting &&
        (!object.casts_shadows || away == 0 || (away > 0 && object.sides == Sides::closed)))
      continue;
    Seen seen{f, {}, plane.normal, plane.normal.dot(plane.point)};
    const auto corners = scene.corners_of(scene.facets()[f]);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec3 &a = scene.vertices()[corners[i].vertex],
                 &b = scene.vertices()[corners[(i + 1) % corners.size()].vertex];
      seen.sides.push_back(((b - a).cross(ray(a))) * (away > 0 ? -1 : 1));
    }
    all.push_back(std::move(seen));
  }
  return all;
}

SeenFacets seen_from(const Scene& scene, const Light& viewer, bool casting) {
  SeenFacets seen{facets_seen_from(scene, viewer, casting), {}};
  const auto object_of = [&](std::size_t i) {
    return scene.faces()[scene.facets()[seen.facets[i].facet].face].object;
  };
  for (std::size_t first = 0, end = 0; first < seen.facets.size(); first = end) {
    Eigen::AlignedBox3d box;
    for (; end < seen.facets.size() && object_of(end) == object_of(first); ++end)
      for (const Corner& corner : scene.corners_of(scene.facets()[seen.facets[end].facet]))
        box.extend(scene.vertices()[corner.vertex]);
    seen.groups.push_back({first, end, box.center(), box.diagonal().norm() / 2});
  }
  return seen;
}

// Whether the ray from the viewer passes through the facet; for a direction, the line through x.
bool through(const Seen& seen, const Scene& scene, const Light& viewer, const Vec3& x) {
  const auto corners = scene.corners_of(scene.facets()[seen.facet]);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 from =
        viewer.kind == Light::Kind::point ? viewer.position : scene.vertices()[corners[i].vertex];
    if (seen.sides[i].dot(x - from) <= 0) return false;
  }
  return true;
}

}  // namespace

RayPicture::RayPicture(const Scene& scene, const Camera& camera)
    : scene_(scene),
      camera_(camera),
      eye_(Light::point(camera.eye)),
      faces_(seen_from(scene, eye_, false)) {
  for (const Light& light : scene.lights()) casters_.push_back(seen_from(scene, light, true));
  const Pose world = camera.view().inverse(Eigen::Isometry);
  const double high = std::tan(camera.fov / 2), wide = high * kWidth / kHeight;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      pixels_.push_back(look(world.linear() * Vec3(wide * (2 * (x + 0.5) / kWidth - 1),
                                                   high * (1 - 2 * (y + 0.5) / kHeight), -1)));
  for (const Seen& seen : faces_.facets) mark_if_thin(seen.facet);
}

bool RayPicture::at_an_edge(int x, int y, int reach) const {
  for (int j = std::max(y - reach, 0); j <= std::min(y + reach, kHeight - 1); ++j) {
    for (int i = std::max(x - reach, 0); i <= std::min(x + reach, kWidth - 1); ++i) {
      const bool near = std::abs(i - x) <= 1 && std::abs(j - y) <= 1;
      if (at(i, j).lit != at(x, y).lit ||
          (near && (at(i, j).facet != at(x, y).facet || at(i, j).ambiguous)))
        return true;
    }
  }
  return false;
}

int RayPicture::reach_of_texels(int x, int y, int side) const {
  const Pixel& pixel = at(x, y);
  if (pixel.facet == invalid_index) return 1;
  const double size = 2 * std::tan(camera_.fov / 2) / kHeight * (pixel.place - camera_.eye).norm();
  double reach = 0;
  for (const Light& light : scene_.lights()) {
    const Vec3 to_light = vector_of(light) - pixel.place;
    const double slant =
        std::abs(scene_.planes()[scene_.facets()[pixel.facet].plane].normal.dot(to_light)) /
        to_light.norm();
    reach = std::max(
        reach, slant < 0.05 ? kWidth : 2 * std::sqrt(3.0) / side * to_light.norm() / slant / size);
  }
  return static_cast<int>(std::min<double>(kWidth, std::ceil(reach))) + 1;
}

bool RayPicture::in_shadow(const Vec3& x) const {
  for (std::size_t k = 0; k < scene_.lights().size(); ++k)
    if (shadowed(k, invalid_index, x)) return true;
  return false;
}

Pixel RayPicture::look(const Vec3& ray) const {
  Pixel pixel;
  double nearest = std::numeric_limits<double>::infinity(), second = nearest;
  const Vec3 ahead = camera_.eye + ray;
  faces_.near_line(camera_.eye, ray, [&](const Seen& seen) {
    const double t = (seen.offset - seen.normal.dot(camera_.eye)) / seen.normal.dot(ray);
    if (!(t > 0) || t >= second || !through(seen, scene_, eye_, ahead)) return;
    second = t;
    if (t < nearest) second = nearest, nearest = t, pixel.facet = seen.facet;
  });
  if (pixel.facet == invalid_index) return pixel;
  pixel.ambiguous = second < nearest * 1.001;
  pixel.place = camera_.eye + nearest * ray;
  shade(pixel, pixel.place);
  return pixel;
}

void RayPicture::mark_if_thin(std::uint32_t facet) {
  const Pose view = camera_.view();
  const double pixel = 2 * std::tan(camera_.fov / 2) / kHeight;
  std::vector<Eigen::Vector2d> outline;
  for (const Corner& corner : scene_.corners_of(scene_.facets()[facet])) {
    const Vec3 p = view * scene_.vertices()[corner.vertex];
    if (p.z() >= -1e-3) return;
    outline.emplace_back(kWidth / 2.0 - p.x() / p.z() / pixel,
                         kHeight / 2.0 + p.y() / p.z() / pixel);
  }
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : outline) box.extend(p);
  const auto whole = [](double v, int end) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(end)));
  };
  for (int y = whole(box.min().y() - 2, kHeight); y < whole(box.max().y() + 2, kHeight); ++y)
    for (int x = whole(box.min().x() - 2, kWidth); x < whole(box.max().x() + 2, kWidth); ++x)
      if (edges_near(outline, {x + 0.5, y + 0.5}) >= 2)
        pixels_[static_cast<std::size_t>(y * kWidth + x)].ambiguous = true;
}

int RayPicture::edges_near(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& p) {
  int near = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d &a = outline[i], d = outline[(i + 1) % outline.size()] - a;
    const double t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-12), 0.0, 1.0);
    near += (a + t * d - p).norm() < 1 ? 1 : 0;
  }
  return near;
}

void RayPicture::shade(Pixel& pixel, const Vec3& x) const {
  const Object& object = scene_.objects()[scene_.faces()[scene_.facets()[pixel.facet].face].object];
  const Vec3& normal = scene_.planes()[scene_.facets()[pixel.facet].plane].normal;
  double brightness = render::ambient_share;
  for (std::size_t k = 0; k < scene_.lights().size(); ++k) {
    const Light& light = scene_.lights()[k];
    const Vec3 to_light =
        light.kind == Light::Kind::point ? Vec3(light.position - x) : Vec3(-light.direction);
    const double facing = normal.dot(to_light);
    const bool seen =
        facing * normal.dot(camera_.eye - x) > 0 && (object.sides == Sides::open || facing > 0);
    pixel.lit.push_back(seen && !shadowed(k, pixel.facet, x));
    if (pixel.lit.back())
      brightness += (1 - render::ambient_share) / static_cast<double>(scene_.lights().size()) *
                    (0.4 + 0.6 * std::abs(facing) / to_light.norm());
  }
  for (std::size_t c = 0; c < 3; ++c) pixel.colour[c] = render::colour_of(object)[c] * brightness;
}

bool RayPicture::shadowed(std::size_t k, std::uint32_t facet, const Vec3& x) const {
  const Light& light = scene_.lights()[k];
  const double contact = 1e-9 * (x.norm() + 1);
  bool some = false;
  casters_[k].near_line(
      x, light.kind == Light::Kind::point ? Vec3(light.position - x) : light.direction,
      [&](const Seen& caster) {
        if (some || caster.facet == facet ||
            (facet != invalid_index &&
             scene_.facets()[caster.facet].plane == scene_.facets()[facet].plane))
          return;
        const double here = caster.normal.dot(x) - caster.offset;
        const double there = light.kind == Light::Kind::point
                                 ? caster.normal.dot(light.position) - caster.offset
                                 : -caster.normal.dot(light.direction);
        some = std::abs(here) > contact && here * there < 0 && through(caster, scene_, light, x);
      });
  return some;
}

void need_context() { static const render::OffscreenContext context; }

Picture picture_of(const Scene& scene, const std::string& technique, const Camera& camera) {
  need_context();
  const render::Target target(kWidth, kHeight);
  const render::Model model(scene);
  const auto t = render::make_technique(technique, scene, model);
  target.bind();
  render::draw(model.frame(camera, kWidth, kHeight), scene, model, *t);
  return target.read();
}

bool has_texels(const std::string& technique) {
  return technique == "shadow-map" || technique == "shadow-texture";
}

Difference difference(const Picture& picture, const RayPicture& rays, bool texels) {
  Difference d;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (rays.at_an_edge(x, y) ||
          (texels && rays.at_an_edge(x, y, rays.reach_of_texels(x, y, kMapSide))))
        continue;
      ++d.covered;
      const Pixel& want = rays.at(x, y);
      double off = 0;
      for (std::size_t c = 0; c < 3; ++c)
        off = std::max(off, std::abs(want.colour[c] - picture.at(x, y)[c]));
      if (off <= 3) continue;
      if (d.pixels++ == 0)
        d.first =
            text("pixel ", x, ", ", y, " of facet ", want.facet, ": ", int{picture.at(x, y)[0]},
                 " ", int{picture.at(x, y)[1]}, " ", int{picture.at(x, y)[2]}, ", should be ",
                 want.colour[0], " ", want.colour[1], " ", want.colour[2]);
    }
  }
  return d;
}

Camera looking(const Vec3& eye, const Vec3& target) { return {eye, target, 1.0, Vec3::UnitZ()}; }

}  // namespace shadowcut::testing
