// The SVBSP tree of one cell, on a few nodes. The light is straight above; a drawing shows faces
// from the side, and a tree with + for the positive and - for the negative side of an SP-node.
#include "svbsp/svbsp_tree.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "light_stage.hpp"
#include "support/free_list.hpp"

namespace shadowcut {
namespace {

class SvbspFixture {
 public:
  explicit SvbspFixture(Kernel kernel) : stage(kernel) {}
  // After the last face: a tree of all faces, in their order.
  void build(std::uint32_t join_threshold = 0) {
    stage.finish();
    tree.emplace(stage.tables(), TreeSettings{true, join_threshold});
    stage.tables().lines.start_blocks(stage.scene().objects());
    for (std::uint32_t f = 0; f < stage.scene().facets().size(); ++f)
      entries.push_back(insert(*tree, stage.cone(f), stage.workspace()));
    tree->end_rebuild();
    check();
  }
  void take_out(std::uint32_t facet) {
    const EntryId entry = entries[facet];
    remove(*tree, {&entry, 1}, stage.workspace());
    check();
  }
  void put_in(std::uint32_t facet) {
    entries[facet] = insert(*tree, stage.cone(facet), stage.workspace());
    check();
  }
  void check() { EXPECT_EQ(validate(*tree, &stage.space()), ""); }
  std::vector<Piece::Kind> kinds(std::uint32_t facet) const {
    std::vector<Piece::Kind> out;
    for (PieceId p = tree->pieces.entry(entries[facet]).first; p.valid(); p = tree->pieces[p].after)
      out.push_back(tree->pieces[p].kind);
    return out;
  }
  using Kinds = std::vector<Piece::Kind>;

