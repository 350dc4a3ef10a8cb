// A face's fragments lie at its locations in the tree. A piece behind a PP-node is one shadowed
// fragment. A piece on a PP-node (its owner, or coplanar with it) is cut by what stands in front:
// the SP-nodes of the front subtree down to the next PP-nodes. Leaves there are lit, the regions of
// those PP-nodes are shadowed by their faces.

#include "emit.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "smallest_feature.hpp"
#include "unite.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {
namespace {

// Calls f(node, is_sp) for every node, after those below it.
template <class F>
void for_each_node_upward(const CellTree& tree, const F& f) {
  std::vector<std::pair<Child, bool>> pending{{tree.root(), false}};
  while (!pending.empty()) {
    const auto [here, below_done] = pending.back();
    pending.pop_back();
    if (here.is_out()) continue;
    if (below_done) {
      f(here.node(), here.is_sp());
      continue;
    }
    pending.emplace_back(here, true);
    pending.emplace_back(tree.nodes()[here.node()].child[0], false);
    if (here.is_sp()) pending.emplace_back(tree.nodes()[here.node()].child[1], false);
  }
}

// In the facet's plane. Where a light nearly touches it the numbers may have no such point: then
// any of the facet's will do.
Vec3 on_plane(const EmitTarget& target, std::uint32_t facet_id, const Real r[3]) {
  const Facet& facet = target.scene.facets()[facet_id];
  const Vec3 x = target.space.back(r, target.tables.planes[facet.plane].q);
  return x.allFinite() ? x : target.scene.vertices()[target.scene.corners_of(facet)[0].vertex];
}

const Vec3& normal_of(const EmitTarget& target, std::uint32_t facet) {
  return target.scene.planes()[target.scene.facets()[facet].plane].normal;
}

class CellEmitter {
 public:
  CellEmitter(const CellTree& tree, std::uint32_t cell, bool merge, const EmitTarget& target,
              Workspace& w, CellOutput& out)
      : tree_(tree),
        cell_(cell),
        target_(target),
        w_(w),
        out_(out),
        nodes_(tree.nodes()),
        pieces_(tree.pieces()),
        merge_(merge),
        reversed_(target.space.handedness() < 0),
        lines_(tree.lines()) {
    w_.points.clear();
    if (merge_) states_ = find_states(tree, target.scene);
  }

  void run() {
    out_.block.fragments.reserve(pieces_.size() * 3);
    out_.block.corners.reserve(pieces_.size() * 14);
    for (const std::uint32_t p : order()) {
      const Piece& piece = pieces_[p];
      if (!hands_out(target_, piece)) continue;
      if (piece.kind == Piece::Kind::owner || piece.kind == Piece::Kind::coplanar) {
        const std::uint32_t front = piece.place * 2;
        const std::uint32_t state = state_of(tree_.child_at(front));
        if (state != mixed_state) {
          emit_piece(p, front, state);
        } else {
          emit_in_front(p, front);
        }
      } else {
        emit_piece(p, none,
                   piece.kind == Piece::Kind::at_leaf ? lit_state : owner_face(tree_, piece.place));
      }
    }
    release();
  }

