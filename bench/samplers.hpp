// What exact shadows are measured against: shadow rays and a shadow map, each as one would write it
// with care. Both say of a point whether it is lit; the lit area of a face is then the share of its
// sample points that are, times its area. On one thread, without a GPU.
//
// Both are asked the engine's question: is there, strictly between the point and the light, a face
// that casts? Faces turned away from the light (the engine's FaceArea::facing) are not sampled, and
// of a face in several facets those that are turned away are dark.
#pragma once

#include <embree3/rtcore.h>

#include <cmath>
#include <memory>
#include <shadowcut/shadows.hpp>
#include <span>
#include <vector>

#include "scenes.hpp"

namespace shadowcut::bench {

// The faces turned to the light, and points on them.
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

  // Strata along each side of a face, for so many samples a face in the mean: the same for all, or
  // by area, but at least four a face, or as many as asked for.
  std::vector<std::uint32_t> strata(std::uint32_t samples, bool by_area) const;

  // Calls visit(point, normal) at a random place in each of strata x strata parts of a face, and
  // returns for how many it returned true.
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

// The area on each receiver for whose sample points the predicate holds, by Receivers' index.
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

// Embree on one thread; started once, and counted in no job's time.
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

// Embree's rtcOccluded1, in the robust mode. Single precision: coordinates are taken from the
// scene's middle, and a ray starts 2^-20 of the scene's radius off its face, towards the light, so
// that neither the face itself nor one that touches it is in the way.
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

// A depth image from the light in single precision, or for a light among the faces a cube of six.
// The window is fitted around the scene, and the nearest texel answers. Against self-shadowing,
// what is drawn is moved away from the light by slope x 0.5 + 4 units, as OpenGL's polygon offset
// does, and what is looked up half a texel off its face: of slopes 0, 0.5, 1.1 and 0, 0.5, 1, 1.5
// texels these gave the smallest errors.
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
