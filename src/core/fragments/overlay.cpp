// A fragment is asked of a finished tree as a face that neither casts nor stays: it is filtered
// down, and where it comes out in front of everything it is lit. Parts that come back in the same
// state are merged again (Slater 1992, figure 6).

#include "fragments/overlay.hpp"

#include <algorithm>
#include <cmath>

#include "svbsp/descend.hpp"

namespace shadowcut {
namespace {

// A part of a polygon, and whether the light reaches it.
struct Answer {
  Cone* cone;
  bool lit;
};

class LightQuery {
 public:
  LightQuery(const LightView& light, Workspace& w) : light_(light), w_(w) {}

  // The parts of a polygon in the facet's plane, its corners in the order in which its lines are
  // positive inside. A part's corner that is a corner of the polygon has that corner's index for a
  // vertex. The cones are the caller's to give back.
  void run(FacetId facet, std::span<const Vec3> polygon, std::vector<Answer>& answers) {
    answers.clear();
    answers_ = &answers;
    lines_.clear();
    if (Cone* cone = make_cone(facet, polygon)) {
      Visitor visitor(*this, nullptr);
      descend(light_.grid.kd_tree(), cone, Place::root(), 0, w_, visitor);
    }
    SHADOWCUT_ASSERT(cuts_.empty());
  }

 private:
  // A cone cut in two, and where its parts' answers begin. Both parts have been answered when
  // nothing is pending above `bottom`.
  struct Cut {
    Cone* whole;
    std::size_t first_answer, bottom;
  };

  // The polygon's way down the k-d tree, where `tree` is null, or down a cell's tree.
  struct Visitor : DescentVisitor {
    static constexpr std::uint32_t first_side = 1;  // the order of the partition's fragments
    LightQuery& query;
    const SvbspTree* tree;
    Visitor(LightQuery& q, const SvbspTree* t) : query(q), tree(t) {}
    CellPredicates cell_predicates() const { return query.predicates(); }
    LineId name_of_cut(const DividingLine& line) {
      return query.add_line(tree ? tree->line(line.id)
                                 : query.light_.context.tables.lines[line.id]);
    }
    void was_cut(Cone* cone, Workspace&) { query.was_cut(cone); }
    bool stops_at(Place, Branch here, std::uint32_t&) const { return here.is_out(); }
    bool stops_at(Place, KdTree::Branch here, std::uint32_t&) const { return here.is_cell(); }
    void arrive(Cone* cone, Place place) {
      if (tree) return query.answer(cone, true);
      const CellGrid& grid = query.light_.grid;
      const SvbspTree& cell = grid[grid.kd_tree().branch(place).cell()];
      Visitor visitor(query, &cell);
      descend(cell, cone, Place::root(), 0, query.w_, visitor);
    }
    Cone* pass_pp_node(Cone* cone, NodeId pp) { return query.pass_pp_node(cone, *tree, pp); }
  };

  // A polygon's corners are rounded, so there is nothing to be exact about: the filter alone
  // decides, whatever the kernel.
  CellPredicates predicates() const { return {light_.context.tables, lines_, nullptr}; }
  LineId add_line(const Line& line) {
    lines_.push_back({line, 0, {}});
    SHADOWCUT_ASSERT(!lines_.empty());
    return LineId(first_local_line + lines_.size() - 1);
  }

  Cone* make_cone(FacetId facet, std::span<const Vec3> polygon) {
    const LightSpace& space = light_.context.space;
    Cone* cone = w_.pool.take(static_cast<std::uint32_t>(polygon.size()) + 1);
    cone->count = 0;
    cone->facet = facet;
    cone->error = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      if (a == b) continue;
      const Line l = space.line(a, b);
      if (!std::isfinite(l.n[0]) || !std::isfinite(l.n[1]) || !std::isfinite(l.n[2])) continue;
      const VertexRay ray = space.ray(a);
      const EdgeRef edge(add_line(l), false);
      cone->corners()[cone->count++] = {
          {ray.r[0], ray.r[1], ray.r[2]}, edge, static_cast<std::uint32_t>(i)};
      cone->error = std::max(cone->error, ray.error);
    }
    if (cone->count >= 3) return cone;
    w_.pool.give_back(cone);
    return nullptr;
  }

