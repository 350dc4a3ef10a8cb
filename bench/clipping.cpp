// See clipping.hpp.
#include "clipping.hpp"

#include <clipper.hpp>
#include <cmath>

#include "lighting.hpp"

namespace shadowcut::bench {
namespace {

using compare::HalfSpace;
using compare::Lighting;
using compare::Polygon;

// A disc around a facet as the light sees it: directions on the unit sphere, or positions in a
// plane across a directional light.
struct Disc {
  std::uint32_t facet;
  Vec3 centre;
  double radius;
};

class Clipping {
 public:
  Clipping(const Scene& scene, const Light& light) : scene_(scene), lighting_(scene, light) {
    for (std::uint32_t i = 0; i < scene.facets().size(); ++i)
      if (lighting_.casts(i)) casters_.push_back(disc_around(i));
  }

  double lit_area(std::uint32_t facet) {
    const Polygon receiver = compare::polygon_of(scene_, facet);
    const double area = compare::area_of(receiver);
    lighting_.shadow_planes(receiver, planes_);
    HalfSpace plane{scene_.planes()[scene_.facets()[facet].plane].normal,
                    scene_.planes()[scene_.facets()[facet].plane].point};
    if (lighting_.in_front_of(plane) < 0) plane.normal = -plane.normal;
    choose_frame(receiver, plane);
    shadows_.clear();
    const Disc disc = disc_around(facet);
    for (const Disc& caster : casters_) {
      const double reach = disc.radius + caster.radius;
      if (caster.facet != facet && (disc.centre - caster.centre).squaredNorm() <= reach * reach)
        add_shadow(caster.facet, plane);
    }
    return area - united_area();
  }

  const Lighting& lighting() const { return lighting_; }

 private:
  Vec3 seen(const Vec3& x) const {
    const Light& light = lighting_.light();
    if (light.kind == Light::Kind::point) return (x - light.position).normalized();
    const Vec3 d = light.direction.stableNormalized();
    return x - d * d.dot(x);
  }

  Disc disc_around(std::uint32_t facet) const {
    Vec3 middle = Vec3::Zero();
    const auto corners = scene_.corners_of(scene_.facets()[facet]);
    for (const Corner& c : corners) middle += scene_.vertices()[c.vertex];
    Disc disc{facet, seen(middle / static_cast<double>(corners.size())), 0};
    for (const Corner& c : corners)
      disc.radius = std::max(disc.radius, (seen(scene_.vertices()[c.vertex]) - disc.centre).norm());
    disc.radius *= 1 + 1e-9;
    return disc;
  }

  // Two axes in the plane of the receiver, and the unit of Clipper's integers.
  void choose_frame(const Polygon& receiver, const HalfSpace& plane) {
    origin_ = receiver.corners[0].at;
    u_ = plane.normal.unitOrthogonal(), v_ = plane.normal.cross(u_);
    double size = 0;
    for (const auto& corner : receiver.corners) size = std::max(size, (corner.at - origin_).norm());
    unit_ = size * 0x1p-30;
  }

  // The part of the caster between the receiver and the light, projected.
  void add_shadow(std::uint32_t facet, const HalfSpace& plane) {
    Polygon part = compare::polygon_of(scene_, facet);
    if (!keep_front(part, plane, lighting_.tolerance())) return;
    for (const HalfSpace& side : planes_)
      if (!keep_front(part, side, lighting_.tolerance())) return;
    ClipperLib::Path path;
    for (const auto& corner : part.corners) path.push_back(projected(corner.at, plane));
    if (!ClipperLib::Orientation(path)) ClipperLib::ReversePath(path);
    shadows_.push_back(std::move(path));
  }

  ClipperLib::IntPoint projected(const Vec3& x, const HalfSpace& plane) const {
    const Light& light = lighting_.light();
    const Vec3 direction =
        light.kind == Light::Kind::point ? Vec3(x - light.position) : light.direction;
    const Vec3 on_plane = x - direction * (plane.above(x) / plane.normal.dot(direction)) - origin_;
    return {std::llround(u_.dot(on_plane) / unit_), std::llround(v_.dot(on_plane) / unit_)};
  }

  double united_area() {
    ClipperLib::Clipper clipper;
    clipper.AddPaths(shadows_, ClipperLib::ptSubject, true);
    ClipperLib::Paths united;
    clipper.Execute(ClipperLib::ctUnion, united, ClipperLib::pftNonZero, ClipperLib::pftNonZero);
    double area = 0;
    for (const ClipperLib::Path& path : united) area += ClipperLib::Area(path);
    return area * unit_ * unit_;
  }

  const Scene& scene_;
  const Lighting lighting_;
  std::vector<Disc> casters_;
  // Of the current receiver.
  boost::container::small_vector<HalfSpace, 8> planes_;
  Vec3 origin_, u_, v_;
  double unit_ = 1;
  ClipperLib::Paths shadows_;
};

}  // namespace

Clipped clip_every_face(const Scene& scene, const Light& light) {
  Clipping clipping(scene, light);
  Clipped result;
  result.lit.assign(scene.faces().size(), 0);
  for (std::uint32_t i = 0; i < scene.facets().size(); ++i) {
    if (!clipping.lighting().receives(i)) continue;
    const double lit = clipping.lit_area(i);
    result.lit[scene.facets()[i].face] += lit;
    result.lit_area += lit;
  }
  return result;
}

}  // namespace shadowcut::bench
