// See gmp_oracle.hpp.
#include "gmp_oracle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace shadowcut::testing {
namespace {

// x = mantissa 2^exponent with an odd mantissa; zero has the greatest exponent.
std::pair<std::int64_t, int> split(double x) {
  if (x == 0) return {0, std::numeric_limits<int>::max()};
  int exponent;
  auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
  exponent -= 53;
  while (mantissa % 2 == 0) mantissa /= 2, ++exponent;
  return {mantissa, exponent};
}

void lower_to(int& unit, const Vec3& v) {
  for (const double x : v) unit = std::min(unit, split(x).second);
}

using Loop = std::vector<std::size_t>;  // into a facet's corners

// Equal neighbours become one.
Loop without_repeats(const std::vector<Triple>& rays) {
  Loop loop;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (loop.empty() || rays[loop.back()] != rays[i]) loop.push_back(i);
  }
  while (loop.size() > 1 && rays[loop.front()] == rays[loop.back()]) loop.pop_back();
  return loop;
}

std::vector<Triple> rays_of(const std::vector<Triple>& rays, const Loop& loop) {
  std::vector<Triple> out;
  for (const std::size_t i : loop) out.push_back(rays[i]);
  return out;
}

bool in_one_line(const std::vector<Triple>& rays, const Loop& loop) {
  for (std::size_t i = 2; i < loop.size(); ++i) {
    for (std::size_t j = 1; j < i; ++j) {
      if (turn(rays[loop[0]], rays[loop[j]], rays[loop[i]]) != 0) return false;
    }
  }
  return true;
}

// Whether two segments have a point in common.
bool meet(const Triple& a, const Triple& b, const Triple& c, const Triple& d) {
  const int c_side = turn(a, b, c), d_side = turn(a, b, d), a_side = turn(c, d, a),
            b_side = turn(c, d, b);
  if (c_side != 0 || d_side != 0 || a_side != 0 || b_side != 0) {
    if (c_side * d_side > 0 || a_side * b_side > 0) return false;
    return true;
  }
  // All on one line: one of them has an end of the other within it, ends included.
  const Triple along = cross(a, b);
  const auto within = [](const Triple& p, const Triple& q, const Triple& x) {
    const Triple line = cross(p, q);
    return sign_of_dot(cross(p, x), line) >= 0 && sign_of_dot(cross(x, q), line) >= 0;
  };
  return within(a, b, c) || within(a, b, d) || within(c, d, a);
}

bool is_simple(const std::vector<Triple>& rays, const Loop& loop) {
  const std::size_t n = loop.size();
  const auto at = [&](std::size_t i) -> const Triple& { return rays[loop[i % n]]; };
  for (std::size_t i = 0; i < n; ++i) {
    const Triple line = cross(at(i), at(i + 1)), next = cross(at(i + 1), at(i + 2));
    // it turns back
    if (sign_of_dot(line, at(i + 2)) == 0 && sign_of_dot(line, next) <= 0) return false;
    for (std::size_t j = i + 2; j < n; ++j) {
      if ((j + 1) % n != i && meet(at(i), at(i + 1), at(j), at(j + 1))) return false;
    }
  }
  return true;
}

// A simple loop in triangles, counter-clockwise, by cutting off ears.
std::vector<Loop> triangles_of(const std::vector<Triple>& rays, Loop loop) {
  std::vector<Loop> out;
  const auto is_ear = [&](std::size_t i) {
    const std::size_t n = loop.size();
    const std::size_t a = loop[(i + n - 1) % n], b = loop[i], c = loop[(i + 1) % n];
    if (turn(rays[a], rays[b], rays[c]) <= 0) return false;
    return std::none_of(loop.begin(), loop.end(), [&](std::size_t x) {
      return x != a && x != b && x != c && turn(rays[a], rays[b], rays[x]) >= 0 &&
             turn(rays[b], rays[c], rays[x]) >= 0 && turn(rays[c], rays[a], rays[x]) >= 0;
    });
  };
  while (loop.size() >= 3) {
    const std::size_t n = loop.size();
    std::size_t i = 0;
    while (i < n &&
           turn(rays[loop[(i + n - 1) % n]], rays[loop[i]], rays[loop[(i + 1) % n]]) != 0 &&
           !is_ear(i))
      ++i;
    if (i == n) return {};
    const Loop ear{loop[(i + n - 1) % n], loop[i], loop[(i + 1) % n]};
    if (turn(rays[ear[0]], rays[ear[1]], rays[ear[2]]) > 0) out.push_back(ear);
    loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return out;
}

// The loop in convex loops, counter-clockwise; nothing if it is not simple. It is not in one line.
std::vector<Loop> convex_loops(const std::vector<Triple>& rays, Loop loop) {
  if (is_convex(rays_of(rays, loop))) return {loop};
  Loop reversed(loop.rbegin(), loop.rend());
  if (is_convex(rays_of(rays, reversed))) return {reversed};
  if (!is_simple(rays, loop)) return {};
  std::vector<Loop> out = triangles_of(rays, loop);
  return out.empty() ? triangles_of(rays, reversed) : out;
}

}  // namespace

