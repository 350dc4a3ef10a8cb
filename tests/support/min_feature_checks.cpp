// See min_feature_checks.hpp.
#include "min_feature_checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include "check.hpp"
#include "text.hpp"

namespace shadowcut::testing {
namespace {

std::string name_of(const FragmentId& id) {
  return text("fragment (", id.cell, ", ", id.piece, ", ", id.place, ")");
}

// As the light sees a polygon. Triangles by Van Oosterom & Strackee 1983, with differences of
// corners, so that needles have digits too.
double solid_angle(std::span<const Vec3> corners, const Light& light) {
  const Vec3 a = corners[0] - light.position;
  double sum = 0;
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const Vec3 b = corners[i - 1] - light.position, c = corners[i] - light.position,
               across = (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]);
    const double x = a.norm(), y = b.norm(), z = c.norm();
    sum += 2 * std::atan2(a.dot(across), x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y);
  }
  return std::abs(sum);
}

// Solid angles may be computed in another way than here: next to the size asked for, either answer
// is right.
enum class Size { below, close, enough };
Size size_of(const Fragment& f, std::span<const Vec3> corners, const Light& light,
             const MinFeature& least) {
  if (f.area < least.area) return Size::below;
  if (least.solid_angle == 0) return Size::enough;
  const double angle = solid_angle(corners, light), slack = 1e-6 * least.solid_angle + 1e-14;
  return angle < least.solid_angle - slack   ? Size::below
         : angle < least.solid_angle + slack ? Size::close
                                             : Size::enough;
}

// Whether a fragment's corners are its facet's, from any of them on.
bool is_whole_facet(const Scene& scene, const Fragment& f, std::span<const Vec3> corners) {
  const auto loop = scene.corners_of(scene.facets()[f.facet]);
  if (loop.size() != corners.size()) return false;
  return std::all_of(loop.begin(), loop.end(), [&](const Corner& c) {
    return std::find(corners.begin(), corners.end(), scene.vertices()[c.vertex]) != corners.end();
  });
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same_bits(const Vec3& a, const Vec3& b) {
  return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0;
}
bool same_bits(const LightLine& a, const LightLine& b) {
  return a.crossing == b.crossing &&
         std::equal(a.v.begin(), a.v.end(), b.v.begin(),
                    [](const Vec3& p, const Vec3& q) { return same_bits(p, q); });
}
bool same_bits(const Construction& a, const Construction& b) {
  return a.vertex == b.vertex &&
         (a.vertex != invalid_index || (same_bits(a.in, b.in) && same_bits(a.out, b.out)));
}

bool same_names(const Fragment& f, const Fragment& g) {
  return f.face == g.face && f.facet == g.facet && f.caster == g.caster && f.lit == g.lit;
}

bool same_fragment(const Block& x, const Fragment& f, const Block& y, const Fragment& g) {
  const auto own = x.corners_of(f), other = y.corners_of(g);
  if (!same_names(f, g) || !same_bits(f.area, g.area) || own.size() != other.size() ||
      x.constructions.empty() != y.constructions.empty())
    return false;
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (!same_bits(own[i], other[i])) return false;
    if (!x.constructions.empty() &&
        !same_bits(x.constructions[f.first_corner + i], y.constructions[g.first_corner + i]))
      return false;
  }
  return true;
}

// What is said of the tree, and of all that was done to it.
std::string check_same_tree(const Stats& a, const Stats& b) {
  const auto counts = [](const Stats& s) {
    return std::array{s.faces,  s.facing_faces,   s.facets,       s.cells,
                      s.nodes,  s.sp_nodes,       s.pp_nodes,     s.pieces,
                      s.depth,  s.crossing_lines, s.marked_nodes, s.longest_location_list,
                      s.joined, s.deferred,       s.cells_rebuilt};
  };
  if (counts(a) != counts(b)) return text("nodes ", a.nodes, ", should be ", b.nodes, "\n");
  return same_bits(a.facing_area, b.facing_area) ? "" : "another facing area\n";
}

