// libFuzzer: bytes make a small scene, mostly on a grid, which is where everything degenerate
// happens; some coordinates are any double. Its shadows are cast in every form, by every kernel,
// with and without smallest features left out; the tree must be valid and each face's fragments
// must add up to its area.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <shadowcut/shadows.hpp>

#include "source.hpp"

namespace {

using namespace shadowcut;
using fuzz::require;

class Source : public fuzz::Bytes {
 public:
  using Bytes::Bytes;
  double coordinate(bool any) {
    if (!any) return byte() % 8 - 2;
    std::uint64_t bits = 0;
    for (int k = 0; k < 8; ++k) bits = bits << 8 | byte();
    // within 8, with all bits
    return static_cast<double>(static_cast<std::int64_t>(bits)) * 0x1p-60;
  }
  Vec3 point(bool any) {
    const double x = coordinate(any), y = coordinate(any), z = coordinate(any);
    return {x, y, z};
  }
};

Mesh some_mesh(Source& source, std::uint8_t kind) {
  return fuzz::some_mesh(kind, [&] { return source.point(kind & 8); });
}

double area_of(std::span<const Vec3> corners) {
  Vec3 twice = Vec3::Zero();
  for (std::size_t i = 2; i < corners.size(); ++i)
    twice += (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]);
  return twice.norm() / 2;
}

// Fragments lie within a face, so areas are compared with the size of the face, not with what a
// needle's area happens to be.
double size_of(const Scene& scene, const Face& face) {
  double size = 0;
  for (std::uint32_t k = 0; k < face.facet_count; ++k) {
    const Facet& facet = scene.facets()[face.first_facet + k];
    const Vec3& first = scene.vertices()[scene.corners_of(facet)[0].vertex];
    for (const Corner& c : scene.corners_of(facet))
      size = std::max(size, (scene.vertices()[c.vertex] - first).norm());
  }
  return size;
}

void check(const Scene& scene, const Shadows& shadows) {
  std::vector<double> lit(scene.faces().size()), shadowed(lit);
  for (const Block& block : shadows.blocks)
    for (const Fragment& f : block.fragments) {
      require(f.corner_count >= 3, "fewer than three corners");
      for (const Vec3& c : block.corners_of(f)) require(c.allFinite(), "a corner is not finite");
      (f.lit ? lit : shadowed)[f.face] += area_of(block.corners_of(f));
    }
  for (std::size_t i = 0; i < lit.size(); ++i) {
    const FaceArea& area = shadows.areas[i];
    if (area.facing == Facing::refused) continue;
    const double size = size_of(scene, scene.faces()[i]);
    // Coordinates and distances from the light are up to 16 here, and every corner carries a
    // rounding of them.
    const double tolerance = 1e-7 * (area.area + size * size) + 64 * 0x1p-53 * 16 * size;
    require(area.lit >= 0 && area.shadowed >= 0, "a negative area");
    require(std::abs(area.lit + area.shadowed + area.dropped - area.area) <= tolerance,
            "lit and shadowed do not make the area");
    require(std::abs(lit[i] - area.lit) <= tolerance &&
                std::abs(shadowed[i] - area.shadowed) <= tolerance,
            "fragments do not add up");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Source source(data, size);
  Options options;
  options.threads = 1;
  const std::uint8_t choice = source.byte();
  options.tuning.order = static_cast<Order>(choice % 3);
  options.tuning.facets_per_cell = choice & 8 ? 2 : choice & 16 ? 0 : 64;
  Light light = choice & 32 ? Light::directional(source.point(false))
                            : Light::point(source.point(choice & 64));
  if (light.kind == Light::Kind::directional && light.direction.isZero()) light.direction.z() = -1;
  Scene scene;
  for (int k = 0; k < 12 && !source.empty(); ++k) {
    const std::uint8_t kind = source.byte();
    ObjectSettings settings;
    settings.sides = kind & 16 ? Sides::open : Sides::automatic;
    settings.casts_shadows = !(kind & 32) || !(kind & 64);
    settings.dynamic = kind & 128;
    scene.add(some_mesh(source, kind), settings);
  }
  options.tuning.incremental = false;
  scene.replace_lights({&light, 1});
  const auto run = [&](Kernel kernel, Form form, double least) {
    options.kernel = kernel, options.form = form, options.min_feature.area = least;
    Engine engine(scene, options);
    engine.update();
    const std::string complaint = engine.validate();
    require(complaint.empty(), complaint.c_str());
    check(scene, engine.shadows(0));
    for (const double open : engine.uncertain_area(0))
      require(open >= 0 && std::isfinite(open), "an uncertain area is no area");
  };
  for (const Form form : {Form::pieces, Form::merged, Form::conforming}) run(Kernel::fast, form, 0);
  run(Kernel::exact, choice & 128 ? Form::pieces : Form::merged, 0);
  run(choice & 128 ? Kernel::exact : Kernel::fast, Form::pieces, 0.25);
  return 0;
}
