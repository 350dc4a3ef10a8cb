// Merging of BSP trees: B. Naylor, J. Amanatides, W. Thibault, "Merging BSP trees yields polyhedral
// set operations", SIGGRAPH 1990 (NAT90).
//
// Two trees over one region become one. The first one's root stays the root. The other tree is
// *partitioned* by the part of its plane that lies in the region (the bounded sub-hyperplane): at
// each node the two parts are compared, and either both subtrees go down both sides (they cross),
// or one subtree goes whole to one side. Then the children are merged with what fell to their
// sides, until one of two trees is a single cell. Here every plane of an SP-node contains the
// light: a region is a convex cone, and the bounded part of a plane an arc of a great circle. So
// what NAT90 do in space with polygons is done on the sphere with arcs.
//
// At a PP-node the other tree is partitioned by the face's plane: along every ray of the region, so
// its SP-nodes are all on both sides. What is behind has no tree, only a list: the polygons of the
// other tree that are behind, with what they hide, join the list.
//
// Departures, all because the result is an SVBSP tree: an SP-node that bounds the shadow volume of
// a polygon still inside stays, though it may not reach into the region; a polygon that meets a
// piece of itself is absorbed by it; an SP-node whose polygon is not inside any more goes if one of
// its sides is OUT, and otherwise stays as a marked, dividing plane (CS95, section 4). Nothing
// recurses.

#include <algorithm>
#include <cmath>

#include "svbsp.hpp"

namespace shadowcut::compare {
namespace {

using Extent = Arc::Extent;

struct ArcSides {
  bool positive = false, negative = false;
  bool both() const { return positive && negative; }
  bool on() const { return !positive && !negative; }
};

// On which sides of m an arc of the plane n lies.
ArcSides sides_of(const Arc& arc, const Vec3& n, const Vec3& m) {
  if (arc.extent == Extent::whole) {
    const bool crosses = n.cross(m).norm() > epsilon;
    return {crosses, crosses};
  }
  ArcSides out;
  for (const Vec3* r : {&arc.from, &arc.to, &arc.middle}) {
    const int s = sign_of(m.dot(*r));
    out.positive = out.positive || s > 0, out.negative = out.negative || s < 0;
  }
  return out;
}

// The larger part of it, where it is on one side but for rounding.
int side_of(const Arc& arc, const Vec3& m) {
  double farthest = 0;
  for (const Vec3* r : {&arc.from, &arc.to, &arc.middle})
    if (std::abs(m.dot(*r)) > std::abs(farthest)) farthest = m.dot(*r);
  return farthest < 0 ? -1 : 1;
}

Arc arc_between(const Vec3& from, const Vec3& to) {
  return {Extent::part, from, to, (from + to).normalized()};
}

// The two parts of an arc that is on both sides of m.
void split(const Arc& arc, const Vec3& n, const Vec3& m, Arc& positive, Arc& negative) {
  const Vec3 cut = n.cross(m).normalized();
  if (arc.extent == Extent::whole) {
    const Vec3 middle = (m - m.dot(n) * n).normalized();
    positive = {Extent::part, cut, -cut, middle}, negative = {Extent::part, cut, -cut, -middle};
    return;
  }
  const Vec3 at = cut.dot(arc.middle) < 0 ? Vec3(-cut) : cut;
  const double a = m.dot(arc.from), b = m.dot(arc.to);  // one of them may be on m, but for rounding
  const bool ahead = std::abs(a) > std::abs(b) ? a > 0 : b < 0;
  positive = ahead ? arc_between(arc.from, at) : arc_between(at, arc.to);
  negative = ahead ? arc_between(at, arc.to) : arc_between(arc.from, at);
}

// A convex cone with the light as its apex: the planes that bound it, and where. Nothing bounds the
// whole of light space.
class Region {
 public:
  // The part of a plane that lies within; none if it only touches.
  Arc part_of(const Vec3& n) const {
    Arc arc;
    arc.extent = Extent::whole;
    for (const Bound& b : bounds_) {
      const ArcSides sides = sides_of(arc, n, b.n);
      if (sides.both()) {
        Arc inside, outside;
        split(arc, n, b.n, inside, outside);
        arc = inside;
      } else if (!sides.positive) {
        return {};
      }
    }
    return arc;
  }

  // On which side of a plane it lies that does not pass through it.
  int side(const Vec3& n) const {
    double farthest = 0;
    const auto look_at = [&](const Vec3& r) {
      if (std::abs(n.dot(r)) > std::abs(farthest)) farthest = n.dot(r);
    };
    for (const Bound& b : bounds_) {
      if (b.arc.extent == Extent::whole) look_at(b.n);  // half of light space
      else look_at(b.arc.from), look_at(b.arc.to), look_at(b.arc.middle);
    }
    return farthest < 0 ? -1 : 1;
  }

