// Everything the engine holds for one light: light space, the prefix, its cells' trees, and the shadows.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "emit.hpp"
#include "prefix.hpp"

namespace shadowcut {

class LightTree {
 public:
  LightTree(const Scene& scene, const Light& light, const Options& options);
  // Builds everything anew, for a light that may be another one; uses its memory again.
  void rebuild(const Light& light);

  const Shadows& shadows() const { return shadows_; }
  Shadows take_shadows() { return std::exchange(shadows_, {}); }
  const LightSpace& space() const { return space_; }
  const LightTables& tables() const { return tables_; }
  const Prefix& prefix() const { return *prefix_; }
  std::span<const CellTree> cells() const { return cells_; }
  std::string validate() const;

  // How a facet's side that counts stands to the light. Only `toward` may be lit.
  Facing facing(std::uint32_t facet) const { return facing_[facet]; }
  // The facet's loop runs counter-clockwise in light space when followed forward.
  bool forward(std::uint32_t facet) const { return turned_[facet] == Turned::toward ? space_.handedness() > 0 : space_.handedness() < 0; }
  bool front_lit(std::uint32_t facet) const { return turned_[facet] == Turned::toward; }

 private:
  void build_all();
  void face_the_light();
  void fill_tables();
  std::vector<std::uint32_t> insertion_order(std::vector<Vec3>& centers) const;
  Cone* cone_of_facet(std::uint32_t facet, ConePool& pool) const;
  void build(const std::vector<std::uint32_t>& order);
  void emit();
  void sum_up();

  const Scene& scene_;
  Options options_;
  Light light_;
  LightSpace space_;
  LightTables tables_;
  std::vector<Turned> turned_;        // by facet
  std::vector<Facing> facing_;        // by facet
  std::vector<std::uint8_t> enters_;  // by facet
  std::unique_ptr<Prefix> prefix_;
  std::vector<CellTree> cells_;
  std::vector<Location> locations_;  // by facet: the head of its location list (CS95, section 3)
  Shadows shadows_;
};

// Whether any point of the facet is within the light's range and cone.
bool within_reach(const Scene& scene, const Facet& facet, const Light& light);

// Whether a point lies inside the solid that the object's faces bound, or on its surface. In doubt it says yes: then far-side faces cast
// too, which is never wrong, only work.
bool in_or_on_solid(const Scene& scene, const Object& object, const Vec3& point);

}  // namespace shadowcut
