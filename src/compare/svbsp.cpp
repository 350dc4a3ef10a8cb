// See svbsp.hpp.

#include "svbsp.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace shadowcut::compare {

// ---- outlines

Sides2 sides_of(const Outline& outline, const Vec3& n, double tolerance) {
  Sides2 out;
  double largest = 0;
  for (const Vec3& r : outline) {
    const double s = n.dot(r);
    out.positive = out.positive || s > tolerance, out.negative = out.negative || s < -tolerance;
    if (std::abs(s) > largest) largest = std::abs(s), out.larger = s > 0 ? 1 : -1;
  }
  return out;
}

void split(const Outline& outline, const Vec3& n, double tolerance, Outline& positive,
           Outline& negative, Vec3* cut) {
  positive.clear(), negative.clear();
  const auto meet = [&](const Vec3& r) {
    positive.push_back(r), negative.push_back(r);
    if (cut) *cut++ = r;
  };
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec3 &a = outline[i], &b = outline[i + 1 == outline.size() ? 0 : i + 1];
    const double sa = n.dot(a), sb = n.dot(b);
    const int here = sign_of(sa, tolerance), next = sign_of(sb, tolerance);
    if (here == 0) meet(a);
    else (here > 0 ? positive : negative).push_back(a);
    if (here * next < 0) meet((a * std::abs(sb) + b * std::abs(sa)).normalized());
  }
}

bool clip(Outline& outline, const Vec3& n, int side, double tolerance) {
  if (outline.empty()) return false;
  const Sides2 sides = sides_of(outline, n, tolerance);
  if (sides.both()) {
    Outline positive, negative;
    split(outline, n, tolerance, positive, negative);
    outline = std::move(side > 0 ? positive : negative);
    return true;
  }
  if (sides.side() != side) outline.clear();
  return false;
}

// ---- nodes and lists

void Svbsp::put(std::uint32_t place, std::uint32_t child) {
  (is_top(place) ? tops_[place - held_place] : nodes[place >> 1].child[place & 1]) = child;
  if (child != invalid_index) nodes[child].parent = place;
}

std::uint32_t Svbsp::take(std::uint32_t place) {
  const std::uint32_t child = child_at(place);
  put(place, invalid_index);
  return child;
}

std::uint32_t Svbsp::add_sp(const Vec3& n, std::uint32_t surface, std::uint32_t owner) {
  std::uint32_t node = static_cast<std::uint32_t>(nodes.size());
  if (free_nodes_.empty()) nodes.emplace_back();
  else node = free_nodes_.back(), free_nodes_.pop_back();
  nodes[node] = {Node::Kind::sp,
                 n,
                 {invalid_index, invalid_index},
                 invalid_index,
                 surface,
                 owner,
                 invalid_index,
                 invalid_index};
  ++counts.sp_nodes;
  counts.marked += owner == invalid_index;
  return node;
}

std::uint32_t Svbsp::add_pp(std::uint32_t surface) {
  const std::uint32_t node = add_sp(Vec3::Zero(), surface, invalid_index);
  --counts.sp_nodes, --counts.marked, ++counts.pp_nodes;
  nodes[node].kind = Node::Kind::pp;
  nodes[node].slot = static_cast<std::uint32_t>(surfaces[surface].pps.size());
  surfaces[surface].pps.push_back(node);
  return node;
}

void Svbsp::release(std::uint32_t node) {
  Node& n = nodes[node];
  if (n.kind == Node::Kind::pp) {
    while (n.first != invalid_index) drop_record(n.first);
    std::vector<std::uint32_t>& pps = surfaces[n.surface].pps;
    nodes[pps.back()].slot = n.slot;
    pps[n.slot] = pps.back();
    pps.pop_back();
    --counts.pp_nodes;
  } else {
    --counts.sp_nodes;
    counts.marked -= n.owner == invalid_index;
  }
  n.kind = Node::Kind::free;
  free_nodes_.push_back(node);
}