  // The part on the positive side of n; arc: part_of(n).
  Region cut(const Vec3& n, const Arc& arc) const {
    Region out;
    out.bounds_.reserve(bounds_.size() + 1);
    for (const Bound& b : bounds_) {
      const ArcSides sides = sides_of(b.arc, b.n, n);
      if (sides.both()) {
        Arc inside, outside;
        split(b.arc, b.n, n, inside, outside);
        out.bounds_.push_back({b.n, inside});
      } else if (sides.positive) {
        out.bounds_.push_back(b);
      }
    }
    out.bounds_.push_back({n, arc});
    return out;
  }

 private:
  struct Bound {
    Vec3 n;  // positive within
    Arc arc;
  };
  std::vector<Bound> bounds_;
};

class Merger {
 public:
  explicit Merger(Svbsp& tree) : tree_(tree) {}

  void merge(std::uint32_t place, std::uint32_t other) {
    Region region;
    for (std::uint32_t up = place; !Svbsp::is_top(up); up = tree_.nodes[up >> 1].parent) {
      const Node& node = tree_.nodes[up >> 1];
      if (node.kind != Node::Kind::sp) continue;
      if (const Arc arc = region.part_of(node.n); arc.extent != Extent::none)
        region = region.cut(up & 1 ? Vec3(-node.n) : node.n, arc);
    }
    tree_.put(other_place, other);
    bound(region);
    pending_.push_back({place, tree_.take(other_place), std::move(region)});
    while (!pending_.empty()) {
      Pair pair = std::move(pending_.back());
      pending_.pop_back();
      merge_roots(pair);
    }
    collapse_idle();
  }

 private:
  struct Pair {
    std::uint32_t place, other;  // a branch; a subtree that is to be merged into it
    Region region;
  };
  // Where a tree that is being partitioned is held, and the two parts that come of it; and, so that
  // one may be within the other, of what is in front of a crossing polygon.
  static constexpr std::uint32_t other_place = Svbsp::held_place, positive_place = other_place + 1,
                                 negative_place = other_place + 2;

  Arc& arc(std::uint32_t node) {
    if (tree_.arcs.size() <= node) tree_.arcs.resize(2 * node + 1);
    return tree_.arcs[node];
  }

  // Clips all planes of the other tree to their regions. What the region does not reach goes.
  void bound(const Region& whole) {
    std::vector<std::pair<std::uint32_t, Region>> rest;
    rest.emplace_back(tree_.child_at(other_place), whole);
    std::vector<std::uint32_t> seen;
    while (!rest.empty()) {
      auto [at, region] = std::move(rest.back());
      rest.pop_back();
      if (at == invalid_index) continue;
      if (tree_.nodes[at].kind == Node::Kind::pp) {
        rest.emplace_back(tree_.nodes[at].child[0], std::move(region));
        continue;
      }
      ++tree_.counts.bounded;
      const Vec3 n = tree_.nodes[at].n;
      const Arc part = arc(at) = region.part_of(n);
      if (part.extent != Extent::none) {
        rest.emplace_back(tree_.nodes[at].child[0], region.cut(n, part));
        rest.emplace_back(tree_.nodes[at].child[1], region.cut(-n, part));
        seen.push_back(at);
        continue;
      }
      const std::uint32_t unreached = region.side(n) > 0 ? 1 : 0;
      tree_.release_all(tree_.take(at * 2 + unreached));
      const std::uint32_t inner = tree_.nodes[at].child[1 - unreached];
      if (unreached == 0) tree_.collapse(at);
      else seen.push_back(at);
      rest.emplace_back(inner, std::move(region));
    }
    clean_up(seen);
  }

  void merge_roots(Pair& pair) {
    const std::uint32_t here = tree_.child_at(pair.place), other = pair.other;
    if (other == invalid_index) return;
    if (here == invalid_index) return tree_.put(pair.place, other);
    ++tree_.counts.visits;
    tree_.put(other_place, other);
    if (tree_.nodes[here].kind == Node::Kind::pp) {
      partition_by_face(here);
      pending_.push_back({here * 2, tree_.take(other_place), std::move(pair.region)});
      return;
    }
    const Vec3 n = tree_.nodes[here].n;
    ++tree_.counts.bounded;
    const Arc part = pair.region.part_of(n);
    if (part.extent == Extent::none) {
      const std::uint32_t side = pair.region.side(n) > 0 ? 0 : 1;
      pending_.push_back({here * 2 + side, tree_.take(other_place), std::move(pair.region)});
      return;
    }
    partition(n, part);
    pending_.push_back({here * 2 + 1, tree_.take(negative_place), pair.region.cut(-n, part)});
    pending_.push_back({here * 2, tree_.take(positive_place), pair.region.cut(n, part)});
  }

