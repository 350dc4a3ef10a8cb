// Groups are found by leaders: in order of their area, a patch that has no leader becomes one, and
// takes all those without one whose corners lie in its plane.
//
// They are found in a tree over all patches, in which a plane passes by what lies elsewhere or
// another way. How far another way matters: a plane within d of a patch's corners differs from the
// patch's own in direction by no more than d / breadth (below), which is tiny for a wall and large
// for a splinter.
#include "scene/coplanar_groups.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "numbers/error_free.hpp"
#include "numbers/exact_numbers.hpp"

namespace shadowcut {
namespace {

template <class Do>
void for_corners(const Figure& figure, const Patch& patch, const Do& act) {
  for (std::uint32_t k = patch.first_facet; k < patch.end_facet; ++k) {
    for (std::uint32_t i = 0; i < figure.facets[k].corner_count; ++i)
      act(figure.at(figure.facets[k], i));
  }
}

// How a patch lies; lengths are multiplied by a unit.
struct Measure {
  Vec3 normal = Vec3::Zero();  // unit length; of no area: zero
  double area = 0, outline = 0;
  // For a square a quarter of its side, for a needle half its width. Corners moved by d turn
  // Newell's normal by no more than d / breadth: each term of its sum changes by d times a piece of
  // the outline.
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
  SHADOWCUT_ASSERT(patch.first_facet < patch.end_facet && patch.end_facet <= figure.facets.size());
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
      : figure_(figure), patches_(patches), most_turn_(most_turn) {
    Eigen::AlignedBox3d box;
    for (const Patch& p : patches) for_corners(figure, p, [&](const Vec3& x) { box.extend(x); });
    if (box.isEmpty()) return;
    middle_ = box.min() / 2 + box.max() / 2;
    const double largest = box.max().cwiseAbs().cwiseMax(box.min().cwiseAbs()).maxCoeff();
    unit_ = unit_for(largest);  // then no distance from the middle is more than two
    tolerance_ = tolerance * (largest * unit_);
  }

  std::vector<Membership> run() {
    std::vector<Membership> out(patches_.size());
    leaf_of_.assign(patches_.size(), invalid_index);
    for (std::uint32_t i = 0; i < out.size(); ++i) {
      out[i] = {i, false};
      measures_.push_back(measure(figure_, patches_[i], unit_));
      const Measure& m = measures_.back();
      // A splinter whose normal is little more than rounding keeps it.
      const double rounding = 8 * unit_roundoff * m.outline;
      if (!(m.area > 0) || rounding > 1e-6 * m.breadth()) continue;
      const double reach = std::min(tolerance_, most_turn_ * m.breadth());
      items_.push_back(item_of(i, (reach + rounding) / m.breadth(), reach));
    }
    if (items_.empty()) return out;
    std::vector<std::uint32_t> order;
    for (const Item& item : items_) order.push_back(item.patch);
    std::stable_sort(order.begin(), order.end(), [this](std::uint32_t a, std::uint32_t b) {
      return measures_[a].area > measures_[b].area;
    });
    build(0, static_cast<std::uint32_t>(items_.size()), invalid_index);
    for (const std::uint32_t leader : order) {
      SHADOWCUT_ASSERT(measures_[leader].area > 0);
      if (leaf_of_[leader] == invalid_index) continue;
      settle(leader);
      take(leader, out);
    }
    return out;
  }

 private:
  struct Item {
    std::uint32_t patch;
    // one for both sides of a plane, unless it lies nearly across (0.48, 0.61, 0.63)
    Vec3 normal;
    Vec3 middle;                       // of its corners
    double radius = 0, thickness = 0;  // of the corners about the middle; and along the normal
    double doubt;                      // by how much the normal of a plane in reach may differ
    double reach;                      // how far corners may lie from that plane
  };
  static constexpr std::uint32_t leaf_size = 8;
  static constexpr double slack = 32 * unit_roundoff;  // of coordinates about one
  struct Node {
    Vec3 axis, middle;
    double cone = 0;                   // normals differ from the axis by no more
    double radius = 0, thickness = 0;  // of all corners about the middle; and along the axis
    double doubt = 0, reach = 0;       // the largest
    std::uint32_t first, end;          // items
    std::uint32_t parent,
        second = invalid_index;  // the first child follows its parent; none: a leaf
    std::uint32_t waiting;       // items that have no leader yet
  };