void Svbsp::release_all(std::uint32_t root) {
  std::vector<std::uint32_t> rest{root};
  while (!rest.empty()) {
    const std::uint32_t node = rest.back();
    rest.pop_back();
    if (node == invalid_index) continue;
    rest.push_back(nodes[node].child[0]), rest.push_back(nodes[node].child[1]);
    release(node);
  }
}

void Svbsp::set_owner(std::uint32_t sp, std::uint32_t owner) {
  counts.marked -= nodes[sp].owner == invalid_index, counts.marked += owner == invalid_index;
  nodes[sp].owner = owner;
}

void Svbsp::collapse(std::uint32_t sp) {
  const Node& n = nodes[sp];
  put(n.parent, n.child[0] == invalid_index ? n.child[1] : n.child[0]);
  release(sp);
}

std::uint32_t Svbsp::top_of_volume(std::uint32_t pp) const {
  std::uint32_t top = pp;
  while (!is_top(nodes[top].parent) && nodes[nodes[top].parent >> 1].kind == Node::Kind::sp &&
         nodes[nodes[top].parent >> 1].owner == pp)
    top = nodes[top].parent >> 1;
  return top;
}

void Svbsp::add_record(std::uint32_t pp, std::uint32_t surface) {
  if (nodes[pp].surface == surface) return;
  // It may be there already; the shorter of the two lists knows.
  std::vector<std::uint32_t>& mine = surfaces[surface].records;
  std::uint32_t r = nodes[pp].first;
  for (std::size_t i = 0; i < mine.size() && r != invalid_index; ++i, r = records_[r].next)
    if (records_[mine[i]].pp == pp || records_[r].surface == surface) return;
  std::uint32_t record = static_cast<std::uint32_t>(records_.size());
  if (free_records_.empty()) records_.emplace_back();
  else record = free_records_.back(), free_records_.pop_back();
  records_[record] = {surface, pp, nodes[pp].first, invalid_index,
                      static_cast<std::uint32_t>(mine.size())};
  if (nodes[pp].first != invalid_index) records_[nodes[pp].first].previous = record;
  nodes[pp].first = record;
  mine.push_back(record);
  ++counts.stored;
}

void Svbsp::drop_record(std::uint32_t record) {
  const Record r = records_[record];
  (r.previous == invalid_index ? nodes[r.pp].first : records_[r.previous].next) = r.next;
  if (r.next != invalid_index) records_[r.next].previous = r.previous;
  std::vector<std::uint32_t>& mine = surfaces[r.surface].records;
  records_[mine.back()].slot = r.slot;
  mine[r.slot] = mine.back();
  mine.pop_back();
  free_records_.push_back(record);
  --counts.stored;
}

void Svbsp::copy_records(std::uint32_t from, std::uint32_t to) {
  for (std::uint32_t r = nodes[from].first; r != invalid_index; r = records_[r].next)
    add_record(to, records_[r].surface);
}

// ---- what is in front of what

Relation Svbsp::relation(std::uint32_t p, std::uint32_t q) const {
  const Vec3 d = nearer(p, q);
  const double tolerance = touching(p, q);
  Sides2 sides = sides_of(surfaces[p].rays, d, tolerance);
  if (sides.both()) {
    Outline common = surfaces[p].rays;
    for (const Vec3& n : surfaces[q].lines) clip(common, n, 1);
    sides = sides_of(common, d, tolerance);
  }
  if (sides.both()) return Relation::crossing;
  return sides.positive ? Relation::front : sides.negative ? Relation::behind : Relation::contact;
}

// Corners of a part are rounded, and the part of q's volume that the tree keeps may reach a little
// beyond the polygon: where they say that the two cross, the polygons have the last word.
Relation Svbsp::relation(const Outline& part, std::uint32_t p, std::uint32_t q) const {
  const Sides2 sides = sides_of(part, nearer(p, q), touching(p, q));
  if (sides.both()) return relation(p, q);
  return sides.positive ? Relation::front : sides.negative ? Relation::behind : Relation::contact;
}

