// The exact oracle and the checks that rest on it: whoever guards the exact kernel must be right
// first. The oracle against areas known by hand, against the older oracle, and, point by point,
// against the definition tested in space; the checks against partitions made from the oracle's own
// parts, which they must accept, and against the same with one thing wrong, which they must not.
//
// SHADOWCUT_SOAK=n decides points in about n random scenes instead of a thousand.
#include "gmp_oracle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "cgal_oracle.hpp"
#include "exact_checks.hpp"
#include "exact_scenes.hpp"
#include "oracle_partition.hpp"
#include "random_scenes.hpp"

namespace shadowcut::testing {
namespace {

using scenes::Random;
using scenes::rectangle;
using Role = GmpOracle::Role;
using State = GmpOracle::State;

std::uint32_t add(Scene& scene, const Mesh& mesh, Sides sides = Sides::open) {
  ObjectSettings settings;
  settings.sides = sides;
  const std::uint32_t object = scene.add(mesh, settings).index;
  return scene.objects()[object].first_facet;
}

Rational lit_area(const GmpOracle& oracle, std::uint32_t facet) {
  return oracle.area(facet, oracle.lit(facet));
}
Rational whole_area(const GmpOracle& oracle, std::uint32_t facet) {
  return oracle.area(facet, oracle.whole(facet));
}

TEST(GmpOracle, SquareHalfwayUpShadowsFourTimesItsArea) {
  Scene scene;
  const auto ground = add(scene, rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}));
  const auto square = add(scene, rectangle({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}));
  const GmpOracle oracle(scene, Light::point({0, 0, 2}));
  EXPECT_EQ(whole_area(oracle, ground), 64);
  EXPECT_EQ(lit_area(oracle, ground), 64 - 16);
  EXPECT_EQ(lit_area(oracle, square), 4);
}

TEST(GmpOracle, SunCastsABoxesOwnShape) {
  Scene scene;
  const auto ground = add(scene, rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}));
  const auto box = add(scene, scenes::box({-0.5, -0.5, 0}, {0.5, 0.5, 1}), Sides::closed);
  const GmpOracle oracle(scene, Light::directional({1, 0, -1}));
  // the roof's shadow and, under the box, the sunny wall's: the bottom does not cast
  EXPECT_EQ(lit_area(oracle, ground), 64 - 2);
  EXPECT_EQ(oracle.role(box), Role::away);  // the bottom
  EXPECT_EQ(oracle.role(box + 1), Role::takes_part);
  EXPECT_EQ(lit_area(oracle, box + 1), 1);
  EXPECT_EQ(oracle.role(box + 2), Role::edge_on);
}

TEST(GmpOracle, CrossingSheetsShadowEachOtherInPart) {
  Scene scene;
  const auto flat = add(scene, rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}));
  const auto steep = add(scene, rectangle({-1, -0.5, -1}, {0, 1, 0}, {2, 0, 2}));
  for (const double down : {-1.0, 1.0}) {
    const GmpOracle oracle(scene, Light::directional({0, 0, down}));
    EXPECT_EQ(lit_area(oracle, flat), 3);
    EXPECT_EQ(2 * lit_area(oracle, steep), whole_area(oracle, steep));
    EXPECT_EQ(oracle.front(flat), down < 0);
  }
}

