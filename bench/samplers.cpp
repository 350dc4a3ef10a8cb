// Shadow rays by Embree, and a shadow map drawn in software; see samplers.hpp.
#include "samplers.hpp"

#include <algorithm>
#include <cmath>

#include "io/convex_clip.hpp"

namespace shadowcut::bench {

namespace {

Eigen::AlignedBox3d bounds(const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (const Facet& facet : scene.facets())
    for (const Corner& c : scene.corners_of(facet)) box.extend(scene.vertices()[c.vertex]);
  return box;
}

bool casts(const Scene& scene, const Facet& facet) {
  return facet.corner_count > 0 && scene.objects()[scene.faces()[facet.face].object].casts_shadows;
}

}  // namespace

Receivers::Receivers(const Scene& scene, const Light& light, std::span<const FaceArea> areas) {
  for (std::uint32_t f = 0; f < areas.size(); ++f) {
    if (areas[f].facing != Facing::toward) continue;
    const Face& face = scene.faces()[f];
    const bool closed = scene.objects()[face.object].sides == Sides::closed;
    const std::size_t first = triangles_.size();
    double area = 0;
    for (const Facet& facet : scene.facets().subspan(face.first_facet, face.facet_count)) {
      const Plane& plane = scene.planes()[facet.plane];
      const double side = light.kind == Light::Kind::point
                              ? plane.normal.dot(light.position - plane.point)
                              : -plane.normal.dot(light.direction);
      const auto corners = scene.corners_of(facet);
      const auto at = [&](std::size_t k) -> const Vec3& {
        return scene.vertices()[corners[k].vertex];
      };
      for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
        const Vec3 ab = at(k) - at(0), ac = at(k + 1) - at(0);
        const double begin = area;
        area += 0.5 * ab.cross(ac).norm();
        if (area > begin)
          triangles_.push_back({at(0), ab, ac, side < 0 ? Vec3(-plane.normal) : plane.normal, begin,
                                area, closed && side <= 0});
      }
    }
    for (std::size_t k = first; k < triangles_.size(); ++k)
      triangles_[k].begin /= area, triangles_[k].end /= area;
    faces_.push_back({f, first, triangles_.size() - first, areas[f].area});
    area_ += areas[f].area;
  }
}

Receivers::Target Receivers::target(std::size_t i) const {
  const Range& r = faces_[i];
  return {r.face, r.area, std::span(triangles_).subspan(r.first, r.count)};
}

std::vector<std::uint32_t> Receivers::strata(std::uint32_t samples, bool by_area) const {
  const double least = std::min(samples, 4u),
               total = static_cast<double>(samples) * static_cast<double>(faces_.size());
  std::vector<std::uint32_t> all;
  for (const Range& r : faces_) {
    const double n = by_area ? std::max(least, total * (r.area / area_)) : samples;
    all.push_back(static_cast<std::uint32_t>(std::lround(std::sqrt(n))));
  }
  return all;
}

// ---- rays

RayDevice::RayDevice() : device_(rtcNewDevice("threads=1,set_affinity=0")) {
  if (!device_) throw Error("Embree cannot be started");
}

Rays::Rays(const RayDevice& device, const Scene& scene, const Light& light) : light_(light) {
  const Eigen::AlignedBox3d box = bounds(scene);
  middle_ = box.center();
  offset_ = 0x1p-20 * 0.5 * box.diagonal().norm();
  std::size_t triangles = 0;
  for (const Facet& facet : scene.facets())
    if (casts(scene, facet)) triangles += facet.corner_count - 2;
  const RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
      std::max<std::size_t>(1, scene.vertices().size())));
  auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles));
  for (const Vec3& v : scene.vertices())
    for (int axis = 0; axis < 3; ++axis) *vertices++ = static_cast<float>(v[axis] - middle_[axis]);
  for (const Facet& facet : scene.facets()) {
    if (!casts(scene, facet)) continue;
    const auto corners = scene.corners_of(facet);
    for (std::size_t k = 1; k + 1 < corners.size(); ++k)
      for (const std::size_t corner : {std::size_t{0}, k, k + 1})
        *indices++ = corners[corner].vertex;
  }
  rtcCommitGeometry(geometry);
  scene_.reset(rtcNewScene(device.get()));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  rtcAttachGeometry(scene_.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_.get());
  if (rtcGetDeviceError(device.get()) != RTC_ERROR_NONE)
    throw Error("Embree cannot build its tree");
}

