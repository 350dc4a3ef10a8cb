// The state of everything in front of a PP-node: lit, shadowed, or mixed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "svbsp/svbsp_tree.hpp"

namespace shadowcut {

// Of a branch in front of a PP-node: lit, shadowed by a face, or more than one of these.
class BranchState {
 public:
  static constexpr BranchState lit() { return BranchState(0xFFFFFFFFu); }
  static constexpr BranchState mixed() { return BranchState(0xFFFFFFFEu); }
  static constexpr BranchState shadowed_by(FaceId face) { return BranchState(face.value()); }

  constexpr bool is_lit() const { return *this == lit(); }
  constexpr bool is_mixed() const { return *this == mixed(); }
  constexpr std::uint32_t caster() const {
    SHADOWCUT_ASSERT(!is_mixed());
    return bits_;
  }  // none if lit; not of a mixed one
  friend constexpr bool operator==(BranchState, BranchState) = default;

 private:
  explicit constexpr BranchState(std::uint32_t bits) : bits_(bits) {}
  std::uint32_t bits_;
};

// Whether fragments in these states may be emitted as one fragment: both lit, or both shadowed by
// faces of one object.
inline bool is_alike(const Scene& scene, BranchState a, BranchState b) {
  if (a == b) return true;
  if (a.is_lit() || a.is_mixed() || b.is_lit() || b.is_mixed()) return false;
  return scene.faces()[a.caster()].object == scene.faces()[b.caster()].object;
}

inline BranchState shadow_of(const SvbspTree& tree, NodeId pp) {
  SHADOWCUT_ASSERT(tree.is_pp(pp));
  return BranchState::shadowed_by(tree.tables().face_of(tree.owner_facet(pp)));
}

// The states of a tree's SP-nodes: what a node's two sides have in common.
class BranchStates {
 public:
  // A node whose state has not been computed is mixed: then fragments are emitted in pieces.
  BranchState of(const SvbspTree& tree, Branch branch) const {
    if (branch.is_out()) return BranchState::lit();
    if (branch.is_pp()) return shadow_of(tree, branch.node());
    const std::uint32_t i = branch.node().value();
    return i < states_.size() ? states_[i] : BranchState::mixed();
  }
  BranchState joint(const SvbspTree& tree, const Scene& scene, NodeId sp) const {
    const Node& node = tree.node(sp);
    SHADOWCUT_ASSERT(tree.branch(tree.links(sp).parent).is_sp());
    const BranchState a = of(tree, node.child[0]), b = of(tree, node.child[1]);
    return is_alike(scene, a, b) ? a : BranchState::mixed();
  }

  // Computes all states, children before their parents.
  void compute(const SvbspTree& tree, const Scene& scene);
  // Computes one state from the sides of the node. True: it has changed.
  bool update(const SvbspTree& tree, const Scene& scene, NodeId sp);
  void grow(const SvbspTree& tree) { states_.resize(tree.nodes().size(), BranchState::mixed()); }
  void forget(NodeId node) {
    SHADOWCUT_ASSERT(node.value() < states_.size());
    states_[node.value()] = BranchState::mixed();
  }
  void clear() { states_.clear(); }
  std::size_t size() const { return states_.size(); }

 private:
  std::vector<BranchState> states_;  // by node
};

}  // namespace shadowcut
