// An engine beside the scene that it follows: what every test of edits asks after an update.
#pragma once

#include <cstdint>
#include <shadowcut/scene.hpp>
#include <shadowcut/shadows.hpp>
#include <string>

#include "edit_checks.hpp"
#include "edit_scripts.hpp"

namespace shadowcut::testing {

// From SHADOWCUT_SEED.
std::uint64_t first_seed();

// Options of every kind.
Options some_options(std::uint64_t seed);

// The partition by all lights has each light's own areas.
std::string check_overlay(const Engine& engine);

// Every light of the engine against new shadows of engine.scene(), and everything that needs no
// other engine. solids: closed objects are.
std::string check_lights(const Engine& engine, std::uint64_t step, bool solids,
                         Form form = Form::merged);

// Trees must not rot: nodes stay within this many times those of a new tree.
inline constexpr double kRot = 1.5;
std::uint64_t nodes_of_new(const Scene& scene, const Options& options);

// An engine that follows a script's scene, and a mirror that follows the engine.
class Follower {
 public:
  Follower(const Setting& setting, std::uint64_t seed, const Options& options);

  // Applies the last edits and checks everything there is to check.
  std::string update(const std::string& edits = "the first update");
  std::string compact();
  std::string check(const Changes& changes);
  std::string check_conforming_lights() const;
  std::string where() const { return where_ + ", step " + std::to_string(step_) + ": " + edits_; }

 private:
  std::string where_, edits_;
  Options options_;
  std::uint64_t step_ = 0;

 public:
  EditScript script;
  Engine engine;
  Mirror mirror;
};

// One random history from a fresh scene; false when something is wrong.
bool run_history(const Setting& setting, std::uint64_t seed, std::uint64_t updates);

}  // namespace shadowcut::testing
