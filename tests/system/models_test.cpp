// Real models, from Debian's assimp-testmodels and glmark2-data: read, cast, and held against the
// oracle on a sample of faces.
#include <gtest/gtest.h>

#include <filesystem>
#include <shadowcut/io.hpp>

#include "check.hpp"
#include "scenes.hpp"

namespace shadowcut::testing {
namespace {

struct Model {
  const char* name;
  const char* path;
  std::size_t least_faces, least_objects;
};

void PrintTo(const Model& model, std::ostream* out) { *out << model.name; }

class RealModel : public ::testing::TestWithParam<Model> {};

// A light above and beside the model, in general position.
Light lamp_over(const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : scene.vertices()) box.extend(v);
  return Light::point(box.center() + Vec3(0.7131, 0.4177, 1.3519).cwiseProduct(box.sizes()) +
                      0.017 * box.diagonal().norm() * Vec3(1, 2, 3));
}

// Coordinates are floats, so faces are flat to 1e-8 only, and details of a millimetre are seen from
// twenty metres: the double kernel takes slivers of 1e-10 for nothing there, which can be more than
// 1e-9 of a small face.
constexpr double kModelTolerance = 1e-8;

TEST_P(RealModel, MatchesTheOracle) {
  if (!std::filesystem::exists(GetParam().path))
    GTEST_SKIP() << GetParam().path << " is not installed";
  const Scene scene = io::read_scene(GetParam().path);
  EXPECT_GE(scene.faces().size(), GetParam().least_faces);
  EXPECT_GE(scene.objects().size(), GetParam().least_objects);
  const Light light = lamp_over(scene);
  const Shadows shadows = cast_shadows(scene, light);
  EXPECT_EQ(check_fragments(scene, light, shadows, kModelTolerance), "");
  const CgalOracle oracle(scene, light);
  EXPECT_EQ(check_points(scene, shadows, oracle, 5, 150), "");
  scenes::Random random(11);
  for (int k = 0; k < 60; ++k) {
    const auto face = static_cast<std::uint32_t>(random.below(scene.faces().size()));
    const CgalOracle::Area want = oracle.area(face);
    const FaceArea& got = shadows.areas[face];
    if (want.unsure) continue;
    EXPECT_EQ(got.facing, want.facing) << "face " << face;
    EXPECT_NEAR(got.lit, want.lit, kModelTolerance * want.area)
        << "face " << face << " of area " << want.area;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Debian, RealModel,
    ::testing::Values(Model{"bunny", "/usr/share/glmark2/models/bunny.obj", 10000, 1},
                      Model{"ifc_house", "/usr/share/assimp/models/IFC/AC14-FZK-Haus.ifc", 500, 50},
                      Model{"wuson", "/usr/share/assimp/models/OBJ/WusonOBJ.obj", 1000, 1},
                      Model{"spider", "/usr/share/assimp/models/OBJ/spider.obj", 1000, 10},
                      Model{"duck", "/usr/share/assimp/models/Collada/duck.dae", 1000, 1},
                      Model{"truck",
                            "/usr/share/assimp/models/glTF/CesiumMilkTruck/CesiumMilkTruck.gltf",
                            1000, 2}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace shadowcut::testing
