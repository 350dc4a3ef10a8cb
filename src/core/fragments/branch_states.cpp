#include "fragments/branch_states.hpp"

#include <utility>

namespace shadowcut {
namespace {

// Calls f(sp) for every SP-node, after all nodes below it.
template <class F>
void for_each_sp_upward(const SvbspTree& tree, const F& f) {
  std::vector<std::pair<Branch, bool>> pending{{tree.branch(Place::root()), false}};
  while (!pending.empty()) {
    const auto [here, below_done] = pending.back();
    pending.pop_back();
    if (here.is_out()) continue;
    if (below_done) {
      if (here.is_sp()) f(here.node());
      continue;
    }
    pending.emplace_back(here, true);
    pending.emplace_back(tree.node(here.node()).child[0], false);
    if (here.is_sp()) pending.emplace_back(tree.node(here.node()).child[1], false);
  }
}

}  // namespace

void BranchStates::compute(const SvbspTree& tree, const Scene& scene) {
  states_.assign(tree.nodes().size(), BranchState::mixed());
  for_each_sp_upward(tree, [&](NodeId sp) { states_[sp.value()] = joint(tree, scene, sp); });
}

bool BranchStates::update(const SvbspTree& tree, const Scene& scene, NodeId sp) {
  const BranchState state = joint(tree, scene, sp);
  return std::exchange(states_[sp.value()], state) != state;
}

}  // namespace shadowcut
