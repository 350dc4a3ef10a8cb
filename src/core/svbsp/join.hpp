// Joining the two sides of a marked SP-node, the plane of an edge of a removed face (CS95, section
// 3.2; NodeLinks says what marked means).
#pragma once

#include "svbsp/svbsp_tree.hpp"

namespace shadowcut {

// Removes a marked node by inserting its smaller side into its larger side. False, and nothing is
// done, if the smaller side has more nodes than TreeSettings::join_threshold.
bool join(SvbspTree& tree, NodeId node, Workspace& w);

// Merges a piece that has come to a PP-node's list with pieces of its facet already there.
void merge_in_list(SvbspTree& tree, PieceId piece, NodeId pp);

}  // namespace shadowcut