GmpOracle::GmpOracle(const Scene& scene, const Light& light)
    : scene_(scene),
      point_light_(light.kind == Light::Kind::point),
      seen_(scene.facets().size()),
      answers_(scene.facets().size()) {
  if (point_light_) {
    lower_to(unit_ = std::numeric_limits<int>::max(), light.position);
    find_unit();
    light_ = position(light.position);
    axes_ = {1, 0, 2};  // the light looks outward
  } else {
    unit_ = std::numeric_limits<int>::max();
    find_unit();
    light_ = direction(light.direction);
    Eigen::Index z;
    light.direction.cwiseAbs().maxCoeff(&z);
    const int last = static_cast<int>(z);
    travel_sign_ = sgn(light_[static_cast<std::size_t>(last)]);
    axes_ = {(last + 1) % 3, (last + 2) % 3, last};
    if (travel_sign_ > 0) std::swap(axes_[0], axes_[1]);
  }
  for (std::uint32_t f = 0; f < seen_.size(); ++f) see(f);
  if (point_light_) check_boxes();
}

void GmpOracle::find_unit() {
  for (const Facet& f : scene_.facets()) {
    if (f.corner_count == 0) continue;
    lower_to(unit_, scene_.planes()[f.plane].point);
    for (const Corner& c : scene_.corners_of(f)) lower_to(unit_, scene_.vertices()[c.vertex]);
  }
  if (unit_ == std::numeric_limits<int>::max()) unit_ = 0;
}

Int GmpOracle::whole_number(double x, int unit) const {
  const auto [mantissa, exponent] = split(x);
  if (mantissa == 0) return 0;
  if (exponent < unit) throw Error("a number that is not the scene's");
  return Int(mantissa) << static_cast<mp_bitcnt_t>(exponent - unit);
}

std::array<Int, 3> GmpOracle::position(const Vec3& x) const {
  return {whole_number(x[0], unit_), whole_number(x[1], unit_), whole_number(x[2], unit_)};
}

std::array<Int, 3> GmpOracle::direction(const Vec3& v) {
  int unit = std::numeric_limits<int>::max();
  lower_to(unit, v);
  std::array<Int, 3> out;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [mantissa, exponent] = split(v[static_cast<Eigen::Index>(i)]);
    out[i] =
        mantissa == 0 ? Int(0) : Int(Int(mantissa) << static_cast<mp_bitcnt_t>(exponent - unit));
  }
  return reduced(std::move(out));
}

GmpOracle::Quad GmpOracle::plane(const Vec3& normal, const Vec3& point) const {
  Quad out;
  out.n = direction(normal);
  out.d = -dot(out.n, position(point));
  return out;
}

// Point light: r = x - light, nearness 1 / distance in units of r, so u = n and w = n . (point -
// light). Directional: with x, y, z along the axes and d the direction,
// r = (x d_z - z d_x, y d_z - z d_y, 1). Put into n.x + D = 0 (times d_z):
// n_x r_0 + n_y r_1 + D d_z r_2 + z (n.d) = 0; nearness is -z where the rays run along +z.
void GmpOracle::nearness(const Quad& plane, Triple& u, Int& w) const {
  const auto axis = [this](std::size_t i) { return static_cast<std::size_t>(axes_[i]); };
  if (point_light_) {
    u = {plane.n[axis(0)], plane.n[axis(1)], plane.n[axis(2)]};
    w = -plane.d - dot(plane.n, light_);
    return;
  }
  u = {plane.n[axis(0)], plane.n[axis(1)], plane.d * light_[axis(2)]};
  w = dot(plane.n, light_);
  if (travel_sign_ < 0) u = negated(u);
}

