// See check.hpp.
#include "check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

#include "scenes.hpp"

namespace shadowcut::testing {
namespace {

// Collects the first few complaints.
class Report {
 public:
  template <class... Parts>
  void add(const Parts&... parts) {
    if (++count_ > 5) return;
    text_.precision(17);
    (text_ << ... << parts) << "\n";
  }
  std::string str() const {
    if (count_ == 0) return {};
    return text_.str() + (count_ > 5 ? std::to_string(count_ - 5) + " more\n" : "");
  }

 private:
  std::ostringstream text_;
  int count_ = 0;
};

std::string name_of(const Scene& scene, std::uint32_t face) {
  if (face >= scene.faces().size() || scene.faces()[face].object == invalid_index)
    return "face " + std::to_string(face) + ", which is no object's,";
  const Face& f = scene.faces()[face];
  return "face " + std::to_string(face) + " (" + scene.objects()[f.object].name + " #" +
         std::to_string(f.number) + ")";
}

const char* name_of(Facing facing) {
  constexpr std::array<const char*, 5> names{"refused", "away", "out_of_reach", "ignored",
                                             "toward"};
  return names[static_cast<std::size_t>(facing)];
}

// False for a face that is no object's.
bool receives(const Scene& scene, std::uint32_t face) {
  const std::uint32_t object = scene.faces()[face].object;
  return object != invalid_index && scene.objects()[object].receives_shadows;
}

Vec3 area_vector(std::span<const Vec3> corners) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 2; i < corners.size(); ++i)
    sum += (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]);
  return 0.5 * sum;
}

double extent(const Scene& scene, const Facet& facet) {
  double most = 0;
  for (const Corner& c : scene.corners_of(facet))
    most = std::max(most, scene.vertices()[c.vertex].cwiseAbs().maxCoeff());
  return most;
}

double diameter(std::span<const Vec3> corners) {
  double most = 0;
  for (const Vec3& a : corners)
    for (const Vec3& b : corners) most = std::max(most, (a - b).norm());
  return most;
}

double diameter(const Scene& scene, const Facet& facet) {
  std::vector<Vec3> corners;
  for (const Corner& c : scene.corners_of(facet)) corners.push_back(scene.vertices()[c.vertex]);
  return diameter(corners);
}

// How far the sum of a face's fragments may be from its area. The corners of a face are the scene's
// vertices to the bit, while its area is meant in its plane: where a corner lies off the plane by
// `flatness`, or by the rounding of its coordinates, the two differ by that, prolonged along the
// light. Of no weight but for thin faces seen at a grazing angle.
double fragment_tolerance(const Scene& scene, const Light& light, std::uint32_t face,
                          double share) {
  const Face& f = scene.faces()[face];
  double slack = 0;
  for (std::uint32_t k = 0; k < f.facet_count; ++k) {
    const Facet& facet = scene.facets()[f.first_facet + k];
    const Plane& plane = scene.planes()[facet.plane];
    double least = 1;
    for (const Corner& c : scene.corners_of(facet)) {
      const Vec3 ray = light.kind == Light::Kind::point
                           ? Vec3(scene.vertices()[c.vertex] - light.position)
                           : light.direction;
      least = std::min(least, std::abs(plane.normal.dot(ray)) / ray.norm());
    }
    const double off = 8 * plane.flatness +
                       0x1p-48 * (extent(scene, facet) +
                                  (light.kind == Light::Kind::point ? light.position.norm() : 0));
    slack += off * diameter(scene, facet) / least;
  }
  return share * f.area + slack;
}

using Bits = std::array<std::uint64_t, 3>;
Bits bits(const Vec3& v) {
  Bits b;
  for (int k = 0; k < 3; ++k) {
    const double x = v[k] == 0 ? 0.0 : v[k];  // -0 is 0
    std::memcpy(&b[static_cast<std::size_t>(k)], &x, sizeof x);
  }
  return b;
}

using Flat = std::vector<Eigen::Vector2d>;  // convex, counter-clockwise
struct FlatPart {
  Flat corners;
  Eigen::AlignedBox2d box;
};