  LightStage stage;
  std::optional<SvbspTree> tree;
  std::vector<EntryId> entries;
};

class Svbsp : public testing::TestWithParam<Kernel>, protected SvbspFixture {
 protected:
  Svbsp() : SvbspFixture(GetParam()) {}
};
INSTANTIATE_TEST_SUITE_P(Kernels, Svbsp, testing::Values(Kernel::fast, Kernel::exact));

//   -----      a triangle:  SP - SP - SP - PP - OUT
TEST_P(Svbsp, OneTriangle) {
  stage.add_face(0, {{-1, -1}, {1, -1}, {0, 1}});
  build();
  EXPECT_EQ(tree->node_count(), 4u);
  EXPECT_EQ(tree->pp_nodes(), 1u);
  EXPECT_EQ(tree->depth(), 4u);
  EXPECT_EQ(kinds(0), (Kinds{Piece::Kind::owner}));
  const PieceId owner = tree->pieces.entry(entries[0]).first;
  EXPECT_TRUE(tree->branch(Place(tree->pieces[owner].node(), 0)).is_empty());
}

//    ---       The upper square (first) owns 4 SP-nodes and a PP-node. Of the lower one the middle
//   -----      is behind that PP-node; four parts around it own PP-nodes of their own.
TEST_P(Svbsp, ASmallSquareAboveALargeOne) {
  stage.add_rectangle(1, -1, -1, 1, 1);
  stage.add_rectangle(0, -2, -2, 2, 2);
  build();
  const Kinds lower = kinds(1);
  EXPECT_EQ(lower.size(), 5u);
  EXPECT_EQ(std::count(lower.begin(), lower.end(), Piece::Kind::behind), 1);
  EXPECT_EQ(tree->pp_nodes(), 5u);
}

//   -----      The large square comes first: it owns one PP-node, and the upper square stands whole
//    ---       in front of it.
TEST_P(Svbsp, TheOtherOrder) {
  stage.add_rectangle(0, -2, -2, 2, 2);
  stage.add_rectangle(1, -1, -1, 1, 1);
  build();
  EXPECT_EQ(kinds(0), (Kinds{Piece::Kind::owner}));
  EXPECT_EQ(kinds(1), (Kinds{Piece::Kind::owner}));
  EXPECT_EQ(tree->node_count(), 10u);
}

//   -- --      Two halves of one table top: the second is coplanar where it overlaps the first.
TEST_P(Svbsp, CoplanarFacesShareAPPNode) {
  stage.add_rectangle(0, -1, -1, 1, 1);
  stage.add_rectangle(0, -0.5, -0.5, 0.5, 0.5);
  build();
  EXPECT_EQ(kinds(1), (Kinds{Piece::Kind::coplanar}));
  EXPECT_EQ(tree->pp_nodes(), 1u);
}

//   \ /        Two faces that cross: the second is cut along the crossing line. Its part in front
//    X         becomes an owner; the line is one of the cell's own.
//   / \.
TEST_P(Svbsp, CrossingFacesAreCutAlongTheirCrossingLine) {
  Mesh mesh;
  mesh.vertices = {{-1, -1, -0.5}, {1, -1, 0.5}, {1, 1, 0.5}, {-1, 1, -0.5}};
  mesh.add_face({0, 1, 2, 3});
  Mesh mirror = mesh;
  for (Vec3& v : mirror.vertices) v.z() = -v.z();
  stage.add_mesh(mesh);
  stage.add_mesh(mirror);
  build();
  Kinds second = kinds(1);
  std::sort(second.begin(), second.end());
  EXPECT_EQ(second, (Kinds{Piece::Kind::owner, Piece::Kind::behind}));
  EXPECT_EQ(tree->lines.size(), 1u);
}

// A face that receives and does not cast rests at the leaf that it reaches.
TEST_P(Svbsp, AFaceThatDoesNotCastRestsAtALeaf) {
  ObjectSettings receives_only;
  receives_only.casts_shadows = false;
  stage.add_rectangle(0, -2, -2, 0, 2);
  stage.add_rectangle(1, 0.5, -1, 1, 1, receives_only);
  build();
  EXPECT_EQ(kinds(1), (Kinds{Piece::Kind::at_leaf}));
  EXPECT_EQ(tree->pp_nodes(), 1u);
}

// CS95, section 3.1 (b), (c): the PP-node gives way, its SP-nodes go, and the part that was behind
// comes to the front. An empty tree is left when all faces have gone.
TEST_P(Svbsp, RemovalLeavesATreeOfTheOtherFaces) {
  for (const std::uint32_t threshold : {0u, 2u, 16u}) {
    SCOPED_TRACE(threshold);
    SvbspFixture f(GetParam());
    f.stage.add_rectangle(1, -1, -1, 1, 1);
    f.stage.add_rectangle(0, -2, -2, 2, 2);
    f.build(threshold);
    f.take_out(0);
    const Kinds lower = f.kinds(1);
    EXPECT_EQ(std::count(lower.begin(), lower.end(), Piece::Kind::behind), 0);
    f.put_in(0);
    f.take_out(1);
    EXPECT_EQ(f.kinds(0), (Kinds{Piece::Kind::owner}));
    EXPECT_EQ(f.tree->pp_nodes(), 1u);
    f.take_out(0);
    EXPECT_EQ(f.tree->node_count(), 0u);
    EXPECT_EQ(f.tree->lines.size(), 0u);
    EXPECT_TRUE(f.tree->branch(Place::root()).is_empty());
  }
}

// An edit log names the pieces and nodes that went, and the places where the tree has changed.
TEST_P(Svbsp, ALogOfEdits) {
  stage.add_rectangle(1, -1, -1, 1, 1);
  stage.add_rectangle(0, -2, -2, 2, 2);
  build();
  EXPECT_TRUE(tree->log.dropped.empty());
  take_out(0);
  EXPECT_FALSE(tree->log.dropped.empty());
  EXPECT_FALSE(tree->log.places_changed.empty());
  for (const Place place : tree->log.places_changed)
    EXPECT_TRUE(place.is_root() || !tree->links(place.node()).is_released());
}

TEST(RangeList, ReusesRangesOfTheSameLength) {
  std::vector<int> v;
  RangeList free;
  EXPECT_EQ(free.take(v, 3), 0u);
  EXPECT_EQ(free.take(v, 2), 3u);
  free.give_back(0, 3);
  EXPECT_EQ(free.unused(), 3u);
  EXPECT_EQ(free.take(v, 2), 5u);  // no free range of this length
  EXPECT_EQ(free.take(v, 3), 0u);
  EXPECT_EQ(free.unused(), 0u);
  EXPECT_EQ(v.size(), 7u);
}

TEST(FreeList, TakesTheLowestFirst) {
  FreeList<NodeId> free;
  for (const std::uint32_t i : {5u, 2u, 9u}) free.give_back(NodeId(i));
  EXPECT_EQ(free.take(), NodeId(2u));
  EXPECT_EQ(free.take(), NodeId(5u));
  free.give_back(NodeId(1u));
  EXPECT_EQ(free.take(), NodeId(1u));
  EXPECT_EQ(free.size(), 1u);
}

}  // namespace
}  // namespace shadowcut
