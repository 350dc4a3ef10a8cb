// See published_tree.hpp: what enters the tree, and what comes of it.

#include "published_tree.hpp"

#include <algorithm>
#include <cmath>

#include "polygon.hpp"
#include "facets/light_position.hpp"
#include "light_space/light_range.hpp"
#include "svbsp.hpp"

namespace shadowcut::compare {

const char* name_of(Joining joining) {
  return joining == Joining::filter ? "filter" : joining == Joining::merge ? "merge" : "reinsert";
}

struct PublishedTree::Impl {
  Impl(const Scene& s, const Light& l, Joining j)
      : scene(s), light(l), space(l, box_of(s)), joining(j) {}

  void insert(std::uint32_t object);
  void enter(std::uint32_t facet, bool light_inside);
  double lit_area(std::uint32_t facet) const;
  double area_of(const Outline& outline, const Vec3& q) const;

  const Scene& scene;
  Light light;
  LightSpace space;
  Joining joining;
  Svbsp tree;
  std::vector<std::vector<std::uint32_t>> facets_of;  // by object: those that have entered
};

// Which facets enter, and what of them may be lit, is as in the engine.
void PublishedTree::Impl::enter(std::uint32_t id, bool light_inside) {
  const Facet& facet = scene.facets()[id];
  const Face& face = scene.faces()[facet.face];
  const Object& object = scene.objects()[face.object];
  const Plane& plane = scene.planes()[facet.plane];
  const Orientation turned = space.orientation(plane);
  if (!within_range(scene, face, light) || turned == Orientation::edge_on) return;
  if (!space.far() && !meets_all_corners(scene, facet, light.position)) return;
  const bool is_far_side = turned == Orientation::away && object.sides == Sides::closed;
  if (is_far_side && !light_inside) return;

  if (tree.surfaces.size() <= id) tree.surfaces.resize(scene.facets().size());
  Surface& s = tree.surfaces[id];
  s.rays.clear(), s.lines.clear();
  const double inside = (turned == Orientation::toward ? 1 : -1) * space.handedness();
  const auto corners = scene.corners_of(facet);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 &a = scene.vertices()[corners[i].vertex],
               &b = scene.vertices()[corners[(i + 1) % corners.size()].vertex];
    const VertexRay ray = space.ray(a);
    const Line line = space.line(a, b);
    s.rays.emplace_back(Vec3(ray.r[0], ray.r[1], ray.r[2]).normalized());
    const Vec3 n = inside * Vec3(line.n[0], line.n[1], line.n[2]).normalized();
    // once for edges in one line
    if (s.lines.empty() || (s.lines.back() - n).norm() > epsilon) s.lines.push_back(n);
  }
  const PlaneCovector q = space.plane(plane);
  s.q = Vec3(q.q[0], q.q[1], q.q[2]);
  s.q_size = s.q.norm();
  s.face = facet.face;
  s.in_tree = object.casts_shadows;
  s.may_be_lit = object.receives_shadows && !is_far_side;
  facets_of[face.object].push_back(id);
}

void PublishedTree::Impl::insert(std::uint32_t index) {
  if (facets_of.size() <= index) facets_of.resize(scene.objects().size());
  if (!facets_of[index].empty()) return;
  const Object& object = scene.objects()[index];
  const bool light_inside = object.casts_shadows && light.kind == Light::Kind::point &&
                            object.sides == Sides::closed &&
                            in_or_on_solid(scene, object, light.position);
  for (std::uint32_t id = object.first_facet; id < object.first_facet + object.facet_count; ++id)
    if (scene.facets()[id].corner_count != 0) enter(id, light_inside);
  for (const std::uint32_t id : facets_of[index]) {
    if (!tree.surfaces[id].in_tree) continue;
    tree.add({id, tree.surfaces[id].rays, Svbsp::root_place});
    tree.run();
  }
}

double PublishedTree::Impl::area_of(const Outline& outline, const Vec3& q) const {
  std::vector<Vec3> corners;
  for (const Vec3& r : outline) corners.push_back(space.back(r.data(), q.data()));
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    sum += (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
  return sum.norm() / 2;
}

// What reaches an OUT leaf is lit.
double PublishedTree::Impl::lit_area(std::uint32_t id) const {
  const Surface& surface = tree.surfaces[id];
  std::vector<std::pair<Outline, std::uint32_t>> rest{{surface.rays, Svbsp::root_place}};
  double area = 0;
  while (!rest.empty()) {
    auto [outline, place] = std::move(rest.back());
    rest.pop_back();
    const std::uint32_t at = tree.child_at(place);
    if (at == invalid_index) {
      area += area_of(outline, surface.q);
      continue;
    }
    const Node& node = tree.nodes[at];
    const bool is_sp = node.kind == Node::Kind::sp, is_own = !is_sp && node.surface == id;
    const Vec3 n = is_sp ? node.n : tree.nearer(id, node.surface);
    const double tolerance = is_sp ? epsilon : tree.touching(id, node.surface);
    const Sides2 sides = sides_of(outline, n, tolerance);
    if (is_own || (!is_sp && !sides.positive && !sides.negative)) {  // contact is not occlusion
      rest.emplace_back(std::move(outline), at * 2);
    } else if (!sides.both()) {
      if (is_sp || sides.side() > 0)
        rest.emplace_back(std::move(outline), at * 2 + (sides.side() < 0));
    } else {
      Outline positive, negative;
      split(outline, n, tolerance, positive, negative);
      if (is_sp) rest.emplace_back(std::move(negative), at * 2 + 1);
      rest.emplace_back(std::move(positive), at * 2);
    }
  }
  return area;
}

PublishedTree::PublishedTree(const Scene& scene, const Light& light, Joining joining) {
  light.check("the light");
  impl_ = std::make_unique<Impl>(scene, light, joining);
  for (std::uint32_t object = 0; object < scene.objects().size(); ++object) impl_->insert(object);
}

PublishedTree::~PublishedTree() = default;
PublishedTree::PublishedTree(PublishedTree&&) noexcept = default;

void PublishedTree::insert(std::uint32_t object) { impl_->insert(object); }

void PublishedTree::remove(std::uint32_t object) {
  if (object >= impl_->facets_of.size()) return;
  impl_->tree.remove(impl_->facets_of[object], impl_->joining);
  impl_->facets_of[object].clear();
}

std::vector<double> PublishedTree::lit_areas() const {
  std::vector<double> areas(impl_->scene.faces().size(), 0.0);
  for (const auto& facets : impl_->facets_of)
    for (const std::uint32_t id : facets)
      if (const Surface& s = impl_->tree.surfaces[id]; s.may_be_lit)
        areas[s.face] += impl_->lit_area(id);
  return areas;
}

const TreeCounts& PublishedTree::counts() const { return impl_->tree.counts; }
std::string PublishedTree::validate() const { return impl_->tree.validate(); }

}  // namespace shadowcut::compare