bool Rays::is_lit(const Vec3& x, const Vec3& normal) const {
  const Vec3 from = x + normal * offset_;
  const bool is_point = light_.kind == Light::Kind::point;
  const Vec3 along = is_point ? Vec3(light_.position - from) : Vec3(-light_.direction);
  const Eigen::Vector3f org = (from - middle_).cast<float>(), dir = along.cast<float>();
  RTCRay ray;
  ray.org_x = org.x(), ray.org_y = org.y(), ray.org_z = org.z();
  ray.dir_x = dir.x(), ray.dir_y = dir.y(), ray.dir_z = dir.z();
  ray.tnear = 0, ray.tfar = is_point ? 1.0f : std::numeric_limits<float>::infinity();
  ray.time = 0, ray.mask = ~0u, ray.id = 0, ray.flags = 0;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene_.get(), &context, &ray);
  return ray.tfar >= 0;
}

// ---- shadow map

namespace {

// A face of the cube around a light, by its axis.
int cube_face(const Vec3& away) {
  int axis;
  away.cwiseAbs().maxCoeff(&axis);
  return 2 * axis + (away[axis] < 0 ? 1 : 0);
}

// The view along the third of three directions, through a window with the given bounds (of x / z
// and y / z, or of x and y).
Eigen::Matrix4d view_map(const Eigen::Matrix3d& axes, const Vec3& eye,
                         const Eigen::AlignedBox2d& window, const Eigen::RowVector4d& nearness,
                         const Eigen::RowVector4d& weight, double side) {
  Eigen::Matrix4d map;
  for (int k = 0; k < 2; ++k) {
    Eigen::RowVector4d r;
    r << axes.col(k).transpose(), -axes.col(k).dot(eye);
    map.row(k) = (r - window.min()[k] * weight) * (side / window.sizes()[k]);
  }
  map.row(2) = nearness;
  map.row(3) = weight;
  return map;
}

Eigen::Matrix3d axes_along(const Vec3& direction) {
  Eigen::Matrix3d axes;
  axes.col(2) = direction.normalized();
  axes.col(0) = axes.col(2).unitOrthogonal();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

// A margin of one texel, so that no geometry lies on the border.
void widen(Eigen::AlignedBox2d& window, double side) {
  const Eigen::Vector2d margin = window.sizes() / side;
  window = {window.min() - margin, window.max() + margin};
}

}  // namespace

ShadowMap::ShadowMap(const Scene& scene, const Light& light, std::uint32_t side)
    : side_(side), light_(light.position) {
  const Eigen::AlignedBox3d box = bounds(scene);
  const auto corner = [&](int k) {
    return box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k));
  };
  const bool is_point = light.kind == Light::Kind::point;
  const Eigen::Matrix3d axes =
      axes_along(is_point ? Vec3(box.center() - light.position) : light.direction);
  Eigen::AlignedBox2d window;
  Eigen::AlignedBox1d depths;
  for (int k = 0; k < 8; ++k) {
    const Vec3 local = axes.transpose() * (is_point ? Vec3(corner(k) - light.position) : corner(k));
    depths.extend(Eigen::AlignedBox1d::VectorType(local.z()));
    window.extend(is_point ? Eigen::Vector2d(local.head<2>() / local.z())
                           : Eigen::Vector2d(local.head<2>()));
  }
  widen(window, side);
  nearest_ = 1e-6 * box.diagonal().norm();
  if (!is_point) {
    light_ = Vec3::Zero();
    const double depth = depths.sizes()[0];
    Eigen::RowVector4d nearness;
    nearness << -axes.col(2).transpose() / depth, 1 + depths.min()[0] / depth;
    add_view(view_map(axes, light_, window, nearness, {0, 0, 0, 1}, side));
  } else if (const double steepest = 4; depths.min()[0] > nearest_ &&
                                        window.min().minCoeff() > -steepest &&
                                        window.max().maxCoeff() < steepest) {
    Eigen::RowVector4d weight;
    weight << axes.col(2).transpose(), -axes.col(2).dot(light.position);
    add_view(view_map(axes, light.position, window, {0, 0, 0, 1}, weight, side));
  } else {
    for (int k = 0; k < 6; ++k) {
      const Vec3 direction = (k % 2 == 0 ? 1 : -1) * Vec3::Unit(k / 2);
      const Eigen::Matrix3d cube_axes =
          (Eigen::Matrix3d() << Vec3::Unit((k / 2 + 1) % 3), Vec3::Unit((k / 2 + 2) % 3), direction)
              .finished();
      Eigen::RowVector4d weight;
      weight << direction.transpose(), -direction.dot(light.position);
      Eigen::AlignedBox2d square(Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, 1));
      widen(square, side);
      add_view(view_map(cube_axes, light.position, square, {0, 0, 0, 1}, weight, side));
    }
  }
  for (View& view : views_) draw(view, scene);
}

