// The unordered shadow-volume BSP tree (CS95) of one cell of light space.
//
//   SP-node  a shadow plane: a plane through the light and an edge. It divides the cell; its two
//            children are the sides on which n.r is
//            positive and negative.
//   PP-node  a face's plane, where everything is inside the shadow volume of one piece of that
//            face. Its one child is what is in front;
//            what is behind is a list of pieces, shadowed.
//   OUT      a leaf: nothing (more) between here and the light. It may hold pieces of faces that
//            receive but do not cast.
//
// A *piece* is what is left of a face where it came to rest: at the PP-node it owns, on a PP-node
// it is behind of or coplanar with, or at a leaf. An *entry* is a facet's part in this cell: it
// holds the list of its pieces (CS95's location list, section 3).
//
// Departures from CS95: only the edges that bound a piece get SP-nodes, and none where the cell is
// already bounded there; a face that crosses another is cut along the crossing line, which becomes
// an SP-node of the part in front; coplanar faces share a PP-node; targets are not stored: a
// PP-node's target is the nearest PP-node above it.
//
// Edits (tree_edit.cpp). Who bounds whom decides what may be removed. An edge needs no SP-node of
// its own where it was cut by a node above, and where it lies on a node of its own object (or of
// the prefix, which stays): then whatever removes that node knows the edge.
#pragma once

#include <cstdint>
#include <shadowcut/shadows.hpp>
#include <span>
#include <string>
#include <vector>

#include "free_list.hpp"
#include "lines.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {

class LiveCell;

// Where a branch leads, in 32 bits.
class Child {
 public:
  static Child out(std::uint32_t first_piece = nothing) { return Child(first_piece << 2); }
  static Child sp(std::uint32_t node) { return Child(node << 2 | 1); }
  static Child pp(std::uint32_t node) { return Child(node << 2 | 2); }

  bool is_out() const { return (bits_ & 3) == 0; }
  bool is_sp() const { return (bits_ & 3) == 1; }
  bool is_pp() const { return (bits_ & 3) == 2; }
  bool is_empty() const { return is_out() && first_piece() == nothing; }
  std::uint32_t node() const { return bits_ >> 2; }
  // of a leaf; `nothing` when it holds none
  std::uint32_t first_piece() const { return bits_ >> 2; }

  static constexpr std::uint32_t nothing = 0xFFFFFFFFu >> 2;

 private:
  explicit Child(std::uint32_t bits) : bits_(bits) {}
  std::uint32_t bits_;
};

struct Node {
  Real n[3];         // SP: the line; PP: the plane's q
  float error;       // of n
  Child child[2];    // SP: positive, negative side; PP: [0] in front, [1] unused
  std::uint32_t id;  // SP: line; PP: the owner, a piece
};
static_assert(sizeof(Node) == 3 * sizeof(Real) + 16);

// What is not needed on the way down.
struct NodeLinks {
  // place: node * 2 + side; root_place for the root. Kept when the node is released, until it is
  // used again
  std::uint32_t parent;
  std::uint32_t owner;  // the piece that attached it; or marked, or released
  std::uint32_t first;  // PP: first piece of its list, or none
};
// an SP-node whose piece is gone (CS95, section 3.1)
inline constexpr std::uint32_t marked = none;
inline constexpr std::uint32_t released = none - 1;  // no node at all
// NodeLinks::first of a marked node: its line has been reported as kept
inline constexpr std::uint32_t line_reported = 1;

struct Location {  // of a facet: in which cell, which entry
  std::uint32_t cell = none, entry = none;
};

struct Entry {
  std::uint32_t facet;
  std::uint32_t first;   // piece
  std::uint32_t pieces;  // how many
  Location next;         // of the same object, over all cells
};

struct Piece {
  enum class Kind : std::uint8_t { owner, behind, coplanar, at_leaf, free };
  std::uint32_t facet;
  std::uint32_t first_corner, corner_count;
  float error;
  // owner, behind, coplanar: the PP-node; at_leaf: the leaf's place
  std::uint32_t place;
  std::uint32_t next, previous;        // in the list of that place; none at its ends
  std::uint32_t entry, after, before;  // in the list of that entry
  Kind kind;
};

inline constexpr std::uint32_t root_place = none;

// Memory that one thread uses again for cell after cell.
struct Workspace {
  ConePool pool;
  std::vector<std::int8_t> spill;  // see Signs
  std::vector<Cone*> pending;
  PointCache points;
};

struct TreeCounts {
  std::uint64_t predicates = 0;
  SignCounts signs;
  std::uint64_t joined = 0, deferred = 0;
};

class CellTree {
 public:
  explicit CellTree(const LightTables& tables) : tables_(&tables) {}
  void clear();  // as new, but for its memory
  // Forgets everything but its entries, which then are to be inserted again. Reports lines as
  // remove() does.
  void start_again(std::vector<std::uint32_t>& given_up);
  void insert_again(std::uint32_t entry, Cone* cone, Workspace& w);

  // Filters a cone down and attaches, or stores, what is left of it where it comes to rest (CS95,
  // section 2). Takes the cone. Returns the facet's entry. Faces that do not cast should come after
  // all those that do.
  std::uint32_t insert(Cone* cone, Workspace& w);

  // Takes facets out of the tree (CS95, section 3.1), and the planes they leave behind (3.2). The
  // lines of the global ids that those planes still use are reported line by line: +1 in `kept` for
  // a plane that stays, in `given_up` for one that an earlier call kept.
  void remove(std::span<const std::uint32_t> entries, Workspace& w,
              std::vector<std::uint32_t>& kept, std::vector<std::uint32_t>& given_up);

  // The cone of a piece, as it lies in the tree.
  Cone* cone_of(const Piece& piece, ConePool& pool) const;

