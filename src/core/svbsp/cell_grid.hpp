// Light space divided into cells: the k-d tree, an SVBSP tree for each cell, and the location lists
// of objects over all cells (CS95, section 3).
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "facets/facet_visibility.hpp"
#include "support/parallel.hpp"
#include "support/progress.hpp"
#include "svbsp/kd_tree.hpp"
#include "svbsp/svbsp_tree.hpp"

namespace shadowcut {

// Parts of facets, by the cell in which they are.
struct FacetParts {
  struct Part {
    CellId cell;
    FacetId facet;
    std::uint32_t first_corner, corner_count;  // 0: the whole facet
    float error;
  };
  std::vector<Part> list;
  std::vector<ConeCorner> corners;

  void append(const FacetParts& other);
};

class CellGrid {
 public:
  CellGrid(const Scene& scene, LightTables& tables, const FacetVisibility& visibility,
           const TreeSettings& settings, PerThread<Workspace>& workspaces)
      : scene_(scene),
        tables_(tables),
        visibility_(visibility),
        settings_(settings),
        workspaces_(workspaces) {}

  const KdTree& kd_tree() const {
    SHADOWCUT_ASSERT(kd_tree_ != nullptr);
    return *kd_tree_;
  }
  std::size_t size() const { return cells_.size(); }
  SvbspTree& operator[](CellId cell) {
    SHADOWCUT_ASSERT(cell.value() < cells_.size());
    return cells_[cell.value()];
  }
  const SvbspTree& operator[](CellId cell) const {
    SHADOWCUT_ASSERT(cell.value() < cells_.size());
    return cells_[cell.value()];
  }

  // Divides light space by the facets' middle rays. Then builds all trees from facets in their
  // order of insertion. The result is the same for any number of threads, to the bit.
  void divide(std::vector<Vec3> rays, bool far, std::uint32_t facets_per_cell);
  void build(std::span<const FacetId> order, const std::function<void(double)>& report);

  // The parts of facets in all cells, sorted by cell; within a cell in the order of the facets.
  FacetParts filter(std::span<const FacetId> order);
  Cone* cone_of(const FacetParts& parts, const FacetParts::Part& part, ConePool& pool) const;
  // Builds a cell's tree again from its entries. `order`: a list of lists of facets, others than
  // the cell's among them, in their order of insertion.
  void rebuild(CellId cell, std::span<const FacetId> order, Workspace& w);

  // Location lists.
  void grow(std::size_t objects) {
    if (locations_.size() < objects) locations_.resize(objects);
  }
  void add_location(CellId cell, EntryId entry);
  // Empties the location lists of objects; returns what they held, by cell and entry.
  std::vector<Location> take_locations(std::span<const std::uint32_t> objects);
  std::uint64_t pieces_of(std::uint32_t object) const;  // the length of its location list

  // Invariants over all cells, under edits; empty when all hold. See validate.cpp.
  std::string validate_locations() const;
  std::string validate_lines() const;

 private:
  void filter_into_cells(FacetId facet, FacetParts& parts, Workspace& w) const;
  std::vector<FacetParts> filter_in_chunks(std::span<const FacetId> order, std::size_t size);

  const Scene& scene_;
  LightTables& tables_;
  const FacetVisibility& visibility_;
  TreeSettings settings_;
  PerThread<Workspace>& workspaces_;
  std::unique_ptr<KdTree> kd_tree_;
  std::vector<SvbspTree> cells_;
  std::vector<Location> locations_;  // by object: the head of its location list
};

// Facets, or parts of them, from which on an edit runs on several threads.
inline constexpr std::size_t worth_threads = 128;

}  // namespace shadowcut
