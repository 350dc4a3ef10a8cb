// A fragment is asked of a finished tree as a face that neither casts nor stays: it is filtered down, and where it comes out in front of
// everything it is lit. Parts that come back in the same state are reunited (Slater 1992, figure 6).

#include "combine.hpp"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace shadowcut {
namespace {

// Lines of the polygon asked about have ids above all of the tree's: those of the scene's edges end at 2^29, a cell's own follow.
constexpr std::uint32_t first_query_line = 0x38000000;

struct Answer {
  Cone* cone;
  bool lit;
};

class Query {
 public:
  Query(const LightTree& light, Workspace& w) : light_(light), w_(w) {}

  // The parts of a polygon in the facet's plane, its corners in the order in which its lines are positive inside. A part's corner that is
  // one of the polygon's has its index for a vertex. The cones are the caller's to give back.
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

  const Line& line(std::uint32_t id) const {
    if (id >= first_query_line) return lines_[id - first_query_line];
    if (id < first_local_line) return light_.tables().lines[id];
    return cut_lines_[id - first_local_line];
  }

  Cone* make_cone(std::uint32_t facet, std::span<const Vec3> polygon) {
    Cone* cone = w_.pool.take(static_cast<std::uint32_t>(polygon.size()) + 1);
    cone->count = 0;
    cone->facet = facet;
    cone->error = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      if (a == b) continue;
      const Line l = light_.space().line(a, b);
      if (!std::isfinite(l.n[0]) || !std::isfinite(l.n[1]) || !std::isfinite(l.n[2])) continue;
      const VertexRay ray = light_.space().ray(a);
      const EdgeRef edge(first_query_line + static_cast<std::uint32_t>(lines_.size()), false);
      cone->corners()[cone->count++] = {{ray.r[0], ray.r[1], ray.r[2]}, edge, static_cast<std::uint32_t>(i)};
      cone->error = std::max(cone->error, ray.error);
      lines_.push_back(l);
    }
    cut_lines_.clear();
    if (cone->count >= 3) return cone;
    w_.pool.give_back(cone);
    return nullptr;
  }

