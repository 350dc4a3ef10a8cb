// The fragments of an engine in the one shape all writers take: of one light or of several, sorted
// by object, each with its light set.
#pragma once

#include <tsl/robin_map.h>

#include <cstdint>
#include <shadowcut/shadows.hpp>
#include <span>
#include <string>
#include <vector>

namespace shadowcut::io {

struct LightSet {
  std::vector<std::uint32_t> lights;  // that reach the piece, ascending; indices of the engine's
  std::string name;                   // "lit", "shadowed"; with several lights "lit by 0+2"
};

struct Piece {
  std::uint32_t face, facet;
  std::uint32_t set;  // into Pieces::sets
  std::uint32_t corner_count;
  std::size_t first_corner;
};

struct Pieces {
  std::vector<Piece> pieces;  // by object, then by set; otherwise in the engine's order
  std::vector<Vec3> corners;
  std::vector<LightSet> sets;
  std::size_t light_count = 0;  // without those that have been removed

  std::span<const Vec3> corners_of(const Piece& p) const {
    return std::span(corners).subspan(p.first_corner, p.corner_count);
  }
  // The share of the lights that reach the piece, 0 to 1.
  double brightness(const LightSet& set) const {
    return static_cast<double>(set.lights.size()) / static_cast<double>(light_count);
  }
};

// The engine's lights that have not been removed, ascending.
std::vector<std::uint32_t> lights_of(const Engine& engine);

Pieces pieces_of(const Scene& scene, const Engine& engine);

// Distinct positions, numbered from 0 in the order of their first appearance.
class VertexPool {
 public:
  std::uint32_t add(const Vec3& position);
  void clear();
  const std::vector<Vec3>& positions() const { return positions_; }

 private:
  struct Hash {
    std::size_t operator()(const Vec3& position) const;
  };
  struct SameBits {
    bool operator()(const Vec3& a, const Vec3& b) const;
  };
  std::vector<Vec3> positions_;
  tsl::robin_map<Vec3, std::uint32_t, Hash, SameBits> numbers_;
};

}  // namespace shadowcut::io
