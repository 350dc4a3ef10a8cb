// Two methods that sample, for comparison with exact shadows: shadow rays and a shadow map. Both
// decide whether a point is lit. The lit area of a face is the share of its sample points that are
// lit, times its area. Both run on one thread, without a graphics card.
//
// Both answer the same question as the engine: is a casting face strictly between the point and the
// light? Faces turned away from the light (FaceArea::facing) are not sampled. Of a face in several
// facets, the facets that are turned away are dark.
#pragma once

#include <embree3/rtcore.h>

#include <cmath>
#include <memory>
#include <shadowcut/shadows.hpp>
#include <span>
#include <vector>

#include "scenes.hpp"

namespace shadowcut::bench {

// The faces turned to the light, and sample points on them.
class Receivers {
 public:
  Receivers(const Scene& scene, const Light& light, std::span<const FaceArea> areas);

  struct Triangle {
    Vec3 a, ab, ac;
    Vec3 normal;        // to the light
    double begin, end;  // share of the face's area before it, and with it
    bool turned_away;
  };
  struct Target {
    std::uint32_t face;  // index into Scene::faces()
    double area;
    std::span<const Triangle> triangles;
  };
  std::size_t size() const { return faces_.size(); }
  Target target(std::size_t i) const;

  // Strata along each side of a face, for a mean number of samples per face: equal for all faces,
  // or by area with at least four samples per face (or the mean number, if it is smaller).
  std::vector<std::uint32_t> strata(std::uint32_t samples, bool by_area) const;

  // Calls visit(point, normal) at a random point in each of strata x strata parts of a face.
  // Returns the number of calls that returned true.
  template <class Visit>
  static std::size_t count(const Target& target, std::uint32_t strata, const Visit& visit) {
    scenes::Random random(target.face * 0x10001ull + strata);
    std::size_t n = 0;
    for (std::uint32_t x = 0; x < strata; ++x) {
      for (std::uint32_t y = 0; y < strata; ++y) {
        const std::uint64_t bits = random.next();
        const double u = (x + static_cast<double>(bits >> 32) * 0x1p-32) / strata,
                     v = (y + static_cast<double>(bits & 0xFFFFFFFF) * 0x1p-32) / strata;
        std::size_t k = 0;
        while (k + 1 < target.triangles.size() && u >= target.triangles[k].end) ++k;
        const Triangle& t = target.triangles[k];
        if (t.turned_away) continue;
        // From the square to the triangle, with areas in proportion.
        const double r = std::sqrt((u - t.begin) / (t.end - t.begin));
        n += visit(Vec3(t.a + t.ab * (r * (1 - v)) + t.ac * (r * v)), t.normal) ? 1 : 0;
      }
    }
    return n;
  }

 private:
  struct Range {
    std::uint32_t face;
    std::size_t first, count;
    double area;
  };
  std::vector<Range> faces_;
  std::vector<Triangle> triangles_;
  double area_ = 0;
};

// By index of Receivers: the area whose sample points fulfil the predicate.
template <class Predicate>
std::vector<double> areas_where(const Receivers& receivers, std::span<const std::uint32_t> strata,
                                const Predicate& predicate) {
  std::vector<double> areas;
  areas.reserve(receivers.size());
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    const Receivers::Target target = receivers.target(i);
    const auto samples = static_cast<double>(strata[i]) * strata[i];
    areas.push_back(
        target.area *
        (static_cast<double>(Receivers::count(target, strata[i], predicate)) / samples));
  }
  return areas;
}

// Embree on one thread. It is started once; no job includes that time.
class RayDevice {
 public:
  RayDevice();
  RTCDevice get() const { return device_.get(); }

 private:
  struct Free {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  };
  std::unique_ptr<RTCDeviceTy, Free> device_;
};

// Embree's rtcOccluded1 in robust mode. Embree uses single precision: coordinates are relative to
// the centre of the scene, and a ray starts off its face, towards the light, by 2^-20 of the radius
// of the scene, so that neither the face nor a face in contact with it occludes the ray.
class Rays {
 public:
  Rays(const RayDevice& device, const Scene& scene, const Light& light);
  bool is_lit(const Vec3& x, const Vec3& normal) const;

 private:
  struct Free {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  Light light_;
  Vec3 middle_ = Vec3::Zero();
  double offset_ = 0;
  std::unique_ptr<RTCSceneTy, Free> scene_;
};

// A depth image from the light in single precision; a cube of six images for a light among the
// faces. The window is fitted around the scene, and the nearest texel is read. Against
// self-shadowing, depths are moved away from the light by slope x 0.5 + 4 units, as OpenGL's
// polygon offset does, and points are looked up half a texel off their face. Of slopes 0, 0.5, 1.1
// and 0, 0.5, 1, 1.5 texels these values gave the smallest errors.
class ShadowMap {
 public:
  ShadowMap(const Scene& scene, const Light& light, std::uint32_t side);
  bool is_lit(const Vec3& x, const Vec3& normal) const;
  std::size_t bytes() const;
  std::size_t images() const { return views_.size(); }

 private:
  struct View {
    Eigen::Matrix4d map;  // (point, 1) to (x, y, nearness, 1) times a weight, x and y in texels
    double texel;         // its size where the weight is one
    std::vector<float> nearness;
  };
  void add_view(const Eigen::Matrix4d& map);
  void draw(View& view, const Scene& scene) const;
  void fill(View& view, std::span<const Vec3> polygon) const;
  const View& view_of(const Vec3& x) const;

  std::uint32_t side_;
  Vec3 light_ = Vec3::Zero();
  double nearest_ = 0;  // no face is drawn nearer to the light
  std::vector<View> views_;
};

}  // namespace shadowcut::bench
