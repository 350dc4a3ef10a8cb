// Inside of the published tree (published_tree.hpp): nodes, lists, and what both ways of joining
// need.
//
// What holds between any two calls, along every ray from the light. On it lie the SP-nodes' sides
// that it takes and the PP-nodes that it meets on its way down:
//   1  each PP-node it meets is nearer to the light than the one before, and its polygon is on the
//      ray;
//   2  every polygon on the ray is met, or is in the list of a PP-node that is met.
// A polygon may be listed in more than one place, and also be met; what is put in where its own
// PP-node stands is there already. So a list need not say what part of its polygons is meant, and
// any polygon may be put in again at any place, if only it is nearer there than all PP-nodes above.
#pragma once

#include <array>
#include <cstdint>
#include <shadowcut/scene.hpp>
#include <span>
#include <utility>
#include <vector>

#include "light_space/light_space.hpp"
#include "published_tree.hpp"

namespace shadowcut::compare {

inline constexpr double epsilon = 1e-12;
inline int sign_of(double s, double tolerance = epsilon) {
  return s > tolerance ? 1 : s < -tolerance ? -1 : 0;
}

using Outline = std::vector<Vec3>;  // of a convex cone: its corners' rays, of length one, in order

// On which sides of a covector an outline lies.
struct Sides2 {
  bool positive = false, negative = false;
  int larger = 1;  // the side of the corner farthest from it
  bool both() const { return positive && negative; }
  int side() const { return both() ? 0 : positive ? 1 : negative ? -1 : larger; }
};
Sides2 sides_of(const Outline& outline, const Vec3& n, double tolerance = epsilon);
// The two parts of an outline that is on both sides; `cut` are the ends of the cut.
void split(const Outline& outline, const Vec3& n, double tolerance, Outline& positive,
           Outline& negative, Vec3* cut = nullptr);
// Leaves what is on one side (1 or -1); true if something was cut off.
bool clip(Outline& outline, const Vec3& n, int side, double tolerance = epsilon);

// The part of a great circle (a plane through the light) that lies in a region: at most half of it,
// or the whole.
struct Arc {
  enum class Extent : std::uint8_t { none, part, whole } extent = Extent::none;
  Vec3 from = Vec3::Zero(), to = Vec3::Zero(), middle = Vec3::Zero();
};

// A facet that has entered.
struct Surface {
  Outline rays;             // corners
  std::vector<Vec3> lines;  // its shadow planes, positive inside
  Vec3 q;
  double q_size;
  std::uint32_t face;
  bool in_tree, may_be_lit;
  // its location list: PP-nodes of its own, and entries in lists of others
  std::vector<std::uint32_t> pps, records;
};

// How a polygon stands to another where both are on a ray.
enum class Relation : std::uint8_t { front, behind, contact, crossing };

struct Node {
  enum class Kind : std::uint8_t { sp, pp, free } kind = Kind::free;
  Vec3 n;                     // SP: the plane, positive inside
  std::uint32_t child[2];     // SP: inside, outside; PP: in front, unused. A node, or none: OUT
  std::uint32_t parent;       // place
  std::uint32_t surface;      // SP: whose shadow plane it is; PP: whose plane
  std::uint32_t owner;        // SP: the PP-node whose volume it bounds, or none: marked
  std::uint32_t first, slot;  // PP: of its list; in Surface::pps
};

struct Record {  // a polygon in a list
  std::uint32_t surface, pp, next, previous, slot;
};

// Something on its way down.
struct Item {
  std::uint32_t surface;
  Outline outline;
  std::uint32_t place;
  std::uint32_t pp = invalid_index;  // a shadow volume that comes whole; otherwise a polygon alone
  std::uint32_t from = 0;   // the place where the volume set out
  // planes that have cut the volume's outline, besides those of its polygon, positive where it is
  std::vector<Vec3> cuts = {};
};

class Svbsp {
 public:
  // A place is a node's side, node * 2 + side; the root; or one of those that hold a subtree while
  // it is moved.
  static constexpr std::uint32_t root_place = invalid_index, held_place = invalid_index - 8;
  static std::uint32_t held(std::uint32_t k) { return held_place + k; }
  static bool is_top(std::uint32_t place) { return place >= held_place; }

