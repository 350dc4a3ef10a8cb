// The extremes: coordinates from 1e-30 to 1e30 and mixed, scenes 1e12 away from the origin, lights
// on planes, edges and vertices or one ulp off, grazing suns, needles, stacks of sheets one ulp
// apart, everything coplanar, everything through one vertex or one line. exact_test.cpp holds the
// exact kernel against the oracle there, fragment by fragment; here the fast kernel's true error is
// held against the bound that it states, and what is too large for the oracle has an answer known
// beforehand.
//
// SHADOWCUT_SOAK=n runs about n scenes instead of some thousands, and a million faces in one cell;
// SHADOWCUT_SEED=k other scenes; SHADOWCUT_SCENE=seed one alone. SHADOWCUT_RECORD=file writes what
// was seen, for docs/accuracy.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <limits>
#include <map>

#include "check.hpp"
#include "exact_scenes.hpp"
#include "gmp_oracle.hpp"
#include "settings.hpp"

namespace shadowcut::testing {
namespace {

// Of one kind of scene and one kernel.
struct Seen {
  std::uint64_t scenes = 0, faces = 0;
  // wholly lit and said to be wholly shadowed, or the reverse
  std::uint64_t wrong_faces = 0;
  std::uint64_t beyond = 0;  // whose error is more than the bound
  // sums; and the largest error of a face as a share of its area
  double area = 0, error = 0, bound = 0, worst = 0;
};

std::map<std::string, std::map<std::string, Seen>>& record() {
  static std::map<std::string, std::map<std::string, Seen>> all;
  return all;
}

// As JSON: it has no infinity, which an error is as a share of a face without area.
struct Number {
  double x;
  friend std::ostream& operator<<(std::ostream& out, Number n) {
    return std::isfinite(n.x) ? out << n.x : out << "null";
  }
};

class Recorder : public ::testing::Environment {
 public:
  void TearDown() override {
    const char* file = std::getenv("SHADOWCUT_RECORD");
    if (!file) return;
    std::ofstream out(file);
    out << std::setprecision(6) << "[";
    const char* comma = "";
    for (const auto& [kind, kernels] : record()) {
      for (const auto& [kernel, s] : kernels) {
        out << comma << "\n  {\"kind\": \"" << kind << "\", \"kernel\": \"" << kernel
            << "\", \"scenes\": " << s.scenes << ", \"faces\": " << s.faces
            << ", \"wrong_faces\": " << s.wrong_faces << ", \"error\": " << Number{s.error / s.area}
            << ", \"bound\": " << Number{s.bound / s.area} << ", \"beyond\": " << s.beyond
            << ", \"worst_face\": " << Number{s.worst} << "}";
        comma = ",";
      }
    }
    out << "\n]\n";
  }
};
const auto* const recorder = ::testing::AddGlobalTestEnvironment(new Recorder);

double exact_lit_area(const GmpOracle& oracle, const Face& face) {
  double sum = 0;
  for (std::uint32_t f = face.first_facet; f < face.first_facet + face.facet_count; ++f) {
    if (oracle.role(f) != GmpOracle::Role::takes_part) continue;
    sum += std::abs(oracle.area(f, oracle.lit(f)).get_d()) * oracle.stretch(f).second;
  }
  return sum;
}

// The lit area of every face against the exact one, and the difference against the bound.
void check_bound(const char* kind, std::uint64_t seed, const ExactScene& made, const Scene& scene,
                 const GmpOracle& oracle, Kernel kernel, const char* name) {
  Options options;
  options.kernel = kernel;
  options.threads = 1;
  options.tuning.incremental = seed % 2 == 0;
  options.form = static_cast<Form>(seed % 3);
  options.tuning.facets_per_cell = seed % 5 == 0 ? 2 : 128;
  const auto [shadows, uncertain] = cast_alone(scene, made.light, options);
  Seen& seen = record()[kind][name];
  ++seen.scenes;
  for (std::uint32_t f = 0; f < scene.faces().size(); ++f) {
    const FaceArea& got = shadows.areas[f];
    if (got.facing == Facing::refused || got.facing == Facing::ignored) continue;
    const double want = exact_lit_area(oracle, scene.faces()[f]), error = std::abs(got.lit - want);
    ++seen.faces;
    seen.area += got.area, seen.error += error, seen.bound += uncertain[f];
    seen.worst = std::max(seen.worst, error / got.area);
    seen.wrong_faces += (want == 0 && got.shadowed == 0) || (got.lit == 0 && want >= got.area);
    if (error <= uncertain[f]) continue;
    ++seen.beyond;
    ASSERT_LE(error, uncertain[f]) << kind << ", seed " << seed << ", kernel " << name << ", "
                                   << describe(options) << ", face " << f << ": lit " << got.lit
                                   << ", should be " << want << " of " << got.area << "\n"
                                   << describe(made);
  }
}

class Extremes : public ::testing::TestWithParam<ExactKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, Extremes, ::testing::ValuesIn(kAllExactKinds),
                         [](const auto& info) { return name_of(info.param); });

TEST_P(Extremes, ErrorsStayWithinWhatIsUndecided) {
  std::uint64_t first = 1000000 * environment("SHADOWCUT_SEED").value_or(0);
  std::uint64_t count = environment("SHADOWCUT_SOAK").value_or(120 * std::size(kAllExactKinds)) /
                            std::size(kAllExactKinds) +
                        1;
  if (const auto one = environment("SHADOWCUT_SCENE")) first = *one, count = 1;
  for (std::uint64_t seed = first; seed < first + count && !HasFatalFailure(); ++seed) {
    const ExactScene made = exact_scene(GetParam(), seed);
    const Scene scene = build(made);
    const GmpOracle oracle(scene, made.light);
    if (!oracle.defined()) continue;
    check_bound(name_of(GetParam()), seed, made, scene, oracle, Kernel::fast, "fast");
  }
}

// What is too large for the oracle, with answers known beforehand: everything is dyadic, so that
// areas are exact.

Mesh sheet(double x0, double x1, double y0, double y1, double z) {
  return scenes::rectangle({x0, y0, z}, {x1 - x0, 0, 0}, {0, y1 - y0, 0});
}
Light straight_down() { return Light::directional({0, 0, -1}); }
ObjectSettings open_sheet(bool casts = true) {
  ObjectSettings settings;
  settings.sides = Sides::open;
  settings.casts_shadows = casts;
  return settings;
}

bool soaks() { return environment("SHADOWCUT_SOAK").has_value(); }

// Sheets one ulp apart, each a step further than the one above it, so that a strip of every sheet
// is lit.
void check_stack(std::uint32_t count, std::uint32_t layers, Order order, std::uint64_t seed) {
  const double step = 1, width = layers;
  Scene scene;
  std::vector<std::uint32_t> level(count);  // which sheet, the top one first, is added as which
  for (std::uint32_t i = 0; i < count; ++i) level[i] = i;
  scenes::Random random(seed);
  for (std::uint32_t i = count - 1; i > 0; --i) std::swap(level[i], level[random.below(i + 1)]);
  for (std::uint32_t k = 0; k < count; ++k) {
    const double z = 1 + (count - level[k]) * 0x1p-52, x = level[k] * step;
    scene.add(sheet(x, x + width, 0, 1, z), open_sheet());
  }
  Options options;
  options.kernel = Kernel::exact;
  options.tuning.order = order, options.tuning.seed = seed;
  const Shadows shadows = cast_shadows(scene, straight_down(), options);
  for (std::uint32_t k = 0; k < count; ++k) {
    const FaceArea& a = shadows.areas[k];
    ASSERT_EQ(a.area, width) << "sheet " << level[k];
    ASSERT_EQ(a.lit, level[k] == 0 ? width : step) << "sheet " << level[k];
    ASSERT_EQ(a.shadowed, width - a.lit) << "sheet " << level[k];
  }
}

TEST(ExtremeSizes, SheetsOneUlpApart) {
  for (const Order order : {Order::as_given, Order::random, Order::solid_angle}) {
    SCOPED_TRACE(static_cast<int>(order));
    check_stack(10000, 4, order, 1);
    // All over each other. The largest first is the nearest last here, or nearly: pieces grow with
    // the square of the number of sheets.
    check_stack(order == Order::solid_angle ? 200 : soaks() ? 10000 : 2000, 100000, order, 2);
  }
}

// A floor of tiles, one half of it under a sheet, in one cell.
void check_tiles(std::uint32_t columns, std::uint32_t rows, Kernel kernel, bool casts) {
  SCOPED_TRACE(text("kernel ", static_cast<int>(kernel), casts ? ", tiles cast" : ""));
  Scene scene;
  const double edge = columns / 2 + 0.5;
  scene.add(sheet(-1, edge, -1, rows + 1, 1), open_sheet());
  Mesh tiles;
  for (std::uint32_t y = 0; y <= rows; ++y) {
    for (std::uint32_t x = 0; x <= columns; ++x) tiles.vertices.emplace_back(x, y, 0);
  }
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::uint32_t a = y * (columns + 1) + x, b = a + columns + 1;
      tiles.add_face({a, a + 1, b + 1, b});
    }
  }
  scene.add(tiles, open_sheet(casts));
  Options options;
  options.kernel = kernel;
  options.tuning.facets_per_cell = 0;
  options.tuning.order = Order::random;
  const Shadows shadows = cast_shadows(scene, straight_down(), options);
  ASSERT_EQ(shadows.stats.cells, 1u);
  ASSERT_EQ(shadows.areas.size(), std::size_t{columns} * rows + 1);
  const double tolerance = kernel == Kernel::fast ? 1e-12 * columns : 0;
  for (std::uint32_t i = 0; i < columns * rows; ++i) {
    const double left = i % columns, lit = std::clamp(left + 1 - edge, 0.0, 1.0);
    ASSERT_NEAR(shadows.areas[i + 1].lit, lit,
                lit == 0 || lit == 1 ? std::min(tolerance, 1e-3) : tolerance)
        << "tile " << i;
    ASSERT_NEAR(shadows.areas[i + 1].shadowed, 1 - lit, tolerance) << "tile " << i;
  }
  EXPECT_EQ(shadows.areas[0].lit, (edge + 1) * (rows + 2));
}

