// See receivers.hpp.
#include "receivers.hpp"

#include <algorithm>
#include <array>

#include "casters.hpp"

namespace shadowcut::render {
namespace {

class Divider {
 public:
  Divider(const Scene& scene, const Object& object, const Light& light, double tolerance)
      : scene_(scene),
        object_(object),
        tolerance_(tolerance),
        facing_(object.facet_count),
        done_(object.facet_count) {
    for (std::uint32_t f = 0; f < object.facet_count; ++f) {
      if (facet(f).corner_count == 0) continue;
      const Plane& plane = scene.planes()[facet(f).plane];
      const double away = plane.normal.dot(away_from(light, plane.point));
      facing_[f] = away < 0 ? 1 : away > 0 && object.sides == Sides::open ? -1 : 0;
    }
    find_neighbours();
  }

  std::vector<std::vector<std::uint32_t>> divide() {
    if (object_.sides == Sides::closed) take_convex_bodies();
    for (std::uint32_t f = 0; f < object_.facet_count; ++f)
      if (facing_[f] != 0 && !done_[f]) grow(f);
    return std::move(receivers_);
  }

 private:
  // Facets are numbered within the object from here on.
  const Facet& facet(std::uint32_t f) const { return scene_.facets()[object_.first_facet + f]; }
  std::uint32_t edge(const Corner& corner) const { return (corner.edge >> 1) - object_.first_edge; }

  void find_neighbours() {
    at_edge_.assign(object_.edge_count, {invalid_index, invalid_index});
    for (std::uint32_t f = 0; f < object_.facet_count; ++f)
      for (const Corner& corner : scene_.corners_of(facet(f))) {
        auto& [a, b] = at_edge_[edge(corner)];
        (a == invalid_index ? a : b) = f;
      }
  }

  template <class Use>
  void for_each_neighbour(std::uint32_t f, const Use& use) const {
    for (const Corner& corner : scene_.corners_of(facet(f)))
      for (const std::uint32_t g : at_edge_[edge(corner)])
        if (g != f && g != invalid_index) use(g);
  }

  // All corners of facet g are behind the front of f's plane turned to the light (side 1), or
  // before it (side -1).
  bool beside(std::uint32_t f, std::uint32_t g, int side, double tolerance) const {
    const Plane& plane = scene_.planes()[facet(f).plane];
    const auto corners = scene_.corners_of(facet(g));
    return std::all_of(corners.begin(), corners.end(), [&](const Corner& corner) {
      return side * plane.normal.dot(scene_.vertices()[corner.vertex] - plane.point) <= tolerance;
    });
  }

  // A closed surface with no reflex edge is convex. Many small tolerances could add up to a large
  // dent, which some corners all over the surface would then show.
  void take_convex_bodies() {
    std::vector<char> seen(object_.facet_count);
    for (std::uint32_t seed = 0; seed < object_.facet_count; ++seed) {
      if (seen[seed]) continue;
      std::vector<std::uint32_t> body{seed};
      seen[seed] = 1;
      bool convex = true;
      for (std::size_t i = 0; i < body.size(); ++i)
        for_each_neighbour(body[i], [&](std::uint32_t g) {
          convex = convex && beside(body[i], g, 1, tolerance_);
          if (!seen[g]) seen[g] = 1, body.push_back(g);
        });
      if (!convex || !behind_samples(body)) continue;
      std::erase_if(body, [this](std::uint32_t f) { return facing_[f] == 0; });
      for (const std::uint32_t f : body) done_[f] = 1;
      add(std::move(body));
    }
  }

  bool behind_samples(const std::vector<std::uint32_t>& body) const {
    const std::size_t step = 1 + body.size() / 32;
    for (const std::uint32_t f : body)
      for (std::size_t k = 0; k < body.size(); k += step)
        if (!beside(f, body[k], 1, tolerance_)) return false;
    return true;
  }

  bool beside_each_other(const std::vector<std::uint32_t>& receiver, std::uint32_t g,
                         int side) const {
    return std::all_of(receiver.begin(), receiver.end(), [&](std::uint32_t f) {
      return beside(f, g, side * facing_[f], tolerance_) &&
             beside(g, f, side * facing_[g], tolerance_);
    });
  }

  void grow(std::uint32_t seed) {
    std::vector<std::uint32_t> receiver{seed};
    done_[seed] = 1;
    bool outside = true, inside = true;
    for (std::size_t i = 0; i < receiver.size(); ++i)
      for_each_neighbour(receiver[i], [&](std::uint32_t g) {
        if (facing_[g] == 0 || done_[g]) return;
        const bool still_outside = outside && beside_each_other(receiver, g, 1);
        const bool still_inside = inside && beside_each_other(receiver, g, -1);
        if (!still_outside && !still_inside) return;
        outside = still_outside, inside = still_inside;
        done_[g] = 1;
        receiver.push_back(g);
      });
    add(std::move(receiver));
  }

  void add(std::vector<std::uint32_t> receiver) {
    if (receiver.empty()) return;
    for (std::uint32_t& f : receiver) f += object_.first_facet;
    std::sort(receiver.begin(), receiver.end());
    receivers_.push_back(std::move(receiver));
  }

  const Scene& scene_;
  const Object& object_;
  const double tolerance_;
  std::vector<int> facing_;  // by facet: 1 with its front, -1 with its back, 0 not
  std::vector<char> done_;   // by facet
  std::vector<std::array<std::uint32_t, 2>> at_edge_;
  std::vector<std::vector<std::uint32_t>> receivers_;
};

}  // namespace

std::vector<std::vector<std::uint32_t>> receivers_of(const Scene& scene, std::uint32_t object,
                                                     const Light& light, double tolerance) {
  return Divider(scene, scene.objects()[object], light, tolerance).divide();
}

}  // namespace shadowcut::render
