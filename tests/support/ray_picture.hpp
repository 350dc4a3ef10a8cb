// A picture made by a ray for every pixel, in doubles and without a tree; and how far a technique's
// picture is from it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "offscreen.hpp"
#include "scenes.hpp"
#include "technique.hpp"

namespace shadowcut::testing {

using render::Camera;
using render::Picture;

inline constexpr int kWidth = 200, kHeight = 150;  // of every picture here

// A facet as seen from one point, or along one direction: the planes through its edges, and its
// own.
struct Seen {
  std::uint32_t facet;
  std::vector<Vec3> sides;  // positive inside
  Vec3 normal;
  double offset;
};

// The facets of one object, and a ball around it: most rays pass by most objects.
struct Group {
  std::size_t first, end;
  Vec3 centre;
  double radius;
  bool near_line(const Vec3& x, const Vec3& along) const {
    return (centre - x).cross(along).squaredNorm() <=
           1.0001 * radius * radius * along.squaredNorm();
  }
};

struct SeenFacets {
  std::vector<Seen> facets;
  std::vector<Group> groups;

  // visit(seen) for those whose object may be met by the line.
  template <class Visit>
  void near_line(const Vec3& x, const Vec3& along, const Visit& visit) const {
    for (const Group& group : groups) {
      if (!group.near_line(x, along)) continue;
      for (std::size_t i = group.first; i < group.end; ++i) visit(facets[i]);
    }
  }
};

struct Pixel {
  std::uint32_t facet = invalid_index;
  bool ambiguous = false;  // two facets at one place
  std::vector<bool> lit;
  std::array<double, 3> colour{255, 255, 255};
  Vec3 place = Vec3::Zero();  // where it is on the facet
};

class RayPicture {
 public:
  RayPicture(const Scene& scene, const Camera& camera);

  const Pixel& at(int x, int y) const { return pixels_[static_cast<std::size_t>(y * kWidth + x)]; }

  // Whether another face, or another shadow, comes within a pixel; a shadow, within `reach` pixels.
  bool at_an_edge(int x, int y, int reach = 1) const;

  // Pixels that a texel of a light's view of that many pixels a side may cover, from its middle on,
  // and one more. Where light grazes a face a texel is drawn out; beyond twenty times its width (3
  // degrees) such views say nothing, and no pixel is near enough to count.
  int reach_of_texels(int x, int y, int side) const;

  bool in_shadow(const Vec3& x) const;

 private:
  Pixel look(const Vec3& ray) const;

  // Where two edges of a facet are within a pixel it may lie between all pixels' middles: at its
  // corners, and where it is seen edge-on.
  void mark_if_thin(std::uint32_t facet);

  static int edges_near(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& p);

  void shade(Pixel& pixel, const Vec3& x) const;

  bool shadowed(std::size_t k, std::uint32_t facet, const Vec3& x) const;

  const Scene& scene_;
  Camera camera_;
  Light eye_;
  SeenFacets faces_;
  std::vector<SeenFacets> casters_;
  std::vector<Pixel> pixels_;
};

// The first call makes the context for all tests.
void need_context();

Picture picture_of(const Scene& scene, const std::string& technique, const Camera& camera);

// Shadow maps and shadow textures show no more than their texels do.
bool has_texels(const std::string& technique);

struct Difference {
  int pixels = 0, covered = 0;
  std::string first;
};

// Pixels away from edges that are not as the rays have them.
Difference difference(const Picture& picture, const RayPicture& rays, bool texels = false);

Camera looking(const Vec3& eye, const Vec3& target);

}  // namespace shadowcut::testing
