#include "facets/fill_tables.hpp"

namespace shadowcut {
namespace {

void set_line(const Scene& scene, const LightSpace& space, std::uint32_t object, std::uint32_t edge,
              LightTables& tables) {
  const Edge& e = scene.edges()[edge];
  const LineId id = tables.lines.of_edge(object, edge);
  const Vec3 &a = scene.vertices()[e.a], &b = scene.vertices()[e.b];
  Line line = space.line(a, b);
  line.a = e.a, line.b = e.b;
  tables.lines.set(id, line);
  if (tables.is_exact()) tables.lines.set_ends(id, a, b);
}

}  // namespace

void fill_tables(const Scene& scene, const LightSpace& space, FacetVisibility& visibility,
                 LightTables& tables) {
  const auto facets = scene.facets();
  std::vector<std::uint8_t> vertex_used(scene.vertices().size(), 0),
      plane_used(scene.planes().size(), 0);
  std::vector<std::uint32_t> object_of_edge(scene.edges().size(), invalid_index);  // of used edges
  for (std::size_t i = 0; i < facets.size(); ++i) {
    if (!visibility.enters(FacetId(i))) continue;
    plane_used[facets[i].plane] = 1;
    for (const Corner& c : scene.corners_of(facets[i])) {
      vertex_used[c.vertex] = 1;
      object_of_edge[c.edge >> 1] = tables.object_of(FacetId(i));
    }
  }
  tables.rays.resize(vertex_used.size());
  tables.planes.resize(plane_used.size());
  tables.lines.reset(object_of_edge.size(), scene.objects().size(), tables.is_exact());
  constexpr std::size_t grain = 4096;
  parallel_for(vertex_used.size(), grain, [&](std::size_t i) {
    if (vertex_used[i]) tables.rays[i] = space.ray(scene.vertices()[i]);
  });
  parallel_for(object_of_edge.size(), grain, [&](std::size_t i) {
    if (object_of_edge[i] != invalid_index)
      set_line(scene, space, object_of_edge[i], static_cast<std::uint32_t>(i), tables);
  });
  parallel_for(plane_used.size(), grain, [&](std::size_t i) {
    if (plane_used[i]) tables.planes[i] = space.plane(scene.planes()[i]);
  });
  if (tables.is_exact()) visibility.check_loops();
}

void fill_tables(const Scene& scene, const LightSpace& space, std::uint32_t o,
                 FacetVisibility& visibility, LightTables& tables) {
  const Object& object = scene.objects()[o];
  const std::uint32_t facets_end = object.first_facet + object.facet_count;
  bool any = false;
  for (std::uint32_t i = object.first_facet; i < facets_end; ++i) {
    if (!visibility.enters(FacetId(i))) continue;
    any = true;
    const std::uint32_t plane = scene.facets()[i].plane;
    tables.planes[plane] = space.plane(scene.planes()[plane]);
  }
  if (!any) return;
  for (std::uint32_t i = 0; i < object.vertex_count; ++i) {
    const std::uint32_t v = object.first_vertex + i;
    tables.rays[v] = space.ray(scene.vertices()[v]);
  }
  for (std::uint32_t i = object.first_edge; i < object.first_edge + object.edge_count; ++i)
    set_line(scene, space, o, i, tables);
  for (std::uint32_t i = object.first_facet; tables.is_exact() && i < facets_end; ++i)
    visibility.check_loop(FacetId(i));
}

void set_exact_kd_lines(const LightSpace& space, LightTables& tables) {
  SHADOWCUT_ASSERT(tables.is_exact());
  LineTable& lines = tables.lines;
  for (std::uint32_t i = lines.first_kd_line(); i < lines.size(); ++i) {
    const LineId id(i);
    const auto [a, b] = space.span({lines[id].n[0], lines[id].n[1], lines[id].n[2]});
    lines.set_ends(id, a, b);
    lines.set(id, space.line(a, b));
    tables.exact->note_position(a);
    tables.exact->note_position(b);
  }
}

}  // namespace shadowcut