// Every face by itself: what is left out of it is what `dropped` says. left_out, of each face: the
// areas of lit and shadowed fragments that are missing.
std::string check_dropped(const Scene& scene, const Shadows& full, const Shadows& kept,
                          const std::vector<std::array<double, 2>>& left_out) {
  double sum = 0;
  for (std::uint32_t i = 0; i < scene.faces().size(); ++i) {
    const FaceArea &x = full.areas[i], &y = kept.areas[i];
    const std::string who = text("face ", i, ": lit ", y.lit, ", shadowed ", y.shadowed,
                                 ", dropped ", y.dropped, " of ", y.area, ": ");
    if (x.facing != y.facing || !same_bits(x.area, y.area)) return who + "another face\n";
    if (x.dropped != 0) return who + "dropped without a size\n";
    const bool has_fragments = y.facing != Facing::refused && y.facing != Facing::ignored;
    if (!has_fragments && (y.dropped != 0 || y.lit != 0 || y.shadowed != 0))
      return who + "should have nothing\n";
    const auto [dark, light] = left_out[i];
    if (dark == 0 && light == 0 && !(same_bits(x.lit, y.lit) && same_bits(x.shadowed, y.shadowed)))
      return who + text("should be lit ", x.lit, ", shadowed ", x.shadowed, "\n");
    const double slack = kAreaTolerance * y.area;
    if (std::abs(y.lit + light - x.lit) > slack || std::abs(y.shadowed + dark - x.shadowed) > slack)
      return who + text("should be lit ", x.lit - light, ", shadowed ", x.shadowed - dark, "\n");
    const double lacking = has_fragments ? std::max(0.0, y.area - y.lit - y.shadowed) : 0;
    if (!(std::abs(y.dropped - lacking) <= 1e-14 * y.area))
      return who + text("should be ", lacking, " dropped\n");
    if (y.facing == Facing::toward) sum += y.dropped;
  }
  if (!(std::abs(kept.stats.dropped_area - sum) <= 1e-12 * kept.stats.facing_area))
    return text("stats: dropped_area ", kept.stats.dropped_area, ", should be ", sum, "\n");
  return {};
}

std::string check_counts(const Shadows& shadows) {
  std::uint64_t lit = 0, shadowed = 0;
  for (const Block& block : shadows.blocks) {
    for (const Fragment& f : block.fragments) {
      if (shadows.areas[f.face].facing == Facing::toward) ++(f.lit ? lit : shadowed);
    }
  }
  return lit == shadows.stats.lit_fragments && shadowed == shadows.stats.shadowed_fragments
             ? ""
             : "stats: another number of fragments\n";
}

}  // namespace