TEST(ExtremeSizes, ManyFacesInOneCell) {
  const std::uint32_t rows = soaks() ? 1000 : 250, columns = soaks() ? 1000 : 400;
  for (const Kernel kernel : {Kernel::fast, Kernel::exact}) {
    check_tiles(columns, rows, kernel, false);
    check_tiles(columns, rows, kernel, true);
  }
}

// As the light sees them, an edge of every sheet lies in one line: of each what reaches beyond all
// above it is lit.
TEST(ExtremeSizes, AllEdgesInOneLine) {
  for (const Kernel kernel : {Kernel::fast, Kernel::exact}) {
    for (const Order order : {Order::as_given, Order::random, Order::solid_angle}) {
      scenes::Random random(5);
      constexpr int count = 1000;
      std::vector<double> x(count);
      Scene scene;
      for (int i = 0; i < count; ++i) {
        x[static_cast<std::size_t>(i)] =
            (random.below(2) ? 1.0 : -1.0) * static_cast<double>(1 + random.below(1 << 20)) / 1024;
        scene.add(sheet(std::min(x[static_cast<std::size_t>(i)], 0.0),
                        std::max(x[static_cast<std::size_t>(i)], 0.0), 0, 1, count - i),
                  open_sheet());
      }
      Options options;
      options.kernel = kernel, options.tuning.order = order;
      const Shadows shadows = cast_shadows(scene, straight_down(), options);
      double farthest[2] = {0, 0};
      for (int i = 0; i < count; ++i) {
        const double at = std::abs(x[static_cast<std::size_t>(i)]);
        double& covered = farthest[x[static_cast<std::size_t>(i)] > 0];
        const double want = std::max(0.0, at - covered),
                     got = shadows.areas[static_cast<std::size_t>(i)].lit;
        covered = std::max(covered, at);
        if (kernel == Kernel::exact) {
          ASSERT_EQ(got, want) << "sheet " << i << ", order " << static_cast<int>(order);
        } else {
          ASSERT_NEAR(got, want, 1e-12 * at)
              << "sheet " << i << ", order " << static_cast<int>(order);
        }
      }
    }
  }
}