  // A node of the same kind with nothing below.
  std::uint32_t copy_of(std::uint32_t at) {
    const Node node = tree_.nodes[at];
    if (node.kind == Node::Kind::sp) return tree_.add_sp(node.n, node.surface, node.owner);
    return tree_.add_pp(node.surface);
  }

  // Divides the tree at other_place by the plane m, which lies in its region as an arc: into
  // positive_place and negative_place.
  void partition(const Vec3& m, const Arc& by) {
    struct Step {
      std::uint32_t at;
      Arc by;
      std::uint32_t places[2];  // where the parts go: positive, negative
    };
    std::vector<Step> rest{{tree_.take(other_place), by, {positive_place, negative_place}}};
    std::vector<std::uint32_t> made;
    while (!rest.empty()) {
      const Step step = rest.back();
      rest.pop_back();
      if (step.at == invalid_index) continue;
      ++tree_.counts.partitions;
      // The node itself goes on on the positive side, a copy on the negative one; clean_up() sees
      // which are needed.
      const std::uint32_t at = step.at, twin = copy_of(at);
      const std::uint32_t below[2] = {tree_.nodes[at].child[0], tree_.nodes[at].child[1]};
      tree_.nodes[at].child[0] = tree_.nodes[at].child[1] = invalid_index;
      tree_.put(step.places[0], at), tree_.put(step.places[1], twin);
      made.push_back(at), made.push_back(twin);
      if (tree_.nodes[at].kind == Node::Kind::pp) {
        divide_list(at, twin, m);
        rest.push_back({below[0], step.by, {at * 2, twin * 2}});
        continue;
      }
      const Arc own = arc(at);
      const Vec3 n = tree_.nodes[at].n;
      arc(twin) = {};
      if (own.extent == Extent::none) {  // all of the region is inside
        rest.push_back({below[0], step.by, {at * 2, twin * 2}});
        continue;
      }
      const ArcSides mine = sides_of(own, n, m), theirs = sides_of(step.by, m, n);
      const auto go_whole = [&](std::uint32_t child, bool positive) {
        tree_.put((positive ? at : twin) * 2 + child, below[child]);
      };
      if (mine.on() && theirs.on()) {  // one plane
        const bool along = n.dot(m) > 0;
        go_whole(0, along), go_whole(1, !along);
        set_arcs(at, twin, {}, {});
      } else if (mine.both() && theirs.both()) {
        Arc positive, negative, inside, outside;
        split(own, n, m, positive, negative);
        split(step.by, m, n, inside, outside);
        set_arcs(at, twin, positive, negative);
        rest.push_back({below[1], outside, {at * 2 + 1, twin * 2 + 1}});
        rest.push_back({below[0], inside, {at * 2, twin * 2}});
      } else {
        // Of two that touch and are nearly parallel, the longer one says on which side of the other
        // it lies; what lies between them and beyond follows from their directions.
        std::uint32_t reached = side_of(step.by, n) > 0 ? 0 : 1;
        const bool positive = mine.on() ? (n.dot(m) > 0) == (reached == 1) : side_of(own, m) > 0;
        if (theirs.on()) reached = (n.dot(m) > 0) == positive ? 1 : 0;
        set_arcs(at, twin, positive ? own : Arc{}, positive ? Arc{} : own);
        go_whole(1 - reached, positive);
        rest.push_back({below[reached], step.by, {at * 2 + reached, twin * 2 + reached}});
      }
    }
    clean_up(made);
  }

  void set_arcs(std::uint32_t at, std::uint32_t twin, const Arc& a, const Arc& b) {
    arc(at) = a, arc(twin) = b;
  }

  // The list of a PP-node that m divides: to each part what may be on its side.
  void divide_list(std::uint32_t positive, std::uint32_t negative, const Vec3& m) {
    for (std::uint32_t r = tree_.nodes[positive].first; r != invalid_index;) {
      const std::uint32_t next = tree_.next_record(r), surface = tree_.surface_of_record(r);
      const Sides2 sides = compare::sides_of(tree_.surfaces[surface].rays, m);
      if (sides.negative || !sides.positive) tree_.add_record(negative, surface);
      if (sides.negative && !sides.positive) tree_.drop_record(r);
      r = next;
    }
  }

