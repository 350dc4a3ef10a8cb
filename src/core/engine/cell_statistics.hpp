// What the cells add to the statistics of a light, kept right while cells change.
#pragma once

#include <vector>

#include "engine/rebuild_policy.hpp"
#include "fragments/fragment_store.hpp"
#include "svbsp/cell_grid.hpp"

namespace shadowcut {

class CellStatistics {
 public:
  CellStatistics(const CellGrid& grid, const FragmentStore& fragments, const RebuildPolicy& policy,
                 Stats& stats)
      : grid_(grid), fragments_(fragments), policy_(policy), stats_(stats) {}

  // All cells, into statistics that hold none of them.
  void start();
  // A cell has changed.
  void update(CellId cell);

 private:
  struct Sums {
    std::uint64_t nodes = 0, pp_nodes = 0, pieces = 0, crossing_lines = 0, predicates = 0, on = 0,
                  by_identity = 0, by_exact = 0, marked = 0, joined = 0, deferred = 0, rebuilds = 0,
                  bytes = 0;
  };
  Sums sums_of(CellId cell) const;
  void add(const Sums& sums, bool more);

  const CellGrid& grid_;
  const FragmentStore& fragments_;
  const RebuildPolicy& policy_;
  Stats& stats_;
  std::vector<Sums> sums_;  // by cell: what the statistics hold of it
};

}  // namespace shadowcut