double area_of(const Flat& polygon) {
  double twice = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const Eigen::Vector2d a = polygon[i - 1] - polygon[0], b = polygon[i] - polygon[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

// The area that two convex polygons have in common (Sutherland & Hodgman 1974).
double common_area(const Flat& a, const Flat& b) {
  Flat part = a, next;
  for (std::size_t i = 0; i < b.size() && part.size() > 2; ++i) {
    const Eigen::Vector2d from = b[i], along = b[(i + 1) % b.size()] - from;
    const auto side = [&](const Eigen::Vector2d& x) {
      return along.x() * (x.y() - from.y()) - along.y() * (x.x() - from.x());
    };
    next.clear();
    for (std::size_t k = 0; k < part.size(); ++k) {
      const Eigen::Vector2d &x = part[k], &y = part[(k + 1) % part.size()];
      const double at_x = side(x), at_y = side(y);
      if (at_x >= 0) next.push_back(x);
      if ((at_x > 0 && at_y < 0) || (at_x < 0 && at_y > 0))
        next.push_back(x + (y - x) * (at_x / (at_x - at_y)));
    }
    part.swap(next);
  }
  return part.size() < 3 ? 0 : std::abs(area_of(part));
}

double common_area(const std::vector<FlatPart>& some, const std::vector<FlatPart>& others) {
  double sum = 0;
  for (const FlatPart& a : some) {
    for (const FlatPart& b : others) {
      if (a.box.intersects(b.box)) sum += common_area(a.corners, b.corners);
    }
  }
  return sum;
}

// The fragments of one facet, lit ones and shadowed ones, seen along the axis nearest to the
// normal.
struct FlatFacet {
  std::vector<FlatPart> lit, shadowed;
};

std::vector<FlatFacet> by_facet(const Scene& scene, const Shadows& shadows) {
  std::vector<FlatFacet> out(scene.facets().size());
  for (const Block& block : shadows.blocks) {
    for (const Fragment& f : block.fragments) {
      if (f.facet >= out.size()) continue;  // check_fragments says so
      int axis = 0;
      scene.planes()[scene.facets()[f.facet].plane].normal.cwiseAbs().maxCoeff(&axis);
      FlatPart part;
      for (const Vec3& c : block.corners_of(f))
        part.corners.emplace_back(c[(axis + 1) % 3], c[(axis + 2) % 3]);
      for (const Eigen::Vector2d& c : part.corners) part.box.extend(c);
      if (area_of(part.corners) < 0) std::reverse(part.corners.begin(), part.corners.end());
      (f.lit ? out[f.facet].lit : out[f.facet].shadowed).push_back(std::move(part));
    }
  }
  return out;
}

// A random point of a convex polygon, or none when it comes too near to an edge to be beyond doubt.
std::optional<Vec3> inner_point(std::span<const Vec3> corners, double scale,
                                scenes::Random& random) {
  Vec3 x = Vec3::Zero();
  double sum = 0;
  for (const Vec3& c : corners) {
    const double w = random.unit() + 1e-3;
    x += w * c;
    sum += w;
  }
  x /= sum;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 &a = corners[i], edge = corners[(i + 1) % corners.size()] - a;
    if (edge.norm() < 1e-13 * scale) continue;
    if (edge.cross(x - a).norm() / edge.norm() < 1e-7 * scale) return std::nullopt;
  }
  return x;
}

// All corners of a face with their fragments, for checks within a face.
struct FaceCorners {
  std::vector<std::vector<Vec3>> fragments;
};

std::map<std::uint32_t, FaceCorners> by_face(const Shadows& shadows) {
  std::map<std::uint32_t, FaceCorners> out;
  for (const Block& block : shadows.blocks)
    for (const Fragment& f : block.fragments) {
      const auto corners = block.corners_of(f);
      out[f.face].fragments.emplace_back(corners.begin(), corners.end());
    }
  return out;
}

void check_fragment(const Scene& scene, const Light& light, const Shadows& shadows,
                    const Fragment& f, std::span<const Vec3> corners, Report& report) {
  if (f.face >= scene.faces().size() || f.facet >= scene.facets().size() ||
      scene.facets()[f.facet].face != f.face || scene.faces()[f.face].object == invalid_index)
    return report.add("a fragment of face ", f.face, ", facet ", f.facet,
                      ": no such face or facet");
  const Facet& facet = scene.facets()[f.facet];
  const Plane& plane = scene.planes()[facet.plane];
  const std::string name = name_of(scene, f.face);
  if (corners.size() < 3) return report.add(name, ": a fragment of ", corners.size(), " corners");
  if (!receives(scene, f.face)) report.add(name, ": does not receive, but has a fragment");
  const bool toward = shadows.areas[f.face].facing == Facing::toward;
  if (f.lit && f.caster != invalid_index) report.add(name, ": a lit fragment with a caster");
  if (f.lit && !toward)
    report.add(name, ": a lit fragment of a face that is ", name_of(shadows.areas[f.face].facing));
  if (!f.lit && f.caster != invalid_index) {
    if (f.caster >= scene.faces().size() || scene.faces()[f.caster].object == invalid_index)
      return report.add(name, ": its caster, face ", f.caster, ", does not exist");
    if (!scene.objects()[scene.faces()[f.caster].object].casts_shadows)
      report.add(name, ": caster ", name_of(scene, f.caster), " does not cast");
    if (f.caster == f.face && scene.faces()[f.face].facet_count == 1)
      report.add(name, ": is its own caster");
  }
  const Vec3 vector = area_vector(corners);
  const double scale = extent(scene, facet), size = diameter(scene, facet);
  const Vec3 to_light = light.kind == Light::Kind::point ? Vec3(light.position - plane.point)
                                                         : Vec3(-light.direction);
  bool back = toward && plane.normal.dot(to_light) < 0 &&
              scene.objects()[scene.faces()[f.face].object].sides == Sides::open;
  // Of a face in several facets one may be seen edge-on while another is toward the light; rounding
  // must not say from where.
  if (std::abs(plane.normal.dot(to_light)) < 1e-13 * (scale + to_light.norm()))
    back = vector.dot(plane.normal) < 0;
  if (vector.dot(back ? Vec3(-plane.normal) : plane.normal) < -1e-11 * size * (size + scale))
    report.add(name, ": a fragment runs clockwise");
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 &a = corners[i], &b = corners[(i + 1) % corners.size()],
               &c = corners[(i + 2) % corners.size()];
    if (!a.allFinite()) return report.add(name, ": a corner is not finite");
    const double off = std::abs(plane.normal.dot(a - plane.point));
    if (off > 2 * plane.flatness + 1e-10 * scale)
      report.add(name, ": a corner lies ", off, " off the plane");
    const double turn = (b - a).cross(c - b).dot(back ? Vec3(-plane.normal) : plane.normal);
    if (turn < -1e-10 * size * (size + scale))
      report.add(name, ": a fragment is not convex, turn ", turn);
  }
}