Triple GmpOracle::ray(const Vec3& x) const {
  const auto axis = [this](std::size_t i) { return static_cast<std::size_t>(axes_[i]); };
  int unit = unit_;  // points of dividing planes may have finer digits than the scene's
  lower_to(unit, x);
  const auto finer = static_cast<mp_bitcnt_t>(unit_ - unit);
  const std::array<Int, 3> p = {whole_number(x[0], unit), whole_number(x[1], unit),
                                whole_number(x[2], unit)};
  if (point_light_) {
    Triple r;
    for (std::size_t i = 0; i < 3; ++i) r[i] = p[axis(i)] - Int(light_[axis(i)] << finer);
    return reduced(std::move(r));
  }
  const Int &dx = light_[axis(0)], &dy = light_[axis(1)], &dz = light_[axis(2)], &z = p[axis(2)];
  return reduced({p[axis(0)] * dz - z * dx, p[axis(1)] * dz - z * dy, Int(Int(1) << finer)});
}

Triple GmpOracle::line(const LightLine& line) const {
  if (!line.crossing) return as_line(cross(ray(line.v[0]), ray(line.v[1])));
  // Planes that an edit has left behind may have finer digits than the scene's.
  int unit = unit_;
  lower_to(unit, line.v[1]);
  lower_to(unit, line.v[3]);
  const auto finer = static_cast<mp_bitcnt_t>(unit_ - unit);
  Triple u[2];
  Int w[2];
  for (std::size_t k = 0; k < 2; ++k) {
    const Vec3& point = line.v[2 * k + 1];
    Quad plane;
    plane.n = direction(line.v[2 * k]);
    plane.d = -dot(plane.n, {whole_number(point[0], unit), whole_number(point[1], unit),
                             whole_number(point[2], unit)});
    // nearness takes the light off once, in the scene's units
    if (point_light_) plane.d += dot(plane.n, light_) * ((Int(1) << finer) - 1);
    nearness(plane, u[k], w[k]);
    if (!point_light_) u[k][0] <<= finer, u[k][1] <<= finer;
  }
  return as_line({u[0][0] * w[1] - u[1][0] * w[0], u[0][1] * w[1] - u[1][1] * w[0],
                  u[0][2] * w[1] - u[1][2] * w[0]});
}

bool GmpOracle::meets(std::uint32_t facet, const Triple& ray) const {
  return point_light_ ? sign_of_dot(seen_[facet].u, ray) > 0 : sgn(ray[2]) > 0;
}

// The plane through the light, a and b. Seen from the light, its positive side is the left of a ->
// b if `a`, `b` run counter-clockwise around the positive side; cone() turns it as needed.
GmpOracle::Quad GmpOracle::wall(const std::array<Int, 3>& a, const std::array<Int, 3>& b) const {
  Quad out;
  Triple to_a = light_, to_b;
  for (std::size_t i = 0; i < 3; ++i) {
    if (point_light_) to_a[i] = a[i] - light_[i];
    to_b[i] = point_light_ ? Int(b[i] - light_[i]) : Int(b[i] - a[i]);
  }
  out.n = reduced(cross(to_a, to_b));
  out.d = -dot(out.n, a);
  return out;
}

GmpOracle::Cone GmpOracle::cone(const std::vector<std::array<Int, 3>>& corners) const {
  Cone out;
  std::array<Int, 3> sum;
  for (const auto& c : corners) {
    for (std::size_t i = 0; i < 3; ++i) sum[i] += c[i];
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    Quad q = wall(corners[i], corners[(i + 1) % corners.size()]);
    const Int inside = dot(q.n, sum) + q.d * static_cast<long>(corners.size());
    if (sgn(inside) < 0) q.n = negated(q.n), q.d = -q.d;
    out.walls.push_back(std::move(q));
  }
  return out;
}

