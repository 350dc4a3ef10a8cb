// The published algorithms against the exact oracle: every face's lit area, in random scenes of
// every kind, in every setting, under one light and under several. A disagreement prints the scene
// reduced to the faces that matter, as OBJ. SHADOWCUT_SOAK=n runs about n random scenes instead of
// some hundred, SHADOWCUT_SEED=k other ones, SHADOWCUT_SCENE=seed a single one.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "check.hpp"
#include "compare.hpp"
#include "light_vector.hpp"
#include "random_scenes.hpp"
#include "settings.hpp"

namespace shadowcut::testing {
namespace {

using compare::Algorithm;
using compare::Result;
using compare::Settings;
using scenes::SceneData;

struct Case {
  const char* name;
  Algorithm algorithm;
  Settings settings;
};

std::vector<Case> all_cases() {
  std::vector<Case> cases{{"brute", Algorithm::brute, {}},
                          {"ordered", Algorithm::ordered, {}},
                          {"ordered_apart", Algorithm::ordered, {}},
                          {"tiling", Algorithm::tiling, {}},
                          {"one_tile", Algorithm::tiling, {}},
                          {"seven_tiles", Algorithm::tiling, {}},
                          {"one_candidate", Algorithm::ordered, {}},
                          {"unordered", Algorithm::unordered, {}},
                          {"unordered_apart", Algorithm::unordered, {}},
                          {"unordered_after_bsp", Algorithm::unordered, {}}};
  cases[2].settings.reunite = cases[8].settings.reunite = false;
  cases[4].settings.tiles = 1, cases[5].settings.tiles = 7;
  cases[6].settings.candidates = 1;
  cases[9].settings.after_bsp = true;
  return cases;
}

// Areas as the oracle has them, and fragments that add up to them.
std::string check(const Scene& scene, const Result& result,
                  const std::vector<CgalOracle::Area>& wanted) {
  std::string what = check_areas(scene, {{}, result.areas, {}}, wanted);
  std::vector<double> lit(scene.faces().size(), 0), shadowed(lit);
  for (const compare::Fragment& f : result.fragments) {
    (f.lit ? lit : shadowed)[scene.facets()[f.polygon.facet].face] += area_of(f.polygon);
  }
  for (std::uint32_t i = 0; i < scene.faces().size(); ++i) {
    const FaceArea& area = result.areas[i];
    if (area.facing != Facing::toward) continue;
    if (std::abs(lit[i] - area.lit) + std::abs(shadowed[i] - area.shadowed) >
        kAreaTolerance * area.area)
      what += text("face ", i, ": fragments make ", lit[i], " and ", shadowed[i], ", areas are ",
                   area.lit, " and ", area.shadowed, "\n");
  }
  return what;
}

std::string check(const SceneData& data, const Case& c) {
  const Scene scene = scenes::build(data);
  return check(scene, compare::cast(scene, {&data.light, 1}, c.algorithm, c.settings).front(),
               CgalOracle(scene, data.light).areas());
}

Mesh without_face(const Mesh& mesh, std::size_t left_out) {
  Mesh less;
  less.vertices = mesh.vertices;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (f == left_out) continue;
    less.add_face(mesh.loop(f, 0));
    for (std::size_t k = 1; k < mesh.loop_count(f); ++k) less.add_hole(mesh.loop(f, k));
  }
  return less;
}

// Leaves out objects, then faces, for as long as the scene still fails. Which sides count stays as
// it was decided.
SceneData reduced(SceneData data, const std::function<bool(const SceneData&)>& fails) {
  const Scene scene = scenes::build(data);
  for (std::size_t o = 0; o < data.objects.size(); ++o)
    data.objects[o].second.sides = scene.objects()[o].sides;
  for (std::size_t o = data.objects.size(); o-- > 0;) {
    SceneData less = data;
    less.objects.erase(less.objects.begin() + static_cast<std::ptrdiff_t>(o));
    if (!less.objects.empty() && fails(less)) data = std::move(less);
  }
  for (auto& [mesh, settings] : data.objects) {
    for (std::size_t f = mesh.face_count(); f-- > 0 && mesh.face_count() > 1;) {
      const Mesh before = mesh;
      mesh = without_face(mesh, f);
      if (!fails(data)) mesh = before;
    }
  }
  return data;
}

std::string as_obj(const SceneData& data) {
  std::string out = text("# light ", data.light.kind == Light::Kind::point ? "point " : "sun ",
                         vector_of(data.light).transpose(), "\n");
  std::size_t first = 1;
  for (const auto& [mesh, settings] : data.objects) {
    out +=
        text("o ", settings.name, settings.sides == Sides::closed ? " (closed)" : " (open)", "\n");
    for (const Vec3& v : mesh.vertices) out += text("v ", (settings.pose * v).transpose(), "\n");
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
      for (std::size_t k = 0; k < mesh.loop_count(f); ++k) {
        out += k == 0 ? "f" : "# hole";
        for (const std::uint32_t i : mesh.loop(f, k)) out += text(' ', first + i);
        out += '\n';
      }
    }
    first += mesh.vertices.size();
  }
  return out;
}