template <class Fragments, class Corners, class State>
std::string check_points_of(const Scene& scene, const Fragments& fragments,
                            const Corners& corners_of, const State& lit, const CgalOracle& oracle,
                            std::uint64_t seed, int count, bool contact_may_cast = false) {
  Report report;
  if (fragments.empty()) return {};
  scenes::Random random(seed);
  for (int i = 0; i < count; ++i) {
    const std::size_t k = random.below(fragments.size());
    const auto corners = corners_of(k);
    const auto x = inner_point(
        corners,
        std::max(diameter(corners), 1e-3 * extent(scene, scene.facets()[fragments[k].facet])),
        random);
    if (!x || oracle.unsure(fragments[k].facet) || oracle.lit(fragments[k].facet, *x) == lit(k))
      continue;
    if (contact_may_cast && !lit(k) && oracle.in_contact(fragments[k].facet, *x)) continue;
    report.add(name_of(scene, fragments[k].face), ": point (", x->transpose(), ") lies in a ",
               lit(k) ? "lit" : "shadowed", " fragment, the ray says otherwise");
  }
  return report.str();
}

}  // namespace

Alone cast_alone(const Scene& scene, const Light& light, const Options& options) {
  Scene lone = scene;
  lone.replace_lights({&light, 1});
  Engine engine(lone, options);
  engine.update();
  return {engine.shadows(0), engine.uncertain_area(0)};
}

double polygon_area(std::span<const Vec3> corners) { return area_vector(corners).norm(); }

std::string check_areas(const Scene& scene, const Shadows& shadows, const CgalOracle& oracle,
                        const UncertainArea* uncertain) {
  return check_areas(scene, shadows, oracle.areas(), uncertain);
}