void GmpOracle::see(std::uint32_t index) {
  const Facet& facet = scene_.facets()[index];
  if (facet.corner_count == 0) return;
  Seen& s = seen_[index];
  const Plane& p = scene_.planes()[facet.plane];
  const Object& object = scene_.objects()[scene_.faces()[facet.face].object];
  s.role = Role::edge_on;
  s.plane = plane(p.exact_normal, p.point);
  nearness(s.plane, s.u, s.w);
  s.front = sgn(s.w) < 0;
  s.at_light = -sgn(s.w);
  if (sgn(s.w) == 0) return;
  if (s.front) s.u = negated(s.u), s.w = -s.w;

  std::vector<Triple> rays;
  for (const Corner& c : scene_.corners_of(facet)) {
    rays.push_back(ray(scene_.vertices()[c.vertex]));
    if (!meets(index, rays.back())) return;
  }
  const Loop loop = without_repeats(rays);
  if (loop.size() < 3 || in_one_line(rays, loop)) return;
  if (object.sides == Sides::closed && !s.front) {
    s.role = Role::away;
    return;
  }
  s.role = Role::takes_part;
  s.casts_shadows = object.casts_shadows;
  const std::vector<Loop> loops = convex_loops(rays, loop);
  if (loops.empty())
    undefined_ = "facet " + std::to_string(index) + " crosses itself as the light sees it";
  for (const Loop& l : loops) {
    s.parts.push_back(part_of(rays_of(rays, l)));
    std::vector<std::array<Int, 3>> corners;
    for (const std::size_t i : l)
      corners.push_back(position(scene_.vertices()[scene_.corners_of(facet)[i].vertex]));
    s.cones.push_back(cone(corners));
    s.whole.add(s.parts.back());
  }
  s.whole.settle();
}

void GmpOracle::check_boxes() {
  Vec3 at;
  for (std::size_t i = 0; i < 3; ++i)
    at[static_cast<Eigen::Index>(i)] = std::ldexp(light_[i].get_d(), unit_);
  for (const Object& object : scene_.objects()) {
    if (!object.alive || object.sides != Sides::closed || object.facet_count == 0) continue;
    Eigen::AlignedBox3d box;
    for (const Vec3& v : scene_.vertices().subspan(object.first_vertex, object.vertex_count))
      box.extend(v);
    const double margin =
        box_margin * std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
    if (box.exteriorDistance(at) <= margin)
      undefined_ = "the light is in the box of a closed object";
  }
}

// The part of the caster's cones in which its plane is nearer than the receiver's: (u_C / w_C - u_F
// / w_F) . r > 0.
std::vector<Part> GmpOracle::shadows_on(const Seen& receiver, const Seen& caster) const {
  Triple nearer;
  for (std::size_t i = 0; i < 3; ++i)
    nearer[i] = caster.u[i] * receiver.w - receiver.u[i] * caster.w;
  if (is_zero(nearer)) return {};  // one plane
  nearer = reduced(std::move(nearer));
  std::vector<Part> out;
  Part inside, outside;
  for (const Part& part : caster.parts) {
    cut(part, nearer, inside, outside);
    if (!inside.corners.empty()) out.push_back(std::move(inside));
  }
  return out;
}

const std::vector<Part>& GmpOracle::lit_parts(std::uint32_t facet) const {
  Answer& answer = answers_[facet];
  if (answer.known) return answer.parts;
  const Seen& f = seen_[facet];
  answer.parts = f.parts;
  for (std::uint32_t c = 0; c < seen_.size() && !answer.parts.empty(); ++c) {
    if (c == facet || !seen_[c].casts_shadows) continue;
    for (const Part& shadow : shadows_on(f, seen_[c])) answer.parts = without(answer.parts, shadow);
  }
  for (const Part& part : answer.parts) answer.region.add(part);
  answer.region.settle();
  answer.known = true;
  return answer.parts;
}

const Region& GmpOracle::lit(std::uint32_t facet) const {
  lit_parts(facet);
  return answers_[facet].region;
}

// Twice the area is the sum over edges p -> q of p x q. On one line p x q = a x q - a x p for any a
// of the line: so the sum over a line is that of count * (a x point).
Rational GmpOracle::area(std::uint32_t facet, const Region& region) const {
  const int axis = stretch(facet).first;
  const auto i = static_cast<std::size_t>((axis + 1) % 3),
             j = static_cast<std::size_t>((axis + 2) % 3);
  Rational twice;
  const auto terms = region.terms();
  for (std::size_t first = 0, t = 0; t < terms.size(); ++t) {
    if (terms[t].line != terms[first].line) first = t;
    if (t == first) continue;
    const Place a = place(facet, terms[first].point), x = place(facet, terms[t].point);
    Rational term(Int((a.n[i] * x.n[j] - a.n[j] * x.n[i]) * terms[t].count), a.d * x.d);
    term.canonicalize();
    twice += term;
  }
  Rational unit_squared = 1;
  if (unit_ >= 0)
    mpq_mul_2exp(unit_squared.get_mpq_t(), unit_squared.get_mpq_t(),
                 static_cast<mp_bitcnt_t>(2 * unit_));
  else
    mpq_div_2exp(unit_squared.get_mpq_t(), unit_squared.get_mpq_t(),
                 static_cast<mp_bitcnt_t>(-2 * unit_));
  return abs(twice) / 2 * unit_squared;
}