  Vec3 scaled(const Vec3& x) const { return (x - middle_) * unit_; }

  Item item_of(std::uint32_t patch, double doubt, double reach) const {
    const Vec3& normal = measures_[patch].normal;
    Item item{patch,
              normal.dot(Vec3(0.48, 0.61, 0.63)) < 0 ? Vec3(-normal) : normal,
              Vec3::Zero(),
              0,
              0,
              doubt,
              reach};
    double corners = 0;
    for_corners(figure_, patches_[patch],
                [&](const Vec3& x) { item.middle += scaled(x), ++corners; });
    item.middle /= corners;  // which is in the plane
    for_corners(figure_, patches_[patch], [&](const Vec3& corner) {
      const Vec3 x = scaled(corner);
      item.radius = std::max(item.radius, (x - item.middle).norm());
      item.thickness = std::max(item.thickness, std::abs(normal.dot(x - item.middle)));
    });
    return item;
  }

  Node node_of(std::uint32_t first, std::uint32_t end) const {
    Node node{};
    node.first = first, node.end = end, node.waiting = end - first;
    Eigen::AlignedBox3d box;
    Vec3 sum = Vec3::Zero();
    const std::span<const Item> items = std::span(items_).subspan(first, end - first);
    for (const Item& item : items) {
      sum += item.normal;
      box.extend(item.middle);
      node.doubt = std::max(node.doubt, item.doubt), node.reach = std::max(node.reach, item.reach);
    }
    node.axis = sum.normalized();
    node.middle = box.center();
    for (const Item& item : items) {
      const double apart = (item.normal - node.axis).norm();
      node.cone = std::max(node.cone, apart);
      node.radius = std::max(node.radius, (item.middle - node.middle).norm() + item.radius);
      node.thickness = std::max(node.thickness, std::abs(node.axis.dot(item.middle - node.middle)) +
                                                    item.thickness + apart * item.radius);
    }
    return node;
  }

  // Divides by what most keeps a plane from passing by: by doubt where that is very different, by
  // direction as far as the doubt lets it matter, then by height, and where neither matters by
  // place.
  void build(std::uint32_t first, std::uint32_t end, std::uint32_t parent) {
    const auto id = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back(node_of(first, end));
    nodes_[id].parent = parent;
    if (end - first <= leaf_size) {
      for (std::uint32_t i = first; i < end; ++i) leaf_of_[items_[i].patch] = id;
      return;
    }
    const Node& node = nodes_[id];
    const auto begin = items_.begin();
    Eigen::AlignedBox3d normals, points;
    double least_doubt = node.doubt;
    for (std::uint32_t i = first; i < end; ++i) {
      normals.extend(items_[i].normal), points.extend(items_[i].middle);
      least_doubt = std::min(least_doubt, items_[i].doubt);
    }
    Eigen::Index widest;
    const std::uint32_t half = first + (end - first) / 2;
    const auto divide = [&](const auto& value) {
      std::nth_element(begin + first, begin + half, begin + end, [&](const Item& a, const Item& b) {
        const double x = value(a), y = value(b);
        return x != y ? x < y : a.patch < b.patch;
      });
    };
    if (node.doubt > 64 * least_doubt) {
      divide([](const Item& i) { return i.doubt; });
    } else if (node.cone > 2 * node.doubt) {
      normals.sizes().maxCoeff(&widest);
      divide([widest](const Item& i) { return i.normal[widest]; });
    } else if (node.thickness > 2 * (node.doubt * node.radius + node.reach)) {
      divide([axis = node.axis](const Item& i) { return axis.dot(i.middle); });
    } else {
      points.sizes().maxCoeff(&widest);
      divide([widest](const Item& i) { return i.middle[widest]; });
    }
    build(first, half, id);
    nodes_[id].second = static_cast<std::uint32_t>(nodes_.size());
    build(half, end, id);
  }

