// Shadow volumes with fewer polygons: H. Batagelo, I. Costa Junior, "Real-time shadow generation
// using BSP trees and stencil buffers", SIBGRAPI 1999, sections 5 to 7. The scene's BSP tree gives
// the polygons that face the light front to back; one that lies wholly in the shadow of those
// before it, by an SVBSP tree, casts none; of the others only edges that no two share are
// silhouettes and get sides; and where the near plane cuts volumes, caps close them, so that what
// passes the depth test is counted right wherever the camera is.
//
// Departures. Section 6 notes that the BSP's cuts leave T-vertices, which make silhouettes of edges
// that are none, and that this can be mended beforehand: here corners on one line are gathered and
// put into every edge that passes them. A cap is the near plane's window cut by the volume's
// planes, and not its clipped edges' ends sorted around; it is the same polygon. Sides end at
// infinity, so that capping needs no far plane.
#include <algorithm>
#include <array>
#include <boost/functional/hash.hpp>
#include <chrono>
#include <cmath>
#include <unordered_map>

#include "casters.hpp"
#include "lighting.hpp"
#include "scene/scene_access.hpp"
#include "scene_bsp.hpp"
#include "shadow_volumes.hpp"
#include "technique.hpp"
#include "volume_buffer.hpp"

namespace shadowcut::render {
namespace {

using Clock = std::chrono::steady_clock;
using compare::Carrier;
using compare::HalfSpace;
using compare::Lighting;
using compare::Polygon;

// The BSP tree, and its polygons as lists of vertices with no T-vertices among them.
class Prepared {
 public:
  explicit Prepared(const Scene& scene)
      : scene_(scene), tolerance_(compare::tolerance_of(scene)), bsp_(scene, 8, tolerance_) {
    for (const Polygon& polygon : bsp_.polygons()) {
      first_corners_.push_back(corners_.size());
      for (const compare::PolygonCorner& corner : polygon.corners)
        corners_.push_back(vertex_at(corner.at));
    }
    collect_lines();
    for (std::uint32_t i = 0; i < bsp_.polygons().size(); ++i) loops_.push_back(loop_of(i));
  }

  const compare::SceneBsp& bsp() const { return bsp_; }
  const std::vector<std::uint32_t>& loop(std::uint32_t polygon) const { return loops_[polygon]; }
  const Vec3& vertex(std::uint32_t i) const { return vertices_[i]; }
  std::size_t vertex_count() const { return vertices_.size(); }

 private:
  // What an edge lies on: an edge of the scene, or where a facet meets the plane that cut it.
  using LineKey = std::array<std::uint32_t, 3>;
  LineKey key_of(const Polygon& polygon, Carrier carrier) const {
    const Facet& facet = scene_.facets()[polygon.facet];
    if (carrier.kind == Carrier::Kind::edge)
      return {0, scene_.corners_of(facet)[carrier.index].edge >> 1, 0};
    return {1, polygon.facet, carrier.index};
  }

  struct OnLine {
    double along;
    std::uint32_t vertex;
  };
  struct Line {
    Vec3 from, direction;
    std::vector<OnLine> corners;
  };

  // All corners on a line, in order along it; those nearer to each other than rounding could part
  // them are one vertex.
  void collect_lines() {
    for (std::uint32_t p = 0; p < bsp_.polygons().size(); ++p) {
      const Polygon& polygon = bsp_.polygons()[p];
      for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
        const std::size_t next = i + 1 == polygon.corners.size() ? 0 : i + 1;
        const Vec3 &a = polygon.corners[i].at, &b = polygon.corners[next].at;
        Line& line = lines_
                         .try_emplace(key_of(polygon, polygon.corners[i].edge),
                                      Line{a, (b - a).normalized(), {}})
                         .first->second;
        line.corners.push_back({(a - line.from).dot(line.direction), corner(p, i)});
        line.corners.push_back({(b - line.from).dot(line.direction), corner(p, next)});
      }
    }
    for (auto& [key, line] : lines_) {
      std::sort(line.corners.begin(), line.corners.end(),
                [](const OnLine& a, const OnLine& b) { return a.along < b.along; });
      line.corners.erase(
          std::unique(line.corners.begin(), line.corners.end(),
                      [](const OnLine& a, const OnLine& b) { return a.vertex == b.vertex; }),
          line.corners.end());
    }
  }

  // Corners are looked up on a grid much finer than features and much coarser than rounding.
  std::uint32_t vertex_at(const Vec3& x) {
    const double cell = 4096 * tolerance_;
    const std::array<std::int64_t, 3> place{std::llround(x.x() / cell), std::llround(x.y() / cell),
                                            std::llround(x.z() / cell)};
    for (int k = 0; k < 27; ++k) {
      const auto near =
          places_.find({place[0] + k % 3 - 1, place[1] + k / 3 % 3 - 1, place[2] + k / 9 - 1});
      if (near != places_.end() && (vertices_[near->second] - x).norm() <= cell)
        return near->second;
    }
    places_.emplace(place, static_cast<std::uint32_t>(vertices_.size()));
    vertices_.push_back(x);
    return static_cast<std::uint32_t>(vertices_.size() - 1);
  }

