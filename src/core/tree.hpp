// The unordered shadow-volume BSP tree (CS95) of one cell of light space.
//
//   SP-node  a shadow plane: a plane through the light and an edge. It divides the cell; its two children are the sides on which n.r is
//   positive and negative. PP-node  a face's plane, where everything is inside the shadow volume of one piece of that face. Its one child
//   is what is in front;
//            what is behind is a list of pieces, shadowed.
//   OUT      a leaf: nothing (more) between here and the light. It may hold pieces of faces that receive but do not cast.
//
// A *piece* is what is left of a face where it came to rest: at the PP-node it owns, on a PP-node it is behind of or coplanar with, or at a
// leaf.
//
// Departures from CS95: only the edges that bound a piece get SP-nodes, and none where the cell is already bounded there; a face
// that crosses another is cut along the crossing line, which becomes an SP-node of the part in front; coplanar faces share
// a PP-node; targets are not stored: a PP-node's target is the nearest PP-node above it.
#pragma once

#include <cstdint>
#include <shadowcut/shadows.hpp>
#include <span>
#include <string>
#include <vector>

#include "cone.hpp"

namespace shadowcut {

// Where a branch leads, in 32 bits.
class Child {
 public:
  static Child out(std::uint32_t first_piece = nothing) { return Child(first_piece << 2); }
  static Child sp(std::uint32_t node) { return Child(node << 2 | 1); }
  static Child pp(std::uint32_t node) { return Child(node << 2 | 2); }

  bool is_out() const { return (bits_ & 3) == 0; }
  bool is_sp() const { return (bits_ & 3) == 1; }
  bool is_pp() const { return (bits_ & 3) == 2; }
  std::uint32_t node() const { return bits_ >> 2; }
  std::uint32_t first_piece() const { return bits_ >> 2; }  // of a leaf; `nothing` when it holds none

  static constexpr std::uint32_t nothing = 0xFFFFFFFFu >> 2;

 private:
  explicit Child(std::uint32_t bits) : bits_(bits) {}
  std::uint32_t bits_;
};

struct Node {
  double n[3];       // SP: the line; PP: the plane's q
  float error;       // of n
  Child child[2];    // SP: positive, negative side; PP: [0] in front, [1] unused
  std::uint32_t id;  // SP: line; PP: the owner, a piece
};
static_assert(sizeof(Node) == 40);

// What is not needed on the way down.
struct NodeLinks {
  std::uint32_t parent;  // place: node * 2 + side; none for the root
  std::uint32_t owner;   // SP: the piece that attached it; PP: first piece of its list, or none
};

struct Location {  // of a piece: in which cell, which piece
  std::uint32_t cell = none, piece = none;
};

struct Piece {
  enum class Kind : std::uint8_t { owner, behind, coplanar, at_leaf };
  std::uint32_t facet;
  std::uint32_t first_corner, corner_count;
  float error;
  std::uint32_t place;  // owner, behind, coplanar: the PP-node; at_leaf: the leaf's place
  std::uint32_t next;   // in the list of that place; none at its end
  Kind kind;
  Location location;  // the next in the facet's location list (CS95, section 3), over all cells
};

inline constexpr std::uint32_t root_place = none;

// What all cells of one light share, read-only while cells are built. Line ids: edges of the scene, then the prefix's, then each cell's
// own.
struct LightTables {
  std::vector<Line> lines;       // by line id, below first_local_line
  std::vector<VertexRay> rays;   // by Scene::vertices(); only those of facets that enter are filled in
  std::vector<PlaneRay> planes;  // by Scene::planes(); likewise
  std::span<const Facet> facets;
  std::span<const Object> objects;
  std::span<const Face> faces;
  std::vector<std::uint8_t> blocks_only;  // by facet: the far wall of a solid the light is in; it casts, its own side is dark
  bool casts(std::uint32_t facet) const { return objects[faces[facets[facet].face].object].casts; }
};

// Memory that one thread uses again for cell after cell.
struct Workspace {
  ConePool pool;
  std::vector<std::int8_t> spill;  // see Signs
  std::vector<Cone*> pending;
};

struct TreeCounts {
  std::uint64_t predicates = 0, on = 0;
};

class CellTree {
 public:
  explicit CellTree(const LightTables& tables) : tables_(&tables) {}

  // Filters a cone down and attaches, or stores, what is left of it where it comes to rest (CS95, section 2). Takes the cone.
  // Faces that do not cast must come after all those that do.
  void insert(Cone* cone, Workspace& w);

  // The cone of a piece, as it lies in the tree.
  Cone* cone_of(const Piece& piece, ConePool& pool) const;

  const Line& line(std::uint32_t id) const {
    return id < tables_->lines.size() ? tables_->lines[id] : local_lines_[id - tables_->lines.size()];
  }
  const LightTables& tables() const { return *tables_; }
  Child root() const { return root_; }
  std::span<const Node> nodes() const { return nodes_; }
  std::span<const NodeLinks> links() const { return links_; }
  std::span<const Piece> pieces() const { return pieces_; }
  std::span<const ConeCorner> corners(const Piece& p) const { return std::span(corners_).subspan(p.first_corner, p.corner_count); }
  std::size_t local_lines() const { return local_lines_.size(); }
  std::size_t pp_nodes() const { return pp_nodes_; }
  const TreeCounts& counts() const { return counts_; }
  Child child_at(std::uint32_t place) const { return place == root_place ? root_ : nodes_[place >> 1].child[place & 1]; }
  std::uint64_t bytes() const;
  std::uint64_t depth() const;
  // Puts every piece in front of its facet's location list.
  void link_locations(std::uint32_t cell, std::vector<Location>& heads);
  void reserve(std::size_t facets);

  // Every invariant of the tree; empty when all hold.
  std::string validate() const;

 private:
  Child& slot(std::uint32_t place) { return place == root_place ? root_ : nodes_[place >> 1].child[place & 1]; }
  void filter(Cone* cone, std::uint32_t place, Workspace& w);
  void attach(Cone& cone, std::uint32_t place);
  std::uint32_t store(const Cone& cone, Piece::Kind kind, std::uint32_t place);
  void add_to_list(std::uint32_t piece, std::uint32_t pp);
  std::uint32_t add_node(const double n[3], float error, std::uint32_t id, std::uint32_t parent, std::uint32_t owner);
  std::uint32_t crossing_line(const double difference[3], double error);

  const LightTables* tables_;
  Child root_ = Child::out();
  std::vector<Node> nodes_;
  std::vector<NodeLinks> links_;
  std::vector<Piece> pieces_;
  std::vector<ConeCorner> corners_;
  std::vector<Line> local_lines_;
  std::size_t pp_nodes_ = 0;
  TreeCounts counts_;
};

}  // namespace shadowcut
