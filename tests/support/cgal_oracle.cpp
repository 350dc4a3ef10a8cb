// See cgal_oracle.hpp. Doubles are used in one place only: to leave out pairs of facets that are
// clear of each other by a margin far above rounding.
#include "cgal_oracle.hpp"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace shadowcut::testing {
namespace {

using K = CGAL::Exact_predicates_exact_constructions_kernel;
using FT = K::FT;
using Polygon = std::vector<K::Point_3>;

K::Point_3 point(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
K::Vector_3 vector(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

// A half-space whose boundary contains the light: the rays on the inner side of an edge.
struct Side {
  Vec3 normal, base;
  double size;  // normal . (x - base) is exact up to some ulps of size * |x - base|
};

// A facet as the light sees it, in doubles.
struct Seen {
  std::uint32_t facet;
  double facing;              // +1: front toward the light, -1: back, 0: edge-on
  bool unsure;                // nearly edge-on
  double extent;              // largest coordinate
  Vec3 normal;                // toward the light
  std::vector<Vec3> corners;  // counter-clockwise seen from the light
  std::vector<Side> sides;    // inner side positive
};

// Keeps the part of a convex polygon where `value` is not negative.
template <class Value>
Polygon clip(const Polygon& in, const Value& value) {
  Polygon out;
  std::vector<FT> at;
  for (const K::Point_3& p : in) at.push_back(value(p));
  for (std::size_t i = 0; i < in.size(); ++i) {
    const std::size_t j = (i + 1) % in.size();
    if (at[i] >= 0) out.push_back(in[i]);
    if (CGAL::sign(at[i]) * CGAL::sign(at[j]) < 0)
      out.push_back(in[i] + (in[j] - in[i]) * (at[i] / (at[i] - at[j])));
  }
  return out;
}

using Flat = std::vector<K::Point_2>;  // convex, counter-clockwise

// The same point, but it forgets how it was made: keeps later tests cheap.
K::Point_2 plain(const K::Point_2& p) { return {FT(p.x().exact()), FT(p.y().exact())}; }

FT area_of(const Flat& polygon) {
  FT twice = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i)
    twice += CGAL::determinant(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
  return twice / 2;
}

// Cuts `in` along the line from a to b. A side that holds nothing but points of the line comes out
// empty.
void cut(const Flat& in, const K::Point_2& a, const K::Point_2& b, Flat& left, Flat& right) {
  left.clear();
  right.clear();
  std::vector<CGAL::Orientation> at;
  for (const K::Point_2& p : in) at.push_back(CGAL::orientation(a, b, p));
  if (std::count(at.begin(), at.end(), CGAL::RIGHT_TURN) == 0) left = in;
  else if (std::count(at.begin(), at.end(), CGAL::LEFT_TURN) == 0) right = in;
  if (!left.empty() || !right.empty()) return;
  for (std::size_t i = 0; i < in.size(); ++i) {
    const std::size_t j = (i + 1) % in.size();
    if (at[i] != CGAL::RIGHT_TURN) left.push_back(in[i]);
    if (at[i] != CGAL::LEFT_TURN) right.push_back(in[i]);
    if (at[i] * at[j] >= 0) continue;
    const FT s = CGAL::determinant(b - a, in[i] - a), t = CGAL::determinant(b - a, in[j] - a);
    const K::Point_2 p = plain(in[i] + (in[j] - in[i]) * (s / (s - t)));
    left.push_back(p);
    right.push_back(p);
  }
}

// The parts without the convex polygon `hole`. Parts that do not overlap it stay whole. (CGAL's own
// union of polygons failed an assertion of its sweep where many edges coincide; cutting convex
// parts needs nothing but exact signs.)
std::vector<Flat> without(const std::vector<Flat>& parts, const Flat& hole) {
  std::vector<Flat> out, fresh;
  Flat rest, inside, outside;
  const CGAL::Bbox_2 box = CGAL::bbox_2(hole.begin(), hole.end());  // rounded outward
  for (const Flat& part : parts) {
    if (!CGAL::do_overlap(box, CGAL::bbox_2(part.begin(), part.end()))) {
      out.push_back(part);
      continue;
    }
    fresh.clear();
    rest = part;
    for (std::size_t i = 0; i < hole.size() && !rest.empty(); ++i) {
      cut(rest, hole[i], hole[(i + 1) % hole.size()], inside, outside);
      if (!outside.empty()) fresh.push_back(outside);
      rest = inside;
    }
    if (rest.empty()) out.push_back(part);
    else out.insert(out.end(), fresh.begin(), fresh.end());
  }
  return out;
}

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (a + t * (b - a) - p).norm();
}

// The least angle between `axis` (of unit length) and a ray through the segment from a to b.
double angle_to_segment(const Vec3& axis, const Vec3& a, const Vec3& b) {
  const auto angle = [&](const Vec3& r) { return std::atan2(axis.cross(r).norm(), axis.dot(r)); };
  // The nearest direction within the plane of a and b, if it lies between them.
  const Vec3 normal = a.cross(b);
  const Vec3 nearest = axis - normal * (axis.dot(normal) / normal.squaredNorm());
  double least = std::min(angle(a), angle(b));
  if (a.cross(nearest).dot(normal) > 0 && nearest.cross(b).dot(normal) > 0)
    least = std::min(least, angle(nearest));
  return least;
}

}  // namespace

struct CgalOracle::Impl {
  const Scene& scene;
  Light light;
  bool point_light;
  K::Point_3 at;                       // point light
  K::Vector_3 travel;                  // directional light
  std::vector<Seen> seen;              // by facet
  std::vector<std::uint32_t> casters;  // facets
  // by face: 1 reached, 0 out of reach, 2 reached but nearly not, 3 the other way
  std::vector<char> reached;