  std::uint32_t corner(std::uint32_t polygon, std::size_t i) const {
    return corners_[first_corners_[polygon] + i];
  }

  std::vector<std::uint32_t> loop_of(std::uint32_t p) const {
    const Polygon& polygon = bsp_.polygons()[p];
    std::vector<std::uint32_t> loop;
    for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
      const std::size_t next = i + 1 == polygon.corners.size() ? 0 : i + 1;
      const Line& line = lines_.at(key_of(polygon, polygon.corners[i].edge));
      const bool forward =
          (polygon.corners[next].at - polygon.corners[i].at).dot(line.direction) > 0;
      append_between(line, corner(p, i), corner(p, next), forward, loop);
    }
    return loop;
  }

  // The vertices of a line from a to b, b left out.
  static void append_between(const Line& line, std::uint32_t a, std::uint32_t b, bool forward,
                             std::vector<std::uint32_t>& loop) {
    const auto place = [&](std::uint32_t v) {
      return std::find_if(line.corners.begin(), line.corners.end(),
                          [&](const OnLine& c) { return c.vertex == v; }) -
             line.corners.begin();
    };
    const std::ptrdiff_t end = place(b);
    for (std::ptrdiff_t i = place(a); i != end; i += forward ? 1 : -1) {
      // an edge no longer than the rounding of its ends
      if (i < 0 || i >= static_cast<std::ptrdiff_t>(line.corners.size())) return;
      loop.push_back(line.corners[static_cast<std::size_t>(i)].vertex);
    }
  }

  const Scene& scene_;
  double tolerance_;
  compare::SceneBsp bsp_;
  std::vector<Vec3> vertices_;
  std::unordered_map<std::array<std::int64_t, 3>, std::uint32_t,
                     boost::hash<std::array<std::int64_t, 3>>>
      places_;
  std::vector<std::size_t> first_corners_;  // of each polygon
  std::vector<std::uint32_t> corners_;      // their vertices
  std::unordered_map<LineKey, Line, boost::hash<LineKey>> lines_;
  std::vector<std::vector<std::uint32_t>> loops_;
};

// Section 6, figure 2: lists of edge ends, in which an edge that comes a second time, the other way
// round, takes the first away.
class Silhouette {
 public:
  explicit Silhouette(std::size_t vertices) : lists_(vertices) {}
  void add(std::span<const std::uint32_t> loop, bool reversed) {
    for (std::size_t k = 0; k < loop.size(); ++k) {
      std::uint32_t i = loop[k], j = loop[k + 1 == loop.size() ? 0 : k + 1];
      if (reversed) std::swap(i, j);
      std::vector<std::uint32_t>& back = lists_[j];
      const auto twin = std::find(back.begin(), back.end(), i);
      if (twin == back.end()) lists_[i].push_back(j);
      else back.erase(twin);
    }
  }
  template <class Visit>
  void each(const Visit& visit) const {
    for (std::uint32_t i = 0; i < lists_.size(); ++i)
      for (const std::uint32_t j : lists_[i]) visit(i, j);
  }

 private:
  std::vector<std::vector<std::uint32_t>> lists_;
};

class Hybrid : public Technique {
 public:
  Hybrid(const Scene& scene, const Model& model) : scene_(scene), model_(model), volumes_(model) {}

  void update() override {
    // lights are not in the BSP
    if (!known_ || !SceneAccess::changed_since(scene_, *known_).empty())
      prepared_ = std::make_unique<Prepared>(scene_);
    known_ = SceneAccess::revision(scene_);
    phases_ = {};
    before_ = after_ = caps_ = 0;
    glFinish();
    clock_ = Clock::now();
  }

  // Their phases A to G, one after the other; a frame's figures are the sums over its lights.
  void add_light(const Frame& frame, std::size_t k) override {
    const Light& light = scene_.lights()[k];
    const Lighting lighting(scene_, light);
    glFinish();
    finish_phase(0);  // what has been drawn since is the scene without its shadows
    find_casters(lighting);
    finish_phase(1);
    make_volumes(lighting);
    finish_phase(2);
    leave_out_hidden(lighting);
    finish_phase(3);
    find_silhouette(light);
    finish_phase(4);
    make_caps(frame, lighting);
    finish_phase(5);
    volumes_.upload();
    volumes_.count_passes(frame);
    model_.add_light(frame, light, scene_.lights().size(), true);
    glDisable(GL_STENCIL_TEST);
    glFinish();
    finish_phase(6);
  }

  Figures figures() const override {
    return {{"A_view_ms", phases_[0]},       {"B_sort_ms", phases_[1]},
            {"C_volumes_ms", phases_[2]},    {"D_svbsp_ms", phases_[3]},
            {"E_silhouette_ms", phases_[4]}, {"F_caps_ms", phases_[5]},
            {"G_draw_ms", phases_[6]},       {"shadow_polygons_before", before_},
            {"shadow_polygons", after_},     {"caps", caps_}};
  }

