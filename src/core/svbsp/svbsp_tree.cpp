#include "svbsp/svbsp_tree.hpp"

#include <algorithm>
#include <utility>

namespace shadowcut {

std::uint64_t SvbspTree::bytes() const {
  return nodes_.size() * sizeof(Node) + links_.size() * sizeof(NodeLinks) + pieces.bytes() +
         lines.bytes();
}

std::uint64_t SvbspTree::depth() const {
  std::uint64_t deepest = 0;
  std::vector<std::pair<Branch, std::uint64_t>> pending{{root_, 0}};
  while (!pending.empty()) {
    const auto [here, above] = pending.back();
    pending.pop_back();
    deepest = std::max(deepest, above);
    if (here.is_out()) continue;
    const Node& n = node(here.node());
    pending.emplace_back(n.child[0], above + 1);
    if (here.is_sp()) pending.emplace_back(n.child[1], above + 1);
  }
  return deepest;
}

Cone* SvbspTree::cone_of(const Piece& piece, ConePool& pool) const {
  Cone* cone = pool.take(piece.corner_count + 1);
  cone->facet = piece.facet;
  cone->entry = piece.entry;
  cone->error = piece.error;
  cone->assign(pieces.corners(piece));
  return cone;
}

void SvbspTree::clear() {
  logs_ = false;
  root_ = Branch::out();
  nodes_.clear(), links_.clear();
  pieces.clear(), lines.clear(), log.clear();
  free_nodes_.clear();
  released_nodes_.clear(), new_marks_.clear();
  pp_nodes_ = marked_nodes_ = 0;
  counts = {};
}

// Generous figures: pages that are never written cost nothing, moving a vector does.
void SvbspTree::reserve(std::size_t facets) {
  nodes_.reserve(facets * 16);
  links_.reserve(facets * 16);
  pieces.reserve(facets);
}

void SvbspTree::begin_rebuild() {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (links_[i].is_marked() && links_[i].line_kept)
      log.lines_released.push_back(nodes_[i].line());
  }
  logs_ = false;
  root_ = Branch::out();
  nodes_.clear(), links_.clear();
  free_nodes_.clear();
  pieces.clear_pieces();
  lines.clear();
  pp_nodes_ = marked_nodes_ = 0;
}

NodeId SvbspTree::add_node(const double n[3], float error, std::uint32_t line_or_owner,
                           Place parent, PieceId owner) {
  const Node node{{n[0], n[1], n[2]}, error, {Branch::out(), Branch::out()}, line_or_owner};
  const NodeLinks links{parent, owner, PieceId(), NodeLinks::Status::owned, false};
  if (free_nodes_.empty()) {
    nodes_.push_back(node);
    links_.push_back(links);
    return NodeId(nodes_.size() - 1);
  }
  const NodeId id = free_nodes_.take();
  SHADOWCUT_ASSERT(this->links(id).is_released());
  nodes_[id.value()] = node;
  links_[id.value()] = links;
  return id;
}

void SvbspTree::add_sp_node(Place& place, EdgeRef edge, PieceId owner) {
  SHADOWCUT_ASSERT(pieces[owner].kind == Piece::Kind::owner && edge.line().valid());
  const Line& l = line(edge.line());
  const NodeId node = add_node(l.n, l.error, edge.line().value(), place, owner);
  lines.count_use(edge.line(), true);
  slot(place) = Branch::sp(node);
  place = Place(node, edge.negative() ? 1 : 0);
}

void SvbspTree::add_pp_node(Place place, PieceId owner) {
  SHADOWCUT_ASSERT(branch(place).is_empty() && pieces[owner].kind == Piece::Kind::owner);
  const PlaneCovector& q = tables_->covector_of(pieces[owner].facet);
  const NodeId pp = add_node(q.q, q.error, owner.value(), place, owner);
  slot(place) = Branch::pp(pp);
  ++pp_nodes_;
  pieces[owner].node_or_leaf = pp.value();
}

PieceId SvbspTree::store(const Cone& cone, Piece::Kind kind, std::uint32_t at) {
  const PieceId piece = pieces.store(cone, kind, at, lines);
  if (logs_) log.pieces_added.push_back(piece);
  return piece;
}

void SvbspTree::add_to_list(PieceId piece, NodeId pp) {
  SHADOWCUT_ASSERT(is_pp(pp) && pieces[piece].node() == pp && !pieces[piece].next.valid());
  PieceId& first = links(pp).first;
  pieces[piece].next = first;
  if (first.valid()) pieces[first].previous = piece;
  first = piece;
}