  Impl(const Scene& s, const Light& l, bool only_facing)
      : scene(s),
        light(l),
        point_light(l.kind == Light::Kind::point),
        at(point(l.position)),
        travel(vector(l.direction)) {
    for (std::uint32_t f = 0; f < scene.facets().size(); ++f) seen.push_back(see(f));
    for (const Face& face : scene.faces()) reached.push_back(reach(face));
    for (std::uint32_t f = 0; f < scene.facets().size(); ++f) {
      if (scene.facets()[f].corner_count == 0) continue;  // no face's
      const Face& face = scene.faces()[scene.facets()[f].face];
      const Object& object = scene.objects()[face.object];
      const bool away = object.sides == Sides::closed && seen[f].facing < 0;
      if (object.casts_shadows && seen[f].facing != 0 && reached[scene.facets()[f].face] % 2 == 1 &&
          !(only_facing && away))
        casters.push_back(f);
    }
  }

  const Plane& plane(std::uint32_t facet) const {
    return scene.planes()[scene.facets()[facet].plane];
  }

  Seen see(std::uint32_t facet) const {
    Seen s;
    s.facet = facet;
    const Plane& p = plane(facet);
    s.extent = point_light ? light.position.cwiseAbs().maxCoeff() : 0;
    for (const Corner& c : scene.corners_of(scene.facets()[facet])) {
      s.corners.push_back(scene.vertices()[c.vertex]);
      s.extent = std::max(s.extent, s.corners.back().cwiseAbs().maxCoeff());
    }
    const Vec3 to_light = point_light ? Vec3(light.position - p.point) : Vec3(-light.direction);
    const double height = p.normal.dot(to_light);
    const double size =
        point_light ? s.extent + p.point.cwiseAbs().maxCoeff() : light.direction.norm();
    // Of a needle a plane says little: its corners could turn it by `tilt`.
    s.unsure = std::abs(height) <= 1e-9 * size + 4 * (p.tilt * to_light.norm() + p.flatness);
    s.facing = std::abs(height) <= 1e-14 * size ? 0 : height > 0 ? 1 : -1;
    s.normal = s.facing < 0 ? Vec3(-p.normal) : p.normal;
    if (s.facing < 0) std::reverse(s.corners.begin(), s.corners.end());
    for (std::size_t i = 0; i < s.corners.size(); ++i) {
      const Vec3 &a = s.corners[i], &b = s.corners[(i + 1) % s.corners.size()];
      if (point_light) {
        s.sides.push_back({(b - light.position).cross(a - light.position), light.position,
                           (b - light.position).norm() * (a - light.position).norm()});
      } else {
        s.sides.push_back(
            {(b - a).cross(light.direction), a, (b - a).norm() * light.direction.norm()});
      }
    }
    return s;
  }

