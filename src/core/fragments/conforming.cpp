// Both sides of a cut name the cut by the same line, so no geometry has to be searched: the corners
// that end an edge on a line are gathered by line, sorted along it, and inserted into every edge on
// that line that passes over them.

#include "fragments/conforming.hpp"

#include <algorithm>
#include <numeric>

#include "support/parallel.hpp"

namespace shadowcut {
namespace {

struct FragmentRef {
  std::uint32_t face, output, fragment;
};

// A line as it lies in a face. A face that was not flat has several planes, and a line that cuts
// two of them lies in each elsewhere; only the facets' own edges are in both.
struct FaceLine {
  std::uint64_t line;
  std::uint32_t plane;  // none: the line is an edge of the facet
  friend auto operator<=>(const FaceLine&, const FaceLine&) = default;
};

struct End {  // a corner at the end of an edge
  FaceLine line;
  double along;
  Vec3 x;
};

struct Insertion {  // behind which corner of which fragment
  std::uint32_t corner;
  Vec3 x;
};

FaceLine key_of(const Scene& scene, std::uint32_t facet, std::uint64_t line) {
  for (const Corner& c : scene.corners_of(scene.facets()[facet])) {
    if (c.edge >> 1 == line) return {line, invalid_index};
  }
  return {line, scene.facets()[facet].plane};
}

// The face's edges' ends, sorted by line and along it.
std::vector<End> ends_of(const Scene& scene, std::span<const FragmentRef> face,
                         const std::vector<CellOutput>& outputs) {
  std::vector<End> ends;
  for (const FragmentRef& ref : face) {
    const CellOutput& o = outputs[ref.output];
    const Fragment& f = o.block.fragments[ref.fragment];
    for (std::uint32_t i = 0; i < f.corner_count; ++i) {
      const FaceLine line = key_of(scene, f.facet, o.edge_lines[f.first_corner + i]);
      ends.push_back({line, 0, o.block.corners[f.first_corner + i]});
      ends.push_back({line, 0, o.block.corners[f.first_corner + (i + 1) % f.corner_count]});
    }
  }
  std::stable_sort(ends.begin(), ends.end(),
                   [](const End& a, const End& b) { return a.line < b.line; });
  for (auto begin = ends.begin(); begin != ends.end();) {
    const auto end =
        std::find_if(begin, ends.end(), [&](const End& e) { return e.line != begin->line; });
    Eigen::AlignedBox3d box;
    for (auto e = begin; e != end; ++e) box.extend(e->x);
    Eigen::Index axis;
    box.sizes().maxCoeff(&axis);
    for (auto e = begin; e != end; ++e) e->along = e->x[axis];
    std::stable_sort(begin, end, [](const End& a, const End& b) { return a.along < b.along; });
    begin = end;
  }
  return ends;
}

// The corners strictly between the ends of the edge a -> b, in its direction.
void between(const std::vector<End>& ends, FaceLine line, const Vec3& a, const Vec3& b,
             std::vector<Vec3>& out) {
  out.clear();
  auto first = std::lower_bound(ends.begin(), ends.end(), line,
                                [](const End& e, FaceLine l) { return e.line < l; });
  const auto last = std::upper_bound(first, ends.end(), line,
                                     [](FaceLine l, const End& e) { return l < e.line; });
  double at_a = 0, at_b = 0;
  for (auto e = first; e != last; ++e) {
    if (e->x == a) at_a = e->along;
    if (e->x == b) at_b = e->along;
  }
  const double low = std::min(at_a, at_b), high = std::max(at_a, at_b);
  first = std::lower_bound(first, last, low, [](const End& e, double t) { return e.along < t; });
  for (; first != last && first->along <= high; ++first) {
    if (first->along == low || first->along == high || first->x == a || first->x == b) continue;
    if (out.empty() || out.back() != first->x) out.push_back(first->x);
  }
  if (at_a > at_b) std::reverse(out.begin(), out.end());
}

// The corners of one face that are one point up to rounding get the same numbers. Two lines meet in
// one corner on both sides of a cut, and so do the edges of one vertex. But where an edge pierces a
// face, or edges of different objects line up, more than two lines pass through one point, and each
// pair of lines gives the point with its own last bits.
class FaceWelder {
 public:
  FaceWelder(const Scene& scene, std::span<const FragmentRef> face,
             std::vector<CellOutput>& outputs) {
    for (const FragmentRef& ref : face) {
      Block& block = outputs[ref.output].block;
      const Fragment& f = block.fragments[ref.fragment];
      for (std::uint32_t i = 0; i < f.corner_count; ++i)
        corners_.push_back(&block.corners[f.first_corner + i]);
    }
    // The scene's own vertices stay; other corners get the numbers of the first point near enough.
    Eigen::AlignedBox3d box;
    const Face& of = scene.faces()[face[0].face];
    for (const Facet& facet : scene.facets().subspan(of.first_facet, of.facet_count)) {
      for (const Corner& c : scene.corners_of(facet))
        points_.push_back(scene.vertices()[c.vertex]), box.extend(points_.back());
    }
    vertices_ = points_.size();
    const double farthest =
        std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
    near_ = 1e-12 * std::max(box.sizes().maxCoeff(), farthest * 1e-2);
    for (const Vec3* c : corners_) points_.push_back(*c);
  }