std::string check_filter(const Scene& scene, const Light& light, const Shadows& full,
                         const Shadows& kept, const MinFeature& least,
                         std::vector<FragmentId>* gone) {
  if (std::string what = check_same_tree(kept.stats, full.stats); !what.empty()) return what;
  if (full.blocks.size() != kept.blocks.size() || full.areas.size() != kept.areas.size())
    return "another number of blocks or areas\n";
  std::vector<std::size_t> of_facet(scene.facets().size());
  for (const Block& block : full.blocks) {
    for (const Fragment& f : block.fragments) ++of_facet[f.facet];
  }
  std::vector<std::array<double, 2>> left_out(scene.faces().size());
  for (std::size_t k = 0; k < full.blocks.size(); ++k) {
    const Block &before = full.blocks[k], &now = kept.blocks[k];
    if (!now.constructions.empty() && now.constructions.size() != now.corners.size())
      return text("block ", k, ": another number of constructions\n");
    std::map<FragmentId, const Fragment*> there;
    for (const Fragment& g : now.fragments) {
      if (!there.emplace(g.id, &g).second) return name_of(g.id) + " is there twice\n";
    }
    for (const Fragment& f : before.fragments) {
      const auto corners = before.corners_of(f);
      const auto it = there.find(f.id);
      const bool is_there = it != there.end();
      if (is_there && !same_fragment(before, f, now, *it->second))
        return name_of(f.id) + " is not as without a smallest feature\n";
      if (is_there) there.erase(it);
      const bool may_be_whole = of_facet[f.facet] == 1,
                 whole = may_be_whole && is_whole_facet(scene, f, corners);
      const Size size = size_of(f, corners, light, least);
      if (!is_there && (whole || size == Size::enough))
        return name_of(f.id) + text(" of facet ", f.facet, " is missing: area ", f.area,
                                    whole ? ", a whole facet\n" : "\n");
      if (is_there && !may_be_whole && size == Size::below)
        return name_of(f.id) +
               text(" of facet ", f.facet, " should be left out: area ", f.area, "\n");
      if (is_there) continue;
      left_out[f.face][f.lit] += f.area;
      if (gone) gone->push_back(f.id);
    }
    if (!there.empty())
      return name_of(there.begin()->first) + " is not there without a smallest feature\n";
  }
  std::string what = check_dropped(scene, full, kept, left_out);
  return what.empty() ? check_counts(kept) : what;
}

std::string check_conforming_filter(const Scene& scene, const Shadows& full, const Shadows& kept,
                                    const Shadows& merged) {
  if (std::string what = check_same_tree(kept.stats, full.stats); !what.empty()) return what;
  if (full.blocks.size() != kept.blocks.size()) return "another number of blocks\n";
  std::vector<double> of_fragments(scene.faces().size());
  for (std::size_t k = 0; k < full.blocks.size(); ++k) {
    std::map<FragmentId, const Fragment*> there;
    for (const Fragment& f : full.blocks[k].fragments) there.emplace(f.id, &f);
    for (const Fragment& g : kept.blocks[k].fragments) {
      const auto it = there.find(g.id);
      if (it == there.end() || !same_names(*it->second, g))
        return name_of(g.id) + " is not there without a smallest feature\n";
      if (std::abs(g.area - it->second->area) > kAreaTolerance * scene.faces()[g.face].area)
        return name_of(g.id) + text(" has area ", g.area, ", should be ", it->second->area, "\n");
      of_fragments[g.face] += g.area;
      there.erase(it);
    }
  }
  for (std::uint32_t i = 0; i < scene.faces().size(); ++i) {
    const FaceArea &x = full.areas[i], &y = kept.areas[i], &z = merged.areas[i];
    const double slack = kAreaTolerance * y.area;
    const std::string who = text("face ", i, ": lit ", y.lit, ", shadowed ", y.shadowed,
                                 ", dropped ", y.dropped, " of ", y.area, ": ");
    if (x.facing != y.facing || !same_bits(x.area, y.area)) return who + "another face\n";
    if (y.lit > x.lit + slack || y.shadowed > x.shadowed + slack) return who + "more than all\n";
    if (!(y.dropped >= 0) || y.dropped > z.dropped + slack)
      return who + text("no more than ", z.dropped, " should be dropped\n");
    if (y.facing == Facing::refused || y.facing == Facing::ignored) continue;
    if (std::abs(of_fragments[i] - y.lit - y.shadowed) > slack)
      return who + text("fragments add up to ", of_fragments[i], "\n");
    // What all fragments lack, they lack of rounding.
    if (std::abs(y.lit + y.shadowed + y.dropped - y.area) >
        slack + std::abs(x.lit + x.shadowed - x.area))
      return who + "do not add up\n";
  }
  return check_counts(kept);
}

double mean_area(const Scene& scene) {
  double sum = 0;
  std::size_t n = 0;
  for (const Face& f : scene.faces()) sum += f.area, n += f.area > 0;
  return sum / static_cast<double>(std::max<std::size_t>(n, 1));
}

}  // namespace shadowcut::testing
