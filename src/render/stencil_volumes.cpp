// Shadow volumes counted in the stencil buffer: T. Heidmann, "Real shadows, real time", IRIS
// Universe 18, 1991, as H. Batagelo and I. Costa Junior have it ("Real-time shadow generation using
// BSP trees and stencil buffers", SIBGRAPI 1999, section 4.1): a volume for every polygon that
// faces the light, its sides up where they face the camera and down where they do not.
//
// stencil-standard counts what passes the depth test. It is wrong where the camera is in shadow or
// its near plane cuts a volume: what is cut off is not counted. stencil-zfail counts what fails the
// depth test, with the volumes closed in front and at infinity, and is right there.
//
// Departures. Sides end at infinity (w = 0, and a camera without a far plane) and not at a far
// distance. Both faces are counted in one pass, with operations that wrap (OpenGL 2.0), so there is
// no order to keep. Facets turned away, and lights that are not reached, are left out by the
// shading. Of solids that hold the light the facets turned away cast too in the engine; here a
// solid's own sides do not.
#include "casters.hpp"
#include "scene/scene_access.hpp"
#include "technique.hpp"
#include "volume_buffer.hpp"

namespace shadowcut::render {
namespace {

class StencilVolumes : public Technique {
 public:
  StencilVolumes(const Scene& scene, const Model& model, bool zfail)
      : scene_(scene), model_(model), zfail_(zfail) {}

  void update() override {
    if (known_ == SceneAccess::revision(scene_)) return;
    known_ = SceneAccess::revision(scene_);
    while (lights_.size() > scene_.lights().size()) lights_.pop_back();
    while (lights_.size() < scene_.lights().size()) lights_.emplace_back(model_);
    shadow_polygons_ = 0;
    for (std::size_t k = 0; k < lights_.size(); ++k) add_volumes(scene_.lights()[k], lights_[k]);
  }

  void add_light(const Frame& frame, std::size_t light) override {
    if (zfail_) lights_[light].count_failures(frame);
    else lights_[light].count_passes(frame);
    model_.add_light(frame, scene_.lights()[light], scene_.lights().size(), true);
    glDisable(GL_STENCIL_TEST);
  }

  Figures figures() const override { return {{"shadow_polygons", shadow_polygons_}}; }

 private:
  void add_volumes(const Light& light, VolumeBuffer& volumes) {
    volumes.clear();
    std::vector<Vec3> polygon;
    for (const Caster& caster : casters_of(scene_, light)) {
      polygon.clear();
      for (const std::uint32_t v : caster.vertices) polygon.push_back(scene_.vertices()[v]);
      for (std::size_t i = 0; i < polygon.size(); ++i)
        volumes.add_side(light, polygon[i], polygon[i + 1 == polygon.size() ? 0 : i + 1]);
      if (zfail_) volumes.add_ends(light, polygon);
      shadow_polygons_ += static_cast<double>(polygon.size());
    }
    volumes.upload();
  }

  const Scene& scene_;
  const Model& model_;
  const bool zfail_;
  std::optional<std::uint64_t> known_;  // revision of the scene that this is of
  std::vector<VolumeBuffer> lights_;
  double shadow_polygons_ = 0;  // sides, of all lights
};

}  // namespace

std::unique_ptr<Technique> make_stencil_volumes(const Scene& scene, const Model& model,
                                                bool zfail) {
  return std::make_unique<StencilVolumes>(scene, model, zfail);
}

}  // namespace shadowcut::render