std::string check_areas(const Scene& scene, const Shadows& shadows,
                        const std::vector<CgalOracle::Area>& wanted,
                        const UncertainArea* uncertain) {
  Report report;
  if (shadows.areas.size() != scene.faces().size()) return "areas are not one for each face\n";
  for (std::uint32_t i = 0; i < scene.faces().size(); ++i) {
    if (!receives(scene, i)) continue;
    const FaceArea& got = shadows.areas[i];
    const CgalOracle::Area& want = wanted[i];
    if (got.facing != want.facing) {
      if (!want.unsure)
        report.add(name_of(scene, i), ": is ", name_of(got.facing), ", should be ",
                   name_of(want.facing));
      continue;
    }
    const double tolerance = kAreaTolerance * want.area;
    if (std::abs(got.area - want.area) > tolerance)
      report.add(name_of(scene, i), ": area ", got.area, ", should be ", want.area);
    const double slack = tolerance + (uncertain ? (*uncertain)[i] : 0),
                 least = uncertain ? want.least_lit : want.lit;
    if (got.lit > want.lit + slack || got.lit < least - slack)
      report.add(name_of(scene, i), ": lit area ", got.lit, ", should be ", want.lit, " of ",
                 want.area, ", uncertain ", slack - tolerance);
    if (std::abs(got.lit + got.shadowed - got.area) > tolerance)
      report.add(name_of(scene, i), ": lit ", got.lit, " and shadowed ", got.shadowed,
                 " do not make ", got.area);
  }
  return report.str();
}

std::string check_same_areas(const Scene& scene, const Shadows& a, const Shadows& b,
                             double tolerance, const UncertainArea* uncertain) {
  Report report;
  if (a.areas.size() != b.areas.size()) return "different numbers of faces\n";
  for (std::uint32_t i = 0; i < a.areas.size(); ++i) {
    const FaceArea &x = a.areas[i], &y = b.areas[i];
    if (x.facing != y.facing)
      report.add(name_of(scene, i), ": is ", name_of(x.facing), " and ", name_of(y.facing));
    const double slack = uncertain ? (*uncertain)[i] : 0;
    if (std::abs(x.lit - y.lit) > tolerance * x.area + slack)
      report.add(name_of(scene, i), ": lit areas ", x.lit, " and ", y.lit, " of ", x.area,
                 ", uncertain ", slack);
  }
  return report.str();
}

std::string check_same_regions(const Scene& scene, const Light& light, const Shadows& a,
                               const Shadows& b, const UncertainArea* uncertain) {
  Report report;
  const std::vector<FlatFacet> of_a = by_facet(scene, a), of_b = by_facet(scene, b);
  for (std::uint32_t i = 0; i < scene.faces().size(); ++i) {
    const Face& face = scene.faces()[i];
    double differs = 0;
    std::size_t fragments = 1;
    for (std::uint32_t f = face.first_facet; f < face.first_facet + face.facet_count; ++f) {
      const double stretch =
          1 / scene.planes()[scene.facets()[f].plane].normal.cwiseAbs().maxCoeff();
      differs += stretch * (common_area(of_a[f].lit, of_b[f].shadowed) +
                            common_area(of_a[f].shadowed, of_b[f].lit));
      fragments += of_a[f].lit.size() + of_a[f].shadowed.size();
    }
    if (differs == 0) continue;
    const double rounding = fragment_tolerance(scene, light, i, 0);
    const double slack = uncertain ? (*uncertain)[i] : 0;
    if (differs > kAreaTolerance * face.area + static_cast<double>(fragments) * rounding + slack)
      report.add(name_of(scene, i), ": lit in one and shadowed in the other on ", differs, " of ",
                 face.area, ", uncertain ", slack);
  }
  return report.str();
}