void ShadowMap::add_view(const Eigen::Matrix4d& map) {
  const double texels = std::min(map.row(0).head<3>().norm(), map.row(1).head<3>().norm());
  views_.push_back({map, 1 / texels, std::vector<float>(std::size_t{side_} * side_, -1.0f)});
}

void ShadowMap::draw(View& view, const Scene& scene) const {
  const Eigen::RowVector4d x = view.map.row(0), y = view.map.row(1), weight = view.map.row(3);
  const Eigen::RowVector4d planes[] = {weight - nearest_ * Eigen::RowVector4d(0, 0, 0, 1), x,
                                       side_ * weight - x, y, side_ * weight - y};
  std::vector<Vec3> polygon, scratch;
  for (const Facet& facet : scene.facets()) {
    if (!casts(scene, facet)) continue;
    polygon.clear();
    for (const Corner& c : scene.corners_of(facet)) polygon.push_back(scene.vertices()[c.vertex]);
    for (const Eigen::RowVector4d& plane : planes)
      io::clip(polygon, scratch, [&](const Vec3& p) { return plane.head<3>().dot(p) + plane[3]; });
    for (Vec3& p : polygon) p = (view.map * p.homogeneous()).hnormalized();
    if (polygon.size() >= 3) fill(view, polygon);
  }
}

// Texels whose centres are inside. The reciprocal depth is linear over the image.
void ShadowMap::fill(View& view, std::span<const Vec3> polygon) const {
  Vec3 normal = Vec3::Zero();
  double top = side_, bottom = 0;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    if (k >= 2) normal += (polygon[k - 1] - polygon[0]).cross(polygon[k] - polygon[0]);
    top = std::min(top, polygon[k].y()), bottom = std::max(bottom, polygon[k].y());
  }
  if (normal.z() == 0) return;
  const double dx = -normal.x() / normal.z(), dy = -normal.y() / normal.z(),
               slope = 0.5 * std::max(std::abs(dx), std::abs(dy));
  const auto texel = [&](double x) {
    return static_cast<std::int32_t>(
        std::clamp(std::ceil(x - 0.5), 0.0, static_cast<double>(side_)));
  };
  for (std::int32_t row = texel(top); row < texel(bottom); ++row) {
    const double y = row + 0.5;
    double left = side_, right = 0;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const Vec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
      if ((a.y() <= y) == (b.y() <= y)) continue;
      const double x = a.x() + (b.x() - a.x()) * ((y - a.y()) / (b.y() - a.y()));
      left = std::min(left, x), right = std::max(right, x);
    }
    const std::int32_t begin = texel(left), count = texel(right) - begin;
    const double start =
        polygon[0].z() + dx * (begin + 0.5 - polygon[0].x()) + dy * (y - polygon[0].y());
    const auto from = static_cast<float>(start - slope - 4 * 0x1p-24 * std::abs(start)),
               step = static_cast<float>(dx);
    float* texels = view.nearness.data() + static_cast<std::size_t>(row) * side_ + begin;
    for (std::int32_t k = 0; k < count; ++k)
      texels[k] = std::max(texels[k], from + step * static_cast<float>(k));
  }
}

const ShadowMap::View& ShadowMap::view_of(const Vec3& x) const {
  return views_.size() == 1 ? views_[0] : views_[static_cast<std::size_t>(cube_face(x - light_))];
}

bool ShadowMap::is_lit(const Vec3& x, const Vec3& normal) const {
  const View& view = view_of(x);
  const double off = 0.5 * view.texel * view.map.row(3).dot(x.homogeneous());
  const Vec3 p = (view.map * Vec3(x + off * normal).homogeneous()).hnormalized();
  const auto texel = [&](double c) {
    return static_cast<std::size_t>(std::clamp(c, 0.0, side_ - 1.0));
  };
  return static_cast<float>(p.z()) >= view.nearness[texel(p.y()) * side_ + texel(p.x())];
}

std::size_t ShadowMap::bytes() const { return views_.size() * side_ * side_ * sizeof(float); }

}  // namespace shadowcut::bench