  // In front of the plane, or touching it, a cone goes on: coplanar faces do not shadow each other,
  // and what shadows one of them is in front of both.
  Cone* pass_pp_node(Cone* cone, const SvbspTree& tree, NodeId pp) {
    const LightTables& tables = light_.context.tables;
    const std::uint32_t own = tables.plane_index(cone->facet);
    if (tables.plane_index(tree.owner_facet(pp)) == own) return cone;
    const Node& node = tree.node(pp);
    const PlaneDifference nearer(tables.planes[own], node.n, node.error);
    const CornerSides sides(*cone, nearer.d, nearer.bound(*cone), w_.spill);
    if (sides.positive() && sides.negative()) {
      const Line line = nearer.line();
      const LineId id = add_line(line);
      Cone *front, *behind;
      split(*cone, sides, {line.n, line.error, id}, true, predicates(), w_.pool, front, behind);
      was_cut(cone);
      answers_->push_back({behind, false});
      return front;
    }
    if (!sides.negative()) return cone;
    answer(cone, false);
    return nullptr;
  }

  void was_cut(Cone* whole) { cuts_.push_back({whole, answers_->size(), w_.pending.size()}); }

  // A part has been answered; so may be the cones that it was cut from.
  void answer(Cone* cone, bool lit) {
    answers_->push_back({cone, lit});
    SHADOWCUT_ASSERT(cuts_.empty() || cuts_.back().bottom <= w_.pending.size());
    while (!cuts_.empty() && cuts_.back().bottom == w_.pending.size()) {
      const Cut cut = cuts_.back();
      cuts_.pop_back();
      merge(cut);
    }
  }

  // A cone whose two parts are in one state is answered whole.
  void merge(const Cut& cut) {
    std::vector<Answer>& answers = *answers_;
    SHADOWCUT_ASSERT(answers.size() >= cut.first_answer + 2);
    if (answers.size() != cut.first_answer + 2 ||
        answers[cut.first_answer].lit != answers[cut.first_answer + 1].lit)
      return w_.pool.give_back(cut.whole);
    SHADOWCUT_ASSERT(answers.back().cone->facet == cut.whole->facet);
    const bool lit = answers.back().lit;
    w_.pool.give_back(answers[cut.first_answer].cone);
    w_.pool.give_back(answers[cut.first_answer + 1].cone);
    answers.resize(cut.first_answer);
    answers.push_back({cut.whole, lit});
  }

  const LightView& light_;
  Workspace& w_;
  std::vector<Answer>* answers_ = nullptr;
  // Lines of the polygon's edges, then of its cuts: one polygon may meet several cells, whose ids
  // overlap.
  std::vector<LocalLine> lines_;
  std::vector<Cut> cuts_;
};

// Fragments of one or more lights so far, and their corners. front_order: whether the corners run
// counter-clockwise seen from the facet's front.
struct Partition {
  LightPartition sets;
  std::vector<std::uint8_t> front_order;