std::string check_fragments(const Scene& scene, const Light& light, const Shadows& shadows,
                            double share, Form form) {
  Report report;
  if (shadows.areas.size() != scene.faces().size()) return "areas are not one for each face\n";
  std::vector<double> lit(scene.faces().size()), shadowed(lit);
  const bool by_face = form == Form::conforming;
  std::vector<std::set<Bits>> corners_seen(by_face ? scene.faces().size() : scene.facets().size());
  std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> ids;
  Stats sums;
  for (const Block& block : shadows.blocks) {
    for (const Fragment& f : block.fragments) {
      if (std::size_t{f.first_corner} + f.corner_count > block.corners.size())
        return "a fragment's corners are out of range\n";
      const auto corners = block.corners_of(f);
      check_fragment(scene, light, shadows, f, corners, report);
      if (!report.str().empty()) continue;
      if (!ids.insert({f.id.cell, f.id.piece, f.id.place}).second)
        report.add(name_of(scene, f.face), ": a fragment id is not unique");
      (f.lit ? lit : shadowed)[f.face] += polygon_area(corners);
      for (const Vec3& c : corners) corners_seen[by_face ? f.face : f.facet].insert(bits(c));
      if (shadows.areas[f.face].facing == Facing::toward)
        ++(f.lit ? sums.lit_fragments : sums.shadowed_fragments);
    }
  }
  for (std::uint32_t i = 0; i < scene.faces().size(); ++i) {
    const FaceArea& area = shadows.areas[i];
    const bool refused = scene.faces()[i].facet_count == 0;
    if (refused != (area.facing == Facing::refused))
      report.add(name_of(scene, i), ": is ", name_of(area.facing));
    if (refused && (area.area != 0 || area.lit != 0 || area.shadowed != 0))
      report.add(name_of(scene, i), ": refused, but has areas");
    if (refused || area.facing == Facing::refused) continue;
    if (receives(scene, i) == (area.facing == Facing::ignored))
      report.add(name_of(scene, i), ": is ", name_of(area.facing), ", and its object does ",
                 receives(scene, i) ? "" : "not ", "receive");
    if (!receives(scene, i) && (area.lit != 0 || area.shadowed != 0))
      report.add(name_of(scene, i), ": does not receive, but has areas");
    if (!receives(scene, i)) continue;
    const double tolerance = fragment_tolerance(scene, light, i, share);
    if (std::abs(area.lit + area.shadowed - area.area) > tolerance)
      report.add(name_of(scene, i), ": lit ", area.lit, " and shadowed ", area.shadowed,
                 " do not make ", area.area);
    if (std::abs(lit[i] - area.lit) > tolerance)
      report.add(name_of(scene, i), ": lit fragments add up to ", lit[i], ", should be ", area.lit,
                 " of ", area.area);
    if (std::abs(shadowed[i] - area.shadowed) > tolerance)
      report.add(name_of(scene, i), ": shadowed fragments add up to ", shadowed[i], ", should be ",
                 area.shadowed, " of ", area.area);
    if (area.facing != Facing::toward && area.lit != 0)
      report.add(name_of(scene, i), ": turned away or out of reach, but lit");
    const Face& face = scene.faces()[i];
    // Conforming welds what is nearer than 1e-12 of the face: of one that is no wider there may be
    // any corner left.
    const double across = diameter(scene, scene.facets()[face.first_facet]);
    if (by_face &&
        face.area <= 2e-12 * across *
                         std::max(across, 1e-2 * extent(scene, scene.facets()[face.first_facet])))
      continue;
    for (std::uint32_t k = 0; k < face.facet_count; ++k) {
      const std::uint32_t facet = face.first_facet + k;
      for (const Corner& c : scene.corners_of(scene.facets()[facet]))
        if (!corners_seen[by_face ? i : facet].count(bits(scene.vertices()[c.vertex])))
          report.add(name_of(scene, i), ": vertex ", c.vertex, " is no corner of a fragment");
    }
  }
  double facing_area = 0, lit_area = 0;
  std::uint64_t facing = 0;
  for (std::uint32_t i = 0; i < scene.faces().size(); ++i) {
    const FaceArea& a = shadows.areas[i];
    if (a.facing != Facing::toward || !receives(scene, i)) continue;
    ++facing;
    facing_area += a.area;
    lit_area += a.lit;
  }
  const Stats& s = shadows.stats;
  const bool all_receive =
      std::all_of(scene.objects().begin(), scene.objects().end(),
                  [](const Object& o) { return o.receives_shadows || !o.alive; });
  if (all_receive) {
    if (s.facing_faces != facing)
      report.add("stats: facing_faces ", s.facing_faces, ", should be ", facing);
    if (std::abs(s.facing_area - facing_area) > 1e-9 * facing_area)
      report.add("stats: facing_area ", s.facing_area, ", should be ", facing_area);
    if (std::abs(s.lit_area - lit_area) > 1e-9 * facing_area)
      report.add("stats: lit_area ", s.lit_area, ", should be ", lit_area);
    if (s.lit_fragments != sums.lit_fragments)
      report.add("stats: lit_fragments ", s.lit_fragments, ", should be ", sums.lit_fragments);
    if (s.shadowed_fragments != sums.shadowed_fragments)
      report.add("stats: shadowed_fragments ", s.shadowed_fragments, ", should be ",
                 sums.shadowed_fragments);
  }
  return report.str();
}