std::string explain(const SceneData& data, const Case& c) {
  const SceneData least = reduced(data, [&](const SceneData& s) { return !check(s, c).empty(); });
  return text(c.name, "; least scene that fails:\n", as_obj(least), "there: ", check(least, c));
}

class PublishedAlgorithmsOf : public ::testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, PublishedAlgorithmsOf, ::testing::ValuesIn(kAllKinds),
                         [](const auto& info) { return name_of(info.param); });

TEST_P(PublishedAlgorithmsOf, RandomScenes) {
  std::uint64_t first = 1000 * environment("SHADOWCUT_SEED").value_or(0),
                end = first +
                      environment("SHADOWCUT_SOAK").value_or(8 * 25) / std::size(kAllKinds) + 1;
  if (const auto one = environment("SHADOWCUT_SCENE")) first = *one, end = first + 1;
  for (std::uint64_t seed = first; seed < end; ++seed) {
    const SceneData data = random_scene(GetParam(), seed);
    const Scene scene = scenes::build(data);
    const std::vector<CgalOracle::Area> wanted = CgalOracle(scene, data.light).areas();
    for (const Case& c : all_cases()) {
      const std::string what = check(
          scene, compare::cast(scene, {&data.light, 1}, c.algorithm, c.settings).front(), wanted);
      ASSERT_EQ(what, "") << name_of(GetParam()) << ", seed " << seed << ", " << explain(data, c);
    }
  }
}

// What one light cut is what the next one cuts, and no light's areas notice.
TEST_P(PublishedAlgorithmsOf, SeveralLights) {
  for (std::uint64_t seed = 700; seed < 704; ++seed) {
    const SceneData data = random_scene(GetParam(), seed);
    scenes::Random random(seed);
    const std::vector<Light> lights{data.light, random_light(GetParam(), random),
                                    random_light(GetParam(), random)};
    const Scene scene = scenes::build(data);
    std::vector<std::vector<CgalOracle::Area>> wanted;
    for (const Light& light : lights) wanted.push_back(CgalOracle(scene, light).areas());
    for (const Case& c : all_cases()) {
      const std::vector<Result> results = compare::cast(scene, lights, c.algorithm, c.settings);
      ASSERT_EQ(results.size(), lights.size());
      for (std::size_t k = 0; k < lights.size(); ++k) {
        ASSERT_EQ(check(scene, results[k], wanted[k]), "")
            << name_of(GetParam()) << ", seed " << seed << ", light " << k << ", " << c.name;
      }
    }
  }
}

TEST(PublishedAlgorithms, MadeScenes) {
  for (const SceneData& data :
       {scenes::room(1), scenes::room(3), scenes::furnished_room(), scenes::tetrahedron(2),
        scenes::tetrahedron(3), scenes::city(6), scenes::spheres(4, 12, 8), scenes::triangles(100),
        scenes::branch(2)}) {
    const Scene scene = scenes::build(data);
    const std::vector<CgalOracle::Area> wanted = CgalOracle(scene, data.light).areas();
    for (const Case& c : all_cases())
      EXPECT_EQ(
          check(scene, compare::cast(scene, {&data.light, 1}, c.algorithm, c.settings).front(),
                wanted),
          "")
          << data.name << ", " << c.name;
  }
}

}  // namespace
}  // namespace shadowcut::testing
