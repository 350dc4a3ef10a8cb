// Which facets enter the trees of one light, how they stand to the light, and their cones.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clipping/clip.hpp"
#include "support/parallel.hpp"

namespace shadowcut {

class FacetVisibility {
 public:
  // The references must stay valid. `tables`: the exact predicates must have seen all positions
  // before decide_all() and decide().
  FacetVisibility(const Scene& scene, const LightSpace& space, const LightTables& tables,
                  PerThread<Workspace>& workspaces)
      : scene_(scene), space_(space), tables_(tables), workspaces_(workspaces) {}

  // Decides every facet, or the facets of one object, without looking at loops.
  void decide_all(const Light& light);
  void decide(std::uint32_t object, const Light& light);
  // Exact kernel: looks at the loops of facets that enter, once the tables are filled. Flat up to
  // rounding, and with straight corners, a loop may be convex only nearly: then it is cut along the
  // lines of its own edges. A facet whose loop has no area, or crosses itself, does not enter.
  void check_loops();
  void check_loop(FacetId facet);
  // The facets of an object that has been removed.
  void leave(std::uint32_t object);
  void grow();  // to the size of the scene

  // How the side of a facet that counts stands to the light. Only `toward` may be lit.
  Facing facing(FacetId f) const {
    SHADOWCUT_ASSERT(f.value() < facing_.size());
    return facing_[f.value()];
  }
  Orientation orientation(FacetId f) const { return orientation_[f.value()]; }
  bool enters(FacetId f) const {
    SHADOWCUT_ASSERT(f.value() < enters_.size());
    return enters_[f.value()];
  }
  std::size_t entered() const;
  // The far wall of a solid that the light is inside: it casts, and its own side is dark.
  bool blocks_only(FacetId f) const { return blocks_only_[f.value()]; }
  // Exact kernel: seen so nearly edge-on that the corners say little about the facet's region.
  bool grazed(FacetId f) const { return grazed_[f.value()]; }
  bool front_faces_light(FacetId f) const { return orientation(f) == Orientation::toward; }
  // The facet's loop runs counter-clockwise in light space when followed forward.
  bool forward(FacetId f) const;
  // Never entered, and is shadowed whole.
  bool is_away(FacetId f) const {
    return tables_.facet(f).corner_count != 0 &&
           (facing(f) == Facing::away || facing(f) == Facing::out_of_reach);
  }
  bool light_is_inside(const Object& object, const Light& light) const;

  // The cone of a facet that enters.
  Cone* cone_of(FacetId facet, ConePool& pool) const;
  // The convex cones of a facet: nearly always one. take(cone) takes each.
  template <class Take>
  void for_each_cone_of(FacetId facet, Workspace& w, const Take& take) const {
    Cone* cone = cone_of(facet, w.pool);
    if (!tables_.is_exact() || !(loops_[facet.value()] & loop_is_cut)) return take(cone);
    std::vector<Cone*> parts;
    cut_convex(cone, w, parts);
    for (Cone* part : parts) take(part);
  }
  // How far the corner behind an edge's end is on the edge's inside, in floating point.
  double turn_behind(const Cone& cone, std::uint32_t edge) const;

 private:
  // Exact kernel: a facet's loop as the light sees it.
  enum LoopFlags : std::uint8_t { loop_is_convex = 0, loop_is_cut = 1, loop_is_reversed = 2 };

  void decide(FacetId facet, bool in_range, bool light_inside, const Light& light);
  bool cut_convex(Cone* cone, Workspace& w, std::vector<Cone*>& parts) const;

  const Scene& scene_;
  const LightSpace& space_;
  const LightTables& tables_;
  PerThread<Workspace>& workspaces_;
  // All by facet.
  std::vector<Orientation> orientation_;
  std::vector<Facing> facing_;
  std::vector<std::uint8_t> enters_, blocks_only_, grazed_, loops_;
};

}  // namespace shadowcut