  void settle(std::uint32_t patch) {
    for (std::uint32_t n = leaf_of_[patch]; n != invalid_index; n = nodes_[n].parent)
      --nodes_[n].waiting;
    leaf_of_[patch] = invalid_index;
  }

  // Gives a leader all that wait and lie in its plane.
  void take(std::uint32_t leader, std::vector<Membership>& out) {
    const Vec3 &n = measures_[leader].normal,
               &point = figure_.at(figure_.facets[patches_[leader].first_facet], 0);
    const Vec3 foot = scaled(point);
    pending_.assign(1, 0);
    while (!pending_.empty()) {
      const std::uint32_t id = pending_.back();
      pending_.pop_back();
      const Node& node = nodes_[id];
      if (node.waiting == 0 || passes_by(n, foot, node)) continue;
      if (node.second != invalid_index) {
        pending_.push_back(node.second);
        pending_.push_back(id + 1);
        continue;
      }
      for (std::uint32_t i = node.first; i < node.end; ++i) {
        const Item& item = items_[i];
        if (std::abs(n.dot(item.middle - foot)) >
            item.reach + item.thickness + item.doubt * item.radius + slack)
          continue;
        if (leaf_of_[item.patch] == invalid_index || !lies_in(item, n, point)) continue;
        settle(item.patch);
        out[item.patch] = {leader, n.dot(measures_[item.patch].normal) < 0};
      }
    }
  }

  // Whether no patch of a node can lie in the plane.
  static bool passes_by(const Vec3& n, const Vec3& foot, const Node& node) {
    const double apart = (n - (n.dot(node.axis) < 0 ? Vec3(-node.axis) : node.axis)).norm();
    if (apart > node.cone + node.doubt + slack) return true;
    return std::abs(n.dot(node.middle - foot)) >
           node.thickness + apart * node.radius + node.reach + slack;
  }

  bool lies_in(const Item& item, const Vec3& n, const Vec3& point) const {
    const Patch& patch = patches_[item.patch];
    for (std::uint32_t k = patch.first_facet; k < patch.end_facet; ++k) {
      const Facet& f = figure_.facets[k];
      for (std::uint32_t i = 0; i < f.corner_count; ++i) {
        if (!(std::abs(n.dot((figure_.at(f, i) - point) * unit_)) <= item.reach)) return false;
      }
    }
    return true;
  }

  const Figure& figure_;
  std::span<const Patch> patches_;
  double most_turn_, tolerance_ = 0, unit_ = 1;
  Vec3 middle_ = Vec3::Zero();
  std::vector<Measure> measures_;  // by patch
  std::vector<Item> items_;        // patches that may share, as the leaves have them
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> leaf_of_;  // by patch; none: it does not wait
  std::vector<std::uint32_t> pending_;
};

// The width of a patch on which its direction rests.
double breadth(const Figure& figure, const Patch& patch) {
  Eigen::AlignedBox3d box;
  for_corners(figure, patch, [&](const Vec3& x) { box.extend(x); });
  const double unit = unit_for(box.sizes().maxCoeff());
  return measure(figure, patch, unit).breadth() / unit;
}

// Exactly.
bool contains(const Plane& plane, const Vec3& x) {
  const Vec3 &n = plane.exact_normal, d = x - plane.point;
  if (std::abs(n.dot(d)) > 8 * unit_roundoff * n.cwiseAbs().dot(d.cwiseAbs())) return false;
  Expansion sum;
  for (int i = 0; i < 3; ++i)
    sum = sum + Expansion(n[i]) * Expansion::difference(x[i], plane.point[i]);
  return sum.sign() == 0;
}

bool parallel(const Vec3& m, const Vec3& n) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if ((Expansion(m[i]) * Expansion(n[j]) - Expansion(m[j]) * Expansion(n[i])).sign() != 0)
      return false;
  }
  return true;
}

