// The unordered shadow-volume BSP tree as it was printed, with the ways of joining subtrees that
// its authors weighed.
//
//   CS95     Y. Chrysanthou, M. Slater, "Shadow Volume BSP Trees for Computation of Shadows in
//            Dynamic Scenes", I3D 1995
//   NAT90    B. Naylor, J. Amanatides, W. Thibault, "Merging BSP trees yields polyhedral set
//            operations", SIGGRAPH 1990
//
// A rival for measurements, apart from the engine: it shares the light space (rays, lines, planes)
// and what enters, and nothing behind it. Plain doubles, one relative epsilon, 1e-12: a unit ray
// within it of a shadow plane is on that plane; two faces whose nearness differs by less along a
// ray touch there. No bounds, no exact signs: what is degenerate below the epsilon may come out
// otherwise than in the exact kernel (boxes that overlap by a last bit; a light that nearly lies in
// a face's plane, or faces less than about 1e-9 of the view across). Crossing faces are handled.
// Lights' ranges and cones, casts and receives mean what they mean to the engine.
//
// What the paper leaves open, and what is done here:
//   - A shadow volume has all planes of its polygon, also where the piece ends elsewhere (section
//     2). So when a plane above it goes, a
//     piece grows by itself, and fragments that meet are one (3.2). A fragment's outline is not
//       stored: it is the polygon, cut by the
//     planes above.
//   - Faces that cross (the paper has none): the line in which P crosses the target Q bounds what
//     is in front, and is one more plane of
//     P's volume, wherever P stands in front of Q.
//   - Coplanar faces: the second is stored with the first, as what is behind is; contact is not
//     occlusion.
//   - Nodes know their parents. So marked nodes are found from the location lists, and no pass over
//     the whole tree is needed (3.1).
//   - Shadows are not kept but computed when areas are asked for, by filtering each face down the
//     finished tree.
//   - Faces that receive and do not cast are filtered down, then, and stand nowhere in the tree.
#pragma once

#include <cstdint>
#include <memory>
#include <shadowcut/scene.hpp>
#include <string>
#include <vector>

namespace shadowcut::compare {

// How the subtrees are put together that the planes of a removed shadow volume held apart (CS95,
// 3.1, case c). The largest stays; the others are put into it:
enum class Joining : std::uint8_t {
  // CS95, 3.2: shadow volumes filtered down whole, with what is in front of them, as long as no
  // plane cuts their polygon
  filter,
  // NAT90: their root is that of the whole, each node partitions the other tree by its bounded part
  // of a plane
  merge,
  reinsert,  // taken to pieces, and every polygon inserted again
};
const char* name_of(Joining joining);

struct TreeCounts {
  // Now.
  // stored: polygons in the lists behind PP-nodes, each once in each list
  std::uint64_t sp_nodes = 0, pp_nodes = 0, stored = 0;
  // planes that bound no shadow volume any more
  std::uint64_t marked = 0;
  // Since the tree was made.
  std::uint64_t joins = 0;       // of two subtrees
  std::uint64_t visits = 0;      // nodes that something was filtered past
  std::uint64_t bounded = 0;     // merge: planes clipped to their region
  std::uint64_t partitions = 0;  // merge: nodes compared with a partitioning plane
  std::uint64_t nodes() const { return sp_nodes + pp_nodes; }
};

class PublishedTree {
 public:
  // Inserts all objects in the scene's order. The scene must outlive the tree. Throws Error when
  // the light is not usable.
  PublishedTree(const Scene& scene, const Light& light, Joining joining);
  ~PublishedTree();
  PublishedTree(PublishedTree&&) noexcept;

  // By index into scene.objects(). An object is taken out as it stood when it was put in, whatever
  // the scene says by now; both do nothing to what is out, or in, already.
  void remove(std::uint32_t object);
  void insert(std::uint32_t object);  // as it stands in the scene

  // By index into scene.faces(); 0 for faces that are not turned to the light or do not receive.
  std::vector<double> lit_areas() const;
  const TreeCounts& counts() const;
  // Every invariant; empty, or a sentence that says which does not hold.
  std::string validate() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace shadowcut::compare
