// Groups are found by leaders: patches in order of their area, each joins the first leader in whose plane its corners lie, or becomes one.
//
// Leaders in whose plane a patch may lie are looked up by normal and offset. A plane within d of a patch's corners differs from the patch's
// own in direction by no more than d / breadth (below), which is tiny for a wall and large for a splinter. So leaders stand in grids of
// several cell sizes, powers of 8, and a patch asks the grid whose cells are some 8 to 64 times its own uncertainty: one or two cells of
// each coordinate.
#include "coplanar.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>

#include "id_table.hpp"
#include "light_space.hpp"
#include "numbers.hpp"

namespace shadowcut {
namespace {

// How a patch lies; lengths are multiplied by a unit.
struct Measure {
  Vec3 normal = Vec3::Zero();  // unit length; of no area: zero
  double area = 0, outline = 0;
  // For a square a quarter of its side, for a needle half its width. Corners moved by d turn Newell's normal by no more than d / breadth:
  // each term of its sum changes by d times a piece of the outline.
  double breadth() const { return outline > 0 ? area / outline : 0; }
};

// A power of two that makes this length about one.
double unit_for(double length) {
  int exponent;
  std::frexp(length, &exponent);
  return std::ldexp(1.0, -std::max(exponent, -1000));
}

Measure measure(const Figure& figure, const Patch& patch, double unit) {
  Measure out;
  Vec3 sum = Vec3::Zero();
  for (std::uint32_t k = patch.first_facet; k < patch.end_facet; ++k) {
    const Facet& f = figure.facets[k];
    const Vec3& origin = figure.at(f, 0);
    Vec3 last = Vec3::Zero();
    for (std::uint32_t i = 1; i <= f.corner_count; ++i) {
      const Vec3 spoke = (figure.at(f, i) - origin) * unit;
      sum += last.cross(spoke);
      out.outline += (spoke - last).norm();
      last = spoke;
    }
  }
  const double length = sum.norm();
  if (length == 0) return out;
  out.normal = sum / length;
  out.area = length / 2;
  return out;
}

class Grouping {
 public:
  Grouping(const Figure& figure, std::span<const Patch> patches, double tolerance, double most_turn)
      : figure_(figure), patches_(patches), most_turn_(most_turn), cells_(2 * patches.size()) {
    Eigen::AlignedBox3d box;
    for (const Patch& p : patches) {
      for (std::uint32_t k = p.first_facet; k < p.end_facet; ++k) {
        for (std::uint32_t i = 0; i < figure.facets[k].corner_count; ++i) box.extend(figure.at(figure.facets[k], i));
      }
    }
    if (box.isEmpty()) return;
    middle_ = box.min() / 2 + box.max() / 2;
    const double largest = box.max().cwiseAbs().cwiseMax(box.min().cwiseAbs()).maxCoeff();
    unit_ = unit_for(largest);  // then no distance from the middle is more than two
    tolerance_ = tolerance * (largest * unit_);
  }

  std::vector<Membership> run() {
    std::vector<Membership> out(patches_.size());
    for (std::uint32_t i = 0; i < out.size(); ++i) out[i] = {i, false};
    measures_.reserve(patches_.size());
    for (const Patch& p : patches_) measures_.push_back(measure(figure_, p, unit_));
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < patches_.size(); ++i) {
      if (!seeks(measures_[i])) continue;
      order.push_back(i);
      levels_.push_back(level_of(measures_[i]));
    }
    std::sort(levels_.begin(), levels_.end());
    levels_.erase(std::unique(levels_.begin(), levels_.end()), levels_.end());
    std::stable_sort(order.begin(), order.end(),
                     [this](std::uint32_t a, std::uint32_t b) { return measures_[a].area > measures_[b].area; });
    for (const std::uint32_t i : order) {
      const std::uint32_t leader = leader_for(i);
      if (leader == none) {
        enter(i);
      } else {
        out[i] = {leaders_[leader], measures_[leaders_[leader]].normal.dot(measures_[i].normal) < 0};
      }
    }
    return out;
  }

 private:
  using Cell = std::array<std::int64_t, 5>;  // level, normal, offset

  // How far a patch's corners may lie from a plane that it is to share.
  double reach(const Measure& m) const { return std::min(tolerance_, most_turn_ * m.breadth()); }
  static double rounding(const Measure& m) { return 8 * unit_roundoff * m.outline; }
  // A splinter whose normal is little more than rounding keeps it.
  bool seeks(const Measure& m) const { return m.area > 0 && rounding(m) <= 1e-6 * m.breadth(); }
  // By how much a plane within reach may differ in each component of its normal, and twice that in its offset.
  double difference(const Measure& m) const { return (reach(m) + rounding(m)) / m.breadth(); }
  // Cells of a level are 8^level wide.
  int level_of(const Measure& m) const {
    const int exponent = std::ilogb(difference(m)) + 4;
    return exponent >= 0 ? (exponent + 2) / 3 : -(-exponent / 3);
  }

