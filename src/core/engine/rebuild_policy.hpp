// When a cell's tree is built again, after edits have made it larger than a fresh tree.
//
// Edits leave faces cut, and insert them in another order than a build. A cell that has grown by a
// tenth since it was built is built again, and so is a cell that several objects have come to and
// left many times, because the size of a fresh tree is then no longer known. In the long run that
// costs in proportion to the growth and to the edits. (An object that goes to and fro is no
// reason.)
//
// Back-off. A single object that is dragged through a cell re-fragments it at each step, so
// rebuilding at once is wasted. Where the same objects move that moved before the cell was built,
// the cell waits until as much has been inserted as a build inserts, and each time twice as long,
// unless it has grown by far. With several movers fragmentation compounds: then it does not wait.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "svbsp/svbsp_tree.hpp"

namespace shadowcut {

class RebuildPolicy {
 public:
  // After a build of all cells.
  void start(std::size_t cells);
  void note_built(CellId cell, const SvbspTree& tree);

  // Edits of a cell. `pieces`: how many pieces had to be inserted again.
  void note_removal(CellId cell, const SvbspTree& tree, std::size_t pieces);
  void note_mover(CellId cell, std::uint32_t object, std::uint32_t update);
  void note_insertion(CellId cell, const SvbspTree& tree, EntryId entry, std::uint32_t object);

  bool should_rebuild(CellId cell, const SvbspTree& tree) const;
  // Of the cell's objects, sorted: those that a rebuild inserts last, at the leaves of the tree.
  // They move again and again while others do not (CS95, section 4), and are not so much of the
  // cell that it is no build any more.
  std::vector<std::uint32_t> movers_at_leaves(CellId cell, const SvbspTree& tree,
                                              std::span<const std::uint32_t> objects) const;
  void note_rebuilt(CellId cell, const SvbspTree& tree);
  std::uint32_t rebuilds(CellId cell) const {
    return cell.value() < cells_.size() ? cells_[cell.value()].rebuilds : 0;
  }

 private:
  struct Mover {
    std::uint32_t object;
    std::uint32_t update;  // in which it was inserted last
    std::uint32_t times;   // in how many updates it was inserted
  };
  struct Cell {
    double nodes_per_entry = 0;          // when the cell was built last
    std::uint64_t edits = 0;             // entries inserted since
    std::uint32_t changes_of_mover = 0;  // since: how often another object than the last few came
    std::uint32_t backoff = 0;           // log2 of the wait, while that stays 0
    bool shattered = false;              // since: by a face that takes up much of the cell
    std::uint32_t rebuilds = 0;
    std::vector<Mover> movers = {};  // the objects inserted last, the latest last
  };

  std::vector<Cell> cells_;
};

}  // namespace shadowcut