// A fan of a thousand triangles round one vertex, under a sheet whose edge crosses it: by clipping,
// and in every order.
TEST(ExtremeSizes, AllFacesShareOneVertex) {
  constexpr std::uint32_t count = 1000;
  constexpr double pi = 3.14159265358979323846;
  Mesh fan;
  fan.vertices.emplace_back(0, 0, 0);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double angle = 2 * pi * i / count;
    fan.vertices.emplace_back(scenes::to_grid(std::cos(angle)), scenes::to_grid(std::sin(angle)),
                              0);
  }
  for (std::uint32_t i = 0; i < count; ++i) fan.add_face({0, 1 + i, 1 + (i + 1) % count});
  constexpr double edge = 0.25;
  Scene scene;
  scene.add(fan, open_sheet());
  scene.add(sheet(edge, 2, -2, 2, 1), open_sheet());
  const auto clipped = [&](std::uint32_t i) {  // the area where x < edge
    std::vector<Vec3> from{fan.vertices[0], fan.vertices[1 + i], fan.vertices[1 + (i + 1) % count]},
        part;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &a = from[k], &b = from[(k + 1) % 3];
      if (a.x() < edge) part.push_back(a);
      if ((a.x() < edge) != (b.x() < edge))
        part.push_back(a + (b - a) * ((edge - a.x()) / (b.x() - a.x())));
    }
    return part.size() < 3 ? 0.0 : polygon_area(part);
  };
  for (const Kernel kernel : {Kernel::fast, Kernel::exact}) {
    for (const Order order : {Order::as_given, Order::random, Order::solid_angle}) {
      for (const std::uint32_t cell : {0u, 128u}) {
        Options options;
        options.kernel = kernel, options.tuning.order = order,
        options.tuning.facets_per_cell = cell;
        const Shadows shadows = cast_shadows(scene, straight_down(), options);
        for (std::uint32_t i = 0; i < count; ++i) {
          ASSERT_NEAR(shadows.areas[i].lit, clipped(i), 1e-13)
              << "triangle " << i << ", kernel " << static_cast<int>(kernel) << ", order "
              << static_cast<int>(order) << ", cell " << cell;
        }
      }
    }
  }
}