  // Distance and angle of the nearest point of the face; convex facets, so either the foot of the
  // perpendicular (the axis) or an edge.
  char reach(const Face& face) const {
    if (!point_light || (std::isinf(light.range) && !light.spot)) return 1;
    double distance = std::numeric_limits<double>::infinity(), angle = distance;
    const Vec3 axis = light.spot ? light.spot->axis.normalized() : Vec3::UnitZ();
    for (std::uint32_t k = 0; k < face.facet_count; ++k) {
      const Seen& s = seen[face.first_facet + k];
      const Plane& p = plane(face.first_facet + k);
      const double height = p.normal.dot(light.position - p.point);
      bool foot_inside = true, axis_inside = true;
      for (std::size_t i = 0; i < s.corners.size(); ++i) {
        const Vec3 &a = s.corners[i], &b = s.corners[(i + 1) % s.corners.size()];
        foot_inside = foot_inside && s.normal.cross(b - a).dot(light.position - a) > 0;
        axis_inside = axis_inside && s.sides[i].normal.dot(axis) > 0;
        distance = std::min(distance, distance_to_segment(light.position, a, b));
        angle = std::min(angle, angle_to_segment(axis, a - light.position, b - light.position));
      }
      if (foot_inside) distance = std::min(distance, std::abs(height));
      if (axis_inside && axis.dot(s.normal) < 0) angle = 0;
    }
    const double limit =
        light.spot ? light.spot->half_angle : std::numeric_limits<double>::infinity();
    const bool inside = distance <= light.range && angle <= limit;
    const bool near =
        std::abs(distance - light.range) <= 1e-9 * light.range || std::abs(angle - limit) <= 1e-9;
    return static_cast<char>(inside ? (near ? 3 : 1) : (near ? 2 : 0));
  }

  // Along the light onto a facet's plane.
  K::Point_3 project(const K::Point_3& x, const Plane& p) const {
    const K::Vector_3 n = vector(p.normal);
    if (point_light) {
      const K::Vector_3 r = x - at;
      return at + r * ((n * (point(p.point) - at)) / (n * r));
    }
    return x + travel * ((n * (point(p.point) - x)) / (n * travel));
  }

  // Whether q lies outside one of p's sides by more than rounding.
  static bool clear(const Seen& p, const Seen& q) {
    return std::any_of(p.sides.begin(), p.sides.end(), [&](const Side& side) {
      return std::all_of(q.corners.begin(), q.corners.end(), [&](const Vec3& x) {
        const Vec3 r = x - side.base;
        return side.normal.dot(r) < -1e-11 * side.size * r.norm();
      });
    });
  }

  double tolerance(const Seen& f, const Seen& q) const {
    return contact_tolerance * std::max(f.extent, q.extent);
  }

  bool may_shadow(const Seen& q, const Seen& f) const {
    const Facet &a = scene.facets()[q.facet], &b = scene.facets()[f.facet];
    if (a.face == b.face && a.plane == b.plane) return false;
    const Plane& p = plane(f.facet);
    // Off its own plane a corner may be up to `flatness`, and the cone prolongs that.
    const double slack = -2 * tolerance(f, q) - 4 * plane(q.facet).flatness;
    const bool behind = std::all_of(q.corners.begin(), q.corners.end(), [&](const Vec3& x) {
      return f.normal.dot(x - p.point) <= slack;
    });
    return !behind && !clear(f, q) && !clear(q, f);
  }

  // The facet itself as the definition has it: its plane cut by its cone.
  Polygon region(const Seen& s) const {
    Polygon polygon;
    for (const Vec3& x : s.corners) polygon.push_back(project(point(x), plane(s.facet)));
    return polygon;
  }

