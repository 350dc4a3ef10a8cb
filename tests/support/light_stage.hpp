// A scene as one light sees it, for unit tests of cones and trees: light space, tables, visibility.
#pragma once

#include <algorithm>
#include <vector>

#include "facets/fill_tables.hpp"
#include "svbsp/svbsp_tree.hpp"

namespace shadowcut {

// A light straight above: the cones of horizontal faces look like the faces seen from above.
class LightStage {
 public:
  explicit LightStage(Kernel kernel = Kernel::fast)
      : light_(Light::directional({0, 0, -1})),
        space_(light_, {Vec3(-4, -4, -4), Vec3(4, 4, 4)}),
        visibility_(scene_, space_, tables_, workspaces_),
        exact_(kernel == Kernel::exact) {}

  // An object of one horizontal face at a height; corners x, y, counter-clockwise from above.
  void add_face(double height, const std::vector<Eigen::Vector2d>& corners,
                const ObjectSettings& settings = {}) {
    Mesh mesh;
    std::vector<std::uint32_t> loop;
    for (const Eigen::Vector2d& c : corners) {
      loop.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
      mesh.vertices.emplace_back(c.x(), c.y(), height);
    }
    mesh.add_face(loop);
    add_mesh(mesh, settings);
  }
  void add_mesh(const Mesh& mesh, const ObjectSettings& settings = {}) {
    scene_.add(mesh, settings);
  }
  void add_rectangle(double height, double x0, double y0, double x1, double y1,
                     const ObjectSettings& settings = {}) {
    add_face(height, {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}, settings);
  }
  // After the last face.
  void finish() {
    tables_.refer_to(scene_);
    if (exact_) {
      tables_.exact = std::make_unique<ExactPredicates>(light_, space_);
      for (const Object& object : scene_.objects()) tables_.exact->note_object(scene_, object);
    }
    visibility_.decide_all(light_);
    fill_tables(scene_, space_, visibility_, tables_);
  }

  const Scene& scene() const { return scene_; }
  const LightSpace& space() const { return space_; }
  LightTables& tables() { return tables_; }
  const FacetVisibility& visibility() const { return visibility_; }
  Workspace& workspace() { return workspaces_.local(); }
  Cone* cone(std::uint32_t facet) { return visibility_.cone_of(FacetId(facet), workspace().pool); }

  // A line of light through two points, under a local id.
  LineId add_line(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const Vec3 p(a.x(), a.y(), 0), q(b.x(), b.y(), 0);
    lines_.push_back({space_.line(p, q), 0, {false, {p, q, Vec3::Zero(), Vec3::Zero()}}});
    return LineId(first_local_line + lines_.size() - 1);
  }
  CellPredicates predicates() const { return CellPredicates(tables_, lines_); }
  DividingLine dividing_line(LineId id) const {
    const Line& line = lines_[id.value() - first_local_line].line;
    return {line.n, line.error, id};
  }

  // The corners of a cone on the plane of its facet, sorted by x, then y.
  std::vector<Eigen::Vector2d> corners(const Cone& cone) const {
    std::vector<Eigen::Vector2d> out;
    for (const ConeCorner& c : cone.span()) {
      const Vec3 x = space_.back(c.r, tables_.covector_of(cone.facet).q);
      out.emplace_back(x.x(), x.y());
    }
    std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) {
      return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
    });
    return out;
  }

 private:
  Scene scene_;
  Light light_;
  LightSpace space_;
  PerThread<Workspace> workspaces_;
  LightTables tables_;
  FacetVisibility visibility_;
  bool exact_;
  std::vector<LocalLine> lines_;
};

}  // namespace shadowcut