bool Svbsp::bound_by_crossing(std::uint32_t pp, std::uint32_t q) {
  const std::uint32_t surface = nodes[pp].surface, other = nodes[q].surface;
  if (surface == other || relation(surface, other) != Relation::crossing) return false;
  const Vec3 n = crossing(surface, other);
  for (std::uint32_t up = nodes[pp].parent;
       !is_top(up) && nodes[up >> 1].owner == pp && nodes[up >> 1].kind == Node::Kind::sp;
       up = nodes[up >> 1].parent) {
    if (nodes[up >> 1].n == n) return false;
  }
  const std::uint32_t place = nodes[pp].parent, sp = add_sp(n, surface, pp);
  put(place, sp);
  put(sp * 2, pp);
  return true;
}

void Svbsp::clip_to(Outline& outline, std::uint32_t place, std::vector<Vec3>* cuts) const {
  for (; !is_top(place) && !outline.empty(); place = nodes[place >> 1].parent) {
    const Node& node = nodes[place >> 1];
    if (node.kind != Node::Kind::sp) continue;
    const int side = place & 1 ? -1 : 1;
    if (clip(outline, node.n, side) && cuts) cuts->push_back(side * node.n);
  }
}

void Svbsp::clip_to_front(Outline& outline, std::uint32_t surface, std::uint32_t place) {
  for (; !is_top(place) && !outline.empty(); place = nodes[place >> 1].parent) {
    const std::uint32_t pp = place >> 1, other = nodes[pp].surface;
    if (nodes[pp].kind != Node::Kind::pp) continue;
    if (other == surface) return outline.clear();
    switch (relation(outline, surface, other)) {
      case Relation::front:
        break;
      case Relation::crossing:
        clip(outline, nearer(surface, other), 1, touching(surface, other));
        break;
      case Relation::contact:
        add_record(pp, surface);
        return outline.clear();
      case Relation::behind:
        return outline.clear();
    }
  }
}

// ---- insertion

void Svbsp::run() {
  while (!pending_.empty()) {
    Item item = std::move(pending_.back());
    pending_.pop_back();
    filter(item);
  }
}

// CS95, section 2; and, for a volume that comes whole, 3.2: as long as its polygon is not cut,
// nothing in it is.
void Svbsp::filter(Item& item) {
  for (;;) {
    const std::uint32_t here = child_at(item.place);
    if (here == invalid_index) return settle(item);
    ++counts.visits;
    if (nodes[here].kind == Node::Kind::sp) {
      const Vec3 n = nodes[here].n;
      const Sides2 sides = sides_of(item.outline, n);
      if (!sides.both()) {
        item.place = here * 2 + (sides.side() < 0);
        continue;
      }
      if (item.pp != invalid_index) open(item, invalid_index);
      Outline inside, outside;
      split(item.outline, n, epsilon, inside, outside);
      pending_.push_back({item.surface, std::move(outside), here * 2 + 1});
      item.outline = std::move(inside);
      item.place = here * 2;
      continue;
    }
    const std::uint32_t other = nodes[here].surface;
    const Relation at =
        other == item.surface ? Relation::contact : relation(item.outline, item.surface, other);
    if (at == Relation::front) {
      item.place = here * 2;
      continue;
    }
    if (at != Relation::crossing) {
      // Its own polygon's PP-node covers all of the polygon here; otherwise it is behind, or
      // touches.
      add_record(here, item.surface);
      if (item.pp != invalid_index) open(item, here);
      return;
    }
    if (item.pp != invalid_index) open(item, invalid_index);
    clip(item.outline, nearer(item.surface, other), 1, touching(item.surface, other));
    add_record(here, item.surface);
    item.place = here * 2;
  }
}

