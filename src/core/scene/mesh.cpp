// Meshes, issues, and the check of a light.

#include <numbers>
#include <numeric>
#include <shadowcut/scene.hpp>

namespace shadowcut {

Mesh::Mesh(std::span<const Vec3> vertices, std::span<const std::uint32_t> triangles)
    : vertices(vertices.begin(), vertices.end()) {
  if (triangles.size() % 3 != 0)
    throw Error("the number of indices of triangles is not a multiple of three: " +
                std::to_string(triangles.size()));
  add_faces(triangles, std::vector<std::uint32_t>(triangles.size() / 3, 3));
}

void Mesh::add_face(std::span<const std::uint32_t> outer) {
  corners_.insert(corners_.end(), outer.begin(), outer.end());
  loop_ends_.push_back(corners_.size());
  face_ends_.push_back(loop_ends_.size());
}

void Mesh::add_faces(std::span<const std::uint32_t> corners,
                     std::span<const std::uint32_t> counts) {
  const std::uint64_t sum = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  if (sum != corners.size())
    throw Error("the faces have " + std::to_string(sum) + " corners, and " +
                std::to_string(corners.size()) + " were given");
  corners_.reserve(corners_.size() + corners.size());
  loop_ends_.reserve(loop_ends_.size() + counts.size());
  face_ends_.reserve(face_ends_.size() + counts.size());
  for (const std::uint32_t n : counts) {
    add_face(corners.first(n));
    corners = corners.subspan(n);
  }
}

void Mesh::add_hole(std::span<const std::uint32_t> loop) {
  if (face_ends_.empty()) throw Error("a hole needs a face");
  corners_.insert(corners_.end(), loop.begin(), loop.end());
  loop_ends_.push_back(corners_.size());
  face_ends_.back() = loop_ends_.size();
}

std::size_t Mesh::loop_count(std::size_t face) const {
  return face_ends_[face] - (face ? face_ends_[face - 1] : 0);
}

std::span<const std::uint32_t> Mesh::loop(std::size_t face, std::size_t k) const {
  const std::size_t l = (face ? face_ends_[face - 1] : 0) + k;
  const std::size_t begin = l ? loop_ends_[l - 1] : 0;
  return std::span(corners_).subspan(begin, loop_ends_[l] - begin);
}

const char* reason_text(Reason reason) {
  switch (reason) {
    case Reason::non_finite:
      return "a coordinate is not finite";
    case Reason::index_out_of_range:
      return "a corner's index is out of range";
    case Reason::too_few_corners:
      return "fewer than three distinct corners";
    case Reason::zero_area:
      return "zero area";
    case Reason::self_intersecting:
      return "the outline intersects itself";
    case Reason::duplicate:
      return "duplicate of an earlier face";
    case Reason::repeated_corner:
      return "repeated corner removed";
    case Reason::not_flat:
      return "not flat, triangulated";
  }
  return "";
}

bool is_refusal(Reason reason) {
  return reason != Reason::repeated_corner && reason != Reason::not_flat;
}

void Light::check(const std::string& who) const {
  if (kind == Kind::directional) {
    if (!direction.allFinite()) throw Error(who + ": a coordinate is not finite");
    if (direction.isZero(0)) throw Error(who + ": its direction is zero");
    if (range != std::numeric_limits<double>::infinity())
      throw Error(who + ": a directional light has no range");
    if (spot) throw Error(who + ": a directional light has no spot");
    return;
  }
  if (!position.allFinite()) throw Error(who + ": a coordinate is not finite");
  if (!(range > 0)) throw Error(who + ": its range is not positive");
  if (spot) {
    if (!spot->axis.allFinite() || spot->axis.isZero(0))
      throw Error(who + ": its spot axis is zero or not finite");
    if (!(spot->half_angle > 0) || spot->half_angle > std::numbers::pi)
      throw Error(who + ": its spot angle is not in (0, pi]");
  }
}

}  // namespace shadowcut
