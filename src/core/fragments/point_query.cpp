#include "fragments/point_query.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace shadowcut {
namespace {

// A negative distance of a point from a facet, in the plane and off it; 0 for points of the facet.
double closeness(const Scene& scene, const Facet& facet, const Vec3& x) {
  const Plane& plane = scene.planes()[facet.plane];
  const auto corners = scene.corners_of(facet);
  double inside = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3& a = scene.vertices()[corners[i].vertex];
    const Vec3 edge = scene.vertices()[corners[(i + 1) % corners.size()].vertex] - a;
    inside = std::min(inside, edge.cross(x - a).dot(plane.normal) / edge.norm());
  }
  return inside - std::abs(plane.normal.dot(x - plane.point));
}

// The facet of a face on which a point lies, or to which the point is nearest.
FacetId facet_at(const Scene& scene, const Face& face, const Vec3& x) {
  FacetId best(face.first_facet);
  double most = -std::numeric_limits<double>::infinity();
  for (std::uint32_t i = face.first_facet;
       face.facet_count > 1 && i < face.first_facet + face.facet_count; ++i) {
    const double c = closeness(scene, scene.facets()[i], x);
    if (c > most) most = c, best = FacetId(i);
  }
  return best;
}

// The ray from the light through a point of a facet. Signs that the floating-point filter leaves
// open are decided exactly in the exact kernel, and are zero in the fast kernel.
class PointQuery {
 public:
  PointQuery(const LightView& light, FacetId facet, const Vec3& point)
      : light_(light),
        tables_(light.context.tables),
        facet_(facet),
        point_(point),
        ray_(light.context.space.ray(point)) {
    if (!tables_.is_exact()) return;
    exact_ = *tables_.exact;  // a copy, which takes the point into account
    exact_->note_position(point_);
  }

  bool is_lit() const {
    const KdTree& kd_tree = light_.grid.kd_tree();
    const CellPredicates shared(tables_, {});
    Place place = Place::root();
    while (!kd_tree.branch(place).is_cell()) {
      const NodeId node = kd_tree.branch(place).node();
      place = Place(node, side(kd_tree.dividing_line(node), shared));
    }
    return is_lit_in(light_.grid[kd_tree.branch(place).cell()]);
  }

 private:
  bool is_lit_in(const SvbspTree& tree) const {
    const CellPredicates predicates = tree.predicates();
    Place place = Place::root();
    for (Branch here = tree.branch(place); !here.is_out(); here = tree.branch(place)) {
      if (here.is_sp()) {
        place = Place(here.node(), side(tree.dividing_line(here.node()), predicates));
      } else if (is_behind(tree, here.node())) {
        return false;
      } else {
        place = Place(here.node(), 0);
      }
    }
    return true;
  }

  // The side of a dividing line on which the ray is. A ray on the line touches both sides.
  std::uint32_t side(const DividingLine& line, const CellPredicates& predicates) const {
    const double value = dot(line.n, ray_.r);
    const double bound =
        static_cast<double>(line.error) + static_cast<double>(ray_.error) + sign_slack;
    if (exact_ && !(std::abs(value) > bound))
      return exact_->side(predicates.exact(line.id), corner()) < 0 ? 1 : 0;
    return value < 0 ? 1 : 0;
  }

  // Whether the point lies behind the face of a PP-node. Contact is not occlusion.
  bool is_behind(const SvbspTree& tree, NodeId pp) const {
    const std::uint32_t own = tables_.plane_index(facet_),
                        other = tables_.plane_index(tree.owner_facet(pp));
    if (own == other) return false;
    const Node& node = tree.node(pp);
    const PlaneDifference nearer(tables_.planes[own], node.n, node.error);
    const double value = dot(nearer.d, ray_.r);
    const double bound =
        nearer.error + nearer.size * (static_cast<double>(ray_.error) + sign_slack);
    if (std::abs(value) > bound) return value < 0;
    return exact_ &&
           exact_->nearer(tables_.scene_planes[own], tables_.scene_planes[other], corner()) < 0;
  }

  ExactCorner corner() const { return {&point_, false, nullptr, nullptr, false, false}; }

  const LightView& light_;
  const LightTables& tables_;
  FacetId facet_;
  Vec3 point_;
  VertexRay ray_;
  std::optional<ExactPredicates> exact_;
};

}  // namespace

bool is_lit(const LightView& light, std::uint32_t face, const Vec3& point) {
  const Scene& scene = light.context.scene;
  if (scene.faces()[face].facet_count == 0) return false;
  const FacetId facet = facet_at(scene, scene.faces()[face], point);
  const FacetVisibility& visibility = light.context.visibility;
  if (!visibility.enters(facet) || visibility.facing(facet) != Facing::toward) return false;
  return PointQuery(light, facet, point).is_lit();
}

}  // namespace shadowcut