  // The part of q's shadow that falls on f, in f's plane; empty if there is none. touches: it is
  // there only if contact casts.
  Polygon shadow(const Seen& q, const Seen& f, bool& touches) const {
    Polygon part = region(q);
    for (const Side& side : f.sides) {
      // Exactly, from the corners; side.normal is rounded.
      const std::size_t i = static_cast<std::size_t>(&side - f.sides.data());
      const Vec3 &a = f.corners[i], &b = f.corners[(i + 1) % f.corners.size()];
      const K::Vector_3 n = point_light ? CGAL::cross_product(point(b) - at, point(a) - at)
                                        : CGAL::cross_product(point(b) - point(a), travel);
      const K::Point_3 base = point_light ? at : point(a);
      part = clip(part, [&](const K::Point_3& x) -> FT { return n * (x - base); });
      if (part.size() < 3) return {};
    }
    const Plane& p = plane(f.facet);
    const auto height = [&](const K::Point_3& x) -> FT {
      return vector(f.normal) * (x - point(p.point));
    };
    const double tol = tolerance(f, q);
    const auto all = [&](const Polygon& of, const auto& holds) {
      return std::all_of(of.begin(), of.end(),
                         [&](const K::Point_3& x) -> bool { return holds(height(x)); });
    };
    const Polygon in_front = clip(part, height);
    touches = in_front.size() < 3 || all(in_front, [tol](const FT& h) { return h <= tol; });
    if (!touches) {
      part = in_front;
    } else {
      // The normals are rounded: what they put a little behind may be in front.
      part = clip(part, [&](const K::Point_3& x) -> FT { return height(x) + tol; });
      if (part.size() < 3 || all(part, [](const FT& h) { return h == 0; })) return {};
    }
    for (K::Point_3& x : part) x = project(x, p);
    return part;
  }

  // Without the coordinate along which the plane's normal is longest; counter-clockwise, without
  // repeated corners. Empty if degenerate.
  static Flat flattened(const Polygon& polygon, int axis) {
    Flat flat;
    for (const K::Point_3& x : polygon) {
      const K::Point_2 p = plain({x[(axis + 1) % 3], x[(axis + 2) % 3]});
      if (flat.empty() || flat.back() != p) flat.push_back(p);
    }
    while (flat.size() > 1 && flat.front() == flat.back()) flat.pop_back();
    const FT area = area_of(flat);
    if (area < 0) std::reverse(flat.begin(), flat.end());
    return area == 0 ? Flat{} : flat;
  }

  // Area, lit area and least lit area of one facet.
  std::array<double, 3> facet_areas(const Seen& f) const {
    int axis = 0;
    f.normal.cwiseAbs().maxCoeff(&axis);
    const double stretch = f.normal.norm() / std::abs(f.normal[axis]);
    std::vector<std::pair<double, Flat>> shadows, touching;
    for (const std::uint32_t q : casters) {
      if (!may_shadow(seen[q], f)) continue;
      bool touches = false;
      Flat polygon = flattened(shadow(seen[q], f, touches), axis);
      if (!polygon.empty())
        (touches ? touching : shadows)
            .emplace_back(CGAL::to_double(area_of(polygon)), std::move(polygon));
    }
    // Large ones first: fewer parts.
    std::stable_sort(shadows.begin(), shadows.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    const Flat whole = flattened(region(f), axis);
    std::vector<Flat> lit{whole};
    for (const auto& entry : shadows) lit = without(lit, entry.second);
    const auto total = [stretch](const std::vector<Flat>& parts) {
      FT sum = 0;
      for (const Flat& part : parts) sum += FT(area_of(part).exact());
      return CGAL::to_double(sum) * stretch;
    };
    std::vector<Flat> least = lit;
    for (const auto& entry : touching) least = without(least, entry.second);
    return {total({whole}), total(lit), total(least)};
  }

  static double plain_area(const Seen& f) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 2; i < f.corners.size(); ++i)
      sum += (f.corners[i - 1] - f.corners[0]).cross(f.corners[i] - f.corners[0]);
    return 0.5 * sum.norm();
  }

