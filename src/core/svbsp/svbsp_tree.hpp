// The unordered shadow-volume BSP (SVBSP) tree of one cell of light space, after Y. Chrysanthou,
// M. Slater, "Shadow Volume BSP Trees for Computation of Shadows in Dynamic Scenes", 1995 (CS95).
//
//   SP-node  a shadow plane: a plane through the light and an edge. Its two children are the sides
//            on which n.r is positive and negative.
//   PP-node  a face's plane, where everything is inside the shadow volume of one piece of that
//            face. Its one child is what is in front. What is behind is a list of pieces, shadowed.
//   OUT      a leaf: nothing (more) between here and the light. It may hold a list of pieces of
//            faces that receive but do not cast.
//
// A *piece* is what is left of a facet where it came to rest: at the PP-node it owns, behind a
// PP-node or coplanar with it, or at a leaf. An *entry* is a facet's part in this cell: the list of
// its pieces (CS95's location list, section 3).
//
// Departures from CS95: only the edges that bound a piece get SP-nodes, and none where the cell is
// already bounded there; a face that crosses another face is cut along the crossing line, which
// becomes an SP-node of the part in front; coplanar faces share a PP-node; targets are not stored:
// a PP-node's target is the nearest PP-node above it.
//
// Edits (remove.cpp). An edge needs no SP-node of its own where a node above has cut the face, or
// where it lies on a node of its own object (or of the k-d tree, which stays): whatever removes
// that node then knows the edge.
//
// SvbspTree is the data structure, with the steps that keep its links right. The algorithms are
// insert() (insert.cpp), remove() (remove.cpp) and join() (join.cpp). The tree knows nothing about
// fragments: an edit leaves a log, and the fragment store reads it.
//
// The class has more than 25 functions because every step that changes a link is a member; the
// algorithms, its pieces (PieceStore) and its own lines (LocalLines) are elsewhere.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "clipping/clip.hpp"
#include "svbsp/edit_log.hpp"
#include "svbsp/local_lines.hpp"
#include "svbsp/nodes.hpp"
#include "svbsp/piece_store.hpp"

namespace shadowcut {

struct TreeSettings {
  bool edits = false;                // whether objects will come and go
  std::uint32_t join_threshold = 0;  // see Options
};

struct TreeCounts {
  std::uint64_t predicates = 0;
  SignCounts signs;
  std::uint64_t joined = 0, deferred = 0;
};

class SvbspTree {
 public:
  SvbspTree(const LightTables& tables, const TreeSettings& settings)
      : tables_(&tables), settings_(settings) {}

  const LightTables& tables() const { return *tables_; }
  const TreeSettings& settings() const { return settings_; }
  CellPredicates predicates() const { return CellPredicates(*tables_, lines.all()); }
  const Line& line(LineId id) const { return is_local(id) ? lines.line(id) : tables_->lines[id]; }

  Branch branch(Place place) const {
    return place.is_root() ? root_ : node(place.node()).child[place.side()];
  }
  const Node& node(NodeId id) const {
    SHADOWCUT_ASSERT(id.value() < nodes_.size());
    return nodes_[id.value()];
  }
  const NodeLinks& links(NodeId id) const {
    SHADOWCUT_ASSERT(id.value() < links_.size());
    return links_[id.value()];
  }
  NodeLinks& links(NodeId id) {
    SHADOWCUT_ASSERT(id.value() < links_.size());
    return links_[id.value()];
  }
  std::span<const Node> nodes() const { return nodes_; }  // released ones among them
  bool is_pp(NodeId id) const { return branch(links(id).parent).is_pp(); }
  FacetId owner_facet(NodeId pp) const {
    SHADOWCUT_ASSERT(pieces[node(pp).owner()].kind == Piece::Kind::owner);
    return pieces[node(pp).owner()].facet;
  }
  DividingLine dividing_line(NodeId sp) const {
    SHADOWCUT_ASSERT(!links(sp).is_released());
    const Node& n = node(sp);
    return {n.n, n.error, n.line()};
  }
  std::size_t node_count() const { return nodes_.size() - free_nodes_.size(); }
  std::size_t pp_nodes() const { return pp_nodes_; }
  std::size_t marked_nodes() const { return marked_nodes_; }
  std::uint64_t bytes() const;
  std::uint64_t depth() const;
  Cone* cone_of(const Piece& piece, ConePool& pool) const;

  void clear();  // as new, but for its memory
  void reserve(std::size_t facets);
  // Forgets everything but its entries, which are to be inserted again. Reports the released lines
  // in the log, and logs nothing else until end_rebuild().
  void begin_rebuild();
  void end_rebuild() { logs_ = settings_.edits; }

  // Steps of insertion.
  NodeId add_node(const double n[3], float error, std::uint32_t line_or_owner, Place parent,
                  PieceId owner);
  void add_sp_node(Place& place, EdgeRef edge, PieceId owner);  // moves on to its inside
  void add_pp_node(Place place, PieceId owner);
  PieceId store(const Cone& cone, Piece::Kind kind, std::uint32_t at);
  void add_to_list(PieceId piece, NodeId pp);
  void rest_at_leaf(PieceId piece, Place place);

  // Steps of removal.
  void put(Place place, Branch branch);
  void unlink(PieceId piece);
  void release_piece(PieceId piece);
  void mark(NodeId sp);
  void release_node(NodeId node, bool is_sp);
  void replace_corners(PieceId piece, std::span<const ConeCorner> corners);
  LineId add_local_copy(LineId line);
  void log_change(Place place) {
    if (logs_) log.places_changed.push_back(place);
  }
  // The place to which a place has come that may be below released nodes.
  Place resolve(Place place) const;
  // The last step: indices of released nodes and lines may be used again from now on.
  void finish_removal();

  PieceStore pieces;
  LocalLines lines;
  EditLog log;  // of edits, until its reader clears it
  TreeCounts counts;

 private:
  Branch& slot(Place place) {
    return place.is_root() ? root_ : nodes_[place.node().value()].child[place.side()];
  }

  const LightTables* tables_;
  TreeSettings settings_;
  bool logs_ = false;
  Branch root_ = Branch::out();
  std::vector<Node> nodes_;
  std::vector<NodeLinks> links_;  // by node
  FreeList<NodeId> free_nodes_;
  std::vector<NodeId> released_nodes_;  // in this edit: places are still named after them
  std::vector<NodeId> new_marks_;       // in this edit
  std::size_t pp_nodes_ = 0, marked_nodes_ = 0;
};

// Filters a cone down the tree from its root and stores what is left of it where it comes to rest
// (CS95, section 2). Takes the cone. Facets that do not cast should come after all facets that do.
// Returns the facet's new entry.
EntryId insert(SvbspTree& tree, Cone* cone, Workspace& w);
// The same for an entry that exists; from a place.
void insert_at(SvbspTree& tree, Cone* cone, Place place, Workspace& w);

// Takes facets out of the tree (CS95, section 3.1), and the planes that they leave behind (3.2).
// Returns the number of pieces that had to be inserted again.
std::size_t remove(SvbspTree& tree, std::span<const EntryId> entries, Workspace& w);

// Every invariant of the tree; empty when all hold. `space`: null leaves out the invariants that
// cost arithmetic (validate.cpp says which).
std::string validate(const SvbspTree& tree, const LightSpace* space);

}  // namespace shadowcut
