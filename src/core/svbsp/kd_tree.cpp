#include "svbsp/kd_tree.hpp"

#include <algorithm>
#include <cmath>

namespace shadowcut {
namespace {

// A plane through the light that divides the rays about evenly. False: none does.
bool dividing_plane(std::span<Vec3> rays, bool far, Vec3& n) {
  const auto count = static_cast<std::ptrdiff_t>(rays.size());
  // Around a near light the coordinate planes come first, until the rays lie in one octant.
  Vec3 c(0, 0, 1);
  if (!far) {
    std::ptrdiff_t best = count / 8;
    int axis = -1;
    for (int a = 0; a < 3; ++a) {
      const std::ptrdiff_t above =
          std::count_if(rays.begin(), rays.end(), [a](const Vec3& r) { return r[a] > 0; });
      c[a] = 2 * above > count ? 1 : -1;
      if (std::min(above, count - above) > best) best = std::min(above, count - above), axis = a;
    }
    if (axis >= 0) {
      n = Vec3::Unit(axis);
      return true;
    }
  }
  // Inside an octant r / (c.r) maps the rays to a flat triangle; take the median along its longer
  // side.
  const int axes = far ? 2 : 3;
  int axis = 0;
  double widest = -1;
  const auto along = [&c](const Vec3& r, int a) { return r[a] / c.dot(r); };
  for (int a = 0; a < axes; ++a) {
    double mean = 0, square = 0;
    for (const Vec3& r : rays) {
      const double t = along(r, a);
      mean += t, square += t * t;
    }
    const double variance = square - mean * mean / static_cast<double>(count);
    if (variance > widest) widest = variance, axis = a;
  }
  const auto middle = rays.begin() + count / 2;
  std::nth_element(rays.begin(), middle, rays.end(),
                   [&](const Vec3& a, const Vec3& b) { return along(a, axis) < along(b, axis); });
  const double k = along(*middle, axis);
  if (!std::isfinite(k)) return false;
  n = (Vec3::Unit(axis) - k * c).normalized();
  return n.allFinite();
}

}  // namespace

KdTree::KdTree(std::vector<Vec3> rays, bool far, std::uint32_t facets_per_cell, LineTable& lines)
    : lines_(&lines) {
  struct Range {
    std::size_t begin, end;
    Place above;
    std::uint32_t depth;
  };
  lines.begin_kd_lines();
  std::vector<Range> pending{{0, rays.size(), Place::root(), 0}};
  while (!pending.empty()) {
    const Range range = pending.back();
    pending.pop_back();
    const std::span<Vec3> here(rays.data() + range.begin, range.end - range.begin);
    Branch branch = Branch::cell(CellId(cell_above_.size()));
    Vec3 n;
    if (facets_per_cell != 0 && here.size() > facets_per_cell && dividing_plane(here, far, n)) {
      const auto middle =
          std::partition(here.begin(), here.end(), [&n](const Vec3& r) { return n.dot(r) > 0; });
      const std::size_t cut = range.begin + static_cast<std::size_t>(middle - here.begin());
      if (cut > range.begin && cut < range.end) {
        const NodeId node(nodes_.size());
        branch = Branch::node(node);
        node_above_.push_back(range.above);
        // The line is what these numbers say: it has no error.
        const LineId line =
            lines.add_kd_line({{n[0], n[1], n[2]}, 0.0f, invalid_index, invalid_index});
        nodes_.push_back({line, {Branch::cell(CellId(0u)), Branch::cell(CellId(0u))}});
        pending.push_back({cut, range.end, Place(node, 1), range.depth + 1});
        pending.push_back({range.begin, cut, Place(node, 0), range.depth + 1});
      }
    }
    if (branch.is_cell()) {
      depth_.push_back(range.depth);
      cell_above_.push_back(range.above);
    }
    if (range.above.is_root()) {
      root_ = branch;
    } else {
      nodes_[range.above.node().value()].side[range.above.side()] = branch;
    }
  }
  lines.end_kd_lines();
  SHADOWCUT_ASSERT(cell_above_.size() == nodes_.size() + 1);
}

Cone* KdTree::part_in(CellId cell, Cone* cone, const CellPredicates& predicates,
                      Workspace& w) const {
  std::vector<Place> way;
  for (Place p = cell_above_[cell.value()]; !p.is_root(); p = node_above_[p.node().value()])
    way.push_back(p);
  SHADOWCUT_ASSERT(way.size() == depth_of(cell));
  for (auto p = way.rbegin(); p != way.rend() && cone; ++p)
    cone = clip(cone, dividing_line(p->node()), p->side(), predicates, w);
  return cone;
}

}  // namespace shadowcut