  Area area(std::uint32_t index) const {
    const Face& face = scene.faces()[index];
    Area out;
    if (face.facet_count == 0) return out;
    out.facing = Facing::away;
    out.unsure = reached[index] >= 2;
    const bool closed = scene.objects()[face.object].sides == Sides::closed;
    for (std::uint32_t k = 0; k < face.facet_count; ++k) {
      const Seen& f = seen[face.first_facet + k];
      out.unsure = out.unsure || f.unsure;
      if (f.facing > 0 || (f.facing < 0 && !closed)) {
        const auto [whole, lit, least] =
            reached[index] % 2 ? facet_areas(f) : std::array{0.0, 0.0, 0.0};
        out.area += whole, out.lit += lit, out.least_lit += least;
        out.facing = Facing::toward;
      } else {
        out.area += plain_area(f);
      }
    }
    if (reached[index] % 2 == 0) return {Facing::out_of_reach, face.area, 0, 0, out.unsure};
    return out;
  }

  enum class Between { no, in_contact, yes };
  // Whether q has a point strictly between x and the light.
  Between between(const Seen& q, const Seen& f, const Vec3& x) const {
    for (const Side& side : q.sides) {
      const Vec3 r = x - side.base;
      if (side.normal.dot(r) < -1e-11 * side.size * r.norm()) return Between::no;
    }
    const Plane& p = plane(q.facet);
    if (q.normal.dot(x - p.point) >= 4 * tolerance(f, q)) return Between::no;  // x is in front of q
    const K::Point_3 target = point(x);
    for (std::size_t i = 0; i < q.corners.size(); ++i) {
      const K::Point_3 a = point(q.corners[i]), b = point(q.corners[(i + 1) % q.corners.size()]);
      const K::Vector_3 n =
          point_light ? CGAL::cross_product(b - at, a - at) : CGAL::cross_product(b - a, travel);
      if (n * (target - (point_light ? at : a)) < 0) return Between::no;
    }
    // q may be in contact with f's plane where the ray to x meets it; the normals are rounded, so
    // on either side.
    const Plane& own = plane(f.facet);
    const FT height = vector(f.normal) * (project(target, p) - point(own.point));
    const double tol = tolerance(f, q);
    return height > tol ? Between::yes : height > -tol ? Between::in_contact : Between::no;
  }

  bool lit(std::uint32_t facet, const Vec3& x) const {
    const Seen& f = seen[facet];
    const Facet& own = scene.facets()[facet];
    const bool closed = scene.objects()[scene.faces()[own.face].object].sides == Sides::closed;
    if (f.facing == 0 || (closed && f.facing < 0) || reached[own.face] % 2 == 0) return false;
    return !any_between(facet, x, Between::yes);
  }

  bool any_between(std::uint32_t facet, const Vec3& x, Between how) const {
    const Facet& own = scene.facets()[facet];
    return std::any_of(casters.begin(), casters.end(), [&](std::uint32_t q) {
      const bool same = scene.facets()[q].face == own.face && scene.facets()[q].plane == own.plane;
      return !same && between(seen[q], seen[facet], x) == how;
    });
  }
};

CgalOracle::CgalOracle(const Scene& scene, const Light& light, bool only_facing)
    : impl_(std::make_unique<Impl>(scene, light, only_facing)) {}
CgalOracle::~CgalOracle() = default;

CgalOracle::Area CgalOracle::area(std::uint32_t face) const { return impl_->area(face); }

std::vector<CgalOracle::Area> CgalOracle::areas() const {
  std::vector<Area> all;
  for (std::uint32_t face = 0; face < impl_->scene.faces().size(); ++face)
    all.push_back(area(face));
  return all;
}

bool CgalOracle::unsure(std::uint32_t facet) const {
  return impl_->seen[facet].unsure || impl_->reached[impl_->scene.facets()[facet].face] >= 2;
}

bool CgalOracle::lit(std::uint32_t facet, const Vec3& x) const { return impl_->lit(facet, x); }

bool CgalOracle::in_contact(std::uint32_t facet, const Vec3& x) const {
  return impl_->any_between(facet, x, Impl::Between::in_contact);
}

}  // namespace shadowcut::testing
