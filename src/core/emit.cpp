// A face's fragments lie at its locations in the tree. A piece behind a PP-node is one shadowed fragment. A piece on a PP-node (its owner, or
// coplanar with it) is cut by what stands in front: the SP-nodes of the front subtree down to the next PP-nodes. Leaves there are lit,
// the regions of those PP-nodes are shadowed by their faces.

#include "emit.hpp"

#include <algorithm>

namespace shadowcut {
namespace {

constexpr std::uint32_t lit_state = none;        // states: lit, a casting face, or
constexpr std::uint32_t mixed_state = none - 1;  // more than one

// By SP-node: the one state of everything below, or mixed. Children come after their parents, so one pass backwards settles all.
std::vector<std::uint32_t> states_of(const CellTree& tree) {
  const auto nodes = tree.nodes();
  std::vector<std::uint32_t> states(nodes.size(), mixed_state);
  const auto face_of = [&](std::uint32_t pp) { return tree.tables().facets[tree.pieces()[nodes[pp].id].facet].face; };
  const auto state_of = [&](Child c) { return c.is_out() ? lit_state : c.is_pp() ? face_of(c.node()) : states[c.node()]; };
  for (std::size_t i = nodes.size(); i-- > 0;) {
    const std::uint32_t a = state_of(nodes[i].child[0]);
    // A PP-node's own entry is never asked for; its place has its owner's state.
    if (a == state_of(nodes[i].child[1])) states[i] = a;
  }
  return states;
}

// The area of a polygon handed over corner by corner, as its part along the plane's normal: linear in the corners, so the areas of parts add up.
class AreaSum {
 public:
  void add(const Vec3& x) {
    if (count_ == 0) origin_ = x;
    const Vec3 spoke = x - origin_;
    if (count_ > 1) doubled_ += last_.cross(spoke);
    last_ = spoke;
    ++count_;
  }
  double area(const Vec3& normal) const { return std::abs(doubled_.dot(normal)) / 2; }