  void weld() {
    std::vector<std::uint32_t> order(points_.size());
    std::iota(order.begin(), order.end(), 0u);
    group_ = order;
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return points_[a].x() != points_[b].x() ? points_[a].x() < points_[b].x() : a < b;
    });
    for (std::size_t i = 0; i < order.size(); ++i) {
      const Vec3& x = points_[order[i]];
      for (std::size_t j = i; j-- > 0 && x.x() - points_[order[j]].x() <= near_;) {
        if ((x - points_[order[j]]).cwiseAbs().maxCoeff() <= near_) join(order[i], order[j]);
      }
    }
    for (std::size_t i = 0; i < corners_.size(); ++i)
      *corners_[i] = points_[group_of(static_cast<std::uint32_t>(vertices_ + i))];
  }

 private:
  std::uint32_t group_of(std::uint32_t i) {
    while (group_[i] != i) i = group_[i] = group_[group_[i]];
    return i;
  }
  // Two vertices of the scene are never joined.
  void join(std::uint32_t i, std::uint32_t j) {
    const std::uint32_t a = group_of(i), b = group_of(j);
    if (a >= vertices_ || b >= vertices_) group_[std::max(a, b)] = std::min(a, b);
  }

  std::vector<Vec3*> corners_;
  std::vector<Vec3> points_;  // the vertices of the face, then the corners
  std::size_t vertices_ = 0;
  double near_ = 0;
  std::vector<std::uint32_t> group_;  // union-find, by point
};

// The fragments of every face that has more than one fragment.
struct FragmentsByFace {
  std::vector<FragmentRef> refs;
  std::vector<std::span<const FragmentRef>> faces;  // into refs

  explicit FragmentsByFace(const std::vector<CellOutput>& outputs) {
    for (std::uint32_t o = 0; o < outputs.size(); ++o) {
      const auto& fragments = outputs[o].block.fragments;
      for (std::uint32_t i = 0; i < fragments.size(); ++i)
        refs.push_back({fragments[i].face, o, i});
    }
    std::stable_sort(refs.begin(), refs.end(),
                     [](const FragmentRef& a, const FragmentRef& b) { return a.face < b.face; });
    for (std::size_t begin = 0; begin < refs.size();) {
      std::size_t end = begin;
      while (end < refs.size() && refs[end].face == refs[begin].face) ++end;
      if (end - begin > 1) faces.emplace_back(refs.data() + begin, end - begin);
      begin = end;
    }
  }
};

// By output and fragment: the corners to insert.
using Insertions = std::vector<std::vector<std::vector<Insertion>>>;

// The corners of other fragments of a face that are on the edges of its fragments.
void find_insertions(const Scene& scene, std::span<const FragmentRef> face,
                     const std::vector<CellOutput>& outputs, Insertions& insertions) {
  const std::vector<End> ends = ends_of(scene, face, outputs);
  std::vector<Vec3> found;
  for (const FragmentRef& ref : face) {
    const CellOutput& o = outputs[ref.output];
    const Fragment& f = o.block.fragments[ref.fragment];
    for (std::uint32_t k = 0; k < f.corner_count; ++k) {
      const std::uint32_t here = f.first_corner + k,
                          next = f.first_corner + (k + 1) % f.corner_count;
      between(ends, key_of(scene, f.facet, o.edge_lines[here]), o.block.corners[here],
              o.block.corners[next], found);
      for (const Vec3& x : found) insertions[ref.output][ref.fragment].push_back({k, x});
    }
  }
}

// Rebuilds a block with the corners inserted. Corners that have become one are left out, and so are
// fragments with fewer than three corners.
void insert_corners(Block& block, const std::vector<std::vector<Insertion>>& insertions) {
  std::vector<Vec3> corners;
  corners.reserve(block.corners.size());
  for (std::size_t i = 0; i < block.fragments.size(); ++i) {
    Fragment& f = block.fragments[i];
    const auto first = static_cast<std::uint32_t>(corners.size());
    const auto put = [&](const Vec3& x) {
      if (corners.size() == first || corners.back() != x) corners.push_back(x);
    };
    auto inserted = insertions[i].begin();
    for (std::uint32_t k = 0; k < f.corner_count; ++k) {
      put(block.corners[f.first_corner + k]);
      for (; inserted != insertions[i].end() && inserted->corner == k; ++inserted) put(inserted->x);
    }
    while (corners.size() > first + 1 && corners.back() == corners[first]) corners.pop_back();
    SHADOWCUT_ASSERT(inserted == insertions[i].end());
    f.first_corner = first;
    f.corner_count = static_cast<std::uint32_t>(corners.size()) - first;
    if (f.corner_count < 3) corners.resize(first);
  }
  std::erase_if(block.fragments, [](const Fragment& f) { return f.corner_count < 3; });
  block.corners = std::move(corners);
}

}  // namespace

void make_conforming(const Scene& scene, std::vector<CellOutput>& outputs) {
  const FragmentsByFace all(outputs);
  // A fragment belongs to one face, so threads never write to one fragment.
  parallel_for(all.faces.size(), 1,
               [&](std::size_t i) { FaceWelder(scene, all.faces[i], outputs).weld(); });
  Insertions insertions(outputs.size());
  for (std::size_t o = 0; o < outputs.size(); ++o)
    insertions[o].resize(outputs[o].block.fragments.size());
  parallel_for(all.faces.size(), 1,
               [&](std::size_t i) { find_insertions(scene, all.faces[i], outputs, insertions); });
  parallel_for(outputs.size(), 1,
               [&](std::size_t o) { insert_corners(outputs[o].block, insertions[o]); });
}

}  // namespace shadowcut
