// See exact_checks.hpp.
#include "exact_checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

namespace shadowcut::testing {
namespace {

using Role = GmpOracle::Role;
using State = GmpOracle::State;

bool same_bits(const Vec3& a, const Vec3& b) {
  return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0;
}

std::string text(const Vec3& v) {
  char buffer[100];
  std::snprintf(buffer, sizeof buffer, "(%.17g, %.17g, %.17g)", v.x(), v.y(), v.z());
  return buffer;
}

class Check {
 public:
  Check(const GmpOracle& oracle, const Shadows& shadows, Form form)
      : oracle_(oracle),
        scene_(oracle.scene()),
        shadows_(shadows),
        form_(form),
        all_(scene_.facets().size()),
        lit_(all_.size()),
        own_rays_(all_.size()) {}

  std::string run() {
    for (const Block& block : shadows_.blocks) {
      if (block.constructions.size() != block.corners.size())
        return "there is not one construction for each corner\n";
      for (const Fragment& f : block.fragments) check(block, f);
    }
    for (std::uint32_t facet = 0; facet < all_.size(); ++facet) compare(facet);
    check_facing();
    return out_.str();
  }

 private:
  template <class... Words>
  void complain(const Words&... words) {
    if (++complaints_ > 8) return;  // more of the same
    (out_ << ... << words) << '\n';
  }

  std::string name(const Fragment& f) const {
    std::ostringstream s;
    s << (f.lit ? "lit" : "shadowed") << " fragment (" << f.id.cell << ", " << f.id.piece << ", "
      << f.id.place << ") of facet " << f.facet;
    return s.str();
  }

  void check(const Block& block, const Fragment& f) {
    if (f.facet >= all_.size() || oracle_.role(f.facet) == Role::absent)
      return complain("a fragment of no facet: ", f.facet);
    if (scene_.facets()[f.facet].face != f.face)
      return complain(name(f), " says it is of face ", f.face);
    if (f.corner_count < 3 || std::size_t{f.first_corner} + f.corner_count > block.corners.size())
      return complain(name(f), " has corners that are not there");
    if (!scene_.objects()[scene_.faces()[f.face].object].receives_shadows)
      return complain(name(f), ", which does not receive");
    if (oracle_.role(f.facet) != Role::takes_part) {
      if (f.lit || f.caster != invalid_index)
        complain(name(f), ", which is turned away or edge-on");
      return;
    }
    std::vector<Triple> rays;
    for (std::uint32_t k = f.first_corner; k < f.first_corner + f.corner_count; ++k) {
      const std::optional<Triple> ray = ray_of(oracle_, f.facet, block.constructions[k]);
      if (!ray)
        return complain(name(f), ": the construction of corner ", k - f.first_corner,
                        " gives none");
      rays.push_back(*ray);
      check_corner(f, k - f.first_corner, block.constructions[k], *ray, block.corners[k]);
    }
    all_[f.facet].add(rays);
    if (f.lit) lit_[f.facet].add(rays);
    if (!is_convex(rays))
      return complain(name(f),
                      " is not convex, not counter-clockwise, flat, or has a corner twice");
    check_middle(f, rays);
  }

  // A corner that is a vertex of its facet is that vertex, however it was made.
  void check_corner(const Fragment& f, std::uint32_t number, const Construction& made,
                    const Triple& ray, const Vec3& corner) {
    const Vec3* vertex = nullptr;
    const auto own = scene_.corners_of(scene_.facets()[f.facet]);
    const std::vector<Triple>& rays = rays_of_corners(f.facet);
    for (std::size_t i = 0; i < own.size(); ++i) {
      if (made.vertex != own[i].vertex && rays[i] != ray) continue;
      vertex = &scene_.vertices()[own[i].vertex];
      if (same_bits(corner, *vertex)) return;
    }
    if (vertex)
      return complain(name(f), ": corner ", number, " is a vertex, ", text(*vertex),
                      ", emitted as ", text(corner));
    const Place place = oracle_.place(f.facet, ray);
    for (int axis = 0; axis < 3; ++axis) {
      if (within_one_ulp(oracle_, place, axis, corner[axis])) continue;
      return complain(name(f), ": corner ", number, " is ", text(oracle_.rounded(place)),
                      ", emitted as ", text(corner));
    }
  }

  const std::vector<Triple>& rays_of_corners(std::uint32_t facet) {
    std::vector<Triple>& rays = own_rays_[facet];
    if (rays.empty()) {
      for (const Corner& c : scene_.corners_of(scene_.facets()[facet]))
        rays.push_back(oracle_.ray(scene_.vertices()[c.vertex]));
    }
    return rays;
  }

  // Some point of the inside; another one where that is on the boundary of a shadow, be it only of
  // the caster's: a fragment may have been joined across it.
  void check_middle(const Fragment& f, const std::vector<Triple>& rays) {
    constexpr unsigned attempts = 4;
    for (unsigned attempt = 0; attempt < attempts; ++attempt) {
      const Triple middle = middle_of(rays, attempt);
      std::vector<std::uint32_t> by;
      const State state = oracle_.state_at(f.facet, oracle_.place(f.facet, middle), &by);
      if (state == State::on_boundary) continue;
      if ((state == State::lit) != f.lit) {
        complain(name(f), ": light ", f.lit ? "does not arrive" : "arrives", " at ",
                 text(oracle_.rounded(oracle_.place(f.facet, middle))));
      }
      if (state == State::shadowed && !f.lit && !casts(f, by)) {
        if (attempt + 1 < attempts) continue;
        complain(name(f), ": its caster, face ", f.caster, ", does not cast there");
      }
      return;
    }
  }