  // Normal and offset, of one sign for both sides of a plane where the sign is clear.
  std::array<double, 4> coordinates(std::uint32_t patch) const {
    const Vec3& n = measures_[patch].normal;
    const double offset = n.dot((point_of(patch) - middle_) * unit_);
    return {n.x(), n.y(), n.z(), offset};
  }
  const Vec3& point_of(std::uint32_t patch) const { return figure_.at(figure_.facets[patches_[patch].first_facet], 0); }
  static double lean(const std::array<double, 4>& c) { return 0.48 * c[0] + 0.61 * c[1] + 0.63 * c[2]; }

  static std::uint64_t hash(const Cell& c) {
    std::uint64_t h = 0;
    for (const std::int64_t i : c) h = mix(h + static_cast<std::uint64_t>(i));
    return h;
  }

  void enter(std::uint32_t patch) {
    const auto leader = static_cast<std::uint32_t>(leaders_.size());
    leaders_.push_back(patch);
    auto c = coordinates(patch);
    if (lean(c) < 0) std::transform(c.begin(), c.end(), c.begin(), std::negate<>());
    for (const int level : levels_) {
      Cell key{level};
      for (std::size_t i = 0; i < 4; ++i) key[i + 1] = static_cast<std::int64_t>(std::floor(std::ldexp(c[i], -3 * level)));
      const auto next = static_cast<std::uint32_t>(keys_.size());
      const std::uint32_t cell = cells_.find_or_add(
          hash(key), next, [&](std::uint32_t k) { return keys_[k] == key; }, [&](std::uint32_t k) { return hash(keys_[k]); });
      if (cell == next) keys_.push_back(key), newest_.push_back(none);
      entries_.push_back({leader, newest_[cell]});
      newest_[cell] = static_cast<std::uint32_t>(entries_.size() - 1);
    }
  }

  // The first leader in whose plane the patch lies; none if there is none.
  std::uint32_t leader_for(std::uint32_t patch) const {
    const double around = 2 * difference(measures_[patch]);
    auto c = coordinates(patch);
    std::uint32_t best = none;
    if (lean(c) >= -around) look(patch, c, best);
    std::transform(c.begin(), c.end(), c.begin(), std::negate<>());
    if (lean(c) >= -around) look(patch, c, best);
    return best;
  }

  void look(std::uint32_t patch, const std::array<double, 4>& c, std::uint32_t& best) const {
    const int level = level_of(measures_[patch]);
    const double d = difference(measures_[patch]);
    Cell low{level}, high{level};
    for (std::size_t i = 0; i < 4; ++i) {
      const double around = i == 3 ? 4 * d : d;  // two lengths of the figure's size from the middle
      low[i + 1] = static_cast<std::int64_t>(std::floor(std::ldexp(c[i] - around, -3 * level)));
      high[i + 1] = static_cast<std::int64_t>(std::floor(std::ldexp(c[i] + around, -3 * level)));
    }
    Cell key = low;
    for (std::size_t i = 1; i < 5;) {
      look(patch, key, best);
      for (i = 1; i < 5 && key[i] == high[i]; ++i) key[i] = low[i];
      if (i < 5) ++key[i];
    }
  }

  void look(std::uint32_t patch, const Cell& key, std::uint32_t& best) const {
    const std::uint32_t cell = cells_.find(hash(key), [&](std::uint32_t k) { return keys_[k] == key; });
    if (cell == none) return;
    for (std::uint32_t e = newest_[cell]; e != none; e = entries_[e].next) {
      if (entries_[e].leader < best && lies_in(patch, leaders_[entries_[e].leader])) best = entries_[e].leader;
    }
  }

  bool lies_in(std::uint32_t patch, std::uint32_t leader) const {
    const Vec3 &n = measures_[leader].normal, &point = point_of(leader);
    const double most = reach(measures_[patch]);
    for (std::uint32_t k = patches_[patch].first_facet; k < patches_[patch].end_facet; ++k) {
      const Facet& f = figure_.facets[k];
      for (std::uint32_t i = 0; i < f.corner_count; ++i) {
        if (!(std::abs(n.dot((figure_.at(f, i) - point) * unit_)) <= most)) return false;
      }
    }
    return true;
  }

  struct Entry {
    std::uint32_t leader, next;
  };

