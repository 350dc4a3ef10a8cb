// The laws of src/core/exact.hpp, one by one, against rational numbers: on random input, and on
// input made degenerate and then nudged by ulps. SHADOWCUT_SOAK=n asks for about n signs instead of
// some hundred thousand, SHADOWCUT_SEED=k for others, SHADOWCUT_CASE=seed for those of a single
// case.
#include <gmpxx.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "light_vector.hpp"
#include "predicates/exact_predicates.hpp"
#include "scenes.hpp"
#include "settings.hpp"

namespace shadowcut {
namespace {

using Number = mpq_class;
using Triple = std::array<Number, 3>;
using scenes::Random;
using testing::vector_of;

Triple triple(const Vec3& v) { return {Number(v[0]), Number(v[1]), Number(v[2])}; }
Triple minus(const Triple& a, const Triple& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Triple cross(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Number dot(const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

double nudged(Random& random, double x) {
  for (std::uint64_t n = random.below(4); n > 0; --n)
    x = std::nextafter(x, random.below(2) == 0 ? -INFINITY : INFINITY);
  return x;
}

// A light and some points, of which many are in line, in plane, or equal, but for ulps.
struct Case {
  Light light;
  std::vector<Vec3> points;

  Case(Random& random, double scale) {
    const bool on_grid = random.below(2) == 0;
    const auto coordinate = [&] {
      return on_grid ? static_cast<double>(random.below(5)) : random.in(-2, 2);
    };
    const auto any = [&] { return Vec3(coordinate(), coordinate(), coordinate()); };
    light =
        random.below(3) == 0 ? Light::directional(any() - Vec3(2, 2, 2.5)) : Light::point(any());
    for (int i = 0; i < 4; ++i) points.push_back(any());
    points.push_back(0.5 * (points[0] + points[1]));
    points.push_back(0.25 * points[2] + 0.75 * (light.kind == Light::Kind::point
                                                    ? light.position
                                                    : Vec3(points[2] + light.direction)));
    for (Vec3& p : points) {
      if (random.below(2) == 0) p = p.unaryExpr([&](double x) { return nudged(random, x); });
      p *= scale;
    }
    vector_of(light) *= scale;
  }

  LightSpace space() const {
    Eigen::AlignedBox3d box;
    for (const Vec3& p : points) box.extend(p);
    return LightSpace(light, box);
  }
  ExactPredicates exact() const {
    ExactPredicates out(light, space());
    for (const Vec3& p : points) out.note_position(p);
    return out;
  }
  // From the light to x: any point of the ray for a directional one.
  Triple from_light(const Vec3& x) const { return minus(triple(x), triple(vector_of(light))); }
  // What light, a, b and x span.
  int volume(const Vec3& a, const Vec3& b, const Vec3& x) const {
    if (light.kind == Light::Kind::point)
      return sgn(dot(cross(from_light(a), from_light(b)), from_light(x)));
    return sgn(dot(triple(light.direction),
                   cross(minus(triple(b), triple(a)), minus(triple(x), triple(a)))));
  }
  // The sign with which the light space's frame shows it.
  int handed() const {
    const LightSpace::Frame f = space().frame();
    return light.kind == Light::Kind::point ? (f.far && f.sign < 0 ? -1 : 1)
                                            : (f.sign > 0 ? 1 : -1);
  }
  Plane plane(std::size_t i, std::size_t j, std::size_t k) const {
    Plane p{};
    p.exact_normal = (points[j] - points[i]).cross(points[k] - points[i]);
    p.point = points[i];
    return p;
  }
};

LightLine edge(const Vec3& a, const Vec3& b) {
  LightLine out;
  out.v[0] = a, out.v[1] = b;
  return out;
}

ExactCorner at(const Vec3& x) { return {&x, false, nullptr, nullptr, false, false}; }

template <class Body>
void for_cases(double scale, const Body& body) {
  std::uint64_t count = testing::environment("SHADOWCUT_SOAK").value_or(100000) / 16,
                first = testing::environment("SHADOWCUT_SEED").value_or(0) * 1000000;
  if (const auto one = testing::environment("SHADOWCUT_CASE")) first = *one, count = 1;
  for (std::uint64_t seed = first; seed < first + count && !::testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", scale " + std::to_string(scale));
    Random random(seed);
    const Case c(random, scale);
    if (c.light.kind == Light::Kind::point || !c.light.direction.isZero()) body(c, random);
  }
}

void check_volumes(const Case& c) {
  const ExactPredicates exact = c.exact();
  const int handed = c.handed();
  for (const Vec3& x : c.points) {
    EXPECT_EQ(exact.side(edge(c.points[0], c.points[1]), at(x)),
              handed * c.volume(c.points[0], c.points[1], x));
    EXPECT_EQ(exact.side(edge(c.points[2], c.points[4]), at(x)),
              handed * c.volume(c.points[2], c.points[4], x));
  }
}

TEST(Predicates, Law1SideIsTheSignOfTheVolume) {
  for_cases(1, [](const Case& c, Random&) { check_volumes(c); });
}

TEST(Predicates, Law2ZeroAtTheEndsAndAtOnesOwnCuts) {
  for_cases(1, [](const Case& c, Random&) {
    const ExactPredicates exact = c.exact();
    const LightLine l = edge(c.points[0], c.points[1]), m = edge(c.points[2], c.points[3]);
    EXPECT_EQ(exact.side(l, at(c.points[0])), 0);
    EXPECT_EQ(exact.side(l, at(c.points[1])), 0);
    EXPECT_EQ(exact.side(l, {nullptr, false, &l, &m, false, true}), 0);
    EXPECT_EQ(exact.side(m, {nullptr, false, &l, &m, true, true}), 0);
  });
}

TEST(Predicates, Law3TurningAnEdgeRound) {
  for_cases(1, [](const Case& c, Random&) {
    const ExactPredicates exact = c.exact();
    for (const Vec3& x : c.points)
      EXPECT_EQ(exact.side(edge(c.points[0], c.points[1]), at(x)),
                -exact.side(edge(c.points[1], c.points[0]), at(x)));
  });
}

TEST(Predicates, Law4NearerIsTheOtherWayRoundForTheOther) {
  for_cases(1, [](const Case& c, Random&) {
    ExactPredicates exact = c.exact();
    const Plane p = c.plane(0, 1, 2), q = c.plane(3, 4, 5);
    exact.note_normal(p.exact_normal);
    exact.note_normal(q.exact_normal);
    if (exact.orientation(p) == 0 || exact.orientation(q) == 0) return;
    for (const Vec3& x : c.points) {
      const int sign = exact.nearer(p, q, at(x));
      EXPECT_EQ(sign, -exact.nearer(q, p, at(x)));
      EXPECT_EQ(exact.nearer(p, p, at(x)), 0);
      if (c.light.kind != Light::Kind::point) continue;
      const auto nearness = [&](const Plane& plane) {
        const Triple m = triple(plane.exact_normal);
        return Number(dot(m, c.from_light(x)) / dot(m, c.from_light(plane.point)));
      };
      EXPECT_EQ(sign, sgn(Number(nearness(p) - nearness(q))));
    }
  });
}

TEST(Predicates, Law5PowersOfTwoAndExactMovesChangeNothing) {
  for_cases(1, [](const Case& c, Random& random) {
    const ExactPredicates exact = c.exact();
    Case larger = c, moved = c;
    const double factor = std::ldexp(1.0, static_cast<int>(random.below(200)) - 100);
    for (Vec3& p : larger.points) p *= factor;
    vector_of(larger.light) *= factor;
    for (std::size_t i = 0; i < c.points.size(); ++i) {
      if (larger.points[i] / factor != c.points[i]) return;  // a subnormal number lost digits
    }
    const Vec3 by(4, -8, 16);
    bool is_exact =
        c.light.kind == Light::Kind::point && Vec3(c.light.position + by - by) == c.light.position;
    for (Vec3& p : moved.points) {
      is_exact = is_exact && Vec3(p + by - by) == p;
      p += by;
    }
    vector_of(moved.light) += by;
    const LightLine l = edge(c.points[0], c.points[1]);
    for (std::size_t i = 0; i < c.points.size(); ++i) {
      const int sign = exact.side(l, at(c.points[i]));
      EXPECT_EQ(sign, larger.exact().side(edge(larger.points[0], larger.points[1]),
                                          at(larger.points[i])));
      if (!is_exact) continue;
      EXPECT_EQ(sign,
                moved.exact().side(edge(moved.points[0], moved.points[1]), at(moved.points[i])));
    }
  });
}

TEST(Predicates, Law6AtAnyMagnitude) {
  for (const double scale : {1e-300, 1e-30, 1e30, 1e150})
    for_cases(scale, [](const Case& c, Random&) { check_volumes(c); });
}

void check_point(const Case& c) {
  if (c.light.kind != Light::Kind::point) return;
  ExactPredicates exact = c.exact();
  const Plane p = c.plane(0, 2, 3);
  exact.note_normal(p.exact_normal);
  const LightLine l = edge(c.points[0], c.points[1]), m = edge(c.points[2], c.points[4]);
  const Triple r = cross(cross(c.from_light(l.v[0]), c.from_light(l.v[1])),
                         cross(c.from_light(m.v[0]), c.from_light(m.v[1])));
  const Triple n = triple(p.exact_normal);
  const Number along = dot(n, r);
  if (along == 0) return;
  const Number s = dot(n, c.from_light(p.point)) / along;
  const Vec3 x = exact.point(p, {nullptr, false, &l, &m, false, false});
  for (std::size_t i = 0; i < 3; ++i) {
    const Number is = Number(vector_of(c.light)[static_cast<Eigen::Index>(i)]) + r[i] * s;
    const double got = x[static_cast<Eigen::Index>(i)];
    const Number largest(std::numeric_limits<double>::max());
    if (abs(is) >= largest) {
      EXPECT_TRUE(std::abs(got) >= std::numeric_limits<double>::max());
      continue;
    }
    ASSERT_TRUE(std::isfinite(got))
        << "coordinate " << i << " is " << is.get_d() << ", came out as " << got;
    EXPECT_TRUE(is >= Number(std::nextafter(got, -INFINITY)) &&
                is <= Number(std::nextafter(got, INFINITY)))
        << "coordinate " << i << " is " << is.get_d() << ", came out as " << got;
  }
}

TEST(Predicates, Law7PointsAreWithinOneUlp) {
  for (const double scale : {1.0, 1e-30, 1e30})
    for_cases(scale, [](const Case& c, Random&) { check_point(c); });
}

// Coordinate 0 is -2^51, exactly, and its numerator has 1 400 digits in base two.
TEST(Predicates, PointAtMinusAPowerOfTwo) {
  Random random(77269092);
  check_point(Case(random, 1));
}

}  // namespace
}  // namespace shadowcut