std::string check_points(const Scene& scene, const Shadows& shadows, const CgalOracle& oracle,
                         std::uint64_t seed, int count, bool contact_may_cast) {
  struct Where {
    std::uint32_t face, facet;
    const Block* block;
    const Fragment* fragment;
  };
  std::vector<Where> all;
  for (const Block& block : shadows.blocks)
    for (const Fragment& f : block.fragments)
      if (shadows.areas[f.face].facing == Facing::toward)
        all.push_back({f.face, f.facet, &block, &f});
  return check_points_of(
      scene, all, [&](std::size_t k) { return all[k].block->corners_of(*all[k].fragment); },
      [&](std::size_t k) { return all[k].fragment->lit; }, oracle, seed, count, contact_may_cast);
}

std::string check_points(const Scene& scene, const LightPartition& sets, std::size_t light,
                         const CgalOracle& oracle, std::uint64_t seed, int count) {
  return check_points_of(
      scene, sets.fragments, [&](std::size_t k) { return sets.corners_of(sets.fragments[k]); },
      [&](std::size_t k) { return sets.reaches(k, light); }, oracle, seed, count);
}

std::string check_point_queries(const Engine& engine, std::size_t light, const CgalOracle* oracle,
                                std::uint64_t seed, int count) {
  const Scene& scene = engine.scene();
  const Shadows& shadows = engine.shadows(light);
  std::vector<std::pair<const Block*, const Fragment*>> all;
  for (const Block& block : shadows.blocks)
    for (const Fragment& f : block.fragments) all.emplace_back(&block, &f);
  if (all.empty()) return {};
  Report report;
  scenes::Random random(seed);
  for (int k = 0; k < count; ++k) {
    const auto& [block, f] = all[random.below(all.size())];
    const double scale = extent(scene, scene.facets()[f->facet]);
    if (f->area < 1e-14 * scale * scale) continue;  // no double lies well inside
    const auto x = inner_point(block->corners_of(*f), scale, random);
    if (!x) continue;
    const bool lit = engine.is_lit(light, f->face, *x);
    if (lit != f->lit)
      report.add(name_of(scene, f->face), ": point (", x->transpose(), ") is ", lit ? "" : "not ",
                 "lit, its fragment, of area ", f->area, ", is ", f->lit ? "lit" : "shadowed");
    if (oracle == nullptr || oracle->unsure(f->facet) || oracle->in_contact(f->facet, *x)) continue;
    if (lit != oracle->lit(f->facet, *x))
      report.add(name_of(scene, f->face), ": point (", x->transpose(), ") is ", lit ? "" : "not ",
                 "lit, unlike the oracle's");
  }
  return report.str();
}

std::string check_conforming(const Scene& scene, const Shadows& shadows) {
  Report report;
  for (const auto& [face, all] : by_face(shadows)) {
    // Every directed edge, and the places where a fragment may end: the outline of the face's
    // facets.
    std::map<std::pair<Bits, Bits>, int> edges;
    double scale = 0;
    for (const auto& fragment : all.fragments) {
      for (std::size_t i = 0; i < fragment.size(); ++i) {
        const Vec3 &a = fragment[i], &b = fragment[(i + 1) % fragment.size()];
        scale = std::max(scale, a.cwiseAbs().maxCoeff());
        if (bits(a) != bits(b)) ++edges[{bits(a), bits(b)}];
      }
    }
    const auto on_outline = [&, face = face](const Vec3& a, const Vec3& b) {
      const Face& f = scene.faces()[face];
      for (const Facet& facet : scene.facets().subspan(f.first_facet, f.facet_count)) {
        const auto corners = scene.corners_of(facet);
        for (std::size_t i = 0; i < corners.size(); ++i) {
          const Vec3 p = scene.vertices()[corners[i].vertex],
                     d = scene.vertices()[corners[(i + 1) % corners.size()].vertex] - p;
          const auto off = [&](const Vec3& x) { return d.cross(x - p).norm() / d.norm(); };
          if (off(a) < 1e-9 * scale && off(b) < 1e-9 * scale) return true;
        }
      }
      return false;
    };
    for (const auto& fragment : all.fragments) {
      for (std::size_t i = 0; i < fragment.size(); ++i) {
        const Vec3 &a = fragment[i], &b = fragment[(i + 1) % fragment.size()];
        if (bits(a) == bits(b)) continue;
        const auto back = edges.find({bits(b), bits(a)});
        const int there = edges[{bits(a), bits(b)}], here = back == edges.end() ? 0 : back->second;
        if (there == here || (here == 0 && on_outline(a, b))) continue;
        report.add(name_of(scene, face), ": the edge (", a.transpose(), ")-(", b.transpose(),
                   ") runs ", there, " times one way and ", here, " times the other");
      }
    }
  }
  return report.str();
}

