#include "fragments/static_fragments.hpp"

#include <algorithm>
#include <tuple>

#include "clipping/merge_convex.hpp"
#include "fragments/emission.hpp"

namespace shadowcut {
namespace {

// Pieces facet by facet, each facet's in the order in which filtering cut it: depth first, positive
// sides first. In a tree just built that is the order of their indices; edits reuse indices.
std::vector<PieceId> order_of_cuts(const SvbspTree& tree) {
  std::vector<PieceId> order;
  for (std::size_t p = 0; p < tree.pieces.pieces().size(); ++p) order.push_back(PieceId(p));
  if (!tree.settings().edits) return order;
  std::vector<std::uint32_t> rank(tree.nodes().size(), 0);  // of nodes, on the way down
  std::vector<Branch> pending{tree.branch(Place::root())};
  std::uint32_t next = 0;
  while (!pending.empty()) {
    const Branch here = pending.back();
    pending.pop_back();
    if (here.is_out()) continue;
    rank[here.node().value()] = next++;
    const Node& node = tree.node(here.node());
    if (here.is_sp()) pending.push_back(node.child[1]);
    pending.push_back(node.child[0]);
  }
  const auto rank_of = [&](const Piece& piece) -> std::uint32_t {
    if (piece.kind == Piece::Kind::free) return 0;
    if (piece.kind != Piece::Kind::at_leaf) return rank[piece.node().value()];
    return piece.leaf().is_root() ? 0 : rank[piece.leaf().node().value()];
  };
  const auto key = [&](PieceId p) {
    const Piece& piece = tree.pieces[p];
    return std::tuple(piece.facet, rank_of(piece), piece.node_or_leaf & 1, piece.kind);
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](PieceId a, PieceId b) { return key(a) < key(b); });
  return order;
}

// Takes the fragments of a cell as they come and merges them.
class MergingSink {
 public:
  MergingSink(const SvbspTree& tree, CellId cell, const EmissionContext& context, Workspace& w,
              CellOutput& out)
      : cell_(cell),
        context_(context),
        w_(w),
        out_(out),
        reversed_(context.space.handedness() < 0),
        predicates_(tree.predicates()),
        tree_(tree) {}

  // A facet's fragments come in the order in which filtering cut it, depth first: the two sides of
  // a cut come side by side once each is in one state. So holding them on a stack, and merging the
  // two on top as long as they merge, removes every cut whose sides came to the same state (Slater
  // 1992, figure 6).
  void add(PieceId piece, std::uint32_t place, BranchState state,
           std::span<const ConeCorner> corners) {
    const FacetId facet = tree_.pieces[piece].facet;
    if (!context_.merges()) return emit(facet, corners, piece, place, state);
    if (facet != held_facet_) release();
    held_facet_ = facet;
    held_.push_back({static_cast<std::uint32_t>(held_corners_.size()),
                     static_cast<std::uint32_t>(corners.size()), piece, place, state});
    held_corners_.insert(held_corners_.end(), corners.begin(), corners.end());
    while (held_.size() > 1 && merge_top()) {
    }
  }

  // Emits what is still held.
  void release() {
    SHADOWCUT_ASSERT(held_.empty() || held_facet_.valid());
    for (const Held& h : held_) {
      emit(held_facet_, std::span<const ConeCorner>(held_corners_).subspan(h.first, h.count),
           h.piece, h.place, h.state);
    }
    held_.clear();
    held_corners_.clear();
  }

 private:
  struct Held {
    std::uint32_t first, count;  // into held_corners_
    PieceId piece;
    std::uint32_t place;
    BranchState state;
  };

  // Merges the two polygons on top of the stack if they are in like states, meet in a whole edge of
  // both, and their union is convex.
  bool merge_top() {
    SHADOWCUT_ASSERT(held_.size() >= 2);
    Held& a = held_[held_.size() - 2];
    const Held& b = held_.back();
    const std::span<const ConeCorner> corners = held_corners_;
    if (!is_alike(context_.scene, a.state, b.state) ||
        !ConvexMerger(predicates_)
             .merge(corners.subspan(a.first, a.count), corners.subspan(b.first, b.count),
                    held_facet_, LineId(), merged_))
      return false;
    held_corners_.resize(a.first);
    held_corners_.insert(held_corners_.end(), merged_.begin(), merged_.end());
    a.count = static_cast<std::uint32_t>(merged_.size());
    held_.pop_back();
    return true;
  }

  void emit(FacetId facet, std::span<const ConeCorner> cone, PieceId piece, std::uint32_t place,
            BranchState state) {
    SHADOWCUT_ASSERT(!state.is_mixed() && cone.size() >= 3);
    const auto count = static_cast<std::uint32_t>(cone.size());
    auto& corners = out_.block.corners;
    const std::size_t first = corners.size();
    corners.resize(first + count);
    const double area =
        place_polygon(context_, predicates_, facet, cone, w_.points, corners.data() + first);
    if (is_below_min_feature(context_, facet, cone, std::span(corners).subspan(first), area)) {
      corners.resize(first);
      return;
    }
    if (context_.constructions) note_constructions(context_, predicates_, cone, first, out_.block);
    const std::uint32_t face = context_.tables.face_of(facet).value();
    out_.block.fragments.push_back({fragment_id(cell_, piece, place), face, facet.value(),
                                    state.caster(), static_cast<std::uint32_t>(first), count,
                                    state.is_lit(), area});
    if (!context_.keeps_lines()) return;
    for (std::uint32_t k = 0; k < count; ++k) {
      // The edge that leaves corner k in this order.
      const std::uint32_t i = reversed_ ? (2 * count - 2 - k) % count : k;
      out_.edge_lines.push_back(name_of_line(facet, cone[i].edge.line()));
    }
  }

  // Edges of the facet's own object by their index; other objects' lines, and the cell's own lines,
  // by what sets them apart.
  std::uint64_t name_of_line(FacetId facet, LineId line) const {
    if (is_local(line)) return static_cast<std::uint64_t>(cell_.value() + 1) << 32 | line.value();
    const std::uint32_t o = context_.tables.object_of(facet);
    return context_.tables.lines.is_own(context_.scene.objects()[o], o, line)
               ? context_.tables.lines.edge_of(o, line)
               : std::uint64_t{1} << 63 | line.value();
  }

  CellId cell_;
  const EmissionContext& context_;
  Workspace& w_;
  CellOutput& out_;
  bool reversed_;
  CellPredicates predicates_;
  const SvbspTree& tree_;
  FacetId held_facet_;
  std::vector<Held> held_;  // fragments of one facet that may still grow
  std::vector<ConeCorner> held_corners_, merged_;
};

}  // namespace

void emit_cell(const SvbspTree& tree, CellId cell, const EmissionContext& context, Workspace& w,
               CellOutput& out) {
  w.points.clear();
  BranchStates states;
  if (context.merges()) states.compute(tree, context.scene);
  const std::size_t pieces = tree.pieces.pieces().size();
  out.block.fragments.reserve(pieces * 3);
  out.block.corners.reserve(pieces * 14);
  MergingSink sink(tree, cell, context, w, out);
  FragmentEmitter emitter(tree, states, context, w, sink);
  for (const PieceId piece : order_of_cuts(tree)) emitter.emit_piece(piece);
  sink.release();
}

}  // namespace shadowcut