std::pair<int, double> GmpOracle::stretch(std::uint32_t facet) const {
  const Vec3& n = scene_.planes()[scene_.facets()[facet].plane].exact_normal;
  Eigen::Index axis;
  const double largest = n.cwiseAbs().maxCoeff(&axis);
  return {static_cast<int>(axis), n.stableNorm() / largest};
}

// Point light: light + r w / (u.r). Directional, with nearness q = (u.r) / (w r_2): z = -q or q, x
// = (r_0 / r_2 + z d_x) / d_z.
Place GmpOracle::place(std::uint32_t facet, const Triple& r) const {
  const Seen& f = seen_[facet];
  const Int near = dot(f.u, r);
  Place out;
  if (point_light_) {
    out.d = near;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto a = static_cast<std::size_t>(axes_[i]);
      out.n[a] = light_[a] * near + r[i] * f.w;
    }
    return out;
  }
  const auto x = static_cast<std::size_t>(axes_[0]), y = static_cast<std::size_t>(axes_[1]),
             z = static_cast<std::size_t>(axes_[2]);
  const Int deep = -travel_sign_ * near;
  out.n[x] = r[0] * f.w + deep * light_[x];
  out.n[y] = r[1] * f.w + deep * light_[y];
  out.n[z] = deep * light_[z];
  out.d = f.w * r[2] * light_[z];
  if (sgn(out.d) < 0) {
    out.n = negated(out.n);
    out.d = -out.d;
  }
  return out;
}

GmpOracle::State GmpOracle::state_at(std::uint32_t facet, const Place& x,
                                     std::vector<std::uint32_t>* by) const {
  const auto sign_at = [&](const Quad& q) { return sgn(Int(dot(q.n, x.n) + q.d * x.d)); };
  bool shadowed = false, doubtful = false;
  for (std::uint32_t c = 0; c < seen_.size(); ++c) {
    const Seen& caster = seen_[c];
    if (c == facet || !caster.casts_shadows) continue;
    const int between = -sign_at(caster.plane) * caster.at_light;
    if (between < 0 || (between == 0 && is_zero(cross(caster.plane.n, seen_[facet].plane.n))))
      continue;
    bool inside = false, touched = false;
    for (const Cone& cone : caster.cones) {
      int least = between;  // where the two planes meet, the caster's shadow ends
      for (const Quad& wall : cone.walls) least = std::min(least, sign_at(wall));
      inside = inside || least > 0;
      touched = touched || least == 0;
    }
    shadowed = shadowed || inside;
    doubtful = doubtful || touched;
    if (inside && by) by->push_back(c);
  }
  return shadowed ? State::shadowed : doubtful ? State::on_boundary : State::lit;
}

int GmpOracle::compare(const Place& x, int axis, double value) const {
  const Int& n = x.n[static_cast<std::size_t>(axis)];
  const auto [mantissa, exponent] = split(value);
  if (mantissa == 0) return sgn(n);
  const Int other = mantissa * x.d;
  const int shift = exponent - unit_;
  return shift >= 0 ? cmp(n, Int(other << static_cast<mp_bitcnt_t>(shift)))
                    : cmp(Int(n << static_cast<mp_bitcnt_t>(-shift)), other);
}

Vec3 GmpOracle::rounded(const Place& x) const {
  Vec3 out;
  for (std::size_t i = 0; i < 3; ++i) {
    Rational q(x.n[i], x.d);
    q.canonicalize();
    if (unit_ >= 0) mpq_mul_2exp(q.get_mpq_t(), q.get_mpq_t(), static_cast<mp_bitcnt_t>(unit_));
    else mpq_div_2exp(q.get_mpq_t(), q.get_mpq_t(), static_cast<mp_bitcnt_t>(-unit_));
    out[static_cast<Eigen::Index>(i)] = q.get_d();
  }
  return out;
}

}  // namespace shadowcut::testing
