// Everything that all cells of one light share: rays of vertices, lines of edges, planes of faces,
// and the arrays of the scene.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "light_space/light_space.hpp"
#include "predicates/exact_predicates.hpp"
#include "predicates/line_table.hpp"
#include "support/index.hpp"

namespace shadowcut {

// Read-only while cells are built or edited.
struct LightTables {
  LineTable lines;
  std::vector<VertexRay> rays;        // by Scene::vertices(); filled for facets that enter the tree
  std::vector<PlaneCovector> planes;  // by Scene::planes(); likewise
  std::unique_ptr<ExactPredicates> exact;  // exact kernel; otherwise null

  // The scene's arrays; refer_to() again after the scene has grown.
  std::span<const Facet> facets;
  std::span<const Object> objects;
  std::span<const Face> faces;
  std::span<const Vec3> vertices;
  std::span<const Plane> scene_planes;

  void refer_to(const Scene& scene) {
    facets = scene.facets();
    objects = scene.objects();
    faces = scene.faces();
    vertices = scene.vertices();
    scene_planes = scene.planes();
  }
  bool is_exact() const { return exact != nullptr; }
  const Facet& facet(FacetId id) const {
    SHADOWCUT_ASSERT(id.value() < facets.size());
    return facets[id.value()];
  }
  FaceId face_of(FacetId id) const { return FaceId(facet(id).face); }
  std::uint32_t object_of(FacetId id) const { return faces[facet(id).face].object; }
  bool casts(FacetId id) const { return objects[object_of(id)].casts_shadows; }
  std::uint32_t plane_index(FacetId id) const { return facet(id).plane; }
  const PlaneCovector& covector_of(FacetId id) const {
    SHADOWCUT_ASSERT(plane_index(id) < planes.size());
    return planes[plane_index(id)];
  }
  const Plane& plane_of(FacetId id) const { return scene_planes[plane_index(id)]; }
};

}  // namespace shadowcut
