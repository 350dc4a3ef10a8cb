// What edits did to a cell's tree, for whoever keeps something beside the tree (fragments; lines).
#pragma once

#include <cstdint>
#include <vector>

#include "svbsp/nodes.hpp"

namespace shadowcut {

struct EditLog {
  // A piece or a node that is no longer what it was, in the order of the edits.
  struct Dropped {
    enum class Kind : std::uint8_t { piece, node } kind;
    std::uint32_t index;
  };
  std::vector<Dropped> dropped;
  std::vector<PieceId> pieces_added;   // may have been dropped again since
  std::vector<Place> places_changed;   // another branch hangs here; places of nodes that exist
  std::vector<LineId> lines_kept;      // one for each marked node that stays and has a line of the
                                       // LineTable
  std::vector<LineId> lines_released;  // one for each such node that has gone since

  void clear() {
    dropped.clear(), pieces_added.clear(), places_changed.clear();
    lines_kept.clear(), lines_released.clear();
  }
};

}  // namespace shadowcut
