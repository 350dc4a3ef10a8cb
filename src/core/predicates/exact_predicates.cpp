#include "predicates/exact_predicates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "numbers/exact_numbers.hpp"
#include "support/assert.hpp"

namespace shadowcut {

// The formulas, for any kind of number. Coordinates are multiplied by `unit`, a power of two.
template <class N>
struct ExactPredicates::Space {
  using V = std::array<N, 3>;
  const ExactPredicates& light;
  double unit;

  static N dot(const V& a, const V& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  static V cross(const V& a, const V& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  static V times(int sign, const V& a) {
    if (sign > 0) return a;
    return {N() - a[0], N() - a[1], N() - a[2]};
  }
  // x, y, z: the world's axes, for a directional light permuted so that z is its largest component.
  V position(const Vec3& p) const {
    return {N(p[light.axis_[0]] * unit), N(p[light.axis_[1]] * unit), N(p[light.axis_[2]] * unit)};
  }
  V apart(const Vec3& a, const Vec3& b) const {
    V out;
    for (std::size_t i = 0; i < 3; ++i)
      out[i] = N::difference(a[light.axis_[i]] * unit, b[light.axis_[i]] * unit);
    return out;
  }
  V direction(const Vec3& d) const {
    return {N(d[light.axis_[0]]), N(d[light.axis_[1]]), N(d[light.axis_[2]])};
  }
  V direction() const { return direction(light.light_); }
  int sign_z() const { return light.light_[light.axis_[2]] > 0 ? 1 : -1; }
  // Along the light's direction onto the plane z = 0; times d_z.
  static std::array<N, 2> sheared(const V& p, const V& d) {
    return {p[0] * d[2] - p[2] * d[0], p[1] * d[2] - p[2] * d[1]};
  }

  V ray(const Vec3& x) const {
    if (light.point_) return apart(x, light.light_);
    const V d = direction();
    const auto [u, v] = sheared(position(x), d);
    return times(sign_z(), {u, v, d[2]});
  }

  // A plane's covector is numerator / denominator.
  V numerator(const Vec3& normal, const Vec3& point) const {
    const V m = direction(normal);
    if (light.point_) return m;
    return {m[0], m[1], N() - dot(m, position(point))};
  }
  N denominator(const Vec3& normal, const Vec3& point) const {
    return dot(direction(normal), light.point_ ? apart(point, light.light_) : direction());
  }
  V difference(const Vec3& m, const Vec3& p, const Vec3& n, const Vec3& q) const {
    const V a = numerator(m, p), b = numerator(n, q);
    const N k = denominator(m, p), l = denominator(n, q);
    if constexpr (std::is_same_v<N, Tracked>) {
      if (!k.is_sure() || !l.is_sure()) return {N::unknown(), N::unknown(), N::unknown()};
    }
    return times(k.sign() * l.sign(),
                 {a[0] * l - b[0] * k, a[1] * l - b[1] * k, a[2] * l - b[2] * k});
  }

  // For a directional light ray(a) x ray(b) has the factor |d_z|. Without the factor it is the
  // plane through the edge along d.
  V line(const LightLine& l) const {
    if (l.crossing) return difference(l.v[0], l.v[1], l.v[2], l.v[3]);
    if (light.point_) return times(light.handed_, cross(ray(l.v[0]), ray(l.v[1])));
    const V n = cross(apart(l.v[0], l.v[1]), direction());
    return times(sign_z(), {n[0], n[1], N() - dot(n, position(l.v[0]))});
  }
  // The line's value at a vertex. For an edge it is a volume, measured from the end of the edge:
  // for points along one axis it is then an exact zero.
  N value(const LightLine& l, const Vec3& x) const {
    if (l.crossing) return dot(line(l), ray(x));
    const N volume = dot(light.point_ ? apart(l.v[0], light.light_) : direction(),
                         cross(apart(l.v[1], l.v[0]), apart(x, l.v[0])));
    return (light.point_ ? light.handed_ : sign_z()) > 0 ? volume : N() - volume;
  }
  V corner(const ExactCorner& c) const {
    if (c.vertex) return times(c.opposite ? -1 : 1, ray(*c.vertex));
    return times((c.in_negative == c.out_negative ? 1 : -1) * light.handed_,
                 cross(line(*c.in), line(*c.out)));
  }

  // Where a corner's ray meets a plane: a numerator for each coordinate, in units, and their
  // denominator.
  N meet(const Plane& plane, const V& r, V& numerators) const {
    const V m = direction(plane.exact_normal);
    if (light.point_) {
      const N along = dot(m, r), k = dot(m, apart(plane.point, light.light_));
      const V at = position(light.light_);
      for (std::size_t i = 0; i < 3; ++i) numerators[i] = at[i] * along + r[i] * k;
      return along;
    }
    const V d = direction();
    const N slope = dot(m, d),
            rest = dot(m, position(plane.point)) * r[2] - m[0] * r[0] - m[1] * r[1];
    numerators = {r[0] * slope + d[0] * rest, r[1] * slope + d[1] * rest, d[2] * rest};
    return r[2] * slope;
  }

  // In the frame of the light space, up to a positive factor.
  V framed(const V& r) const {
    if (!light.frame_.far) return r;
    const auto& axis = light.frame_.axis;
    const auto at = [&](const Vec3& p) {
      return V{N(p[axis[0]] * unit), N(p[axis[1]] * unit), N(p[axis[2]] * unit)};
    };
    const N scale(light.frame_.scale * unit);
    if (light.point_) {
      const V e = {r[static_cast<std::size_t>(axis[0])], r[static_cast<std::size_t>(axis[1])],
                   r[static_cast<std::size_t>(axis[2])]};
      const V c = at(light.frame_.center), l = at(light.light_),
              d = {c[0] - l[0], c[1] - l[1], c[2] - l[2]};
      const auto [u, v] = sheared(e, d);
      return times(d[2].sign(), {u, v, e[2] * scale});
    }
    const V d = direction();
    const auto [u, v] = sheared(at(light.frame_.center), d);
    return times(sign_z(), {r[0] * d[2] - u * r[2], r[1] * d[2] - v * r[2], r[2] * d[2] * scale});
  }
};

namespace {

// Up to eleven factors (seven where no two planes cross), of 53 digits each, have to stay within
// double's range to the last digit.
constexpr double smallest_with_crossings = 0x1p-52, smallest_without = 0x1p-90,
                 largest_allowed = 0x1p60;

bool crosses(const ExactCorner& c) { return !c.vertex && (c.in->crossing || c.out->crossing); }

}  // namespace

ExactPredicates::ExactPredicates(const Light& light, const LightSpace& space)
    : point_(light.kind == Light::Kind::point),
      light_(point_ ? light.position : light.direction),
      frame_(space.frame()) {
  for (std::size_t i = 0; i < 3; ++i) axis_[i] = point_ ? static_cast<int>(i) : frame_.axis[i];
  if (point_) {
    unit_ = 1 / frame_.scale;
    handed_ = frame_.far && frame_.sign < 0 ? -1 : 1;
    note(light_, unit_);
    note(frame_.center, unit_);
  } else {
    int exponent;
    std::frexp(light_[axis_[2]], &exponent);
    const Vec3 scaled = light_.unaryExpr([exponent](double c) { return std::ldexp(c, -exponent); });
    // Only if no digit was lost.
    if (scaled.unaryExpr([exponent](double c) { return std::ldexp(c, exponent); }) == light_)
      light_ = scaled;
    unit_ = 1 / frame_.scale;
    note(light_, 1);
    note(frame_.center, unit_);
  }
}

void ExactPredicates::note(const Vec3& v, double unit) {
  for (int i = 0; i < 3; ++i) {
    if (v[i] == 0) continue;
    SHADOWCUT_ASSERT(std::isfinite(v[i]) && unit > 0);
    const double size = std::abs(v[i] * unit);
    smallest_ = std::min(smallest_, size), largest_ = std::max(largest_, size);
  }
}

// Answers a question with the cheapest number type that is exact.
template <class Question>
auto ExactPredicates::ask(bool crossing, const Question& question) const {
  if (is_tame(crossing)) return question(Space<Expansion>{*this, unit_});
  return question(Space<Wide>{*this, 1.0});
}

bool ExactPredicates::is_tame(bool crossing) const {
  return smallest_ >= (crossing ? smallest_with_crossings : smallest_without) &&
         largest_ <= largest_allowed;
}

// Where the answer is a sign, two doubles often decide it.
template <class Question>
int ExactPredicates::sign_of(bool crossing, const Question& question) const {
  if (is_tame(crossing)) {
    const Tracked number = question(Space<Tracked>{*this, unit_});
    if (number.is_sure()) return number.sign();
  }
  return ask(crossing, [&](const auto& s) { return question(s).sign(); });
}

int ExactPredicates::side(const LightLine& line, const ExactCorner& corner) const {
  SHADOWCUT_ASSERT(corner.vertex || (corner.in && corner.out));
  if (corner.vertex) {
    const int sign =
        sign_of(line.crossing, [&](const auto& s) { return s.value(line, *corner.vertex); });
    return corner.opposite ? -sign : sign;
  }
  return sign_of(line.crossing || crosses(corner),
                 [&](const auto& s) { return s.dot(s.line(line), s.corner(corner)); });
}

bool ExactPredicates::contains(const Plane& p, const Vec3& x) const {
  return x == p.point || sign_of(false, [&](const auto& s) {
                           return s.dot(s.direction(p.exact_normal), s.apart(x, p.point));
                         }) == 0;
}

int ExactPredicates::nearer(const Plane& p, const Plane& q, const ExactCorner& corner) const {
  // At a vertex that p contains, only the vertex's side of q is open: whether the ray meets q
  // behind the vertex.
  if (corner.vertex && !corner.opposite && contains(p, *corner.vertex)) {
    const Vec3& x = *corner.vertex;
    const int side = x == q.point ? 0 : sign_of(false, [&](const auto& s) {
      return s.dot(s.direction(q.exact_normal), s.apart(q.point, x));
    });
    return side == 0 ? 0 : -orientation(q) * side;
  }
  return sign_of(true, [&](const auto& s) {
    return s.dot(s.difference(p.exact_normal, p.point, q.exact_normal, q.point), s.corner(corner));
  });
}

int ExactPredicates::orientation(const Plane& p) const {
  return -sign_of(false, [&](const auto& s) { return s.denominator(p.exact_normal, p.point); });
}

int ExactPredicates::ahead(const Plane& p, const Vec3& x) const {
  if (!point_) return 1;
  return -orientation(p) * sign_of(false, [&](const auto& s) {
    return s.dot(s.direction(p.exact_normal), s.ray(x));
  });
}

bool ExactPredicates::is_null(const LightLine& line) const {
  return ask(line.crossing, [&](const auto& s) {
    const auto n = s.line(line);
    return n[0].sign() == 0 && n[1].sign() == 0 && n[2].sign() == 0;
  });
}

VertexRay ExactPredicates::ray(const ExactCorner& corner) const {
  return ask(true, [&](const auto& s) {
    const auto r = s.framed(s.corner(corner));
    std::size_t largest = 0;
    const auto size = [&](std::size_t i) {
      return r[i].sign() < 0 ? decltype(r[i] - r[i])() - r[i] : r[i];
    };
    for (std::size_t i = 1; i < 3; ++i) {
      if ((size(i) - size(largest)).sign() > 0) largest = i;
    }
    VertexRay out{};
    for (std::size_t i = 0; i < 3; ++i) out.r[i] = quotient(r[i], size(largest));
    const double length =
        std::sqrt(out.r[0] * out.r[0] + out.r[1] * out.r[1] + out.r[2] * out.r[2]);
    for (double& c : out.r) c /= length;
    out.error = static_cast<float>(4 * unit_roundoff);
    return out;
  });
}

Vec3 ExactPredicates::point(const Plane& plane, const ExactCorner& corner) const {
  Vec3 out;
  // A plane normal to an axis gives that coordinate without differences of equal numbers.
  const Vec3& m = plane.exact_normal;
  const auto is_given = [&m](int i) { return m[(i + 1) % 3] == 0 && m[(i + 2) % 3] == 0; };
  bool sure = is_tame(true);
  if (sure) {  // two doubles nearly always suffice
    const Space<Tracked> s{*this, unit_};
    typename Space<Tracked>::V n;
    const Tracked d = s.meet(plane, s.corner(corner), n);
    sure = d.error() <= 0x1p-60 * std::abs(d.leading().high);
    for (std::size_t i = 0; i < 3; ++i) {
      const int axis = axis_[i];
      sure = sure && (is_given(axis) || n[i].error() <= 0x1p-60 * std::abs(n[i].leading().high));
      out[axis] =
          is_given(axis) ? plane.point[axis] : quotient(n[i].leading(), d.leading()) / unit_;
    }
  }
  if (sure) return out;
  ask(true, [&](const auto& s) {
    const auto r = s.corner(corner);
    std::remove_const_t<decltype(r)> n;
    const auto d = s.meet(plane, r, n);
    for (std::size_t i = 0; i < 3; ++i)
      out[axis_[i]] = is_given(axis_[i]) ? plane.point[axis_[i]] : quotient(n[i], d) / s.unit;
    return 0;
  });
  return out;
}

void ExactPredicates::note_object(const Scene& scene, const Object& object) {
  for (const Vec3& v : scene.vertices().subspan(object.first_vertex, object.vertex_count))
    note_position(v);
  for (const Facet& f : scene.facets().subspan(object.first_facet, object.facet_count)) {
    if (f.corner_count != 0) note_normal(scene.planes()[f.plane].exact_normal);
  }
}

}  // namespace shadowcut
