// The inputs and settings of fragment emission, and the ids of fragments.
#pragma once

#include "facets/facet_visibility.hpp"

namespace shadowcut {

// The parts of a light from which its fragments are emitted, and the form of the fragments.
struct EmissionContext {
  const Scene& scene;
  const LightSpace& space;
  const LightTables& tables;
  const FacetVisibility& visibility;
  const Light& light;
  Form form;
  bool constructions;  // fill Block::constructions
  MinFeature min_feature;

  bool merges() const { return form != Form::pieces; }
  bool keeps_lines() const { return form == Form::conforming; }
  bool receives(FacetId facet) const {
    return scene.objects()[tables.object_of(facet)].receives_shadows;
  }
};

// All fragment ids are made here. `cell`: the index of the fragment's block. `place`: in front of
// the piece's PP-node, the place that the fragment fills; invalid_index for a piece behind its
// PP-node or at a leaf. A merged fragment has the id of one of its parts.
inline FragmentId fragment_id(CellId cell, PieceId piece, std::uint32_t place) {
  return {cell.value(), piece.value(), place};
}
// Of a facet that is turned away: the block of such facets follows the blocks of the cells.
inline FragmentId away_fragment_id(std::size_t cell_count, FacetId facet) {
  return {static_cast<std::uint32_t>(cell_count), facet.value(), invalid_index};
}

}  // namespace shadowcut
