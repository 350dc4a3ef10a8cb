// The balanced k-d tree above the SVBSP trees.
#include "svbsp/kd_tree.hpp"

#include <gtest/gtest.h>

#include <map>

#include "light_stage.hpp"
#include "svbsp/descend.hpp"

namespace shadowcut {
namespace {

// A grid of n by n squares with gaps:
//   + +  + +  + +
//   + +  + +  + +
class KdTreeOfAGrid : public testing::Test {
 protected:
  static constexpr int n = 8;
  KdTreeOfAGrid() {
    for (int i = 0; i < n * n; ++i) {
      const double x = i % n - n / 2, y = i / n - n / 2;
      stage.add_rectangle(0, x, y, x + 0.75, y + 0.75);
      // No two rays on one dividing plane: then all splits are even.
      rays.push_back(Vec3(x + 0.001 * i, y + 0.0007 * i, 8).normalized());
    }
    stage.finish();
  }
  KdTree tree(std::uint32_t facets_per_cell) {
    return KdTree(rays, stage.space().far(), facets_per_cell, stage.tables().lines);
  }
  LightStage stage;
  std::vector<Vec3> rays;
};

struct Arrivals : DescentVisitor {
  const LightStage& stage;
  const KdTree& tree;
  std::map<CellId, std::vector<Cone*>> parts;
  Arrivals(const LightStage& s, const KdTree& t) : stage(s), tree(t) {}
  CellPredicates cell_predicates() const { return stage.predicates(); }
  bool stops_at(Place, KdTree::Branch here, std::uint32_t&) const { return here.is_cell(); }
  void arrive(Cone* cone, Place place) { parts[tree.branch(place).cell()].push_back(cone); }
};

TEST_F(KdTreeOfAGrid, ZeroFacetsPerCellIsOneCell) {
  const KdTree one = tree(0);
  EXPECT_EQ(one.cell_count(), 1u);
  EXPECT_EQ(one.node_count(), 0u);
  EXPECT_TRUE(one.branch(Place::root()).is_cell());
}

// 64 facets, at most 8 in a cell: 8 cells of depth 3, or one level more where a half rounds up.
TEST_F(KdTreeOfAGrid, IsBalanced) {
  const KdTree t = tree(8);
  EXPECT_EQ(t.cell_count(), t.node_count() + 1);
  EXPECT_GE(t.cell_count(), 8u);
  EXPECT_LE(t.cell_count(), 16u);
  for (std::size_t c = 0; c < t.cell_count(); ++c) EXPECT_LE(t.depth_of(CellId(c)), 4u);
}

// A floor under all squares is delivered to every cell; its parts are the parts that part_in()
// gives for each cell by itself.
TEST_F(KdTreeOfAGrid, DeliversAFloorToEveryCell) {
  stage.add_rectangle(-1, -4, -4, 4, 4);
  stage.finish();
  const KdTree t = tree(8);
  Arrivals arrivals(stage, t);
  descend(t, stage.cone(n * n), Place::root(), 0, stage.workspace(), arrivals);
  EXPECT_EQ(arrivals.parts.size(), t.cell_count());
  for (const auto& [cell, parts] : arrivals.parts) {
    ASSERT_EQ(parts.size(), 1u);
    Cone* part = t.part_in(cell, stage.cone(n * n), stage.predicates(), stage.workspace());
    ASSERT_NE(part, nullptr);
    EXPECT_EQ(stage.corners(*part), stage.corners(*parts[0]));
  }
}

// A small square meets few cells; the others get nothing of it.
TEST_F(KdTreeOfAGrid, PartInIsNullElsewhere) {
  const KdTree t = tree(8);
  Arrivals arrivals(stage, t);
  descend(t, stage.cone(0), Place::root(), 0, stage.workspace(), arrivals);
  for (std::size_t c = 0; c < t.cell_count(); ++c) {
    const Cone* part = t.part_in(CellId(c), stage.cone(0), stage.predicates(), stage.workspace());
    EXPECT_EQ(part != nullptr, arrivals.parts.count(CellId(c)) == 1) << "cell " << c;
  }
}

}  // namespace
}  // namespace shadowcut