// The plane of a group, but for flatness and tilt: the leader's where all corners lie in it
// exactly; else one through the leader's first corner and two of the group's far from it and from
// each other. A leader that is one small tile of a large wall says little about the wall's far end.
Plane common_plane(const Figure& figure, std::span<const Patch> patches,
                   std::span<const std::uint32_t> group, Plane leader) {
  const Vec3 origin = leader.point;
  const auto for_group = [&](const auto& act) {
    for (const std::uint32_t p : group) for_corners(figure, patches[p], act);
  };
  bool in_it = true;
  for_group([&](const Vec3& x) { in_it = in_it && contains(leader, x); });
  if (in_it) return leader;
  Vec3 far = Vec3::Zero();
  double longest = 0;
  for_group([&](const Vec3& x) {
    const Vec3 d = x - origin;
    if (const double length = d.stableNorm(); length > longest) far = d, longest = length;
  });
  const double unit = unit_for(far.cwiseAbs().maxCoeff());
  far *= unit;
  Vec3 normal = Vec3::Zero();
  for_group([&](const Vec3& x) {
    const Vec3 n = far.cross((x - origin) * unit);
    if (n.squaredNorm() > normal.squaredNorm()) normal = n;
  });
  if (normal.dot(leader.normal) < 0) normal = -normal;
  // What rounding has left across an axis goes: short normals keep exact signs cheap.
  normal = normal.unaryExpr([least = 0x1p-50 * normal.cwiseAbs().maxCoeff()](double c) {
    return std::abs(c) < least ? 0.0 : c;
  });
  leader.normal = normal.normalized();
  leader.exact_normal = normal * std::ldexp(1.0, -std::ilogb(normal.cwiseAbs().maxCoeff()));
  return leader;
}

}  // namespace

double distance_from(const Plane& plane, const Figure& figure, const Patch& patch) {
  double most = 0;
  for_corners(figure, patch, [&](const Vec3& x) {
    most = std::max(most, std::abs(plane.normal.dot(x - plane.point)));
  });
  return most;
}

bool same_plane(const Plane& p, const Plane& q) {
  if (p.exact_normal == q.exact_normal && p.point == q.point) return true;
  return parallel(p.exact_normal, q.exact_normal) && contains(p, q.point);
}

std::vector<Membership> find_groups(const Figure& figure, std::span<const Patch> patches,
                                    double tolerance, double most_turn) {
  return Grouping(figure, patches, tolerance, most_turn).run();
}

std::vector<Plane> common_planes(const Figure& figure, std::span<const Patch> patches,
                                 std::span<const Plane> own, std::span<const Membership> members) {
  std::vector<Plane> planes(own.begin(), own.end());
  std::vector<std::uint32_t> order(patches.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return members[a].leader < members[b].leader;
  });
  for (std::size_t begin = 0, end; begin < order.size(); begin = end) {
    const std::uint32_t leader = members[order[begin]].leader;
    for (end = begin + 1; end < order.size() && members[order[end]].leader == leader;) ++end;
    if (end == begin + 1) continue;
    const auto group = std::span<const std::uint32_t>(order).subspan(begin, end - begin);
    Plane common = common_plane(figure, patches, group, own[leader]);
    common.flatness = 0;
    for (const std::uint32_t p : group)
      common.flatness = std::max(common.flatness, distance_from(common, figure, patches[p]));
    for (const std::uint32_t p : group) {
      planes[p] = common;
      if (members[p].opposite)
        planes[p].normal = -common.normal, planes[p].exact_normal = -common.exact_normal;
      planes[p].tilt = own[p].tilt;
      if (common.flatness > 0) planes[p].tilt += common.flatness / breadth(figure, patches[p]);
    }
  }
  return planes;
}

}  // namespace shadowcut
