// libFuzzer: any bytes as an OBJ file. The reader throws Error or gives a scene whose every promise
// can be relied upon; then a shadow is cast.
#include <cmath>
#include <cstdlib>
#include <shadowcut/io.hpp>
#include <string_view>

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

void check(const shadowcut::Scene& scene) {
  using namespace shadowcut;
  for (const Issue& issue : scene.issues()) {
    require(issue.object < scene.objects().size());
    require(issue.face < scene.objects()[issue.object].face_count);
    require(!io::describe(scene, issue, "fuzz.obj").empty());
  }
  for (const Vec3& v : scene.vertices()) require(v.allFinite());
  for (const Facet& facet : scene.facets()) {
    require(facet.corner_count >= 3);
    require(std::abs(scene.planes()[facet.plane].normal.norm() - 1) < 1e-9);
    for (const Corner& c : scene.corners_of(facet))
      require(c.vertex < scene.vertices().size() && (c.edge >> 1) < scene.edges().size());
  }
  for (const Face& face : scene.faces()) require((face.facet_count == 0) == (face.area == 0));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace shadowcut;
  try {
    const Scene scene = io::read_obj({reinterpret_cast<const char*>(data), size}, "fuzz.obj");
    check(scene);
    if (scene.facets().size() < 200) cast_shadows(scene, Light::point({0.1, 0.2, 3}));
  } catch (const Error&) {
  }
  return 0;
}