 private:
  // A facet's pieces together, in the order in which filtering cut it, depth first. In a tree just
  // built that is the order of their indices; edits use indices again.
  std::vector<std::uint32_t> order() const {
    std::vector<std::uint32_t> order(pieces_.size());
    std::iota(order.begin(), order.end(), 0u);
    if (!target_.tables.edits) return order;
    // of nodes, from the root down, positive side first
    std::vector<std::uint32_t> rank(nodes_.size() + 1, 0);
    std::vector<Child> pending{tree_.root()};
    std::uint32_t next = 0;
    while (!pending.empty()) {
      const Child here = pending.back();
      pending.pop_back();
      if (here.is_out()) continue;
      rank[here.node()] = next++;
      if (here.is_sp()) pending.push_back(nodes_[here.node()].child[1]);
      pending.push_back(nodes_[here.node()].child[0]);
    }
    const auto key = [&](std::uint32_t p) {
      const Piece& piece = pieces_[p];
      const std::uint32_t node = piece.kind != Piece::Kind::at_leaf ? piece.place
                                 : piece.place == root_place        ? 0
                                                                    : piece.place >> 1;
      return std::tuple(piece.facet, piece.kind == Piece::Kind::free ? 0 : rank[node],
                        piece.place & 1, piece.kind);
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    return order;
  }

  struct Held {
    std::uint32_t first, count;  // into held_corners_
    std::uint32_t piece, place, state;
  };

  std::uint32_t state_of(Child c) const { return SHADOWCUT_NUMBERS::state_of(tree_, states_, c); }

  void emit_in_front(std::uint32_t piece, std::uint32_t front) {
    std::uint32_t state = mixed_state;
    const auto stop = [&](Child here) { return (state = state_of(here)) != mixed_state; };
    descend(tree_, tree_.cone_of(pieces_[piece], w_.pool), front, true, w_, stop, [&](Cone* cone) {
      hold(cone->facet, cone->span(), piece, cone->at, state);
      w_.pool.give_back(cone);
    });
  }

  void emit_piece(std::uint32_t p, std::uint32_t place, std::uint32_t state) {
    hold(pieces_[p].facet, tree_.corners(pieces_[p]), p, place, state);
  }

  // A facet's fragments come in the order in which filtering cut it, depth first: the two sides of
  // a cut stand side by side once each is in one. So holding them on a stack and joining the two on
  // top as long as they join reunites every cut whose sides came to the same state (Slater 1992,
  // figure 6).
  void hold(std::uint32_t facet, std::span<const ConeCorner> corners, std::uint32_t piece,
            std::uint32_t place, std::uint32_t state) {
    if (!merge_) return emit_polygon(facet, corners, piece, place, state);
    if (facet != held_facet_) release();
    held_facet_ = facet;
    held_.push_back({static_cast<std::uint32_t>(held_corners_.size()),
                     static_cast<std::uint32_t>(corners.size()), piece, place, state});
    held_corners_.insert(held_corners_.end(), corners.begin(), corners.end());
    while (held_.size() > 1 && join_top()) {
    }
  }

  void release() {
    for (const Held& h : held_) {
      emit_polygon(held_facet_,
                   std::span<const ConeCorner>(held_corners_).subspan(h.first, h.count), h.piece,
                   h.place, h.state);
    }
    held_.clear();
    held_corners_.clear();
  }

  // Joins the two polygons on top of the stack if they are in like states, meet in a whole edge of
  // both, and their union is convex.
  bool join_top() {
    Held& a = held_[held_.size() - 2];
    const Held& b = held_.back();
    const std::span<const ConeCorner> corners = held_corners_;
    if (!alike_states(target_.scene, a.state, b.state) ||
        !unite(corners.subspan(a.first, a.count), corners.subspan(b.first, b.count), held_facet_,
               none, lines_, joined_))
      return false;
    held_corners_.resize(a.first);
    held_corners_.insert(held_corners_.end(), joined_.begin(), joined_.end());
    a.count = static_cast<std::uint32_t>(joined_.size());
    held_.pop_back();
    return true;
  }

  // Counter-clockwise seen from the light.
  void emit_polygon(std::uint32_t facet_id, std::span<const ConeCorner> cone, std::uint32_t piece,
                    std::uint32_t place, std::uint32_t state) {
    const Facet& facet = target_.scene.facets()[facet_id];
    const auto count = static_cast<std::uint32_t>(cone.size());
    auto& corners = out_.block.corners;
    const std::size_t first = corners.size();
    corners.resize(first + count);
    const double area =
        place_polygon(target_, lines_, facet_id, cone, w_.points, corners.data() + first);
    if (target_.constructions) note_constructions(target_, lines_, cone, first, out_.block);
    const bool lit = state == lit_state;
    out_.block.fragments.push_back({{cell_, piece, place},
                                    facet.face,
                                    facet_id,
                                    lit ? none : state,
                                    static_cast<std::uint32_t>(first),
                                    count,
                                    lit,
                                    area});
    if (!target_.keep_lines) return;
    for (std::uint32_t k = 0; k < count; ++k) {
      // The edge that leaves corner k in this order.
      out_.edge_lines.push_back(
          name_of_line(facet.face, cone[reversed_ ? (2 * count - 2 - k) % count : k].edge.line()));
    }
  }

  // One name for a line wherever it is met: of the object's own edges their index, of others' lines
  // and the cell's own what sets them apart.
  std::uint64_t name_of_line(std::uint32_t face, std::uint32_t line) const {
    if (line >= first_local_line) return static_cast<std::uint64_t>(cell_ + 1) << 32 | line;
    const std::uint32_t o = target_.scene.faces()[face].object;
    const Object& object = target_.scene.objects()[o];
    const std::uint32_t edge = line - target_.tables.line_shift[o];
    return edge - object.first_edge < object.edge_count ? edge : std::uint64_t{1} << 63 | line;
  }

  const CellTree& tree_;
  std::uint32_t cell_;
  const EmitTarget& target_;
  Workspace& w_;
  CellOutput& out_;
  std::span<const Node> nodes_;
  std::span<const Piece> pieces_;
  bool merge_, reversed_;
  Lines lines_;
  std::vector<std::uint32_t> states_;  // by node; empty: leave everything in pieces

  std::uint32_t held_facet_ = none;
  std::vector<Held> held_;  // fragments of one facet that may still grow
  std::vector<ConeCorner> held_corners_, joined_;
};

}  // namespace

// Children are settled before their parents.
std::vector<std::uint32_t> find_states(const CellTree& tree, const Scene& scene) {
  std::vector<std::uint32_t> states(tree.nodes().size(), mixed_state);
  for_each_node_upward(tree, [&](std::uint32_t node, bool is_sp) {
    const auto& child = tree.nodes()[node].child;
    if (is_sp)
      states[node] =
          joint_state(scene, state_of(tree, states, child[0]), state_of(tree, states, child[1]));
  });
  return states;
}

// The region of a face is its plane cut by its cone. Where its corners are flat only up to
// rounding, corners and region differ by as much, and by more where the light nearly lies in the
// plane; areas are the region's, so that they add up. Elsewhere its vertices will do.
bool corners_will_do(const EmitTarget& target, std::uint32_t facet) {
  constexpr double flat = 900 * roundoff;
  const double flatness = target.scene.planes()[target.scene.facets()[facet].plane].flatness;
  const double area = target.scene.faces()[target.scene.facets()[facet].face].area;
  return flatness * flatness <= flat * flat * area && !target.tables.grazed[facet];
}

namespace {

// The exact kernel's corners are the true ones, rounded.
double place_exactly(const EmitTarget& target, const Lines& lines, std::uint32_t facet_id,
                     std::span<const ConeCorner> cone, PointCache& points, Vec3* out) {
  const auto count = static_cast<std::uint32_t>(cone.size());
  const bool reversed = target.space.handedness() < 0;
  const auto own = target.scene.corners_of(target.scene.facets()[facet_id]);
  // A corner where two edges of one of the facet's own vertices meet is that vertex.
  const auto vertex = [&](std::uint32_t i) {
    if (cone[i].vertex != none) return cone[i].vertex;
    const std::uint32_t v = lines.shared_vertex(incoming(cone, i), cone[i].edge);
    return std::any_of(own.begin(), own.end(), [v](const Corner& c) { return c.vertex == v; })
               ? v
               : none;
  };
  const auto at = [&](std::uint32_t i) { return lines.point(cone, i, facet_id, points); };
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t i = reversed ? count - 1 - k : k;
    const std::uint32_t v = vertex(i);
    out[k] = v == none ? at(i) : target.scene.vertices()[v];
  }
  const bool will_do = corners_will_do(target, facet_id);
  AreaSum sum(will_do ? out[0] : at(0));
  for (std::uint32_t k = 1; k < count; ++k) sum.add(will_do ? out[k] : at(k));
  return sum.area(normal_of(target, facet_id));
}

}  // namespace