std::string check_shared_corners(const Scene& scene, const Shadows& shadows) {
  Report report;
  for (const auto& [face, all] : by_face(shadows)) {
    std::vector<Vec3> corners;
    double scale = 0;
    for (const auto& fragment : all.fragments)
      for (const Vec3& c : fragment) {
        corners.push_back(c);
        scale = std::max(scale, c.cwiseAbs().maxCoeff());
      }
    std::sort(corners.begin(), corners.end(),
              [](const Vec3& a, const Vec3& b) { return a.x() < b.x(); });
    for (std::size_t i = 0; i < corners.size(); ++i)
      for (std::size_t j = i + 1;
           j < corners.size() && corners[j].x() - corners[i].x() < 1e-12 * scale; ++j)
        if ((corners[i] - corners[j]).norm() < 1e-12 * scale &&
            bits(corners[i]) != bits(corners[j]))
          report.add(name_of(scene, face), ": corners (", corners[i].transpose(), ") and (",
                     corners[j].transpose(), ") differ in their last bits");
  }
  return report.str();
}

std::vector<double> lit_areas(const Scene& scene, const LightPartition& sets, std::size_t light) {
  std::vector<double> out(scene.faces().size());
  for (std::size_t k = 0; k < sets.fragments.size(); ++k)
    if (sets.reaches(k, light))
      out[sets.fragments[k].face] += polygon_area(sets.corners_of(sets.fragments[k]));
  return out;
}

std::string check_identical(const Shadows& a, const Shadows& b) {
  Report report;
  if (a.blocks.size() != b.blocks.size()) return "different numbers of blocks\n";
  for (std::size_t k = 0; k < a.blocks.size(); ++k) {
    const Block &x = a.blocks[k], &y = b.blocks[k];
    if (x.fragments.size() != y.fragments.size() || x.corners.size() != y.corners.size()) {
      report.add("block ", k, ": different sizes");
      continue;
    }
    for (std::size_t i = 0; i < x.fragments.size(); ++i) {
      const Fragment &f = x.fragments[i], &g = y.fragments[i];
      if (f.id != g.id || f.face != g.face || f.facet != g.facet || f.caster != g.caster ||
          f.first_corner != g.first_corner || f.corner_count != g.corner_count || f.lit != g.lit)
        report.add("block ", k, ", fragment ", i, " differs");
    }
    for (std::size_t i = 0; i < x.corners.size(); ++i)
      if (std::memcmp(x.corners[i].data(), y.corners[i].data(), 3 * sizeof(double)) != 0)
        report.add("block ", k, ", corner ", i, " differs");
  }
  if (a.areas.size() != b.areas.size()) return "different numbers of areas\n";
  for (std::size_t i = 0; i < a.areas.size(); ++i)
    if (a.areas[i].facing != b.areas[i].facing || a.areas[i].area != b.areas[i].area ||
        a.areas[i].lit != b.areas[i].lit || a.areas[i].shadowed != b.areas[i].shadowed ||
        a.areas[i].dropped != b.areas[i].dropped)
      report.add("area of face ", i, " differs");
  const auto counts = [](const Stats& s) {
    return std::array{
        s.faces,          s.facing_faces, s.facets,   s.lit_fragments, s.shadowed_fragments,
        s.cells,          s.nodes,        s.sp_nodes, s.pp_nodes,      s.pieces,
        s.crossing_lines, s.predicates,   s.on,       s.depth};
  };
  if (counts(a.stats) != counts(b.stats)) report.add("statistics differ");
  return report.str();
}

}  // namespace shadowcut::testing