// Straight corners off the line by roundings, and as the light sees them the loop turns the wrong
// way behind three of them in one line: it has to be cut there, and was lost whole.
TEST(ExtremeSizes, ANearlyStraightSideIsNoReasonToLoseAFace) {
  Mesh mesh;
  mesh.vertices = {{-0.96946338118376474, 0.29382979467056503, 5.445862547374384},
                   {0.051718777598869003, 1.5382761399964906, 3.5},
                   {-1.1687119755285504, -2.9740666200502952, 8.2500596938440278},
                   {-1.7017218330602164, -2.4135758613575065, 8.2958983636808004},
                   {-1.4576356824347325, -1.5111073093481493, 7.3458864249119946},
                   {-1.2135495318092486, -0.60863875733879214, 6.3958744861431889}};
  mesh.add_face({0, 1, 2, 3, 4, 5});
  const Light light = Light::point({2.6288025820009624, -2.9187873557860682, 5.5065393478184115});
  Scene scene;
  scene.add(mesh, open_sheet());
  const GmpOracle oracle(scene, light);
  ASSERT_TRUE(oracle.defined());
  for (const Kernel kernel : {Kernel::fast, Kernel::exact}) {
    for (const Form form : {Form::pieces, Form::merged, Form::conforming}) {
      Options options;
      options.kernel = kernel, options.form = form;
      const Shadows shadows = cast_shadows(scene, light, options);
      EXPECT_EQ(shadows.areas[0].facing, Facing::toward);
      EXPECT_NEAR(shadows.areas[0].lit, exact_lit_area(oracle, scene.faces()[0]), 1e-12);
      EXPECT_EQ(check_fragments(scene, light, shadows, kAreaTolerance, form), "");
    }
  }
}