double place_polygon(const EmitTarget& target, const Lines& lines, std::uint32_t facet_id,
                     std::span<const ConeCorner> cone, PointCache& points, Vec3* out) {
  if (lines.is_exact()) return place_exactly(target, lines, facet_id, cone, points, out);
  const std::size_t count = cone.size();
  const bool reversed = target.space.handedness() < 0;
  const Real* q = target.tables.planes[target.scene.facets()[facet_id].plane].q;
  const Vec3* vertices = target.scene.vertices().data();
  const bool will_do = corners_will_do(target, facet_id);
  if (will_do) {
    for (std::size_t k = 0; k < count; ++k) {
      const ConeCorner& c = cone[reversed ? count - 1 - k : k];
      out[k] = c.vertex == none ? target.space.back(c.r, q) : vertices[c.vertex];
    }
    AreaSum sum(out[0]);
    for (std::size_t k = 1; k < count; ++k) sum.add(out[k]);
    // Every corner has a part in it: no point at infinity hides from it.
    if (const double area = sum.area(normal_of(target, facet_id)); std::isfinite(area)) return area;
  }
  const auto at = [&](std::size_t k) {
    return on_plane(target, facet_id, cone[reversed ? count - 1 - k : k].r);
  };
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t v = cone[reversed ? count - 1 - k : k].vertex;
    out[k] = v == none ? at(k) : vertices[v];
  }
  AreaSum sum(will_do ? out[0] : at(0));
  for (std::size_t k = 1; k < count; ++k) sum.add(will_do ? out[k] : at(k));
  return sum.area(normal_of(target, facet_id));
}

void note_constructions(const EmitTarget& target, const Lines& lines,
                        std::span<const ConeCorner> cone, std::size_t first, Block& block) {
  block.constructions.resize(block.corners.size());
  const auto count = static_cast<std::uint32_t>(cone.size());
  const bool reversed = target.space.handedness() < 0;
  for (std::uint32_t k = 0; k < count; ++k) {
    Construction c = lines.construction(cone, reversed ? count - 1 - k : k);
    if (reversed) std::swap(c.in, c.out);
    block.constructions[first + k] = c;
  }
}

double area_of_facet(const EmitTarget& target, std::uint32_t facet_id, bool in_light) {
  const Facet& facet = target.scene.facets()[facet_id];
  const Plane& plane = target.scene.planes()[facet.plane];
  const bool project = in_light && !corners_will_do(target, facet_id);
  const auto corner = [&](const Corner& c) -> Vec3 {
    const Vec3& vertex = target.scene.vertices()[c.vertex];
    if (!project) return vertex;
    if (target.tables.exact)
      return target.tables.exact->point(plane, {&vertex, false, nullptr, nullptr, false, false});
    return on_plane(target, facet_id, target.tables.rays[c.vertex].r);
  };
  const auto corners = target.scene.corners_of(facet);
  AreaSum sum(corner(corners[0]));
  for (const Corner& c : corners.subspan(1)) sum.add(corner(c));
  return sum.area(plane.normal);
}

void emit_cell(const CellTree& tree, std::uint32_t cell, bool merge, const EmitTarget& target,
               Workspace& w, CellOutput& out) {
  CellEmitter(tree, cell, merge, target, w, out).run();
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