// At an OUT leaf.
void Svbsp::settle(Item& item) {
  if (item.pp == invalid_index) {
    const std::uint32_t pp = add_pp(item.surface);
    std::uint32_t place = item.place;
    for (const Vec3& n : surfaces[item.surface].lines) {
      const std::uint32_t sp = add_sp(n, item.surface, pp);
      put(place, sp);
      place = sp * 2;
    }
    put(place, pp);
    for (std::uint32_t up = item.place; !is_top(up); up = nodes[up >> 1].parent)
      if (nodes[up >> 1].kind == Node::Kind::pp) bound_by_crossing(pp, up >> 1);
    return;
  }
  const std::uint32_t top = top_of_volume(item.pp);
  put(item.place, top);
  std::vector<std::uint32_t> targets;
  for (std::uint32_t up = item.place; up != item.from; up = nodes[up >> 1].parent)
    if (nodes[up >> 1].kind == Node::Kind::pp) targets.push_back(up >> 1);
  if (targets.empty()) return;
  std::vector<std::uint32_t> rest{top};
  while (!rest.empty()) {
    const std::uint32_t node = rest.back();
    rest.pop_back();
    if (node == invalid_index) continue;
    rest.push_back(nodes[node].child[0]), rest.push_back(nodes[node].child[1]);
    if (nodes[node].kind != Node::Kind::pp) continue;
    for (const std::uint32_t q : targets) bound_by_crossing(node, q);
  }
}

// Takes a volume to pieces: what is in front of its polygon, and in its list, goes on alone from
// where the volume is, and the polygon is an item without a volume. list_to: the PP-node that gets
// the list instead, or none.
void Svbsp::open(Item& item, std::uint32_t list_to) {
  const std::uint32_t pp = item.pp;
  if (list_to == invalid_index) {
    std::vector<Vec3> planes = surfaces[item.surface].lines;
    planes.insert(planes.end(), item.cuts.begin(), item.cuts.end());
    list_of(pp, planes, item.place, invalid_index, pending_);
  } else {
    copy_records(pp, list_to);
  }
  std::vector<Item> volumes;
  collect({nodes[pp].child[0]}, volumes);
  detach(volumes);
  for (Item& v : volumes) {
    for (const Vec3& n : item.cuts)
      if (clip(v.outline, n, 1)) v.cuts.push_back(n);
    v.place = item.place, v.from = item.from;
    if (v.outline.empty()) release_all(top_of_volume(v.pp));
    else pending_.push_back(std::move(v));
  }
  nodes[pp].child[0] = invalid_index;
  release_all(top_of_volume(pp));
  item.pp = invalid_index;
  item.cuts.clear();
}

// What is in a PP-node's list, to be inserted at a place. planes: positive where the PP-node's
// volume is. cell: a place that bounds it too.
void Svbsp::list_of(std::uint32_t pp, const std::vector<Vec3>& planes, std::uint32_t place,
                    std::uint32_t cell, std::vector<Item>& items) {
  while (nodes[pp].first != invalid_index) {
    const std::uint32_t surface = records_[nodes[pp].first].surface;
    drop_record(nodes[pp].first);
    Outline outline = surfaces[surface].rays;
    for (const Vec3& n : planes) clip(outline, n, 1);
    clip_to(outline, cell);
    clip_to_front(outline, surface, place);
    if (!outline.empty()) items.push_back({surface, std::move(outline), place});
  }
}

// ---- removal

// The shadow volumes of some subtrees that are in front of nothing within them, each with its
// polygon as it lies there; the upper ones last, since what is added last goes first.
void Svbsp::collect(std::vector<std::uint32_t> roots, std::vector<Item>& volumes) const {
  while (!roots.empty()) {
    const std::uint32_t root = roots.back();
    roots.pop_back();
    if (root == invalid_index) continue;
    std::uint32_t node = root;
    for (; nodes[node].kind == Node::Kind::sp; node = nodes[node].child[0])
      roots.push_back(nodes[node].child[1]);
    Item volume{nodes[node].surface, surfaces[nodes[node].surface].rays, invalid_index, node};
    clip_to(volume.outline, nodes[node].parent, &volume.cuts);
    volumes.push_back(std::move(volume));
  }
  std::reverse(volumes.begin(), volumes.end());
}

