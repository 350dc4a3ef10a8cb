// The symmetric difference of lit regions; see difference.hpp.
//
// Polygons are not clipped here: the line through two corners that are 1e-15 apart has an arbitrary
// direction, and would cut off an arbitrary part. The common area of polygons P and Q is taken from
// their edges instead. With s(e) = +1 for edges that run to the left and -1 for the others, the
// indicator of P is the sum over its edges of s(e) [y is below e], and so
//   area(P and Q) = sum over edges e of P and f of Q of s(e) s(f) * integral of min(y_e, y_f) - y0
//     over the x that both span,
// whatever y0. Each term moves by no more than the corners do, however short or steep an edge is.
#include "difference.hpp"

#include <algorithm>
#include <cmath>

namespace shadowcut::cli {

namespace {

using Point = Eigen::Vector2d;
using Box = Eigen::AlignedBox2d;

struct Polygon {
  std::size_t first, count;  // into Layer::corners
  Box box;
  double area;  // positive when it runs counter-clockwise
};

// The lit fragments of one facet, flat.
struct Layer {
  std::vector<Point> corners;
  std::vector<Polygon> polygons;

  std::span<const Point> of(const Polygon& p) const {
    return std::span(corners).subspan(p.first, p.count);
  }
  void clear() { corners.clear(), polygons.clear(); }
};

double cross(const Point& a, const Point& b) { return a.x() * b.y() - a.y() * b.x(); }

// The integral of min(e, f) - y0 over the x that both edges span; signed as above.
double below_both(const Point& a, const Point& b, const Point& c, const Point& d, double y0) {
  const auto at = [](const Point& p, const Point& q, double x) {
    return p.y() + (q.y() - p.y()) * ((x - p.x()) / (q.x() - p.x()));
  };
  const double left = std::max(std::min(a.x(), b.x()), std::min(c.x(), d.x()));
  const double right = std::min(std::max(a.x(), b.x()), std::max(c.x(), d.x()));
  if (!(left < right)) return 0;
  const double e0 = at(a, b, left) - y0, e1 = at(a, b, right) - y0, f0 = at(c, d, left) - y0,
               f1 = at(c, d, right) - y0;
  double integral = 0.5 * (std::min(e0, f0) + std::min(e1, f1));
  if ((e0 < f0 && e1 > f1) || (e0 > f0 && e1 < f1)) {  // they cross
    const double gap0 = std::abs(e0 - f0), gap1 = std::abs(e1 - f1), share = gap0 / (gap0 + gap1);
    const double y = e0 + share * (e1 - e0);
    integral = 0.5 * (share * (std::min(e0, f0) + y) + (1 - share) * (y + std::min(e1, f1)));
  }
  return ((a.x() < b.x()) == (c.x() < d.x()) ? 1 : -1) * integral * (right - left);
}

double common_area(const Layer& one, const Polygon& p, const Layer& other, const Polygon& q) {
  const Box both = p.box.intersection(q.box);
  if (both.isEmpty()) return 0;
  const double y0 = both.center().y();
  const std::span<const Point> ps = one.of(p), qs = other.of(q);
  double sum = 0;
  for (std::size_t i = 0; i < ps.size(); ++i)
    for (std::size_t k = 0; k < qs.size(); ++k)
      sum += below_both(ps[i], ps[(i + 1) % ps.size()], qs[k], qs[(k + 1) % qs.size()], y0);
  return std::abs(sum);
}

// Finds the polygons of a layer that may meet a box.
class Grid {
 public:
  explicit Grid(const Layer& layer)
      : side_(std::clamp(std::ceil(std::sqrt(static_cast<double>(layer.polygons.size()))), 1.0,
                         1024.0)) {
    for (const Polygon& p : layer.polygons) box_.extend(p.box);
    cells_.resize(static_cast<std::size_t>(side_ * side_));
    seen_.resize(layer.polygons.size(), invalid_index);
    for (std::uint32_t i = 0; i < layer.polygons.size(); ++i)
      each_cell(layer.polygons[i].box, [&](auto& cell) { cell.push_back(i); });
  }

  // Each once; `number` is one that has not been used before.
  template <typename Visit>
  void visit(const Box& box, std::uint32_t number, const Visit& visit) {
    each_cell(box, [&](const auto& cell) {
      for (const std::uint32_t i : cell) {
        if (seen_[i] == number) continue;
        seen_[i] = number;
        visit(i);
      }
    });
  }

 private:
  template <typename Visit>
  void each_cell(const Box& box, const Visit& visit) {
    const Point unit = box_.sizes() / side_;
    const auto index = [&](double x, int axis) {
      const double cell = unit[axis] > 0 ? std::floor((x - box_.min()[axis]) / unit[axis]) : 0;
      return static_cast<std::size_t>(std::clamp(cell, 0.0, side_ - 1));
    };
    const std::size_t left = index(box.min().x(), 0), right = index(box.max().x(), 0);
    for (std::size_t y = index(box.min().y(), 1); y <= index(box.max().y(), 1); ++y)
      for (std::size_t x = left; x <= right; ++x)
        visit(cells_[y * static_cast<std::size_t>(side_) + x]);
  }

