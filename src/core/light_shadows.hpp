// What the engine holds for one light, whatever its tree's numbers are (tree_numbers.hpp).
#pragma once

#include <chrono>
#include <memory>
#include <shadowcut/shadows.hpp>
#include <span>
#include <string>
#include <vector>

namespace shadowcut {

using Clock = std::chrono::steady_clock;

inline double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

class LightShadows {
 public:
  virtual ~LightShadows() = default;

  virtual const Shadows& shadows() const = 0;
  virtual Shadows take_shadows() = 0;
  virtual const Fragment* find(FragmentId id) const = 0;
  // of every face, how much could be in another state; see Engine::undecided
  virtual std::vector<double> undecided() const = 0;
  virtual std::string validate() const = 0;

  // An update is one call of begin_update, any number of edits, and finish_update, which says what
  // has changed.
  //   rebuild        everything anew, for a light that may be another one; uses its memory again
  //   remove_objects takes objects out, while the scene still holds them as they were inserted
  //   insert_objects puts them, or what the scene now holds in their place, in again. The same
  //     objects must have been removed.
  virtual void begin_update() = 0;
  virtual void rebuild(const Light& light) = 0;
  virtual void remove_objects(std::span<const std::uint32_t> objects) = 0;
  virtual void insert_objects(std::span<const std::uint32_t> objects) = 0;
  virtual void finish_update(LightChanges& changes) = 0;
  // instead of all that: the light is gone
  virtual void rebuild_to_nothing(LightChanges& changes) = 0;
};

// The scene must outlive what is made. combine() cuts the first light's fragments by the second
// light's tree, and so on (CS95, section 4); a null stands for a light that there is not, the
// others must have been made in the same namespace. `faces`, where it is given, chooses whose
// fragments.
namespace double_numbers {
std::unique_ptr<LightShadows> make_light_shadows(const Scene& scene, const Light& light,
                                                 const Options& options);
LightSets combine(const std::vector<const LightShadows*>& lights, const std::vector<bool>* faces);
}  // namespace double_numbers
namespace single_numbers {
std::unique_ptr<LightShadows> make_light_shadows(const Scene& scene, const Light& light,
                                                 const Options& options);
LightSets combine(const std::vector<const LightShadows*>& lights, const std::vector<bool>* faces);
}  // namespace single_numbers

}  // namespace shadowcut