  Lines lines() const { return Lines(*tables_, local_lines_); }
  const Line& line(std::uint32_t id) const {
    return id < first_local_line ? tables_->lines[id] : local_lines_[id - first_local_line].line;
  }
  const LightTables& tables() const { return *tables_; }
  Child root() const { return root_; }
  std::span<const Node> nodes() const { return nodes_; }  // released ones among them
  std::span<const NodeLinks> links() const { return links_; }
  std::span<const Piece> pieces() const { return pieces_; }  // likewise, of kind free
  std::span<Entry> entries() { return entries_; }            // likewise, of facet none
  std::span<const Entry> entries() const { return entries_; }
  std::span<const ConeCorner> corners(const Piece& p) const {
    return std::span(corners_).subspan(p.first_corner, p.corner_count);
  }
  std::size_t local_lines() const { return local_lines_.size() - free_lines_.size(); }
  std::size_t live_nodes() const { return nodes_.size() - free_nodes_.size(); }
  std::size_t live_entries() const { return entries_.size() - free_entries_.size(); }
  std::size_t live_pieces() const { return pieces_.size() - free_pieces_.size(); }
  std::size_t pp_nodes() const { return pp_nodes_; }
  std::size_t marked_nodes() const { return marked_nodes_; }
  // pieces that the last remove() had to insert again
  std::size_t displaced_last() const { return displaced_last_; }
  const TreeCounts& counts() const { return counts_; }
  Child child_at(std::uint32_t place) const {
    return place == root_place ? root_ : nodes_[place >> 1].child[place & 1];
  }
  std::uint64_t bytes() const;
  std::uint64_t depth() const;
  void reserve(std::size_t facets);
  // Who keeps the fragments, and is told of every change from now on; null: nobody.
  void set_live(LiveCell* live) { live_ = live; }

  // Every invariant of the tree; empty when all hold.
  std::string validate() const;

 private:
  struct Displaced {
    Cone* cone;
    std::uint32_t place;
  };

  Child& slot(std::uint32_t place) {
    return place == root_place ? root_ : nodes_[place >> 1].child[place & 1];
  }
  void put(std::uint32_t place, Child child);
  void insert_at(Cone* cone, std::uint32_t place, Workspace& w);
  void filter(Cone* cone, std::uint32_t place, Workspace& w);
  bool drop_smallest(Cone*& a, Cone*& b, std::uint32_t line_id, Workspace& w);
  void attach(Cone& cone, std::uint32_t place);
  std::uint32_t store(const Cone& cone, Piece::Kind kind, std::uint32_t place);
  void set_corners(std::uint32_t piece, std::span<const ConeCorner> corners);
  void release_corners(const Piece& piece);
  void add_to_list(std::uint32_t piece, std::uint32_t pp);
  void rest_at_leaf(std::uint32_t piece, std::uint32_t place);
  void unlink(std::uint32_t piece);
  void release_piece(std::uint32_t piece);
  std::uint32_t add_node(const Real n[3], float error, std::uint32_t id, std::uint32_t parent,
                         std::uint32_t owner);
  std::uint32_t add_local_line(const Line& line, const LightLine& exact);
  std::uint32_t add_local_copy(std::uint32_t id);
  void count_use(std::uint32_t line, bool more);

  // tree_edit.cpp
  std::uint32_t resolve(std::uint32_t place) const;
  void mark_planes_of(std::uint32_t piece);
  void take_pp_out(std::uint32_t pp, std::vector<Displaced>& displaced, Workspace& w);
  void displace(std::uint32_t piece, std::uint32_t place, std::vector<Displaced>& displaced,
                Workspace& w);
  void insert_displaced(std::vector<Displaced>& displaced, Workspace& w);
  void release_node(std::uint32_t node, bool is_sp);
  void clear_up(std::uint32_t place, bool joining, Workspace& w);
  bool collapse(std::uint32_t node);
  std::uint32_t smaller_side(std::uint32_t node, std::uint32_t limit) const;
  void take_apart(Child side, std::vector<Displaced>& displaced, Workspace& w);
  bool join(std::uint32_t node, Workspace& w);
  std::uint32_t depth_below(std::uint32_t piece, std::uint32_t node) const;
  void rename_edges(std::uint32_t piece, std::uint32_t line, std::uint32_t name, bool bounded);
  void add_sp_above(std::uint32_t pp, EdgeRef edge, std::uint32_t owner);
  bool reunite(std::uint32_t piece, std::uint32_t line, std::uint32_t node,
               std::vector<Displaced>& halves, Workspace& w);
  bool fits_below(Cone& cone, std::uint32_t place, std::uint32_t node, Workspace& w) const;
  void reunite_in_list(std::uint32_t piece, std::uint32_t pp);

  const LightTables* tables_;
  LiveCell* live_ = nullptr;
  Child root_ = Child::out();
  std::vector<Node> nodes_;
  std::vector<NodeLinks> links_;
  std::vector<Piece> pieces_;
  std::vector<Entry> entries_;
  std::vector<ConeCorner> corners_;
  RangeList free_corners_;
  std::vector<LocalLine> local_lines_;
  FreeList free_nodes_, free_pieces_, free_entries_, free_lines_;
  std::vector<std::uint32_t> idle_lines_;  // used by nothing stored, perhaps only just now
  // in this edit: not to be used again before it ends, because places are named after them
  std::vector<std::uint32_t> released_nodes_;
  std::vector<std::uint32_t> new_marks_, given_up_lines_;  // of this edit; see remove()
  // pieces that come to a list look for others of their facet
  bool reuniting_ = false;
  std::size_t pp_nodes_ = 0, marked_nodes_ = 0, displaced_last_ = 0;
  TreeCounts counts_;
};

}  // namespace shadowcut::SHADOWCUT_NUMBERS
