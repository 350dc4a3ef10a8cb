// The parts of a cell's SVBSP tree: branches, places, nodes, pieces, entries.
#pragma once

#include <cstdint>

#include "predicates/cone.hpp"
#include "support/index.hpp"

namespace shadowcut {

// Where a branch of the tree leads, in 32 bits: to an SP-node, to a PP-node, or to an OUT leaf,
// which may hold a list of pieces.
class Branch {
 public:
  static Branch out() { return Branch(no_piece << 2); }
  static Branch out(PieceId first) {
    SHADOWCUT_ASSERT(first.value() < no_piece);
    return Branch(first.value() << 2);
  }
  static Branch sp(NodeId node) {
    SHADOWCUT_ASSERT(node.value() < no_piece);
    return Branch(node.value() << 2 | 1);
  }
  static Branch pp(NodeId node) {
    SHADOWCUT_ASSERT(node.value() < no_piece);
    return Branch(node.value() << 2 | 2);
  }

  bool is_out() const { return (bits_ & 3) == 0; }
  bool is_sp() const { return (bits_ & 3) == 1; }
  bool is_pp() const { return (bits_ & 3) == 2; }
  bool is_empty() const { return bits_ == no_piece << 2; }  // a leaf without pieces
  NodeId node() const {
    SHADOWCUT_ASSERT(!is_out());
    return NodeId(bits_ >> 2);
  }
  PieceId first_piece() const {  // of a leaf
    SHADOWCUT_ASSERT(is_out());
    return is_empty() ? PieceId() : PieceId(bits_ >> 2);
  }

 private:
  static constexpr std::uint32_t no_piece = 0xFFFFFFFFu >> 2;
  explicit Branch(std::uint32_t bits) : bits_(bits) {}
  std::uint32_t bits_;
};

// A place in the tree, where a branch hangs: a side of a node, or the root. An SP-node has two
// sides (0: n.r > 0, 1: n.r < 0), a PP-node has one (0: in front).
class Place {
 public:
  constexpr Place() = default;  // the root
  constexpr explicit Place(std::uint32_t value) : value_(value) {}
  constexpr Place(NodeId node, std::uint32_t side) : value_(node.value() * 2 + side) {
    SHADOWCUT_ASSERT(node.valid() && side <= 1);
  }
  static constexpr Place root() { return Place(); }

  constexpr bool is_root() const { return value_ == 0xFFFFFFFFu; }
  constexpr NodeId node() const {
    SHADOWCUT_ASSERT(!is_root());
    return NodeId(value_ >> 1);
  }
  constexpr std::uint32_t side() const { return value_ & 1; }
  constexpr Place other_side() const { return Place(value_ ^ 1); }
  constexpr std::uint32_t value() const { return value_; }
  friend constexpr auto operator<=>(Place, Place) = default;

 private:
  std::uint32_t value_ = 0xFFFFFFFFu;
};

// What a descent reads of a node.
struct Node {
  double n[3];                  // SP: the line; PP: the plane's q
  float error;                  // of n
  Branch child[2];              // SP: positive, negative side; PP: [0] in front, [1] unused
  std::uint32_t line_or_owner;  // SP: a LineId; PP: a PieceId

  LineId line() const { return LineId(line_or_owner); }     // of an SP-node
  PieceId owner() const { return PieceId(line_or_owner); }  // of a PP-node
};
static_assert(sizeof(Node) == 40);

// What a descent does not read. owner: the piece that attached the node. A node whose owner has
// been removed is *marked* (CS95, section 3.1); a released node is no node at all.
struct NodeLinks {
  enum class Status : std::uint8_t { owned, marked, released };
  Place parent;   // kept when the node is released, until its index is used again
  PieceId owner;  // of an owned node
  PieceId first;  // PP: the first piece of its list
  Status status;
  bool line_kept;  // of a marked node: its line has been reported in EditLog::lines_kept

  bool is_marked() const { return status == Status::marked; }
  bool is_released() const { return status == Status::released; }
};

// A facet's part in one cell: the list of its pieces (CS95's location list, section 3).
struct Location {
  CellId cell;
  EntryId entry;
};
struct Entry {
  FacetId facet;  // invalid: free
  PieceId first;
  std::uint32_t pieces;  // the length of the list
  Location next;         // of the same object, over all cells; see CellGrid
};

// What is left of a facet where it came to rest.
struct Piece {
  enum class Kind : std::uint8_t {
    owner,     // of a PP-node
    behind,    // a PP-node: shadowed
    coplanar,  // with a PP-node
    at_leaf,   // receives and does not cast
    free,      // no piece at all
  };
  FacetId facet;
  std::uint32_t first_corner, corner_count;
  float error;
  std::uint32_t node_or_leaf;  // owner, behind, coplanar: a NodeId; at_leaf: a Place
  PieceId next, previous;      // in the list of that node or leaf
  EntryId entry;
  PieceId after, before;  // in the list of that entry
  Kind kind;

  NodeId node() const {
    SHADOWCUT_ASSERT(kind != Kind::at_leaf);
    return NodeId(node_or_leaf);
  }
  Place leaf() const {
    SHADOWCUT_ASSERT(kind == Kind::at_leaf);
    return Place(node_or_leaf);
  }
  // In front of its PP-node, where SP-nodes and PP-nodes of the front subtree cut it.
  bool is_in_front() const { return kind == Kind::owner || kind == Kind::coplanar; }
};

}  // namespace shadowcut