// Sheets that all end in one vertex, every which way, over and through each other: the same in
// every order, exactly.
TEST(ExtremeSizes, SheetsOfOneVertexInEveryOrder) {
  scenes::Random random(9);
  Scene scene;
  const std::uint32_t count = soaks() ? 1000 : 150;
  for (std::uint32_t i = 0; i < count; ++i) {
    Mesh triangle;
    triangle.vertices = {Vec3(0.5, 0.25, 0.125), random.in_cube(-1, 1), random.in_cube(-1, 1)};
    triangle.add_face({0, 1, 2});
    scene.add(triangle, open_sheet());
  }
  for (const Light& light :
       {straight_down(), Light::point({0.5, 0.25, 4}), Light::point({0.125, -0.5, 3})}) {
    Options options;
    options.kernel = Kernel::exact;
    const Shadows first = cast_shadows(scene, light, options);
    EXPECT_GT(first.stats.shadowed_area, 0);
    for (const Order order : {Order::as_given, Order::random}) {
      options.tuning.order = order, options.tuning.seed = 3,
      options.tuning.facets_per_cell = order == Order::random ? 0 : 16;
      EXPECT_EQ(check_same_areas(scene, first, cast_shadows(scene, light, options), 1e-13), "")
          << static_cast<int>(order);
    }
  }
}

