// Classifying, clipping and merging convex cones. The light is straight above: a drawing shows the
// face from above.
#include "clipping/clip.hpp"

#include <gtest/gtest.h>

#include "clipping/merge_convex.hpp"
#include "light_stage.hpp"

namespace shadowcut {
namespace {

using Points = std::vector<Eigen::Vector2d>;

void expect_corners(const LightStage& stage, const Cone& cone, const Points& expected) {
  const Points found = stage.corners(cone);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_LT((found[i] - expected[i]).norm(), 1e-14) << "corner " << i;
}

class Clip : public testing::TestWithParam<Kernel> {
 protected:
  // Square of side 2 around the origin:
  //   -1,1 +-----+ 1,1
  //        |     |
  //        |     |
  //  -1,-1 +-----+ 1,-1
  Clip() : stage(GetParam()) {
    stage.add_rectangle(0, -1, -1, 1, 1);
    stage.finish();
  }
  CornerSides sides(Cone& cone, LineId line) {
    SignCounts counts;
    return sides_of_line(cone, stage.dividing_line(line), stage.predicates(),
                         stage.workspace().spill, counts);
  }
  // The parts of the square on both sides of a line that cuts it, the one with the larger x first.
  std::pair<Cone*, Cone*> cut(LineId line, bool bounded = true) {
    Cone* cone = stage.cone(0);
    const CornerSides s = sides(*cone, line);
    EXPECT_TRUE(s.positive() && s.negative());
    Cone *a, *b;
    split(*cone, s, stage.dividing_line(line), bounded, stage.predicates(), stage.workspace().pool,
          a, b);
    if (stage.corners(*a).back().x() < stage.corners(*b).back().x()) std::swap(a, b);
    return {a, b};
  }
  LightStage stage;
};
INSTANTIATE_TEST_SUITE_P(Kernels, Clip, testing::Values(Kernel::fast, Kernel::exact));

//   +--|--+
//   |  |  |    The line x = 0.25 crosses two opposite edges: two rectangles.
//   +--|--+
TEST_P(Clip, ThroughOppositeEdges) {
  const auto [right, left] = cut(stage.add_line({0.25, -3}, {0.25, 3}));
  expect_corners(stage, *right, {{0.25, -1}, {0.25, 1}, {1, -1}, {1, 1}});
  expect_corners(stage, *left, {{-1, -1}, {-1, 1}, {0.25, -1}, {0.25, 1}});
}

//   +-----+
//   |     /    Through two neighbouring edges: a triangle and a pentagon.
//   +---/-+
TEST_P(Clip, ThroughNeighbouringEdges) {
  const auto [one, other] = cut(stage.add_line({0, -1.5}, {1.5, 0}));
  const Cone& triangle = one->count == 3 ? *one : *other;
  const Cone& pentagon = one->count == 3 ? *other : *one;
  expect_corners(stage, triangle, {{0.5, -1}, {1, -1}, {1, -0.5}});
  expect_corners(stage, pentagon, {{-1, -1}, {-1, 1}, {0.5, -1}, {1, -0.5}, {1, 1}});
}

//   +-----/
//   |   / |    Through two opposite corners: both are on the line, and stay vertices.
//   | /   |
//   /-----+
TEST_P(Clip, ThroughCorners) {
  Cone* cone = stage.cone(0);
  const LineId line = stage.add_line({-2, -2}, {2, 2});
  const CornerSides s = sides(*cone, line);
  EXPECT_EQ(s.count_on(), 2u);
  auto [lower, upper] = cut(line);
  if (stage.corners(*lower)[1].x() < 0) std::swap(lower, upper);
  expect_corners(stage, *lower, {{-1, -1}, {1, -1}, {1, 1}});
  expect_corners(stage, *upper, {{-1, -1}, {-1, 1}, {1, 1}});
  for (const Cone* part : {lower, upper}) {
    for (const ConeCorner& c : part->span()) EXPECT_LT(c.vertex, 4u);
  }
}

//   +-----+
//   |     |
//   +-----+
//   =======    The line runs along an edge: nothing is cut, and the edge counts as bounded.
TEST_P(Clip, AlongAnEdge) {
  Cone* cone = stage.cone(0);
  const LineId line = stage.add_line({-3, -1}, {3, -1});
  const CornerSides s = sides(*cone, line);
  EXPECT_NE(s.positive(), s.negative());
  EXPECT_EQ(s.count_on(), 2u);
  const std::uint32_t side = s.negative() ? 1 : 0;
  mark_bounded_edges(*cone, s, stage.dividing_line(line), side, stage.predicates(),
                     [](EdgeRef) { return true; });
  std::size_t bounded = 0;
  for (const ConeCorner& c : cone->span()) bounded += c.edge.bounded();
  EXPECT_EQ(bounded, 1u);
}

//   +--|--+
//   |  |  |    Both parts have the same bits in the corners of the cut, and its edge is bounded
//   +--|--+    when a node stands on the cut.
TEST_P(Clip, BothSidesOfACutShareTheirCorners) {
  const LineId line = stage.add_line({0.1, -3}, {0.3, 3});
  const auto [right, left] = cut(line);
  std::vector<std::array<double, 3>> of_right, of_left;
  const auto collect = [&](const Cone& cone, auto& out) {
    for (std::uint32_t i = 0; i < cone.count; ++i) {
      const ConeCorner& c = cone.corners()[i];
      if (c.edge.line() == line) {
        EXPECT_TRUE(c.edge.bounded());
      }
      if (c.edge.line() == line || incoming(cone.span(), i).line() == line)
        out.push_back({c.r[0], c.r[1], c.r[2]});
    }
    std::sort(out.begin(), out.end());
  };
  collect(*right, of_right);
  collect(*left, of_left);
  EXPECT_EQ(of_right.size(), 2u);
  EXPECT_EQ(of_right, of_left);
}

//   |  +-----+
//   |  |     |    The line misses the square: one side keeps it, the other gets nothing.
//   |  +-----+
TEST_P(Clip, Beside) {
  const LineId line = stage.add_line({-2, -3}, {-2, 3});
  Cone* kept[2];
  for (const std::uint32_t side : {0u, 1u})
    kept[side] =
        clip(stage.cone(0), stage.dividing_line(line), side, stage.predicates(), stage.workspace());
  EXPECT_NE(kept[0] == nullptr, kept[1] == nullptr);
  expect_corners(stage, kept[0] ? *kept[0] : *kept[1], {{-1, -1}, {-1, 1}, {1, -1}, {1, 1}});
}

// A face with more than 64 corners takes the path without bit masks, and gives the same parts.
TEST(ClipLarge, APolygonOfAHundredCorners) {
  LightStage stage;
  Points ring;
  for (int i = 0; i < 100; ++i) {
    const double t = 2 * 3.14159265358979 * (i + 0.5) / 100;
    ring.emplace_back(std::cos(t), std::sin(t));
  }
  stage.add_face(0, ring);
  stage.finish();
  const LineId line = stage.add_line({0, -3}, {0, 3});
  Cone* cone = stage.cone(0);
  SignCounts counts;
  const CornerSides s = sides_of_line(*cone, stage.dividing_line(line), stage.predicates(),
                                      stage.workspace().spill, counts);
  Cone *a, *b;
  split(*cone, s, stage.dividing_line(line), true, stage.predicates(), stage.workspace().pool, a,
        b);
  EXPECT_EQ(a->count, 52u);
  EXPECT_EQ(b->count, 52u);
}

//   +--|--+        +-----+
//   |  |  |   ->   |     |    The halves of a cut merge to the polygon before the cut.
//   +--|--+        +-----+
TEST_P(Clip, HalvesMergeAgain) {
  const auto [right, left] = cut(stage.add_line({0.25, -3}, {0.25, 3}));
  const CellPredicates predicates = stage.predicates();
  std::vector<ConeCorner> whole;
  const auto span = [](const Cone* c) { return c->span(); };
  ASSERT_TRUE(
      ConvexMerger(predicates).merge(span(right), span(left), FacetId(0u), LineId(), whole));
  EXPECT_EQ(whole.size(), 4u);
  Cone* cone = stage.workspace().pool.take(5);
  cone->facet = FacetId(0u);
  cone->assign(whole);
  expect_corners(stage, *cone, {{-1, -1}, {-1, 1}, {1, -1}, {1, 1}});
  // Across another line than the cut there is nothing to merge.
  EXPECT_FALSE(
      ConvexMerger(predicates)
          .merge(span(right), span(left), FacetId(0u), stage.add_line({9, 0}, {9, 1}), whole));
}

//   +--|--+
//   |--|  |    A quarter and the other half meet in a part of an edge: not merged.
//   +--|--+
TEST_P(Clip, PartsThatMeetInAPartOfAnEdgeDoNotMerge) {
  const auto [right, left] = cut(stage.add_line({0, -3}, {0, 3}));
  const LineId across = stage.add_line({-3, 0}, {3, 0});
  Cone* quarter = clip(left, stage.dividing_line(across), 0, stage.predicates(), stage.workspace());
  ASSERT_NE(quarter, nullptr);
  const CellPredicates predicates = stage.predicates();
  std::vector<ConeCorner> whole;
  EXPECT_FALSE(
      ConvexMerger(predicates).merge(right->span(), quarter->span(), FacetId(0u), LineId(), whole));
}

}  // namespace
}  // namespace shadowcut
