// The invariants of a cell's fragments, checked.

#include "fragments/cell_fragments.hpp"
#include "support/message.hpp"

namespace shadowcut {
namespace {

// In front of a PP-node, an SP-node's state is what its sides have in common. (Elsewhere states are
// not used.)
std::string check_states(const SvbspTree& tree, const EmissionContext& context,
                         const BranchStates& states) {
  std::vector<std::uint8_t> below_pp(tree.nodes().size(), 0);
  std::vector<Branch> pending{tree.branch(Place::root())};
  while (!pending.empty()) {
    const Branch here = pending.back();
    pending.pop_back();
    if (here.is_out()) continue;
    const NodeId id = here.node();
    const Node& node = tree.node(id);
    for (const Branch c : {node.child[0], node.child[1]}) {
      if (c.is_out()) continue;
      below_pp[c.node().value()] = here.is_pp() || below_pp[id.value()];
      pending.push_back(c);
    }
    if (!here.is_sp() || !below_pp[id.value()]) continue;
    if (states.of(tree, here) != states.joint(tree, context.scene, id))
      return message("a node's state is not its sides' state", id.value());
  }
  return {};
}

// The state of a fragment of a piece in front of its PP-node: its place is uniform, and no place
// above it is. Writes into `problem` when that does not hold.
BranchState state_in_front(const SvbspTree& tree, const BranchStates& states, const Piece& piece,
                           std::uint32_t at, const char*& problem) {
  if (at == invalid_index) {
    problem = "a fragment in front of a PP-node has no place";
    return BranchState::mixed();
  }
  Place place(at);
  const BranchState state = states.of(tree, tree.branch(place));
  if (state.is_mixed()) problem = "a fragment's place is not uniform";
  while (!tree.is_pp(place.node())) {
    place = tree.links(place.node()).parent;
    if (place.is_root()) {
      problem = "a fragment's place is in front of nothing";
      return state;
    }
    if (!states.of(tree, tree.branch(place)).is_mixed())
      problem = "a fragment's place is part of a uniform place";
  }
  if (place.node() != piece.node()) problem = "a fragment's place is not in front of its piece";
  return state;
}

}  // namespace

std::string CellFragments::validate(const SvbspTree& tree, const EmissionContext& context,
                                    const Block& block) const {
  if (records_.size() != block.fragments.size())
    return "fragments and their records differ in number";
  std::size_t corners = free_corners_.unused();
  for (const Fragment& f : block.fragments) corners += f.corner_count;
  if (corners != block.corners.size()) return "corners are lost, or used twice";
  if (context.merges()) {
    if (std::string problem = check_states(tree, context, states_); !problem.empty())
      return problem;
  }
  for (std::uint32_t i = 0; i < block.fragments.size(); ++i) {
    const Fragment& f = block.fragments[i];
    if (find(f.id) != i) return message("a fragment is not found under its id", i);
    const Piece& piece = tree.pieces[PieceId(f.id.piece)];
    if (!emits(context, piece) || piece.facet.value() != f.facet)
      return message("a fragment's piece is not its own", i);
    BranchState state = BranchState::lit();
    const char* problem = nullptr;
    if (piece.is_in_front()) {
      state = state_in_front(tree, states_, piece, f.id.place, problem);
    } else {
      if (f.id.place != invalid_index) problem = "a fragment away from all PP-nodes has a place";
      if (piece.kind == Piece::Kind::behind) state = shadow_of(tree, piece.node());
    }
    if (problem) return message(problem, i);
    if (f.lit != state.is_lit() || (!f.lit && f.caster != state.caster()))
      return message("a fragment's state is not its place's state", i);
  }
  return {};
}

}  // namespace shadowcut