  std::vector<Surface> surfaces;  // by facet
  std::vector<Node> nodes;
  // by node: where its plane lies in its region; for merge(), and stale between its calls
  std::vector<Arc> arcs;
  TreeCounts counts;

  std::uint32_t child_at(std::uint32_t place) const {
    return is_top(place) ? tops_[place - held_place] : nodes[place >> 1].child[place & 1];
  }
  void put(std::uint32_t place, std::uint32_t child);
  std::uint32_t take(std::uint32_t place);  // leaves OUT
  std::uint32_t add_sp(const Vec3& n, std::uint32_t surface, std::uint32_t owner);
  std::uint32_t add_pp(std::uint32_t surface);
  void release(std::uint32_t node);
  void release_all(std::uint32_t root);
  void set_owner(std::uint32_t sp, std::uint32_t owner);
  void collapse(std::uint32_t sp);  // one of whose sides is OUT
  std::uint32_t top_of_volume(std::uint32_t pp) const;

  void add_record(std::uint32_t pp, std::uint32_t surface);
  void drop_record(std::uint32_t record);
  void copy_records(std::uint32_t from, std::uint32_t to);
  std::uint32_t next_record(std::uint32_t record) const { return records_[record].next; }
  std::uint32_t surface_of_record(std::uint32_t record) const { return records_[record].surface; }

  // positive where p is
  Vec3 nearer(std::uint32_t p, std::uint32_t q) const { return surfaces[p].q - surfaces[q].q; }
  double touching(std::uint32_t p, std::uint32_t q) const {
    return epsilon * (1 + surfaces[p].q_size + surfaces[q].q_size);
  }
  // where both are seen
  Relation relation(std::uint32_t p, std::uint32_t q) const;
  // of a part of p that lies within q's volume
  Relation relation(const Outline& part, std::uint32_t p, std::uint32_t q) const;
  // The plane in which p crosses q, as a plane of p's volume.
  Vec3 crossing(std::uint32_t p, std::uint32_t q) const { return nearer(p, q).normalized(); }
  // Sees to it that p's volume ends where p crosses q, a PP-node above it. True if a plane was
  // added.
  bool bound_by_crossing(std::uint32_t pp, std::uint32_t q);
  // Cuts an outline by the planes above a place; those that cut something off are added to `cuts`,
  // positive inside.
  void clip_to(Outline& outline, std::uint32_t place, std::vector<Vec3>* cuts = nullptr) const;
  // Cuts away what is behind PP-nodes above a place; all, where the polygon's own stands there, or
  // one that it touches, which gets it.
  void clip_to_front(Outline& outline, std::uint32_t surface, std::uint32_t place);

  void add(Item item) { pending_.push_back(std::move(item)); }
  void run();  // until all items have come to rest
  void remove(std::span<const std::uint32_t> facets, Joining joining);

  std::string validate() const;

 private:
  void filter(Item& item);
  void settle(Item& item);
  void open(Item& item, std::uint32_t list_to);
  void list_of(std::uint32_t pp, const std::vector<Vec3>& planes, std::uint32_t place,
               std::uint32_t cell, std::vector<Item>& items);
  void collect(std::vector<std::uint32_t> roots, std::vector<Item>& volumes) const;
  void detach(const std::vector<Item>& volumes);
  void take_apart(std::uint32_t root, std::uint32_t place, std::vector<Item>& polygons,
                  std::vector<Item>& lists);
  void take_out(std::uint32_t pp, Joining joining);
  void keep_largest(std::vector<std::uint32_t>& roots) const;

  std::array<std::uint32_t, 9> tops_{invalid_index, invalid_index, invalid_index,
                                     invalid_index, invalid_index, invalid_index,
                                     invalid_index, invalid_index, invalid_index};
  std::vector<std::uint32_t> free_nodes_, free_records_;
  std::vector<Record> records_;
  std::vector<Item> pending_;
};

// NAT90: the tree at `place` and the subtree `other`, which is detached, become one, at `place`.
void merge(Svbsp& tree, std::uint32_t place, std::uint32_t other);

}  // namespace shadowcut::compare
