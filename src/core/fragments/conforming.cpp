// Both sides of a cut name it by the same line, so no geometry has to be searched: the corners that
// end an edge on a line are gathered by line, sorted along it, and given to every edge on that line
// that passes over them.

#include "fragments/conforming.hpp"

#include <algorithm>

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
    if (c.edge >> 1 == line) return {line, none};
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

// Two lines meet in one corner whoever cuts, and so do the edges of one vertex. But where an edge
// pierces a face, or edges of different objects line up, more lines pass through one point, and
// each pair of them gives it with its own last bits.
void weld(const Scene& scene, std::span<const std::span<const FragmentRef>> faces,
          std::vector<CellOutput>& outputs) {
  parallel_for(faces.size(), 1, [&](std::size_t face) {
    std::vector<Vec3*> all;
    for (const FragmentRef& ref : faces[face]) {
      Block& block = outputs[ref.output].block;
      const Fragment& f = block.fragments[ref.fragment];
      for (std::uint32_t i = 0; i < f.corner_count; ++i)
        all.push_back(&block.corners[f.first_corner + i]);
    }
    // The input's own vertices stand; other corners take the numbers of the first one near enough.
    Eigen::AlignedBox3d box;
    std::vector<Vec3> anchors;
    for (const Facet& facet :
         scene.facets().subspan(scene.faces()[faces[face][0].face].first_facet,
                                scene.faces()[faces[face][0].face].facet_count)) {
      for (const Corner& c : scene.corners_of(facet))
        anchors.push_back(scene.vertices()[c.vertex]), box.extend(anchors.back());
    }
    const double near =
        1e-12 *
        std::max(box.sizes().maxCoeff(),
                 std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff()) * 1e-2);
    const std::size_t vertices = anchors.size();
    for (const Vec3* c : all) anchors.push_back(*c);
    std::vector<std::uint32_t> order(anchors.size()), group(anchors.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = group[i] = i;
    const auto find = [&](std::uint32_t i) {
      while (group[i] != i) i = group[i] = group[group[i]];
      return i;
    };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return anchors[a].x() != anchors[b].x() ? anchors[a].x() < anchors[b].x() : a < b;
    });
    for (std::size_t i = 0; i < order.size(); ++i) {
      for (std::size_t j = i; j-- > 0 && anchors[order[i]].x() - anchors[order[j]].x() <= near;) {
        if ((anchors[order[i]] - anchors[order[j]]).cwiseAbs().maxCoeff() > near) continue;
        const std::uint32_t a = find(order[i]), b = find(order[j]);
        if (a >= vertices || b >= vertices) group[std::max(a, b)] = std::min(a, b);
      }
    }
    for (std::size_t i = 0; i < all.size(); ++i)
      *all[i] = anchors[find(static_cast<std::uint32_t>(vertices + i))];
  });
}

}  // namespace

void make_conforming(const Scene& scene, std::vector<CellOutput>& outputs) {
  std::vector<FragmentRef> refs;
  for (std::uint32_t o = 0; o < outputs.size(); ++o) {
    const auto& fragments = outputs[o].block.fragments;
    for (std::uint32_t i = 0; i < fragments.size(); ++i) refs.push_back({fragments[i].face, o, i});
  }
  std::stable_sort(refs.begin(), refs.end(),
                   [](const FragmentRef& a, const FragmentRef& b) { return a.face < b.face; });
  std::vector<std::span<const FragmentRef>> faces;
  for (std::size_t begin = 0; begin < refs.size();) {
    std::size_t end = begin;
    while (end < refs.size() && refs[end].face == refs[begin].face) ++end;
    if (end - begin > 1) faces.emplace_back(refs.data() + begin, end - begin);
    begin = end;
  }

  weld(scene, faces, outputs);

  // By output and fragment: what to add. A fragment belongs to one face, so threads never meet.
  std::vector<std::vector<std::vector<Insertion>>> insertions(outputs.size());
  for (std::size_t o = 0; o < outputs.size(); ++o)
    insertions[o].resize(outputs[o].block.fragments.size());
  parallel_for(faces.size(), 1, [&](std::size_t i) {
    const std::vector<End> ends = ends_of(scene, faces[i], outputs);
    std::vector<Vec3> found;
    for (const FragmentRef& ref : faces[i]) {
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
  });

  parallel_for(outputs.size(), 1, [&](std::size_t o) {
    Block& block = outputs[o].block;
    std::vector<Vec3> corners;
    corners.reserve(block.corners.size());
    for (std::size_t i = 0; i < block.fragments.size(); ++i) {
      Fragment& f = block.fragments[i];
      const auto first = static_cast<std::uint32_t>(corners.size());
      const auto put = [&](const Vec3& x) {
        if (corners.size() == first || corners.back() != x) corners.push_back(x);
      };
      auto add = insertions[o][i].begin();
      for (std::uint32_t k = 0; k < f.corner_count; ++k) {
        put(block.corners[f.first_corner + k]);
        for (; add != insertions[o][i].end() && add->corner == k; ++add) put(add->x);
      }
      while (corners.size() > first + 1 && corners.back() == corners[first]) corners.pop_back();
      f.first_corner = first;
      f.corner_count = static_cast<std::uint32_t>(corners.size()) - first;
      if (f.corner_count < 3) corners.resize(first);
    }
    std::erase_if(block.fragments, [](const Fragment& f) { return f.corner_count < 3; });
    block.corners = std::move(corners);
  });
}

}  // namespace shadowcut