  const Figure& figure_;
  std::span<const Patch> patches_;
  double most_turn_, tolerance_ = 0, unit_ = 1;
  Vec3 middle_ = Vec3::Zero();
  std::vector<Measure> measures_;
  std::vector<int> levels_;             // in use
  std::vector<std::uint32_t> leaders_;  // patches
  IdTable cells_;
  std::vector<Cell> keys_;             // by cell
  std::vector<std::uint32_t> newest_;  // by cell: into entries_
  std::vector<Entry> entries_;
};

// The width of a patch on which its direction rests.
double breadth(const Figure& figure, const Patch& patch) {
  Eigen::AlignedBox3d box;
  for (std::uint32_t k = patch.first_facet; k < patch.end_facet; ++k) {
    for (std::uint32_t i = 0; i < figure.facets[k].corner_count; ++i) box.extend(figure.at(figure.facets[k], i));
  }
  const double unit = unit_for(box.sizes().maxCoeff());
  return measure(figure, patch, unit).breadth() / unit;
}

// Exactly.
bool contains(const Plane& plane, const Vec3& x) {
  const Vec3 &n = plane.exact_normal, d = x - plane.point;
  if (std::abs(n.dot(d)) > 8 * unit_roundoff * n.cwiseAbs().dot(d.cwiseAbs())) return false;
  Expansion sum;
  for (int i = 0; i < 3; ++i) sum = sum + Expansion(n[i]) * Expansion::difference(x[i], plane.point[i]);
  return sum.sign() == 0;
}

bool parallel(const Vec3& m, const Vec3& n) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if ((Expansion(m[i]) * Expansion(n[j]) - Expansion(m[j]) * Expansion(n[i])).sign() != 0) return false;
  }
  return true;
}

template <class Do>
void for_each_corner(const Figure& figure, std::span<const Patch> patches, std::span<const std::uint32_t> group, const Do& act) {
  for (const std::uint32_t p : group) {
    for (std::uint32_t k = patches[p].first_facet; k < patches[p].end_facet; ++k) {
      for (std::uint32_t i = 0; i < figure.facets[k].corner_count; ++i) act(figure.at(figure.facets[k], i));
    }
  }
}

// The plane of a group, but for flatness and tilt: the leader's where all corners lie in it exactly; else one through the
// leader's first corner and two of the group's far from it and from each other. A leader that is one small tile of a large wall says little
// about the wall's far end.
Plane common_plane(const Figure& figure, std::span<const Patch> patches, std::span<const std::uint32_t> group, Plane leader) {
  const Vec3 origin = leader.point;
  bool in_it = true;
  Vec3 far = Vec3::Zero();
  for_each_corner(figure, patches, group, [&](const Vec3& x) {
    const Vec3 d = x - origin;
    in_it = in_it && contains(leader, x);
    if (d.stableNorm() > far.stableNorm()) far = d;
  });
  if (in_it) return leader;
  const double unit = unit_for(far.cwiseAbs().maxCoeff());
  far *= unit;
  Vec3 normal = Vec3::Zero();
  for_each_corner(figure, patches, group, [&](const Vec3& x) {
    const Vec3 n = far.cross((x - origin) * unit);
    if (n.squaredNorm() > normal.squaredNorm()) normal = n;
  });
  if (normal.dot(leader.normal) < 0) normal = -normal;
  leader.normal = normal.normalized();
  leader.exact_normal = normal * std::ldexp(1.0, -std::ilogb(normal.cwiseAbs().maxCoeff()));
  return leader;
}

}  // namespace

double distance_from(const Plane& plane, const Figure& figure, const Patch& patch) {
  double most = 0;
  const std::uint32_t only = 0;
  for_each_corner(figure, std::span(&patch, 1), std::span(&only, 1),
                  [&](const Vec3& x) { most = std::max(most, std::abs(plane.normal.dot(x - plane.point))); });
  return most;
}

bool same_plane(const Plane& p, const Plane& q) {
  if (p.exact_normal == q.exact_normal && p.point == q.point) return true;
  return parallel(p.exact_normal, q.exact_normal) && contains(p, q.point);
}

std::vector<Membership> find_groups(const Figure& figure, std::span<const Patch> patches, double tolerance, double most_turn) {
  return Grouping(figure, patches, tolerance, most_turn).run();
}

std::vector<Plane> common_planes(const Figure& figure, std::span<const Patch> patches, std::span<const Plane> own,
                                 std::span<const Membership> members) {
  std::vector<Plane> planes(own.begin(), own.end());
  std::vector<std::uint32_t> order(patches.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return members[a].leader < members[b].leader; });
  for (std::size_t begin = 0, end; begin < order.size(); begin = end) {
    const std::uint32_t leader = members[order[begin]].leader;
    for (end = begin + 1; end < order.size() && members[order[end]].leader == leader;) ++end;
    if (end == begin + 1) continue;
    const auto group = std::span<const std::uint32_t>(order).subspan(begin, end - begin);
    Plane common = common_plane(figure, patches, group, own[leader]);
    common.flatness = 0;
    for (const std::uint32_t p : group) common.flatness = std::max(common.flatness, distance_from(common, figure, patches[p]));
    for (const std::uint32_t p : group) {
      planes[p] = common;
      if (members[p].opposite) planes[p].normal = -common.normal, planes[p].exact_normal = -common.exact_normal;
      planes[p].tilt = own[p].tilt;
      if (common.flatness > 0) planes[p].tilt += common.flatness / breadth(figure, patches[p]);
    }
  }
  return planes;
}

}  // namespace shadowcut
