// What tests are asked for by the environment, and with which options they run.
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <shadowcut/shadows.hpp>
#include <string>

#include "text.hpp"

namespace shadowcut::testing {

inline std::optional<std::uint64_t> environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? std::optional(std::strtoull(value, nullptr, 10)) : std::nullopt;
}

inline std::string describe(const Options& o) {
  constexpr std::array forms{"pieces", "merged", "conforming"};
  constexpr std::array orders{"solid_angle", "as_given", "random"};
  return text("form ", forms[static_cast<std::size_t>(o.form)], ", order ",
              orders[static_cast<std::size_t>(o.tuning.order)], ", seed ", o.tuning.seed,
              ", facets_per_cell ", o.tuning.facets_per_cell, ", join_threshold ",
              o.tuning.join_threshold, ", threads ", o.threads,
              o.tuning.incremental ? "" : ", no edits");
}

}  // namespace shadowcut::testing
