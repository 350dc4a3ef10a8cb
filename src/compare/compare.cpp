// See compare.hpp. Here: the engine as one of the algorithms, on a scene's own faces or on its
// BSP's polygons.
#include "compare.hpp"

#include <algorithm>

#include "front_to_back.hpp"
#include "lighting.hpp"
#include "scene_bsp.hpp"

namespace shadowcut::compare {
namespace {

// The scene with the BSP's polygons for faces, object by object, and the facet that each was cut
// from.
struct CutScene {
  Scene scene;
  std::vector<std::uint32_t> facet_of;  // by face
};

CutScene cut_by_bsp(const Scene& scene, std::uint32_t candidates) {
  const SceneBsp bsp(scene, candidates, tolerance_of(scene));
  std::vector<Mesh> meshes(scene.objects().size());
  std::vector<std::vector<std::uint32_t>> facets(scene.objects().size());
  for (const Polygon& polygon : bsp.polygons()) {
    const std::uint32_t object = scene.faces()[scene.facets()[polygon.facet].face].object;
    Mesh& mesh = meshes[object];
    std::vector<std::uint32_t> loop;
    for (const PolygonCorner& corner : polygon.corners) {
      loop.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
      mesh.vertices.push_back(corner.at);
    }
    mesh.add_face(loop);
    facets[object].push_back(polygon.facet);
  }
  CutScene cut;
  for (std::size_t o = 0; o < meshes.size(); ++o) {
    const Object& object = scene.objects()[o];
    cut.scene.add(meshes[o], {object.name, Pose::Identity(), object.sides, object.casts_shadows,
                              object.receives_shadows, object.dynamic});
    cut.facet_of.insert(cut.facet_of.end(), facets[o].begin(), facets[o].end());
  }
  return cut;
}

Polygon polygon_of(const Block& block, const shadowcut::Fragment& fragment) {
  Polygon polygon;
  polygon.facet = fragment.facet;
  for (const Vec3& corner : block.corners_of(fragment))
    polygon.corners.push_back({corner, {Carrier::Kind::shadow_plane, 0}});
  return polygon;
}

// Fragments of faces turned to the light, and all areas.
void hand_out(const Shadows& shadows, Result& result) {
  result.areas = shadows.areas;
  for (const Block& block : shadows.blocks)
    for (const shadowcut::Fragment& f : block.fragments)
      if (shadows.areas[f.face].facing == Facing::toward)
        result.fragments.push_back({polygon_of(block, f), f.lit});
}

// The same in terms of the scene that was cut.
void hand_back(const Scene& scene, const CutScene& cut, const Light& light, Result& result) {
  const Lighting lighting(scene, light);
  std::vector<FaceArea> areas(scene.faces().size());
  for (std::uint32_t f = 0; f < areas.size(); ++f)
    areas[f] = {lighting.facing(f), scene.faces()[f].area, 0, 0, 0};
  for (std::uint32_t f = 0; f < result.areas.size(); ++f) {
    FaceArea& area = areas[scene.facets()[cut.facet_of[f]].face];
    area.lit += result.areas[f].lit, area.shadowed += result.areas[f].shadowed;
  }
  result.areas = std::move(areas);
  for (Fragment& f : result.fragments)
    f.polygon.facet = cut.facet_of[cut.scene.facets()[f.polygon.facet].face];
}

std::vector<Result> cast_unordered(const Scene& scene, std::span<const Light> lights,
                                   const Settings& settings) {
  Options options;
  options.kernel = settings.kernel;
  options.form = settings.reunite ? Form::merged : Form::pieces;
  options.threads = 1;
  const Clock::time_point start = Clock::now();
  const CutScene cut = settings.after_bsp ? cut_by_bsp(scene, settings.candidates) : CutScene{};
  const double bsp_ms = ms_since(start);
  const Scene& given = settings.after_bsp ? cut.scene : scene;
  std::vector<Result> results;
  for (const Light& light : lights) {
    Result result;
    const Clock::time_point begin = Clock::now();
    const Shadows shadows = cast_shadows(given, light, options);
    result.shadow_ms = ms_since(begin);
    result.order_ms = settings.after_bsp && results.empty() ? bsp_ms : 0;
    result.faces_after_bsp = shadows.stats.faces;
    result.memory_bytes = shadows.stats.bytes;
    hand_out(shadows, result);
    if (settings.after_bsp) hand_back(scene, cut, light, result);
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace

std::vector<Result> cast(const Scene& scene, std::span<const Light> lights, Algorithm algorithm,
                         const Settings& settings) {
  std::vector<Result> results = algorithm == Algorithm::unordered
                                    ? cast_unordered(scene, lights, settings)
                                    : cast_front_to_back(scene, lights, algorithm, settings);
  for (Result& result : results) {
    result.faces_in = static_cast<std::uint64_t>(
        std::count_if(scene.faces().begin(), scene.faces().end(),
                      [](const Face& face) { return face.facet_count > 0; }));
    for (const Fragment& f : result.fragments)
      ++(f.lit ? result.lit_fragments : result.shadowed_fragments);
    for (const FaceArea& area : result.areas) {
      if (area.facing != Facing::toward) continue;
      result.lit_area += area.lit, result.shadowed_area += area.shadowed;
    }
  }
  return results;
}

const char* name_of(Algorithm algorithm) {
  constexpr const char* names[] = {"brute", "ordered", "tiling", "unordered"};
  return names[static_cast<std::size_t>(algorithm)];
}

}  // namespace shadowcut::compare