// Makes each volume a tree of its own.
void Svbsp::detach(const std::vector<Item>& volumes) {
  for (const Item& v : volumes) {
    const std::uint32_t top = top_of_volume(v.pp);
    nodes[top].parent = held(0);
    for (std::uint32_t node = top; node != v.pp; node = nodes[node].child[0])
      nodes[node].child[1] = invalid_index;
  }
}

// Leaves nothing of a subtree but its polygons, the upper ones last.
void Svbsp::take_apart(std::uint32_t root, std::uint32_t place, std::vector<Item>& polygons,
                       std::vector<Item>& lists) {
  std::vector<std::uint32_t> rest{root}, pps;
  while (!rest.empty()) {
    const std::uint32_t node = rest.back();
    rest.pop_back();
    if (node == invalid_index) continue;
    rest.push_back(nodes[node].child[0]), rest.push_back(nodes[node].child[1]);
    if (nodes[node].kind == Node::Kind::pp) pps.push_back(node);
  }
  for (auto pp = pps.rbegin(); pp != pps.rend(); ++pp) {
    const std::uint32_t surface = nodes[*pp].surface;
    list_of(*pp, {}, nodes[*pp].parent, nodes[*pp].parent, lists);
    Outline outline = surfaces[surface].rays;
    clip_to(outline, nodes[*pp].parent);
    if (!outline.empty()) polygons.push_back({surface, std::move(outline), place});
  }
  for (Item& item : lists) item.place = place;
  release_all(root);
}

// Brings the largest subtree to the front: all are counted in step until one is left.
void Svbsp::keep_largest(std::vector<std::uint32_t>& roots) const {
  std::vector<std::vector<std::uint32_t>> rest;
  for (const std::uint32_t root : roots) rest.push_back({root});
  std::size_t left = roots.size(), last = 0;
  for (;;) {
    for (std::size_t i = 0; i < rest.size(); ++i) {
      if (rest[i].empty()) continue;
      last = i;
      if (left == 1) return std::swap(roots[0], roots[i]);
      const std::uint32_t node = rest[i].back();
      rest[i].pop_back();
      for (const std::uint32_t child : nodes[node].child)
        if (child != invalid_index) rest[i].push_back(child);
      if (rest[i].empty() && --left == 0) return std::swap(roots[0], roots[last]);
    }
  }
}

void Svbsp::remove(std::span<const std::uint32_t> facets, Joining joining) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pps;  // depth of its volume, node
  for (const std::uint32_t facet : facets) {
    // CS95, 3.1, case (a)
    while (!surfaces[facet].records.empty()) drop_record(surfaces[facet].records.back());
    for (const std::uint32_t pp : surfaces[facet].pps) {
      std::uint32_t depth = 0;
      for (std::uint32_t up = nodes[top_of_volume(pp)].parent; !is_top(up);
           up = nodes[up >> 1].parent)
        ++depth;
      pps.emplace_back(depth, pp);
    }
  }
  // Deepest first: what is below a volume when it goes is to stay.
  std::sort(pps.rbegin(), pps.rend());
  for (const auto& [depth, pp] : pps) take_out(pp, joining);
}