TEST(GmpOracle, ContactIsNotOcclusion) {
  Scene scene;
  const auto wall = add(scene, rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
  const auto poster = add(scene, rectangle({1, 1, 0}, {1, 0, 0}, {0, 1, 0}));
  const auto raised = add(
      scene, rectangle({2, 1, std::numeric_limits<double>::denorm_min()}, {1, 0, 0}, {0, 1, 0}));
  const GmpOracle oracle(scene, Light::directional({0, 0, -1}));
  EXPECT_EQ(lit_area(oracle, wall), 15);  // one denormal number is no contact
  EXPECT_EQ(lit_area(oracle, poster), 1);
  EXPECT_EQ(lit_area(oracle, raised), 1);
}

// Light arrives along the line on which a sheet stands, however it is shadowed on both sides of it;
// so no place on the line tells of either.
TEST(GmpOracle, WhereACasterMeetsTheReceiverIsABoundary) {
  Scene scene;
  const auto wall = add(scene, rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
  add(scene, rectangle({1, 1, 0}, {2, 0, 2}, {0, 2, 0}));
  add(scene, rectangle({1, 1, 0}, {0, 2, 0}, {-1, 0, 1}));
  add(scene, rectangle({2, 0, 0}, {1, 0, 0}, {0, 1, 0}));  // in its plane
  const GmpOracle oracle(scene, Light::directional({0, 0, -1}));
  const auto state_at = [&](double x, double y) {
    return oracle.state_at(wall, oracle.place(wall, oracle.ray({x, y, 0})));
  };
  EXPECT_EQ(state_at(0.5, 1.5), State::shadowed);
  EXPECT_EQ(state_at(1, 1.5), State::on_boundary);
  EXPECT_EQ(state_at(1.5, 1.5), State::shadowed);
  EXPECT_EQ(state_at(1, 0.5), State::lit);
  EXPECT_EQ(state_at(2.5, 0.5), State::lit);
}

TEST(GmpOracle, LightInThePlaneSeesItEdgeOn) {
  Scene scene;
  const auto square = add(scene, rectangle({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
  EXPECT_EQ(GmpOracle(scene, Light::point({8, 1, 0})).role(square), Role::edge_on);
  EXPECT_EQ(GmpOracle(scene, Light::point({8, 1, 1e-300})).role(square), Role::takes_part);
  EXPECT_EQ(GmpOracle(scene, Light::directional({1, 1, 0})).role(square), Role::edge_on);
  EXPECT_TRUE(GmpOracle(scene, Light::directional({1, 1, -1e-300})).front(square));
  EXPECT_FALSE(GmpOracle(scene, Light::directional({1, 1, 1e-300})).front(square));
}

// A quadrilateral that is flat within the scene's tolerance only. From nearly beside it, its lifted
// corner is seen anywhere.
TEST(GmpOracle, LoopsAreAsTheLightSeesThem) {
  constexpr double lift = 1e-7;
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, lift}, {0, 1, 0}};
  mesh.add_face({0, 1, 2, 3});
  Scene scene;
  const auto quad = add(scene, mesh);
  const GmpOracle above(scene, Light::directional({0, 0, -1}));
  EXPECT_EQ(above.parts(quad).size(), 1u);
  EXPECT_EQ(whole_area(above, quad), 1);
  // the corner is seen at (0.2, 0.2)
  const GmpOracle reflex(scene, Light::directional({1, 1, lift / 0.8}));
  ASSERT_TRUE(reflex.defined());
  EXPECT_EQ(reflex.parts(quad).size(), 2u);
  EXPECT_NEAR(whole_area(reflex, quad).get_d(), 1, 1e-6);
  // at (-0.5, 1): two edges cross
  EXPECT_FALSE(GmpOracle(scene, Light::directional({1, 0, lift / 1.5})).defined());
}

// The two know nothing of each other; where planes do not nearly touch, which in these kinds they
// do not, they agree.
TEST(GmpOracle, AgreesWithTheOlderOracle) {
  int compared = 0;
  for (const Kind kind :
       {Kind::soup, Kind::grid_soup, Kind::solids, Kind::grid_boxes, Kind::outlines}) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const scenes::SceneData data = random_scene(kind, seed);
      SCOPED_TRACE(data.name);
      const Scene scene = scenes::build(data);
      const GmpOracle exact(scene, data.light);
      if (!exact.defined()) continue;
      const CgalOracle older(scene, data.light, true);
      for (std::uint32_t i = 0; i < scene.faces().size(); ++i) {
        const Face& face = scene.faces()[i];
        const CgalOracle::Area area = older.area(i);
        if (area.facing != Facing::toward || area.unsure) continue;
        double lit = 0, all = 0;
        for (std::uint32_t f = face.first_facet; f < face.first_facet + face.facet_count; ++f) {
          lit += lit_area(exact, f).get_d() * exact.stretch(f).second;
          all += whole_area(exact, f).get_d() * exact.stretch(f).second;
        }
        EXPECT_NEAR(lit, area.lit, 1e-9 * area.area) << "face " << i;
        EXPECT_NEAR(all, area.area, 1e-9 * area.area) << "face " << i;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 300);
}

int side_of(const Part& part, const Triple& ray) {  // least sign of its lines at the ray
  int least = 1;
  for (const Triple& line : part.lines) least = std::min(least, sign_of_dot(line, ray));
  return least;
}

class OfExactKind : public ::testing::TestWithParam<ExactKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, OfExactKind, ::testing::ValuesIn(kAllExactKinds),
                         [](const auto& info) { return name_of(info.param); });

// Regions come from light space, points are decided in space.
TEST_P(OfExactKind, RandomPointsAgreeWithRegions) {
  std::uint64_t decided = 0, lit = 0, defined = 0;
  const char* soak = std::getenv("SHADOWCUT_SOAK");
  const std::uint64_t scene_count =
      soak ? std::strtoull(soak, nullptr, 10) / std::size(kAllExactKinds) + 1 : 60;
  for (std::uint64_t seed = 0; seed < scene_count; ++seed) {
    const ExactScene made = exact_scene(GetParam(), seed);
    const Scene scene = build(made);
    const GmpOracle oracle(scene, made.light);
    if (!oracle.defined()) continue;
    ++defined;
    Random random(seed);
    for (std::uint32_t f = 0; f < scene.facets().size(); ++f) {
      for (const Part& part : oracle.parts(f)) {
        for (int k = 0; k < 20; ++k) {
          Triple ray;
          for (const Triple& corner : part.corners) {
            const unsigned long weight = random.below(1000);
            for (std::size_t i = 0; i < 3; ++i) ray[i] += corner[i] * weight;
          }
          const State state = oracle.state_at(f, oracle.place(f, ray));
          int most = -1;
          for (const Part& p : oracle.lit_parts(f)) most = std::max(most, side_of(p, ray));
          if (state == State::on_boundary || most == 0 || side_of(part, ray) <= 0) continue;
          ASSERT_EQ(state == State::lit, most > 0) << "seed " << seed << ", facet " << f << '\n'
                                                   << describe(made);
          ++decided;
          lit += state == State::lit;
        }
      }
    }
  }
  EXPECT_GT(defined, scene_count / 3);
  EXPECT_GT(decided, 500);
  EXPECT_GT(lit, decided / 20);
  EXPECT_LT(lit, decided);
}

// By fans of triangles, a fraction each.
Rational plain_area(const GmpOracle& oracle, std::uint32_t facet, const std::vector<Part>& parts) {
  const int axis = oracle.stretch(facet).first;
  const auto i = static_cast<std::size_t>((axis + 1) % 3),
             j = static_cast<std::size_t>((axis + 2) % 3);
  Rational sum;
  for (const Part& part : parts) {
    std::vector<std::array<Rational, 2>> at;
    for (const Triple& corner : part.corners) {
      const Place p = oracle.place(facet, corner);
      at.push_back({Rational(p.n[i], p.d), Rational(p.n[j], p.d)});
      for (Rational& x : at.back()) x.canonicalize();
    }
    for (std::size_t k = 2; k < at.size(); ++k)
      sum += (at[k - 1][0] - at[0][0]) * (at[k][1] - at[0][1]) -
             (at[k - 1][1] - at[0][1]) * (at[k][0] - at[0][0]);
  }
  return abs(sum);
}

// A region's area from its boundary is that of its parts, as fractions (here only up to the unit,
// which the ratio does not see).
TEST_P(OfExactKind, AreaFromTheBoundaryIsTheSumOfParts) {
  for (std::uint64_t seed = 100; seed < 110; ++seed) {
    const ExactScene made = exact_scene(GetParam(), seed);
    const Scene scene = build(made);
    const GmpOracle oracle(scene, made.light);
    if (!oracle.defined()) continue;
    for (std::uint32_t f = 0; f < scene.facets().size(); ++f) {
      if (oracle.role(f) != Role::takes_part) continue;
      const Rational whole = plain_area(oracle, f, oracle.parts(f)),
                     lit = plain_area(oracle, f, oracle.lit_parts(f));
      ASSERT_EQ(lit_area(oracle, f) * whole, whole_area(oracle, f) * lit)
          << "seed " << seed << ", facet " << f;
      ASSERT_EQ(oracle.lit(f).empty(), lit == 0);
      ASSERT_EQ(oracle.lit(f) == oracle.whole(f), lit == whole);
    }
  }
}

TEST_P(OfExactKind, ChecksAcceptTheOraclesOwnPartition) {
  for (std::uint64_t seed = 200; seed < 230; ++seed) {
    const ExactScene made = exact_scene(GetParam(), seed);
    const Scene scene = build(made);
    const GmpOracle oracle(scene, made.light);
    if (!oracle.defined()) continue;
    ASSERT_EQ(check_exact(oracle, Partition(oracle).take(), Form::merged), "")
        << "seed " << seed << '\n'
        << describe(made);
  }
}

// One wrong thing at a time.
struct Mistake {
  const char* name;
  bool (*make)(Shadows&, Random&, const GmpOracle&);  // false: cannot be made here
};

Fragment& some_fragment(Block& block, Random& random) {
  return block.fragments[random.below(block.fragments.size())];
}

// A corner that is not a vertex.
std::optional<std::size_t> some_cut_corner(const Block& block, Random& random) {
  for (int k = 0; k < 100; ++k) {
    const std::size_t i = random.below(block.corners.size());
    if (block.constructions[i].vertex == invalid_index) return i;
  }
  return {};
}

const Mistake kMistakes[] = {
    {"state",
     [](Shadows& s, Random& random, const GmpOracle&) {
       Fragment& f = some_fragment(s.blocks[0], random);
       f.lit = !f.lit;
       return true;
     }},
    {"missing",
     [](Shadows& s, Random& random, const GmpOracle&) {
       s.blocks[0].fragments.erase(
           s.blocks[0].fragments.begin() +
           static_cast<std::ptrdiff_t>(random.below(s.blocks[0].fragments.size())));
       return true;
     }},
    {"twice",
     [](Shadows& s, Random& random, const GmpOracle&) {
       s.blocks[0].fragments.push_back(some_fragment(s.blocks[0], random));
       return true;
     }},
    {"clockwise",
     [](Shadows& s, Random& random, const GmpOracle&) {
       Block& b = s.blocks[0];
       const Fragment& f = some_fragment(b, random);
       std::reverse(b.corners.begin() + f.first_corner,
                    b.corners.begin() + f.first_corner + f.corner_count);
       std::reverse(b.constructions.begin() + f.first_corner,
                    b.constructions.begin() + f.first_corner + f.corner_count);
       return true;
     }},
    {"three ulps",
     [](Shadows& s, Random& random, const GmpOracle&) {
       const auto i = some_cut_corner(s.blocks[0], random);
       if (!i) return false;
       double& x = s.blocks[0].corners[*i][static_cast<Eigen::Index>(random.below(3))];
       for (int k = 0; k < 3; ++k) x = std::nextafter(x, std::numeric_limits<double>::infinity());
       return true;
     }},
    {"one ulp off a vertex",
     [](Shadows& s, Random& random, const GmpOracle&) {
       Block& b = s.blocks[0];
       const Fragment& f = some_fragment(b, random);
       for (std::uint32_t k = f.first_corner; k < f.first_corner + f.corner_count; ++k) {
         if (b.constructions[k].vertex == invalid_index) continue;
         b.corners[k].x() = std::nextafter(b.corners[k].x(), 0.0) == b.corners[k].x()
                                ? 1e-300
                                : std::nextafter(b.corners[k].x(), 0.0);
         return true;
       }
       return false;
     }},
    {"another line",
     [](Shadows& s, Random& random, const GmpOracle& oracle) {
       Block& b = s.blocks[0];
       const Fragment& f = some_fragment(b, random);
       Construction& c = b.constructions[f.first_corner + random.below(f.corner_count)];
       const auto i = some_cut_corner(b, random);
       if (!i || c.vertex != invalid_index) return false;
       const auto before = ray_of(oracle, f.facet, c);
       c.in = b.constructions[*i].in;
       return ray_of(oracle, f.facet, c) != before;
     }},
    {"facing",
     [](Shadows& s, Random& random, const GmpOracle&) {
       FaceArea& a = s.areas[random.below(s.areas.size())];
       a.facing = a.facing == Facing::toward ? Facing::away : Facing::toward;
       return true;
     }},
};

TEST(ExactChecks, SeeEveryMistake) {
  for (const Mistake& mistake : kMistakes) {
    int made_so_often = 0;
    for (std::uint64_t seed = 300; seed < 400; ++seed) {
      const ExactScene made = exact_scene(seed % 2 ? ExactKind::grid : ExactKind::soup, seed);
      const Scene scene = build(made);
      const GmpOracle oracle(scene, made.light);
      if (!oracle.defined()) continue;
      Shadows shadows = Partition(oracle).take();
      Random random(seed);
      if (shadows.blocks[0].fragments.empty() || !mistake.make(shadows, random, oracle)) continue;
      ++made_so_often;
      EXPECT_NE(check_exact(oracle, shadows, Form::merged), "")
          << mistake.name << ", seed " << seed << '\n'
          << describe(made);
    }
    EXPECT_GT(made_so_often, 20) << mistake.name;
  }
}

TEST(ExactChecks, OneUlpIsOneUlp) {
  Scene scene;
  const auto ground = add(scene, rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}));
  add(scene, rectangle({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}));
  const GmpOracle oracle(scene, Light::point({0, 0, 3}));
  Place third{{Int(1), Int(0), Int(-1)}, 3};
  const double up = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(within_one_ulp(oracle, third, 0, 1.0 / 3));
  EXPECT_TRUE(within_one_ulp(oracle, third, 0, std::nextafter(1.0 / 3, up)));
  // beyond it lies a third already
  EXPECT_FALSE(within_one_ulp(oracle, third, 0, std::nextafter(1.0 / 3, 0)));
  EXPECT_FALSE(within_one_ulp(oracle, third, 0, -1.0 / 3));
  EXPECT_TRUE(within_one_ulp(oracle, third, 1, 0));
  EXPECT_TRUE(within_one_ulp(oracle, third, 1, std::numeric_limits<double>::denorm_min()));
  EXPECT_FALSE(within_one_ulp(oracle, third, 1, 2 * std::numeric_limits<double>::denorm_min()));
  EXPECT_TRUE(within_one_ulp(oracle, third, 2, -1.0 / 3));
  EXPECT_FALSE(within_one_ulp(oracle, third, 2, std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(oracle.role(ground), Role::takes_part);
}

}  // namespace
}  // namespace shadowcut::testing
