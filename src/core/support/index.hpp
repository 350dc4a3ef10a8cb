// Strong index types. An index into one array cannot be passed where an index into another array
// is expected, and arithmetic on an index has to say so (value()).
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace shadowcut {

template <class Tag>
class Index {
 public:
  constexpr Index() = default;  // names no element
  constexpr explicit Index(std::uint32_t value) : value_(value) {}
  constexpr explicit Index(std::size_t value) : value_(static_cast<std::uint32_t>(value)) {}

  constexpr std::uint32_t value() const { return value_; }
  constexpr bool valid() const { return value_ != 0xFFFFFFFFu; }
  friend constexpr auto operator<=>(Index, Index) = default;

 private:
  std::uint32_t value_ = 0xFFFFFFFFu;
};

using FaceId = Index<struct FaceTag>;    // into Scene::faces()
using FacetId = Index<struct FacetTag>;  // into Scene::facets()
using LineId = Index<struct LineTag>;    // into a light's LineTable, or into a cell's own lines
using CellId = Index<struct CellTag>;    // into CellGrid's cells
using NodeId = Index<struct NodeTag>;    // into an SvbspTree's nodes
using PieceId = Index<struct PieceTag>;  // into an SvbspTree's pieces
using EntryId = Index<struct EntryTag>;  // into an SvbspTree's entries

}  // namespace shadowcut