// Mesh import: the ends of double's range, zeros of both signs and what is no number, among faces
// of everyday size. Whatever is emitted is finite, and the everyday faces, out of the others'
// way, are what they are alone.
TEST(ExtremeNumbers, OddObjectsHarmNoOther) {
  constexpr double infinity = std::numeric_limits<double>::infinity(),
                   nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double least = std::numeric_limits<double>::denorm_min(),
                   most = std::numeric_limits<double>::max();
  const auto everyday = [](Scene& scene) {
    scene.add(sheet(0, 4, 0, 4, 0), open_sheet());
    scene.add(sheet(1, 2, 1, 3, 1), open_sheet());
    scene.add(scenes::box({2.5, 2.5, 0}, {3, 3, 2}), {});
  };
  const auto sized = [](double size, const Vec3& at) {
    Mesh mesh;
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}})
      mesh.vertices.emplace_back(at + size * Vec3(x, y, 0));
    mesh.add_face({0, 1, 2, 3});
    mesh.add_face({0, 1, 2});
    return mesh;
  };
  std::vector<std::pair<std::string, Mesh>> odd;
  const Vec3 aside(-10, -10, -5);
  for (const double size : {1e-310, least, 4 * least, 1e-308, 1e-200, 1e-160, 1e-100, 1e-30, 1e30,
                            1e100, 1e150, 1e153, 1e160, 1e200, 1e300, 1e308, most})
    odd.emplace_back(text("size ", size), sized(-size, size < 1 ? Vec3(Vec3::Zero()) : aside));
  for (const double bad : {infinity, -infinity, nan}) {
    for (int axis = 0; axis < 3; ++axis) {
      Mesh mesh = sized(1, aside);
      mesh.vertices[2][axis] = bad;
      odd.emplace_back(text("coordinate ", bad), mesh);
    }
  }
  {
    Mesh mesh;  // differences overflow
    mesh.vertices = {
        {-1e308, -1e308, -5}, {1e308, -1e308, -5}, {1e308, 1e308, -5}, {-1e308, 1e308, -5}};
    mesh.add_face({0, 1, 2, 3});
    odd.emplace_back("differences overflow", mesh);
  }
  {
    Mesh mesh;  // thin and endless
    mesh.vertices = {
        {-1e300, -20, -5}, {-10, -20, -5}, {-10, -20 + 1e-10, -5}, {-1e300, -20 + 1e-10, -5}};
    mesh.add_face({0, 1, 2, 3});
    odd.emplace_back("a thread", mesh);
  }
  {
    Mesh mesh = sized(1, aside);
    for (Vec3& v : mesh.vertices)
      v += Vec3(10, 10, 5), v = v.unaryExpr([](double c) { return c == 0 ? -0.0 : c; });
    for (Vec3& v : mesh.vertices) v += Vec3(-0.0, -20, -0.0);
    odd.emplace_back("negative zeros", mesh);
  }
  for (const Light& light : {straight_down(), Light::point({1.5, 2, 8})}) {
    for (const Kernel kernel : {Kernel::fast, Kernel::exact}) {
      for (const Form form : {Form::pieces, Form::merged, Form::conforming}) {
        for (const bool edits : {false, true}) {
          Options options;
          options.kernel = kernel, options.form = form, options.tuning.incremental = edits,
          options.threads = 1;
          Scene alone;
          everyday(alone);
          const std::uint32_t count = static_cast<std::uint32_t>(alone.faces().size());
          const Shadows want = cast_shadows(alone, light, options);
          for (const auto& [name, mesh] : odd) {
            SCOPED_TRACE(text(name, ", kernel ", static_cast<int>(kernel), ", light ",
                              static_cast<int>(light.kind), ", ", describe(options)));
            Scene scene;
            everyday(scene);
            scene.add(mesh, open_sheet());
            scene.add(light);
            for (std::uint32_t f = count; f < scene.faces().size(); ++f) {
              bool finite = true;
              for (const std::uint32_t v : mesh.loop(f - count, 0))
                finite = finite && mesh.vertices[v].allFinite();
              if (!finite) {
                EXPECT_EQ(scene.faces()[f].facet_count, 0u) << "a face that is not finite";
              }
              EXPECT_TRUE(std::isfinite(scene.faces()[f].area)) << "area " << scene.faces()[f].area;
            }
            for (const Issue& issue : scene.issues()) EXPECT_EQ(issue.object, 3u);
            Engine engine(scene, options);
            engine.update();
            const Shadows& got = engine.shadows(0);
            const UncertainArea uncertain = engine.uncertain_area(0);
            for (const double u : uncertain) EXPECT_GE(u, 0);  // no NaN
            for (const Block& block : got.blocks) {
              for (const Vec3& c : block.corners)
                EXPECT_TRUE(c.allFinite()) << "corner " << c.transpose();
              for (const Fragment& f : block.fragments)
                EXPECT_TRUE(std::isfinite(f.area) && f.area >= 0)
                    << "face " << f.face << ": " << f.area;
            }
            for (std::uint32_t f = 0; f < got.areas.size(); ++f) {
              const FaceArea& a = got.areas[f];
              EXPECT_TRUE(std::isfinite(a.area) && std::isfinite(a.lit) &&
                          std::isfinite(a.shadowed))
                  << "face " << f;
              if (f >= count) continue;
              EXPECT_EQ(a.facing, want.areas[f].facing) << "face " << f;
              EXPECT_NEAR(a.lit, want.areas[f].lit, uncertain[f] + 1e-12) << "face " << f;
            }
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace shadowcut::testing