 private:
  Vec3 origin_, last_, doubled_ = Vec3::Zero();
  int count_ = 0;
};

// The region of a face is its plane cut by its cone. Where its corners are flat only up to rounding, corners and region differ by as much;
// areas are the region's, so that they add up. Where they are flat, its vertices will do.
bool flat_enough(const Plane& plane, const Face& face) { return plane.flatness * plane.flatness <= 1e-26 * face.area; }

}  // namespace

double area_of_facet(const EmitTarget& target, std::uint32_t facet_id, bool in_light) {
  const Facet& facet = target.scene.facets()[facet_id];
  const Plane& plane = target.scene.planes()[facet.plane];
  const bool project = in_light && !flat_enough(plane, target.scene.faces()[facet.face]);
  AreaSum sum;
  for (const Corner& c : target.scene.corners_of(facet)) {
    sum.add(project ? target.space.back(target.tables.rays[c.vertex].r, target.tables.planes[facet.plane].q) : target.scene.vertices()[c.vertex]);
  }
  return sum.area(plane.normal);
}

void emit_cone(const Cone& cone, const EmitTarget& target, FragmentId id, bool lit, std::uint32_t caster, std::uint64_t local_lines, CellOutput& out) {
  const Facet& facet = target.scene.facets()[cone.facet];
  const Plane& plane = target.scene.planes()[facet.plane];
  const PlaneRay& q = target.tables.planes[facet.plane];
  auto& corners = out.block.corners;
  const std::size_t first = corners.size();
  const bool reversed = target.space.handedness() < 0;
  const bool vertices_serve = flat_enough(plane, target.scene.faces()[facet.face]);
  AreaSum sum;
  for (std::uint32_t k = 0; k < cone.count; ++k) {
    const std::uint32_t i = reversed ? cone.count - 1 - k : k;
    const double r[3] = {cone.x[i], cone.y[i], cone.z[i]};
    const std::uint32_t v = cone.vertex[i];
    const bool is_vertex = v != none;
    corners.push_back(is_vertex ? target.scene.vertices()[v] : target.space.back(r, q.q));
    sum.add(is_vertex && !vertices_serve ? target.space.back(r, q.q) : corners.back());
    if (target.keep_lines) {
      const std::uint32_t leaving = reversed ? (i == 0 ? cone.count - 1 : i - 1) : i;
      const std::uint64_t line = cone.edge[leaving].line();
      out.edge_lines.push_back(line < target.tables.lines.size() ? line : line + local_lines);
    }
  }
  out.block.fragments.push_back({id, facet.face, cone.facet, caster, static_cast<std::uint32_t>(first), cone.count, lit, sum.area(plane.normal)});
}

void emit_cell(const CellTree& tree, std::uint32_t cell, bool merge, const EmitTarget& target, Workspace& w, CellOutput& out) {
  const auto nodes = tree.nodes();
  const auto pieces = tree.pieces();
  const std::uint64_t local_lines = static_cast<std::uint64_t>(cell + 1) << 32;
  const auto line_of = [&tree](std::uint32_t id) -> const Line& { return tree.line(id); };
  const auto facet_face = [&](std::uint32_t facet) { return target.scene.facets()[facet].face; };
  const auto receives = [&](std::uint32_t facet) {
    const Face& face = target.scene.faces()[facet_face(facet)];
    return target.scene.objects()[face.object].receives && !target.tables.blocks_only[facet];
  };
  std::vector<std::uint32_t> states;
  if (merge) states = states_of(tree);

  const auto emit_in_front = [&](std::uint32_t piece, std::uint32_t pp) {
    Cone* whole = tree.cone_of(pieces[piece], w.pool);
    whole->at = pp * 2;
    w.pending.push_back(whole);
    while (!w.pending.empty()) {
      Cone* cone = w.pending.back();
      w.pending.pop_back();
      std::uint32_t place = cone->at;
      for (;;) {
        const Child here = tree.child_at(place);
        std::uint32_t state = mixed_state;
        if (here.is_out()) {
          state = lit_state;
        } else if (here.is_pp()) {
          state = facet_face(pieces[nodes[here.node()].id].facet);
        } else if (merge) {
          state = states[here.node()];
        }
        if (state != mixed_state) {
          emit_cone(*cone, target, {cell, piece, place}, state == lit_state, state, local_lines, out);
          break;
        }
        const Node& node = nodes[here.node()];
        const double bound = static_cast<double>(node.error) + static_cast<double>(cone->error) + sign_slack;
        const Sides3 sides = classify(*cone, node.n, bound);
        place = here.node() * 2 + (sides.positive ? 0u : 1u);
        if (sides.positive && sides.negative) {
          signs_of(*cone, node.n, bound, w.signs);
          Cone *positive, *negative;
          split(*cone, w.signs, tree.line(node.id), node.id, true, line_of, w.pool, positive, negative);
          w.pool.give_back(cone);
          negative->at = here.node() * 2 + 1;
          w.pending.push_back(negative);
          cone = positive;
        }
      }
      w.pool.give_back(cone);
    }
  };

  for (std::uint32_t p = 0; p < pieces.size(); ++p) {
    const Piece& piece = pieces[p];
    if (!receives(piece.facet)) continue;
    if (piece.kind == Piece::Kind::owner || piece.kind == Piece::Kind::coplanar) {
      emit_in_front(p, piece.place);
      continue;
    }
    const bool lit = piece.kind == Piece::Kind::at_leaf;
    const std::uint32_t caster = lit ? none : facet_face(pieces[nodes[piece.place].id].facet);
    Cone* cone = tree.cone_of(piece, w.pool);
    emit_cone(*cone, target, {cell, p, none}, lit, caster, local_lines, out);
    w.pool.give_back(cone);
  }
}

}  // namespace shadowcut