  // Whether the fragment's caster is among those.
  bool casts(const Fragment& f, const std::vector<std::uint32_t>& by) const {
    return f.caster < scene_.faces().size() &&
           std::any_of(by.begin(), by.end(), [&](std::uint32_t facet) {
             const std::uint32_t face = scene_.facets()[facet].face;
             return form_ == Form::pieces
                        ? face == f.caster
                        : scene_.faces()[face].object == scene_.faces()[f.caster].object;
           });
  }

  void compare(std::uint32_t facet) {
    all_[facet].settle();
    lit_[facet].settle();
    if (oracle_.role(facet) != Role::takes_part ||
        !scene_.objects()[scene_.faces()[scene_.facets()[facet].face].object].receives_shadows)
      return;
    compare(facet, all_[facet], oracle_.whole(facet), "all fragments");
    compare(facet, lit_[facet], oracle_.lit(facet), "lit fragments");
  }

  void compare(std::uint32_t facet, const Region& is, const Region& should, const char* what) {
    if (is == should) return;
    const Rational is_area = oracle_.area(facet, is), should_area = oracle_.area(facet, should);
    const Rational share = (is_area - should_area) / oracle_.area(facet, oracle_.whole(facet));
    complain(what, " of facet ", facet, " do not cover what they should; projected along axis ",
             oracle_.stretch(facet).first, " their area is ", is_area.get_d(), ", should be ",
             should_area.get_d(), ": ", share.get_d(), " of the facet's more; ",
             difference(facet, is, should));
  }

  // A corner of one boundary that the other has not.
  std::string difference(std::uint32_t facet, const Region& a, const Region& b) const {
    const auto in = [](const Region& region, const Region::Term& t) {
      return std::find(region.terms().begin(), region.terms().end(), t) != region.terms().end();
    };
    for (const Region* region : {&a, &b}) {
      const Region& other = region == &a ? b : a;
      for (const Region::Term& t : region->terms()) {
        if (!in(other, t))
          return std::string(region == &a ? "theirs" : "it") + " has a corner at " +
                 text(oracle_.rounded(oracle_.place(facet, t.point)));
      }
    }
    return {};
  }

  void check_facing() {
    for (std::uint32_t i = 0; i < scene_.faces().size(); ++i) {
      const Face& face = scene_.faces()[i];
      Facing facing = Facing::refused;
      if (face.facet_count != 0) {
        facing = scene_.objects()[face.object].receives_shadows ? Facing::away : Facing::ignored;
        for (std::uint32_t f = face.first_facet;
             f < face.first_facet + face.facet_count && facing == Facing::away; ++f) {
          if (oracle_.role(f) == Role::takes_part) facing = Facing::toward;
        }
      }
      if (shadows_.areas[i].facing != facing)
        complain("facing of face ", i, " is ", static_cast<int>(shadows_.areas[i].facing),
                 ", should be ", static_cast<int>(facing));
    }
  }

  const GmpOracle& oracle_;
  const Scene& scene_;
  const Shadows& shadows_;
  Form form_;
  std::vector<Region> all_, lit_;              // by facet
  std::vector<std::vector<Triple>> own_rays_;  // by facet, of its corners
  std::ostringstream out_;
  int complaints_ = 0;
};

}  // namespace

std::optional<Triple> ray_of(const GmpOracle& oracle, std::uint32_t facet,
                             const Construction& made) {
  if (made.vertex != invalid_index && made.vertex >= oracle.scene().vertices().size()) return {};
  try {
    Triple ray = made.vertex != invalid_index
                     ? oracle.ray(oracle.scene().vertices()[made.vertex])
                     : reduced(cross(oracle.line(made.in), oracle.line(made.out)));
    if (is_zero(ray)) return {};
    if (made.vertex == invalid_index && !oracle.meets(facet, ray)) ray = negated(ray);
    if (!oracle.meets(facet, ray)) return {};
    return ray;
  } catch (const Error&) {  // of numbers that are not the scene's
    return {};
  }
}

Triple middle_of(std::span<const Triple> rays, unsigned attempt) {
  Triple middle;
  for (std::size_t k = 0; k < rays.size(); ++k) {
    const unsigned long weight = 1 + (k * 7 * attempt + 5 * attempt) % 11;
    for (std::size_t i = 0; i < 3; ++i) middle[i] += rays[k][i] * weight;
  }
  return middle;
}

bool within_one_ulp(const GmpOracle& oracle, const Place& x, int axis, double value) {
  if (!std::isfinite(value)) return false;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return oracle.compare(x, axis, std::nextafter(value, -infinity)) >= 0 &&
         oracle.compare(x, axis, std::nextafter(value, infinity)) <= 0;
}

std::string check_exact(const GmpOracle& oracle, const Shadows& shadows, Form form) {
  return Check(oracle, shadows, form).run();
}

}  // namespace shadowcut::testing
