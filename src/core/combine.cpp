// Several lights: one partition for all of them (CS95, section 4). A fragment is asked of a
// finished tree as a face that neither casts nor stays: it is filtered down, and where it comes out
// in front of everything it is lit. Parts that come back in the same state are reunited (Slater
// 1992, figure 6).

#include <algorithm>
#include <optional>

#include "light_tree.hpp"

namespace shadowcut::SHADOWCUT_NUMBERS {
namespace {

struct Answer {
  Cone* cone;
  bool lit;
};

class Query {
 public:
  Query(const LightTree& light, Workspace& w) : light_(light), w_(w) {}

  // The parts of a polygon in the facet's plane, its corners in the order in which its lines are
  // positive inside. A part's corner that is one of the polygon's has its index for a vertex. The
  // cones are the caller's to give back.
  void run(std::uint32_t facet, std::span<const Vec3> polygon, std::vector<Answer>& answers) {
    answers.clear();
    lines_.clear();
    Cone* cone = make_cone(facet, polygon);
    if (!cone) return;
    frames_.push_back({cone, none, light_.prefix().root().bits, 0, false});
    while (!frames_.empty()) {
      const Frame frame = frames_.back();
      frames_.pop_back();
      if (frame.split) {
        reunite(frame, answers);
      } else {
        descend(frame, answers);
      }
    }
  }

 private:
  struct Frame {
    Cone* cone;
    std::uint32_t cell;   // none: still in the prefix
    std::uint32_t place;  // in the cell's tree, or a prefix branch
    std::size_t first_answer;
    bool split;  // its parts have been answered from first_answer on
  };

  // A polygon's corners are rounded, so there is nothing to be exact about: the numbers' word
  // stands, whatever the kernel.
  Lines lines() const { return Lines(light_.tables(), lines_, nullptr); }
  std::uint32_t add_line(const Line& line) {
    lines_.push_back({line, 0, {}});
    return first_local_line + static_cast<std::uint32_t>(lines_.size() - 1);
  }

  Cone* make_cone(std::uint32_t facet, std::span<const Vec3> polygon) {
    Cone* cone = w_.pool.take(static_cast<std::uint32_t>(polygon.size()) + 1);
    cone->count = 0;
    cone->facet = facet;
    cone->error = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      if (a == b) continue;
      const Line l = rounded(light_.space().line(a, b));
      if (!std::isfinite(l.n[0]) || !std::isfinite(l.n[1]) || !std::isfinite(l.n[2])) continue;
      const VertexRay ray = rounded(light_.space().ray(a));
      const EdgeRef edge(add_line(l), false);
      cone->corners()[cone->count++] = {
          {ray.r[0], ray.r[1], ray.r[2]}, edge, static_cast<std::uint32_t>(i)};
      cone->error = std::max(cone->error, ray.error);
    }
    if (cone->count >= 3) return cone;
    w_.pool.give_back(cone);
    return nullptr;
  }

  // Follows a cone until it is answered or cut in two.
  void descend(Frame frame, std::vector<Answer>& answers) {
    Cone& cone = *frame.cone;
    const PlaneRay& own = light_.tables().planes[light_.tables().facets[cone.facet].plane];
    for (;;) {
      std::uint32_t sides[2];
      std::optional<PlaneDifference> nearer;  // at a PP-node
      Line line{};                            // elsewhere
      if (frame.cell == none) {
        const Prefix::Branch here{frame.place};
        if (here.is_cell()) {
          frame.cell = here.index();
          frame.place = root_place;
          continue;
        }
        const Prefix::Node& node = light_.prefix().nodes()[here.index()];
        line = light_.tables().lines[node.line];
        sides[0] = node.side[0].bits, sides[1] = node.side[1].bits;
      } else {
        const CellTree& tree = light_.cells()[frame.cell];
        const Child here = tree.child_at(frame.place);
        if (here.is_out()) return answers.push_back({&cone, true});
        const Node& node = tree.nodes()[here.node()];
        sides[0] = here.node() * 2, sides[1] = here.node() * 2 + 1;
        if (here.is_sp()) {
          line = tree.line(node.id);
        } else if (light_.tables().facets[tree.pieces()[node.id].facet].plane ==
                   light_.tables().facets[cone.facet].plane) {
          frame.place = sides[0];
          continue;
        } else {
          nearer.emplace(own, node.n, node.error);
        }
      }
      const double bound =
          nearer ? nearer->bound(cone)
                 : static_cast<double>(line.error) + static_cast<double>(cone.error) + sign_slack;
      const Signs signs(cone, nearer ? nearer->d : line.n, bound, w_.spill);
      if (signs.positive() && signs.negative()) {
        if (nearer) line = nearer->line();
        const std::uint32_t id = add_line(line);
        Cone *positive, *negative;
        split(cone, signs, line.n, line.error, id, true, lines(), w_.pool, positive, negative);
        frames_.push_back({frame.cone, frame.cell, frame.place, answers.size(), true});
        frames_.push_back({positive, frame.cell, sides[0], 0, false});
        if (nearer) {
          answers.push_back({negative, false});
        } else {
          frames_.push_back({negative, frame.cell, sides[1], 0, false});
        }
        return;
      }
      if (nearer && signs.negative()) return answers.push_back({&cone, false});
      // In front, or touching: coplanar faces do not shadow each other, and neither can shadow what
      // is in front of both.
      frame.place = sides[!nearer && signs.negative() ? 1 : 0];
    }
  }