 private:
  struct VolumeOf {
    std::uint32_t polygon;
    compare::Volume planes;
    HalfSpace behind;  // the polygon's own plane, front away from the light
  };

  void finish_phase(std::size_t phase) {
    const Clock::time_point now = Clock::now();
    phases_[phase] += std::chrono::duration<double, std::milli>(now - clock_).count();
    clock_ = now;
  }

  void find_casters(const Lighting& lighting) {
    casters_.clear();
    node_ends_.assign(1, 0);
    prepared_->bsp().front_to_back(
        [&](const HalfSpace& plane) { return lighting.in_front_of(plane); },
        [&](std::span<const std::uint32_t> node) {
          for (const std::uint32_t i : node) {
            const std::uint32_t facet = prepared_->bsp().polygons()[i].facet;
            if (lighting.casts(facet)) casters_.push_back(i);
          }
          node_ends_.push_back(casters_.size());
        });
  }

  void make_volumes(const Lighting& lighting) {
    volume_of_.clear();
    for (const std::uint32_t i : casters_) {
      const Polygon& polygon = prepared_->bsp().polygons()[i];
      VolumeOf volume{i, {}, {}};
      lighting.shadow_planes(polygon, volume.planes);
      const Plane& plane = scene_.planes()[scene_.facets()[polygon.facet].plane];
      volume.behind = {plane.normal, plane.point};
      if (lighting.in_front_of(volume.behind) > 0) volume.behind.normal = -volume.behind.normal;
      before_ += static_cast<double>(polygon.corners.size());
      volume_of_.push_back(std::move(volume));
    }
  }

  // Polygons of one plane hide nothing from each other.
  void leave_out_hidden(const Lighting& lighting) {
    const auto tree = compare::make_ordered(lighting, {});
    std::vector<compare::Fragment> parts;
    std::vector<std::size_t> kept, of_node;
    for (std::size_t n = 0; n + 1 < node_ends_.size(); ++n) {
      of_node.clear();
      for (std::size_t k = node_ends_[n]; k < node_ends_[n + 1]; ++k) {
        parts.clear();
        tree->cut(prepared_->bsp().polygons()[casters_[k]], parts);
        if (std::any_of(parts.begin(), parts.end(),
                        [](const compare::Fragment& f) { return f.lit; }))
          of_node.push_back(k);
      }
      for (const std::size_t k : of_node) tree->add(prepared_->bsp().polygons()[casters_[k]], true);
      kept.insert(kept.end(), of_node.begin(), of_node.end());
    }
    std::vector<VolumeOf> visible;
    for (const std::size_t k : kept) visible.push_back(std::move(volume_of_[k]));
    volume_of_ = std::move(visible);
  }

  void find_silhouette(const Light& light) {
    Silhouette silhouette(prepared_->vertex_count());
    for (const VolumeOf& volume : volume_of_) {
      const Polygon& polygon = prepared_->bsp().polygons()[volume.polygon];
      const Plane& plane = scene_.planes()[scene_.facets()[polygon.facet].plane];
      silhouette.add(prepared_->loop(volume.polygon),
                     plane.normal.dot(away_from(light, plane.point)) > 0);
    }
    volumes_.clear();
    silhouette.each([&](std::uint32_t a, std::uint32_t b) {
      volumes_.add_side(light, prepared_->vertex(a), prepared_->vertex(b));
      ++after_;
    });
  }

  // The near plane's window, a little larger and nearer, cut by each volume.
  void make_caps(const Frame& frame, const Lighting& lighting) {
    const std::array<Vec3, 4> window = frame.near_window(1.01);
    for (const VolumeOf& volume : volume_of_) {
      Polygon cap;
      for (const Vec3& corner : window)
        cap.corners.push_back({corner, {Carrier::Kind::shadow_plane, 0}});
      bool some = keep_front(cap, volume.behind, lighting.tolerance());
      for (const HalfSpace& plane : volume.planes)
        some = some && keep_front(cap, plane, lighting.tolerance());
      if (!some) continue;
      corners_.clear();
      for (const compare::PolygonCorner& corner : cap.corners) corners_.push_back(corner.at);
      volumes_.add_cap(corners_);
      ++caps_;
    }
  }

  const Scene& scene_;
  const Model& model_;
  VolumeBuffer volumes_;
  std::unique_ptr<Prepared> prepared_;
  std::optional<std::uint64_t> known_;  // revision of the scene that this is of
  std::vector<std::uint32_t> casters_;  // polygons of the BSP, front to back
  std::vector<std::size_t> node_ends_;
  std::vector<VolumeOf> volume_of_;
  std::vector<Vec3> corners_;
  Clock::time_point clock_;
  std::array<double, 7> phases_{};  // milliseconds
  double before_ = 0, after_ = 0, caps_ = 0;
};

}  // namespace

std::unique_ptr<Technique> make_stencil_hybrid(const Scene& scene, const Model& model) {
  return std::make_unique<Hybrid>(scene, model);
}

}  // namespace shadowcut::render