  // Follows a cone until it is answered or cut in two.
  void descend(Frame frame, std::vector<Answer>& answers) {
    Cone& cone = *frame.cone;
    const PlaneRay& own = light_.tables().planes[light_.tables().facets[cone.facet].plane];
    for (;;) {
      const double* n;
      double n_error;
      std::uint32_t sides[2], cell[2] = {frame.cell, frame.cell};
      bool is_pp = false;
      double d[3];
      std::uint32_t cut = none;
      Line crossing{};
      if (frame.cell == none) {
        const Prefix::Branch here{frame.place};
        if (here.is_cell()) {
          frame.cell = here.index();
          frame.place = root_place;
          continue;
        }
        const Prefix::Node& node = light_.prefix().nodes()[here.index()];
        n = light_.tables().lines[node.line].n, n_error = 0, cut = node.line;
        sides[0] = node.side[0].bits, sides[1] = node.side[1].bits;
      } else {
        const CellTree& tree = light_.cells()[frame.cell];
        const Child here = tree.child_at(frame.place);
        if (here.is_out()) return answers.push_back({&cone, true});
        const Node& node = tree.nodes()[here.node()];
        sides[0] = here.node() * 2, sides[1] = here.node() * 2 + 1;
        n = node.n, n_error = static_cast<double>(node.error), cut = node.id;
        if (here.is_pp()) {
          is_pp = true;
          const std::uint32_t other = light_.tables().facets[tree.pieces()[node.id].facet].plane;
          if (other == light_.tables().facets[cone.facet].plane) {
            frame.place = sides[0];
            continue;
          }
          for (int i = 0; i < 3; ++i) d[i] = own.q[i] - node.n[i];
          n = d;
          n_error = static_cast<double>(own.error) + static_cast<double>(node.error);
        }
      }
      const double size = is_pp ? std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]) : 1.0;
      const double bound = n_error + size * (static_cast<double>(cone.error) + sign_slack + (is_pp ? 2 * unit_roundoff : 0.0));
      const Signs signs(cone, n, bound, w_.spill);
      if (signs.positive() && signs.negative()) {
        if (is_pp) {
          const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
          crossing = {{n[0] / length, n[1] / length, n[2] / length},
                      static_cast<float>(n_error / length + 2 * unit_roundoff) * (1 + 0x1p-22f),
                      none,
                      none};
        } else if (frame.cell != none) {
          crossing = light_.cells()[frame.cell].line(cut);
        } else {
          crossing = light_.tables().lines[cut];
        }
        // A cell's own lines and the crossings with it are copied: one polygon may meet several cells, whose ids overlap.
        const auto id = first_local_line + static_cast<std::uint32_t>(cut_lines_.size());
        cut_lines_.push_back(crossing);
        Cone *positive, *negative;
        split(
            cone, signs, crossing.n, crossing.error, id, true, light_.tables().rays,
            [this](std::uint32_t i) -> const Line& { return line(i); }, w_.pool, positive, negative);
        frames_.push_back({frame.cone, frame.cell, frame.place, answers.size(), true});
        frames_.push_back({positive, cell[0], sides[0], 0, false});
        if (is_pp) {
          answers.push_back({negative, false});
        } else {
          frames_.push_back({negative, cell[1], sides[1], 0, false});
        }
        return;
      }
      if (is_pp && signs.negative()) return answers.push_back({&cone, false});
      // In front, or touching: coplanar faces do not shadow each other, and neither can shadow what is in front of both.
      frame.place = sides[!is_pp && signs.negative() ? 1 : 0];
    }
  }

  void reunite(const Frame& frame, std::vector<Answer>& answers) {
    if (answers.size() != frame.first_answer + 2 || answers[frame.first_answer].lit != answers[frame.first_answer + 1].lit) {
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
  std::vector<Line> lines_;      // of the polygon's own edges
  std::vector<Line> cut_lines_;  // of the cuts made so far
  std::vector<Frame> frames_;
};

// Fragments of one or more lights so far, and their corners; front_order: whether corners run counter-clockwise seen from the facet's
// front.
struct Partition {
  LightSets sets;
  std::vector<std::uint8_t> front_order;

  void add(std::uint32_t face, std::uint32_t facet, std::span<const std::uint64_t> lights, bool front) {
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

Partition first_partition(const LightTree& light, std::size_t number, std::size_t words) {
  Partition out;
  out.sets.words = words;
  std::vector<std::uint64_t> set(words);
  for (const Block& block : light.shadows().blocks) {
    for (const Fragment& f : block.fragments) {
      set[number / 64] = f.lit ? std::uint64_t{1} << (number % 64) : 0;
      const bool front = light.facing(f.facet) == Facing::toward ? light.front_lit(f.facet) : true;
      out.add(f.face, f.facet, set, front);
      for (const Vec3& x : block.corners_of(f)) out.corner(x);
    }
  }
  return out;
}

// Fragment i of `in`, cut by a further light.
void cut_by(const LightTree& light, std::size_t number, const Partition& in, std::size_t i, Query& query, std::vector<Answer>& answers,
            Workspace& w, Partition& out) {
  const LightSets::Fragment& f = in.sets.fragments[i];
  const std::span<const std::uint64_t> before(in.sets.lights.data() + i * in.sets.words, in.sets.words);
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

LightSets combine(const std::vector<const LightTree*>& lights) {
  const auto first = std::find_if(lights.begin(), lights.end(), [](const LightTree* t) { return t != nullptr; });
  if (first == lights.end()) return {};
  const auto first_number = static_cast<std::size_t>(first - lights.begin());
  Partition partition = first_partition(**first, first_number, (lights.size() + 63) / 64);
  for (std::size_t number = first_number + 1; number < lights.size(); ++number) {
    if (!lights[number]) continue;
    // Chunks of a fixed size keep the order the same for any number of threads.
    constexpr std::size_t chunk = 1024;
    const std::size_t count = partition.sets.fragments.size();
    std::vector<Partition> parts((count + chunk - 1) / chunk);
    tbb::enumerable_thread_specific<Workspace> workspaces;
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t c) {
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

}  // namespace shadowcut