// CS95, 3.1, cases (b) and (c).
void Svbsp::take_out(std::uint32_t pp, Joining joining) {
  const std::uint32_t top = top_of_volume(pp), place = nodes[top].parent;
  std::vector<Item> lists, polygons;
  list_of(pp, {}, place, nodes[pp].parent, lists);
  std::vector<std::uint32_t> roots;
  if (nodes[pp].child[0] != invalid_index) roots.push_back(nodes[pp].child[0]);
  for (std::uint32_t up = nodes[pp].parent; up != place; up = nodes[up >> 1].parent)
    if (nodes[up >> 1].child[1] != invalid_index) roots.push_back(nodes[up >> 1].child[1]);
  if (roots.size() > 1) keep_largest(roots);
  counts.joins += roots.empty() ? 0 : roots.size() - 1;

  const std::vector<std::uint32_t> smaller(roots.begin() + !roots.empty(), roots.end());
  if (joining == Joining::filter) collect(smaller, polygons);
  if (joining == Joining::filter) detach(polygons);
  if (joining == Joining::reinsert)
    for (const std::uint32_t root : smaller) take_apart(root, place, polygons, lists);
  for (std::uint32_t node = top, inner; node != pp; node = inner)
    inner = nodes[node].child[0], release(node);
  release(pp);
  put(place, roots.empty() ? invalid_index : roots[0]);

  if (joining == Joining::merge)
    for (const std::uint32_t root : smaller) merge(*this, place, root);
  for (Item& item : lists) pending_.push_back(std::move(item));
  for (Item& item : polygons) {
    item.place = item.from = place;
    if (!item.outline.empty()) pending_.push_back(std::move(item));
    else if (item.pp != invalid_index) release_all(top_of_volume(item.pp));
  }
  run();
  for (std::uint32_t up = place; !is_top(up);) {
    const std::uint32_t node = up >> 1;
    if (nodes[node].kind != Node::Kind::sp || nodes[node].owner != invalid_index ||
        (nodes[node].child[0] != invalid_index && nodes[node].child[1] != invalid_index))
      break;
    up = nodes[node].parent;
    collapse(node);
  }
}

// ---- checks

std::string Svbsp::validate() const {
  std::size_t sps = 0, pps = 0, marked = 0, stored = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> rest{{child_at(root_place), root_place}};
  while (!rest.empty()) {
    const auto [at, place] = rest.back();
    rest.pop_back();
    if (at == invalid_index) continue;
    const Node& node = nodes[at];
    if (node.kind == Node::Kind::free) return "a branch leads to a released node";
    if (node.parent != place) return "a node does not know its place";
    rest.emplace_back(node.child[0], at * 2);
    if (node.kind == Node::Kind::pp) {
      ++pps;
      if (is_top(place) || nodes[place >> 1].owner != at) return "a PP-node has no shadow volume";
      if (node.slot >= surfaces[node.surface].pps.size() ||
          surfaces[node.surface].pps[node.slot] != at)
        return "a PP-node is not in its polygon's location list";
      for (std::uint32_t r = node.first; r != invalid_index; r = records_[r].next, ++stored) {
        const Record& record = records_[r];
        if (record.pp != at || surfaces[record.surface].records[record.slot] != r)
          return "a list and a location list do not agree";
      }
      continue;
    }
    ++sps;
    rest.emplace_back(node.child[1], at * 2 + 1);
    if (node.owner == invalid_index) {
      ++marked;
      if (node.child[0] == invalid_index || node.child[1] == invalid_index)
        return "a marked node divides nothing";
      continue;
    }
    const std::uint32_t inner = node.child[0];
    if (inner == invalid_index) return "a shadow volume has no polygon";
    if (nodes[inner].kind == Node::Kind::pp ? inner != node.owner
                                            : nodes[inner].owner != node.owner)
      return "the planes of a shadow volume do not follow each other";
  }
  if (sps != counts.sp_nodes || pps != counts.pp_nodes || marked != counts.marked ||
      stored != counts.stored)
    return "the counts are wrong";
  std::size_t own = 0, listed = 0;
  for (const Surface& s : surfaces) own += s.pps.size(), listed += s.records.size();
  return own == pps && listed == stored ? "" : "a location list names what is not in the tree";
}

}  // namespace shadowcut::compare
