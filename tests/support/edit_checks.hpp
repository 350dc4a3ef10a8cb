// What every test of edits asks of an engine after an update. Each check returns an empty string,
// or says what is wrong; none looks inside.
#pragma once

#include <cstdint>
#include <map>
#include <shadowcut/scene.hpp>
#include <shadowcut/shadows.hpp>
#include <string>
#include <vector>

namespace shadowcut::testing {

// Whether the object at an index is the same in two scenes, to the bit, and stands at the same
// place in every array (or is in neither).
bool same_object(const Scene& a, const Scene& b, std::size_t index);
bool same_light(const Scene& a, const Scene& b, std::size_t index);

// Two scenes are equal: objects, lights, issues, arrays; and what is no object's is marked so in
// both.
std::string check_same_scene(const Scene& a, const Scene& b);

// What scene.hpp promises of the arrays: every index leads to something of the same object, and
// rooms do not overlap.
std::string check_arrays(const Scene& scene);

// Equal to the bit, in order.
std::string check_identical(const Changes& a, const Changes& b);

// The fragments and areas of every light, known from nothing but changes.
class Mirror {
 public:
  // Applies what the engine's last call returned, gone first; then everything must be as the engine
  // lists it.
  std::string apply(const Changes& changes, const Engine& engine);

  // Engine::find for every `stride`-th fragment, for those gone lately, and for ids that never
  // were.
  std::string check_find(const Engine& engine, std::size_t stride = 1) const;

 private:
  struct Copy {
    std::uint32_t face, facet, caster;
    bool lit;
    double area;
    std::vector<Vec3> corners;
  };
  struct OfLight {
    std::map<FragmentId, Copy> fragments;
    std::vector<FaceArea> areas;
    std::vector<FragmentId> gone_lately;
  };
  static bool same(const Copy& copy, const Fragment& f, std::span<const Vec3> corners);
  static Copy copied(const Block& block, const Fragment& f);
  std::string apply(const LightChanges& changes, const Engine& engine);
  std::string compare(std::uint32_t light, const Shadows& shadows) const;

  std::map<std::uint32_t, OfLight> lights_;
};

}  // namespace shadowcut::testing