  // SP-nodes just made or looked at, the upper ones first: finds the owner of each. What has none
  // and does not divide its region goes. What would leave a larger region to what is below it waits
  // until there is no more need of the arcs.
  void clean_up(const std::vector<std::uint32_t>& made) {
    for (auto at = made.rbegin(); at != made.rend(); ++at) {
      const Node& node = tree_.nodes[*at];
      if (node.kind != Node::Kind::sp) continue;
      const std::uint32_t inner = node.child[0];
      const bool bounds =
          inner != invalid_index && tree_.nodes[inner].surface == node.surface &&
          (tree_.nodes[inner].kind == Node::Kind::pp || tree_.nodes[inner].owner != invalid_index);
      tree_.set_owner(*at, !bounds                                     ? invalid_index
                           : tree_.nodes[inner].kind == Node::Kind::pp ? inner
                                                                       : tree_.nodes[inner].owner);
      if (bounds) continue;
      if (arc(*at).extent == Extent::none ||
          (inner == invalid_index && node.child[1] == invalid_index))
        tree_.collapse(*at);
      else if (inner == invalid_index || node.child[1] == invalid_index) idle_.push_back(*at);
    }
  }

  void collapse_idle() {
    for (std::uint32_t at : idle_) {
      while (tree_.nodes[at].kind == Node::Kind::sp && tree_.nodes[at].owner == invalid_index &&
             (tree_.nodes[at].child[0] == invalid_index ||
              tree_.nodes[at].child[1] == invalid_index)) {
        const std::uint32_t above = tree_.nodes[at].parent;
        tree_.collapse(at);
        if (Svbsp::is_top(above)) break;
        at = above >> 1;
      }
    }
  }

  // Takes out of the tree at other_place what is behind a PP-node, within whose volume it lies, or
  // touches it; that joins its list.
  void partition_by_face(std::uint32_t pp) {
    const std::uint32_t face = tree_.nodes[pp].surface;
    std::vector<std::uint32_t> rest{tree_.child_at(other_place)}, seen;
    while (!rest.empty()) {
      const std::uint32_t at = rest.back();
      rest.pop_back();
      if (at == invalid_index) continue;
      ++tree_.counts.partitions;
      if (tree_.nodes[at].kind == Node::Kind::sp) {
        seen.push_back(at);
        rest.push_back(tree_.nodes[at].child[0]), rest.push_back(tree_.nodes[at].child[1]);
        continue;
      }
      const std::uint32_t surface = tree_.nodes[at].surface, front = tree_.nodes[at].child[0];
      Relation relation = surface == face ? Relation::contact : tree_.relation(surface, face);
      if (relation == Relation::crossing) relation = cross(at, pp, rest);
      if (relation == Relation::crossing) continue;
      rest.push_back(front);
      if (relation == Relation::front) continue;
      tree_.add_record(pp, surface);
      tree_.copy_records(at, pp);
      tree_.put(tree_.nodes[at].parent, front);
      tree_.release(at);
    }
    clean_up(seen);
  }

  // A PP-node of the other tree whose polygon crosses that of pp: its relation, if here it is on
  // one side only; or it is divided.
  Relation cross(std::uint32_t at, std::uint32_t pp, std::vector<std::uint32_t>& rest) {
    const std::uint32_t surface = tree_.nodes[at].surface, face = tree_.nodes[pp].surface;
    Outline outline = tree_.surfaces[surface].rays;
    tree_.clip_to(outline, tree_.nodes[at].parent);
    tree_.clip_to(outline, pp * 2);
    const Vec3 d = tree_.nearer(surface, face);
    const double tolerance = tree_.touching(surface, face);
    const Sides2 sides = compare::sides_of(outline, d, tolerance);
    if (outline.empty() || (!sides.both() && sides.side() < 0)) return Relation::behind;
    const std::uint32_t above = tree_.nodes[at].parent;
    const bool is_new = tree_.bound_by_crossing(at, pp);
    if (is_new) arc(tree_.nodes[at].parent >> 1) = {};
    if (!sides.both() || !is_new) return Relation::front;

    // In front of the crossing it stays; beyond, only what was in front of it does.
    tree_.add_record(pp, surface);
    tree_.copy_records(at, pp);
    Outline positive, negative;
    Vec3 cut[2];
    compare::split(outline, d, tolerance, positive, negative, cut);
    const Vec3 n = tree_.crossing(surface, face);
    const std::uint32_t kept = tree_.take(other_place);
    tree_.put(other_place, tree_.take(at * 2));
    const Arc chord = arc_between(cut[0], cut[1]);
    partition(n, chord);
    const std::uint32_t front = tree_.take(positive_place), beyond = tree_.take(negative_place);
    tree_.put(other_place, kept);
    tree_.put(at * 2, front);
    const std::uint32_t sp = tree_.child_at(above);
    arc(sp) = chord;
    tree_.put(sp * 2 + 1, beyond);
    rest.push_back(front), rest.push_back(beyond);
    return Relation::crossing;
  }

  Svbsp& tree_;
  std::vector<std::uint32_t> idle_;  // nodes that may be without owner, with nothing on one side
  std::vector<Pair> pending_;
};

}  // namespace

void merge(Svbsp& tree, std::uint32_t place, std::uint32_t other) {
  Merger(tree).merge(place, other);
}

}  // namespace shadowcut::compare