  double side_;
  Box box_;
  std::vector<std::vector<std::uint32_t>> cells_;
  std::vector<std::uint32_t> seen_;
};

// The area that is not exactly once in both layers. It is summed by polygon, so that an area
// covered twice cannot compensate a missing one.
double symmetric_difference(const Layer& one, const Layer& other) {
  if (one.polygons.empty() && other.polygons.empty()) return 0;
  std::vector<double> rest;
  for (const Polygon& q : other.polygons) rest.push_back(std::abs(q.area));
  Grid grid(other);
  double sum = 0;
  for (std::uint32_t i = 0; i < one.polygons.size(); ++i) {
    const Polygon& p = one.polygons[i];
    double mine = std::abs(p.area);
    grid.visit(p.box, i, [&](std::uint32_t k) {
      const double common = common_area(one, p, other, other.polygons[k]);
      mine -= common;
      rest[k] -= common;
    });
    sum += std::abs(mine);
  }
  for (const double r : rest) sum += std::abs(r);
  return sum;
}

// The lit fragments of one light's shadows, by facet.
class LitFragments {
 public:
  LitFragments(const Scene& scene, const Shadows& shadows)
      : scene_(scene), first_(scene.facets().size() + 1, 0) {
    for (const Block& block : shadows.blocks)
      for (const Fragment& f : block.fragments)
        if (f.lit) ++first_[f.facet + 1];
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    all_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (const Block& block : shadows.blocks)
      for (const Fragment& f : block.fragments)
        if (f.lit) all_[next[f.facet]++] = block.corners_of(f);
  }

  void lay_flat(std::uint32_t facet, Layer& out) const {
    out.clear();
    const Plane& plane = scene_.planes()[scene_.facets()[facet].plane];
    const Vec3 u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
    for (std::size_t i = first_[facet]; i < first_[facet + 1]; ++i) {
      Polygon p{out.corners.size(), all_[i].size(), {}, 0};
      for (const Vec3& x : all_[i]) {
        out.corners.emplace_back(u.dot(x - plane.point), v.dot(x - plane.point));
        p.box.extend(out.corners.back());
      }
      const std::span<const Point> c = out.of(p);
      for (std::size_t k = 2; k < c.size(); ++k)
        p.area += 0.5 * cross(c[k - 1] - c[0], c[k] - c[0]);
      out.polygons.push_back(p);
    }
  }

 private:
  const Scene& scene_;
  std::vector<std::size_t> first_;  // by facet, into all_
  std::vector<std::span<const Vec3>> all_;
};

}  // namespace

std::vector<double> lit_differences(const Scene& scene, const Shadows& one, const Shadows& other) {
  const LitFragments lit_one(scene, one), lit_other(scene, other);
  Layer layer_one, layer_other;
  std::vector<double> by_face(scene.faces().size(), 0);
  for (std::uint32_t f = 0; f < scene.faces().size(); ++f) {
    const Face& face = scene.faces()[f];
    for (std::uint32_t k = face.first_facet; k < face.first_facet + face.facet_count; ++k) {
      lit_one.lay_flat(k, layer_one);
      lit_other.lay_flat(k, layer_other);
      by_face[f] += symmetric_difference(layer_one, layer_other);
    }
  }
  return by_face;
}

std::vector<double> difference_shares(const Scene& scene, const Shadows& one,
                                      const Shadows& other) {
  std::vector<double> shares = lit_differences(scene, one, other);
  for (std::uint32_t f = 0; f < shares.size(); ++f) {
    const Face& face = scene.faces()[f];
    const double region = shares[f], area = std::abs(one.areas[f].lit - other.areas[f].lit);
    if (face.facet_count == 0) shares[f] = 0;
    else
      shares[f] = std::isfinite(region + area) ? std::max(region, area) / face.area
                                               : std::numeric_limits<double>::infinity();
  }
  return shares;
}

Difference greatest_difference(const Scene& scene, const Shadows& one, const Shadows& other) {
  const std::vector<double> shares = difference_shares(scene, one, other);
  Difference greatest;
  for (std::uint32_t f = 0; f < shares.size(); ++f) {
    if (scene.faces()[f].facet_count == 0) continue;
    if (greatest.face == invalid_index || shares[f] > greatest.share) greatest = {shares[f], f};
  }
  return greatest;
}

double tolerance_of(const Scene& scene, const Light& light, std::uint32_t f, Kernel kernel) {
  constexpr double largest = 1e-9, exact = 1e-12, unit_roundoff = 0x1p-53;
  if (kernel == Kernel::fast) return largest;
  const Face& face = scene.faces()[f];
  double area = 0;
  for (const Facet& facet : scene.facets().subspan(face.first_facet, face.facet_count)) {
    const Plane& plane = scene.planes()[facet.plane];
    const std::span<const Corner> corners = scene.corners_of(facet);
    double outline = 0, slide = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec3& x = scene.vertices()[corners[i].vertex];
      outline += (scene.vertices()[corners[(i + 1) % corners.size()].vertex] - x).norm();
      const Vec3 ray =
          light.kind == Light::Kind::point ? Vec3(light.position - x) : light.direction;
      const double sine = std::abs(plane.normal.dot(ray)) / ray.norm();
      const double off = plane.flatness + 4 * unit_roundoff * x.cwiseAbs().maxCoeff();
      slide = std::max(slide, off / sine);
    }
    area += outline * slide;
  }
  const double tolerance = exact + area / face.area;
  return tolerance < largest ? tolerance : largest;
}

}  // namespace shadowcut::cli
