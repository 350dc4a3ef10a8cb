// Shadows put together from the GMP oracle's parts.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "gmp_oracle.hpp"

namespace shadowcut::testing {

// With constructions.
class Partition {
 public:
  explicit Partition(const GmpOracle& oracle) : oracle_(oracle), scene_(oracle.scene()) {
    name_lines();
    out_.blocks.resize(1);
    for (std::uint32_t f = 0; f < scene_.facets().size(); ++f) {
      if (oracle.role(f) != GmpOracle::Role::takes_part || !object(f).receives_shadows) continue;
      std::vector<Part> dark = oracle.parts(f);
      for (const Part& part : oracle.lit_parts(f)) {
        add(f, part, true);
        dark = without(dark, part);
      }
      for (const Part& part : dark) add(f, part, false);
    }
    for (std::uint32_t i = 0; i < scene_.faces().size(); ++i)
      out_.areas.push_back({facing(i), 0, 0, 0});
  }
  Shadows take() { return std::move(out_); }

 private:
  const Object& object(std::uint32_t facet) const {
    return scene_.objects()[scene_.faces()[scene_.facets()[facet].face].object];
  }

  Facing facing(std::uint32_t i) const {
    const Face& face = scene_.faces()[i];
    if (face.facet_count == 0) return Facing::refused;
    if (!scene_.objects()[face.object].receives_shadows) return Facing::ignored;
    for (std::uint32_t f = face.first_facet; f < face.first_facet + face.facet_count; ++f) {
      if (oracle_.role(f) == GmpOracle::Role::takes_part) return Facing::toward;
    }
    return Facing::away;
  }

  void name_lines() {
    const auto put = [&](const LightLine& line) { lines_.emplace(oracle_.line(line), line); };
    for (const Facet& f : scene_.facets()) {
      const auto corners = scene_.corners_of(f);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j)
          put({false,
               {scene_.vertices()[corners[i].vertex], scene_.vertices()[corners[j].vertex],
                Vec3::Zero(), Vec3::Zero()}});
      }
    }
    for (const Facet& f : scene_.facets()) {
      for (const Facet& g : scene_.facets()) {
        if (f.corner_count == 0 || g.corner_count == 0) continue;
        const Plane &p = scene_.planes()[f.plane], &q = scene_.planes()[g.plane];
        put({true, {p.exact_normal, p.point, q.exact_normal, q.point}});
      }
    }
  }

  void add(std::uint32_t facet, const Part& part, bool lit) {
    Block& block = out_.blocks[0];
    const auto first = static_cast<std::uint32_t>(block.corners.size()),
               size = static_cast<std::uint32_t>(part.corners.size());
    for (std::size_t i = 0; i < size; ++i) add_corner(facet, part, i);
    const std::vector<std::uint32_t> by = lit ? std::vector<std::uint32_t>{} : casters(facet, part);
    const std::uint32_t caster =
        lit ? invalid_index : scene_.facets()[by.empty() ? facet : by[0]].face;
    block.fragments.push_back({{0, static_cast<std::uint32_t>(block.fragments.size()), 0},
                               scene_.facets()[facet].face,
                               facet,
                               caster,
                               first,
                               size,
                               lit,
                               0});
  }

  // In the middle of a part; elsewhere in it where that is on the boundary of a shadow.
  std::vector<std::uint32_t> casters(std::uint32_t facet, const Part& part) const {
    std::vector<std::uint32_t> by;
    for (unsigned attempt = 0; attempt < 3 && by.empty(); ++attempt)
      oracle_.state_at(facet, oracle_.place(facet, middle_of(part.corners, attempt)), &by);
    return by;
  }

  void add_corner(std::uint32_t facet, const Part& part, std::size_t i) {
    Block& block = out_.blocks[0];
    const Triple& ray = part.corners[i];
    for (const Corner& own : scene_.corners_of(scene_.facets()[facet])) {
      const Vec3& vertex = scene_.vertices()[own.vertex];
      if (oracle_.ray(vertex) != ray) continue;
      block.corners.push_back(vertex);
      block.constructions.push_back({{}, {}, own.vertex});
      return;
    }
    block.corners.push_back(oracle_.rounded(oracle_.place(facet, ray)));
    const std::size_t before = (i + part.lines.size() - 1) % part.lines.size();
    block.constructions.push_back(
        {lines_.at(as_line(part.lines[before])), lines_.at(as_line(part.lines[i])), invalid_index});
  }

  const GmpOracle& oracle_;
  const Scene& scene_;
  std::map<Triple, LightLine> lines_;
  Shadows out_;
};

}  // namespace shadowcut::testing