  void reunite(const Frame& frame, std::vector<Answer>& answers) {
    if (answers.size() != frame.first_answer + 2 ||
        answers[frame.first_answer].lit != answers[frame.first_answer + 1].lit) {
      return w_.pool.give_back(frame.cone);
    }
    const bool lit = answers.back().lit;
    w_.pool.give_back(answers[frame.first_answer].cone);
    w_.pool.give_back(answers[frame.first_answer + 1].cone);
    answers.resize(frame.first_answer);
    answers.push_back({frame.cone, lit});
  }

  const LightTree& light_;
  Workspace& w_;
  // of the polygon's edges, then of its cuts: one polygon may meet several cells, whose ids overlap
  std::vector<LocalLine> lines_;
  std::vector<Frame> frames_;
};

// Fragments of one or more lights so far, and their corners; front_order: whether corners run
// counter-clockwise seen from the facet's front.
struct Partition {
  LightSets sets;
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
    for (LightSets::Fragment f : other.sets.fragments) {
      f.first_corner += offset;
      sets.fragments.push_back(f);
    }
    sets.corners.insert(sets.corners.end(), other.sets.corners.begin(), other.sets.corners.end());
    sets.lights.insert(sets.lights.end(), other.sets.lights.begin(), other.sets.lights.end());
    front_order.insert(front_order.end(), other.front_order.begin(), other.front_order.end());
  }
};

Partition first_partition(const LightTree& light, std::size_t number, std::size_t words,
                          const std::vector<bool>* faces) {
  Partition out;
  out.sets.words = words;
  std::vector<std::uint64_t> set(words);
  for (const Block& block : light.shadows().blocks) {
    for (const Fragment& f : block.fragments) {
      if (faces && !(*faces)[f.face]) continue;
      set[number / 64] = f.lit ? std::uint64_t{1} << (number % 64) : 0;
      const bool front = light.facing(f.facet) == Facing::toward ? light.front_lit(f.facet) : true;
      out.add(f.face, f.facet, set, front);
      for (const Vec3& x : block.corners_of(f)) out.corner(x);
    }
  }
  return out;
}

// Fragment i of `in`, cut by a further light.
void cut_by(const LightTree& light, std::size_t number, const Partition& in, std::size_t i,
            Query& query, std::vector<Answer>& answers, Workspace& w, Partition& out) {
  const LightSets::Fragment& f = in.sets.fragments[i];
  const std::span<const std::uint64_t> before(in.sets.lights.data() + i * in.sets.words,
                                              in.sets.words);
  std::vector<Vec3> corners(in.sets.corners_of(f).begin(), in.sets.corners_of(f).end());
  if (light.facing(f.facet) == Facing::toward) {
    const bool flip = light.forward(f.facet) != static_cast<bool>(in.front_order[i]);
    if (flip) std::reverse(corners.begin(), corners.end());
    query.run(f.facet, corners, answers);
    if (!answers.empty()) {
      std::vector<std::uint64_t> set(before.begin(), before.end());
      const PlaneRay& q = light.tables().planes[light.tables().facets[f.facet].plane];
      for (const Answer& a : answers) {
        set[number / 64] = before[number / 64] | (a.lit ? std::uint64_t{1} << (number % 64) : 0);
        out.add(f.face, f.facet, set, in.front_order[i]);
        for (std::uint32_t k = 0; k < a.cone->count; ++k) {
          const std::uint32_t j = flip ? a.cone->count - 1 - k : k;
          const ConeCorner& c = a.cone->corners()[j];
          out.corner(c.vertex != none ? corners[c.vertex] : light.space().back(c.r, q.q));
        }
        w.pool.give_back(a.cone);
      }
      return;
    }
    std::copy(in.sets.corners_of(f).begin(), in.sets.corners_of(f).end(), corners.begin());
  }
  out.add(f.face, f.facet, before, in.front_order[i]);
  for (const Vec3& x : corners) out.corner(x);
}

}  // namespace

LightSets combine(const std::vector<const LightShadows*>& all, const std::vector<bool>* faces) {
  std::vector<const LightTree*> lights;
  for (const LightShadows* light : all) lights.push_back(static_cast<const LightTree*>(light));
  const auto first =
      std::find_if(lights.begin(), lights.end(), [](const LightTree* t) { return t != nullptr; });
  if (first == lights.end()) return {};
  const auto first_number = static_cast<std::size_t>(first - lights.begin());
  Partition partition = first_partition(**first, first_number, (lights.size() + 63) / 64, faces);
  for (std::size_t number = first_number + 1; number < lights.size(); ++number) {
    if (!lights[number]) continue;
    // Chunks of a fixed size keep the order the same for any number of threads.
    constexpr std::size_t chunk = 1024;
    const std::size_t count = partition.sets.fragments.size();
    std::vector<Partition> parts((count + chunk - 1) / chunk);
    PerThread<Workspace> workspaces;
    parallel_for(parts.size(), 1, [&](std::size_t c) {
      Workspace& w = workspaces.local();
      Query query(*lights[number], w);
      std::vector<Answer> answers;
      for (std::size_t i = c * chunk; i < std::min(count, (c + 1) * chunk); ++i) {
        cut_by(*lights[number], number, partition, i, query, answers, w, parts[c]);
      }
    });
    Partition next;
    next.sets.words = partition.sets.words;
    for (const Partition& p : parts) next.append(p);
    partition = std::move(next);
  }
  return std::move(partition.sets);
}

}  // namespace shadowcut::SHADOWCUT_NUMBERS