  void add(std::uint32_t face, std::uint32_t facet, std::span<const std::uint64_t> lights,
           bool front) {
    sets.fragments.push_back({face, facet, static_cast<std::uint32_t>(sets.corners.size()), 0});
    sets.lights.insert(sets.lights.end(), lights.begin(), lights.end());
    front_order.push_back(front);
  }
  void corner(const Vec3& x) {
    sets.corners.push_back(x);
    ++sets.fragments.back().corner_count;
  }
  void append(const Partition& other) {
    const auto offset = static_cast<std::uint32_t>(sets.corners.size());
    for (LightPartition::Fragment f : other.sets.fragments) {
      f.first_corner += offset;
      sets.fragments.push_back(f);
    }
    const auto add_all = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    add_all(sets.corners, other.sets.corners);
    add_all(sets.lights, other.sets.lights);
    add_all(front_order, other.front_order);
  }
};

Partition first_partition(const LightView& light, std::size_t number, std::size_t words,
                          const std::vector<bool>* faces) {
  const FacetVisibility& visibility = light.context.visibility;
  Partition out;
  out.sets.words = words;
  std::vector<std::uint64_t> set(words);
  for (const Block& block : light.shadows.blocks) {
    for (const Fragment& f : block.fragments) {
      if (faces && !(*faces)[f.face]) continue;
      set[number / 64] = f.lit ? std::uint64_t{1} << (number % 64) : 0;
      const FacetId facet(f.facet);
      const bool front =
          visibility.facing(facet) != Facing::toward || visibility.front_faces_light(facet);
      out.add(f.face, f.facet, set, front);
      for (const Vec3& x : block.corners_of(f)) out.corner(x);
    }
  }
  return out;
}

// Fragment i of `in`, cut by a further light.
void cut_by(const LightView& light, std::size_t number, const Partition& in, std::size_t i,
            LightQuery& query, std::vector<Answer>& answers, Workspace& w, Partition& out) {
  const EmissionContext& context = light.context;
  const LightPartition::Fragment& f = in.sets.fragments[i];
  const FacetId facet(f.facet);
  const std::span<const std::uint64_t> before(in.sets.lights.data() + i * in.sets.words,
                                              in.sets.words);
  const auto given = in.sets.corners_of(f);
  if (context.visibility.facing(facet) == Facing::toward) {
    std::vector<Vec3> corners(given.begin(), given.end());
    const bool flip = context.visibility.forward(facet) != static_cast<bool>(in.front_order[i]);
    if (flip) std::reverse(corners.begin(), corners.end());
    query.run(facet, corners, answers);
    std::vector<std::uint64_t> set(before.begin(), before.end());
    for (const Answer& a : answers) {
      set[number / 64] = before[number / 64] | (a.lit ? std::uint64_t{1} << (number % 64) : 0);
      out.add(f.face, f.facet, set, in.front_order[i]);
      for (std::uint32_t k = 0; k < a.cone->count; ++k) {
        const ConeCorner& c = a.cone->corners()[flip ? a.cone->count - 1 - k : k];
        out.corner(c.vertex != invalid_index
                       ? corners[c.vertex]
                       : context.space.back(c.r, context.tables.covector_of(facet).q));
      }
      w.pool.give_back(a.cone);
    }
    if (!answers.empty()) return;
  }
  out.add(f.face, f.facet, before, in.front_order[i]);
  for (const Vec3& x : given) out.corner(x);
}

// All fragments, cut by a further light. Chunks of a fixed size keep the order the same for any
// number of threads.
Partition cut_all_by(const LightView& light, std::size_t number, const Partition& in) {
  constexpr std::size_t chunk = 1024;
  const std::size_t count = in.sets.fragments.size();
  std::vector<Partition> parts((count + chunk - 1) / chunk);
  PerThread<Workspace> workspaces;
  parallel_for(parts.size(), 1, [&](std::size_t c) {
    Workspace& w = workspaces.local();
    LightQuery query(light, w);
    std::vector<Answer> answers;
    for (std::size_t i = c * chunk; i < std::min(count, (c + 1) * chunk); ++i)
      cut_by(light, number, in, i, query, answers, w, parts[c]);
  });
  Partition out;
  out.sets.words = in.sets.words;
  for (const Partition& p : parts) out.append(p);
  return out;
}

}  // namespace

LightPartition overlay(const std::vector<const LightView*>& lights,
                       const std::vector<bool>* faces) {
  const auto first = std::find_if(lights.begin(), lights.end(),
                                  [](const LightView* light) { return light != nullptr; });
  if (first == lights.end()) return {};
  const auto first_number = static_cast<std::size_t>(first - lights.begin());
  Partition partition = first_partition(**first, first_number, (lights.size() + 63) / 64, faces);
  for (std::size_t number = first_number + 1; number < lights.size(); ++number) {
    if (lights[number]) partition = cut_all_by(*lights[number], number, partition);
  }
  return std::move(partition.sets);
}

}  // namespace shadowcut