void SvbspTree::rest_at_leaf(PieceId piece, Place place) {
  const Branch leaf = branch(place);
  SHADOWCUT_ASSERT(leaf.is_out() && pieces[piece].leaf() == place);
  if (!leaf.is_empty()) {
    pieces[piece].next = leaf.first_piece();
    pieces[leaf.first_piece()].previous = piece;
  }
  slot(place) = Branch::out(piece);
}

// A branch in its place; what it leads to knows the place.
void SvbspTree::put(Place place, Branch branch) {
  SHADOWCUT_ASSERT(branch.is_out() || !links(branch.node()).is_released());
  slot(place) = branch;
  if (!branch.is_out()) {
    links(branch.node()).parent = place;
  } else {
    for (PieceId p = branch.first_piece(); p.valid(); p = pieces[p].next)
      pieces[p].node_or_leaf = place.value();
  }
}

// Takes a piece out of the list of its node or leaf. Owners are in no list.
void SvbspTree::unlink(PieceId piece) {
  const Piece& p = pieces[piece];
  SHADOWCUT_ASSERT(p.kind != Piece::Kind::owner && p.kind != Piece::Kind::free);
  if (p.next.valid()) pieces[p.next].previous = p.previous;
  if (p.previous.valid()) {
    pieces[p.previous].next = p.next;
  } else if (p.kind == Piece::Kind::at_leaf) {
    slot(p.leaf()) = p.next.valid() ? Branch::out(p.next) : Branch::out();
  } else {
    links(p.node()).first = p.next;
  }
}

void SvbspTree::release_piece(PieceId piece) {
  if (logs_) log.dropped.push_back({EditLog::Dropped::Kind::piece, piece.value()});
  pieces.release(piece, lines);
}

void SvbspTree::replace_corners(PieceId piece, std::span<const ConeCorner> corners) {
  if (logs_) log.dropped.push_back({EditLog::Dropped::Kind::piece, piece.value()});
  pieces.replace_corners(piece, corners, lines);
  if (logs_) log.pieces_added.push_back(piece);
}

void SvbspTree::mark(NodeId sp) {
  SHADOWCUT_ASSERT(branch(links(sp).parent).is_sp() && !links(sp).is_marked());
  links(sp).status = NodeLinks::Status::marked;
  ++marked_nodes_;
  new_marks_.push_back(sp);
}

void SvbspTree::release_node(NodeId node, bool is_sp) {
  if (logs_) log.dropped.push_back({EditLog::Dropped::Kind::node, node.value()});
  NodeLinks& l = links(node);
  SHADOWCUT_ASSERT(!l.is_released());
  if (is_sp) {
    const LineId line = this->node(node).line();
    if (l.is_marked()) {
      --marked_nodes_;
      if (l.line_kept) log.lines_released.push_back(line);
    }
    lines.count_use(line, false);
  } else {
    --pp_nodes_;
  }
  l.status = NodeLinks::Status::released;
  released_nodes_.push_back(node);
}

// A copy of a line, for edges that stay after the line's object, or its node, has gone.
LineId SvbspTree::add_local_copy(LineId id) {
  SHADOWCUT_ASSERT(id.valid());
  Line copy = line(id);
  copy.a = copy.b = invalid_index;
  return lines.add_idle(copy, tables_->is_exact() ? predicates().exact(id) : LightLine{});
}

Place SvbspTree::resolve(Place place) const {
  while (!place.is_root() && links(place.node()).is_released()) place = links(place.node()).parent;
  return place;
}

void SvbspTree::finish_removal() {
  SHADOWCUT_ASSERT(marked_nodes_ <= nodes_.size() && pp_nodes_ <= nodes_.size());
  for (const NodeId node : new_marks_) {
    NodeLinks& l = links(node);
    if (!l.is_marked()) continue;
    ++counts.deferred;
    const LineId line = this->node(node).line();
    if (is_local(line)) continue;
    l.line_kept = true;
    log.lines_kept.push_back(line);
  }
  new_marks_.clear();
  for (Place& place : log.places_changed) place = resolve(place);
  SHADOWCUT_ASSERT(
      std::none_of(log.places_changed.begin(), log.places_changed.end(),
                   [this](Place p) { return !p.is_root() && links(p.node()).is_released(); }));
  for (const NodeId node : released_nodes_) free_nodes_.give_back(node);
  released_nodes_.clear();
  lines.release_idle();
}

}  // namespace shadowcut
