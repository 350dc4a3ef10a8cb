// Meshes and scenes of c.h.
#include <limits>

#include "handles.hpp"
#include "scene/scene_access.hpp"

namespace shadowcut::c {

const Scene& value_of(const shadowcut_scene* scene) {
  require_pointers(scene);
  return *scene->scene;
}

Light light_of(const shadowcut_light* light) {
  require_size(light);
  Light out;
  out.kind = enum_of(light->kind, Light::Kind::directional);
  out.position = Vec3(light->position), out.direction = Vec3(light->direction);
  if (light->name) out.name = light->name;
  out.range = light->range;
  if (flag(light->has_spot)) out.spot = Light::Spot{Vec3(light->spot_axis), light->spot_half_angle};
  return out;
}

namespace {

Mesh& change(shadowcut_mesh* mesh) {
  require_pointers(mesh);
  require(mesh->whole, "the mesh ran out of memory: it can only be destroyed");
  return mesh->mesh;
}
const Mesh& value_of(const shadowcut_mesh* mesh) {
  require_pointers(mesh);
  require(mesh->whole, "the mesh ran out of memory: it can only be destroyed");
  return mesh->mesh;
}

Scene& change(shadowcut_scene* scene) {
  require_pointers(scene);
  require(scene->own != nullptr, "an engine's scene can only be read");
  return *scene->own;
}

// Changes a mesh, which is no good any more if memory runs out on the way.
template <class Body>
shadowcut_status changed(shadowcut_mesh* mesh, const Body& body) noexcept {
  return guarded([&] {
    Mesh& m = change(mesh);
    try {
      body(m);
    } catch (const std::bad_alloc&) {
      mesh->whole = false;
      throw;
    }
  });
}

template <class Number>
std::vector<Vec3> points_of(const Number* xyz, std::int32_t count) {
  const std::span<const Number> numbers = span_of(xyz, std::int64_t{count} * 3);
  std::vector<Vec3> points;
  points.reserve(numbers.size() / 3);
  for (std::size_t i = 0; i + 2 < numbers.size(); i += 3)
    points.emplace_back(static_cast<double>(numbers[i]), static_cast<double>(numbers[i + 1]),
                        static_cast<double>(numbers[i + 2]));
  return points;
}

using Rows = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

Pose pose_of(const double* rows) {
  require_pointers(rows);
  const Eigen::Map<const Rows> m(rows);
  if (m(3, 0) != 0 || m(3, 1) != 0 || m(3, 2) != 0 || m(3, 3) != 1)
    fail(SHADOWCUT_REFUSED, "the last row of a pose is not 0 0 0 1");
  Pose pose;
  pose.matrix() = m;
  return pose;
}
void copy(const Pose& pose, double* rows) {
  Eigen::Map<Rows> out(rows);
  out = pose.matrix();
}

ObjectId id_of(const shadowcut_object_id* id) {
  require_pointers(id);
  return {id->index, id->generation, id->scene};
}
LightId id_of(const shadowcut_light_id* id) {
  require_pointers(id);
  return {id->index, id->generation, id->scene};
}

template <class Id, class Out>
void copy_id(const Id& id, Out* out) {
  *out = {id.index, id.generation, id.scene};
}
template <class Id, class Out>
void copy_found(const Id& id, const char* missing, Out* out) {
  if (id.index == invalid_index) fail(SHADOWCUT_NOT_FOUND, missing);
  copy_id(id, out);
}

void expect(Status status) {
  if (status == Status::stale)
    fail(SHADOWCUT_STALE, "the object or light of the id has been removed");
  if (status == Status::foreign)
    fail(SHADOWCUT_FOREIGN, "the id belongs to another scene, or to no scene");
}

ObjectSettings settings_of(const shadowcut_object_settings* settings) {
  if (!settings) return {};
  require_size(settings);
  ObjectSettings out;
  if (settings->name) out.name = settings->name;
  out.pose = pose_of(settings->pose);
  out.sides = enum_of(settings->sides, Sides::open);
  out.casts_shadows = flag(settings->casts_shadows),
  out.receives_shadows = flag(settings->receives_shadows), out.dynamic = flag(settings->dynamic);
  return out;
}

}  // namespace
}  // namespace shadowcut::c

using namespace shadowcut;
using namespace shadowcut::c;

shadowcut_status shadowcut_mesh_create(shadowcut_mesh** mesh) {
  return guarded([&] {
    require_pointers(mesh);
    *mesh = new shadowcut_mesh;
  });
}
void shadowcut_mesh_destroy(shadowcut_mesh* mesh) { delete mesh; }

shadowcut_status shadowcut_mesh_set_vertices(shadowcut_mesh* mesh, const double* xyz,
                                             int32_t vertex_count) {
  return guarded([&] { change(mesh).vertices = points_of(xyz, vertex_count); });
}
shadowcut_status shadowcut_mesh_set_vertices_float(shadowcut_mesh* mesh, const float* xyz,
                                                   int32_t vertex_count) {
  return guarded([&] { change(mesh).vertices = points_of(xyz, vertex_count); });
}

shadowcut_status shadowcut_mesh_add_face(shadowcut_mesh* mesh, const uint32_t* corners,
                                         int32_t corner_count) {
  return changed(mesh, [&](Mesh& m) { m.add_face(span_of(corners, corner_count)); });
}
shadowcut_status shadowcut_mesh_add_hole(shadowcut_mesh* mesh, const uint32_t* corners,
                                         int32_t corner_count) {
  return changed(mesh, [&](Mesh& m) { m.add_hole(span_of(corners, corner_count)); });
}

shadowcut_status shadowcut_mesh_add_faces(shadowcut_mesh* mesh, const uint32_t* corners,
                                          const int32_t* corner_counts, int32_t face_count) {
  return changed(mesh, [&](Mesh& m) {
    require(face_count >= 0, "a count is negative");
    std::int64_t all = std::int64_t{face_count} * 3;
    if (corner_counts) {
      all = 0;
      for (const std::int32_t n : span_of(corner_counts, face_count)) {
        require(n >= 0, "a count is negative");
        all += n;
      }
    }
    std::span<const std::uint32_t> left = span_of(corners, all);
    for (std::int32_t f = 0; f < face_count; ++f) {
      const auto n = static_cast<std::size_t>(corner_counts ? corner_counts[f] : 3);
      m.add_face(left.first(n));
      left = left.subspan(n);
    }
  });
}

shadowcut_status shadowcut_mesh_vertices(const shadowcut_mesh* mesh, const double** xyz,
                                         uint32_t* vertex_count) {
  return guarded([&] {
    require_pointers(xyz, vertex_count);
    const Mesh& m = value_of(mesh);
    *vertex_count = count_of(m.vertices.size());
    *xyz = numbers_of(m.vertices);
  });
}
shadowcut_status shadowcut_mesh_face_count(const shadowcut_mesh* mesh, uint32_t* face_count) {
  return guarded([&] {
    require_pointers(face_count);
    *face_count = count_of(value_of(mesh).face_count());
  });
}
shadowcut_status shadowcut_mesh_loop_count(const shadowcut_mesh* mesh, uint32_t face,
                                           uint32_t* loop_count) {
  return guarded([&] {
    require_pointers(loop_count);
    require(face < value_of(mesh).face_count(), "there is no such face");
    *loop_count = count_of(mesh->mesh.loop_count(face));
  });
}
shadowcut_status shadowcut_mesh_loop(const shadowcut_mesh* mesh, uint32_t face, uint32_t loop,
                                     const uint32_t** corners, uint32_t* corner_count) {
  return guarded([&] {
    require_pointers(corners, corner_count);
    require(face < value_of(mesh).face_count() && loop < mesh->mesh.loop_count(face),
            "there is no such face or loop");
    const std::span<const std::uint32_t> indices = mesh->mesh.loop(face, loop);
    *corner_count = count_of(indices.size());
    *corners = indices.data();
  });
}

shadowcut_status shadowcut_object_settings_init(shadowcut_object_settings* settings) {
  shadowcut_object_settings out{};
  out.casts_shadows = out.receives_shadows = 1;
  for (int i = 0; i < 4; ++i) out.pose[5 * i] = 1;
  return initialise(settings, out);
}
shadowcut_status shadowcut_light_init(shadowcut_light* light) {
  shadowcut_light out{};
  out.range = std::numeric_limits<double>::infinity();
  return initialise(light, out);
}
shadowcut_status shadowcut_object_init(shadowcut_object* object) {
  return initialise(object, shadowcut_object{});
}
shadowcut_status shadowcut_scene_counts_init(shadowcut_scene_counts* counts) {
  return initialise(counts, shadowcut_scene_counts{});
}

shadowcut_status shadowcut_scene_create(shadowcut_scene** scene) {
  return guarded([&] {
    require_pointers(scene);
    auto own = std::make_shared<Scene>();
    const Scene* view = own.get();
    *scene = new shadowcut_scene{std::move(own), view};
  });
}
shadowcut_status shadowcut_scene_copy(const shadowcut_scene* scene, shadowcut_scene** copy) {
  return guarded([&] {
    require_pointers(copy);
    auto own = std::make_shared<Scene>(value_of(scene));
    const Scene* view = own.get();
    *copy = new shadowcut_scene{std::move(own), view};
  });
}
void shadowcut_scene_destroy(shadowcut_scene* scene) {
  if (scene && scene->own) delete scene;  // an engine's goes with it
}

shadowcut_status shadowcut_scene_set_tolerances(shadowcut_scene* scene, double flatness,
                                                double coplanarity) {
  return guarded([&] {
    Scene& s = change(scene);
    const auto usable = [](double tolerance) {
      return tolerance >= 0 && tolerance < std::numeric_limits<double>::infinity();
    };
    if (!usable(flatness) || !usable(coplanarity))
      fail(SHADOWCUT_REFUSED, "a tolerance must be finite and not negative");
    s.flatness_tolerance = flatness, s.coplanarity_tolerance = coplanarity;
  });
}
shadowcut_status shadowcut_scene_tolerances(const shadowcut_scene* scene, double* flatness,
                                            double* coplanarity) {
  return guarded([&] {
    require_pointers(flatness, coplanarity);
    *flatness = value_of(scene).flatness_tolerance,
    *coplanarity = scene->scene->coplanarity_tolerance;
  });
}

shadowcut_status shadowcut_scene_add_object(shadowcut_scene* scene, const shadowcut_mesh* mesh,
                                            const shadowcut_object_settings* settings,
                                            shadowcut_object_id* id) {
  return guarded([&] {
    require_pointers(id);
    copy_id(change(scene).add(value_of(mesh), settings_of(settings)), id);
  });
}
shadowcut_status shadowcut_scene_remove_object(shadowcut_scene* scene,
                                               const shadowcut_object_id* id) {
  return guarded([&] { expect(change(scene).remove(id_of(id))); });
}
shadowcut_status shadowcut_scene_set_pose(shadowcut_scene* scene, const shadowcut_object_id* id,
                                          const double* pose) {
  return guarded([&] { expect(change(scene).set_pose(id_of(id), pose_of(pose))); });
}
shadowcut_status shadowcut_scene_set_vertices(shadowcut_scene* scene, const shadowcut_object_id* id,
                                              const double* xyz, int32_t vertex_count) {
  return guarded(
      [&] { expect(change(scene).set_vertices(id_of(id), points_of(xyz, vertex_count))); });
}
shadowcut_status shadowcut_scene_set_vertices_float(shadowcut_scene* scene,
                                                    const shadowcut_object_id* id, const float* xyz,
                                                    int32_t vertex_count) {
  return guarded(
      [&] { expect(change(scene).set_vertices(id_of(id), points_of(xyz, vertex_count))); });
}
shadowcut_status shadowcut_scene_set_casts_shadows(shadowcut_scene* scene,
                                                   const shadowcut_object_id* id,
                                                   int32_t casts_shadows) {
  return guarded([&] { expect(change(scene).set_casts_shadows(id_of(id), flag(casts_shadows))); });
}
shadowcut_status shadowcut_scene_set_receives_shadows(shadowcut_scene* scene,
                                                      const shadowcut_object_id* id,
                                                      int32_t receives_shadows) {
  return guarded(
      [&] { expect(change(scene).set_receives_shadows(id_of(id), flag(receives_shadows))); });
}

shadowcut_status shadowcut_scene_source(const shadowcut_scene* scene, const shadowcut_object_id* id,
                                        shadowcut_mesh** mesh,
                                        shadowcut_object_settings* settings) {
  return guarded([&] {
    require_pointers(mesh);
    if (settings) require_size(settings);
    const Scene& s = value_of(scene);
    expect(s.status(id_of(id)));
    auto source = s.source(id_of(id));
    *mesh = new shadowcut_mesh{std::move(source->first)};
    if (!settings) return;
    const ObjectSettings& as = source->second;
    settings->sides = static_cast<std::int32_t>(as.sides);
    settings->casts_shadows = as.casts_shadows, settings->receives_shadows = as.receives_shadows,
    settings->dynamic = as.dynamic;
    copy(as.pose, settings->pose);
    settings->name = s.find(id_of(id))->name.c_str();
  });
}

shadowcut_status shadowcut_scene_add_light(shadowcut_scene* scene, const shadowcut_light* light,
                                           shadowcut_light_id* id) {
  return guarded([&] {
    require_pointers(id);
    copy_id(change(scene).add(light_of(light)), id);
  });
}
shadowcut_status shadowcut_scene_remove_light(shadowcut_scene* scene,
                                              const shadowcut_light_id* id) {
  return guarded([&] { expect(change(scene).remove(id_of(id))); });
}
shadowcut_status shadowcut_scene_set_light(shadowcut_scene* scene, const shadowcut_light_id* id,
                                           const shadowcut_light* light) {
  return guarded([&] { expect(change(scene).set_light(id_of(id), light_of(light))); });
}
shadowcut_status shadowcut_scene_replace_lights(shadowcut_scene* scene,
                                                const shadowcut_light* const* lights,
                                                int32_t light_count) {
  return guarded([&] {
    Scene& s = change(scene);
    std::vector<Light> all;
    for (const shadowcut_light* light : span_of(lights, light_count))
      all.push_back(light_of(light));
    s.replace_lights(all);
  });
}

shadowcut_status shadowcut_scene_object_id(const shadowcut_scene* scene, uint32_t index,
                                           shadowcut_object_id* id) {
  return guarded([&] {
    require_pointers(id);
    copy_found(value_of(scene).object_id(index), "there is no object at this index", id);
  });
}
shadowcut_status shadowcut_scene_light_id(const shadowcut_scene* scene, uint32_t index,
                                          shadowcut_light_id* id) {
  return guarded([&] {
    require_pointers(id);
    copy_found(value_of(scene).light_id(index), "there is no light at this index", id);
  });
}
shadowcut_status shadowcut_scene_light(const shadowcut_scene* scene, const shadowcut_light_id* id,
                                       shadowcut_light* light) {
  return guarded([&] {
    require_size(light);
    expect(value_of(scene).status(id_of(id)));
    const Light* found = scene->scene->find(id_of(id));
    light->kind = static_cast<std::int32_t>(found->kind);
    copy(found->position, light->position), copy(found->direction, light->direction);
    light->range = found->range;
    light->has_spot = found->spot.has_value();
    if (found->spot)
      copy(found->spot->axis, light->spot_axis), light->spot_half_angle = found->spot->half_angle;
    light->name = found->name.c_str();
  });
}

shadowcut_status shadowcut_scene_object(const shadowcut_scene* scene, const shadowcut_object_id* id,
                                        shadowcut_object* object) {
  return guarded([&] {
    require_size(object);
    expect(value_of(scene).status(id_of(id)));
    const Object* o = scene->scene->find(id_of(id));
    object->sides = static_cast<std::int32_t>(o->sides);
    object->casts_shadows = o->casts_shadows, object->receives_shadows = o->receives_shadows,
    object->dynamic = o->dynamic;
    object->first_face = o->first_face, object->face_count = o->face_count;
    object->first_vertex = o->first_vertex, object->vertex_count = o->vertex_count;
    object->first_facet = o->first_facet, object->facet_count = o->facet_count;
    object->first_edge = o->first_edge, object->edge_count = o->edge_count;
    object->aligned = o->aligned, object->aligned_by = o->aligned_by;
    object->signed_volume = o->signed_volume;
    copy(o->pose, object->pose);
    object->name = o->name.c_str();
  });
}

shadowcut_status shadowcut_scene_count(const shadowcut_scene* scene,
                                       shadowcut_scene_counts* counts) {
  return guarded([&] {
    require_size(counts);
    const Scene& s = value_of(scene);
    *counts = {counts->size,
               count_of(s.objects().size()),
               count_of(s.lights().size()),
               count_of(s.faces().size()),
               count_of(s.facets().size()),
               count_of(s.corners().size()),
               count_of(s.vertices().size()),
               count_of(s.edges().size()),
               count_of(s.planes().size()),
               count_of(s.issues().size()),
               SceneAccess::revision(s)};
  });
}

shadowcut_status shadowcut_scene_changed_since(const shadowcut_scene* scene,
                                               const uint64_t* revision, uint32_t capacity,
                                               uint32_t* indices, uint32_t* count) {
  return guarded([&] {
    require_pointers(revision);
    require_pointers(count);
    require(indices != nullptr || capacity == 0, "a pointer is null");
    const std::vector<std::uint32_t> changed =
        SceneAccess::changed_since(value_of(scene), *revision);
    *count = count_of(changed.size());
    std::copy_n(changed.begin(), std::min(capacity, *count), indices);
  });
}

shadowcut_status shadowcut_scene_faces(const shadowcut_scene* scene, uint32_t first, uint32_t count,
                                       shadowcut_face* faces) {
  return guarded([&] {
    copy_out(value_of(scene).faces(), first, count, faces, [](const Face& f) {
      return shadowcut_face{f.object, f.number, f.first_facet, f.facet_count, f.area};
    });
  });
}
shadowcut_status shadowcut_scene_facets(const shadowcut_scene* scene, uint32_t first,
                                        uint32_t count, shadowcut_facet* facets) {
  return guarded([&] {
    copy_out(value_of(scene).facets(), first, count, facets, [](const Facet& f) {
      return shadowcut_facet{f.face, f.plane, f.first_corner, f.corner_count};
    });
  });
}
shadowcut_status shadowcut_scene_corners(const shadowcut_scene* scene, uint32_t first,
                                         uint32_t count, shadowcut_corner* corners) {
  return guarded([&] {
    copy_out(value_of(scene).corners(), first, count, corners, [](const Corner& x) {
      return shadowcut_corner{x.vertex, x.edge};
    });
  });
}
shadowcut_status shadowcut_scene_vertices(const shadowcut_scene* scene, uint32_t first,
                                          uint32_t count, double* xyz) {
  return guarded([&] {
    for (const Vec3& x : part_of(value_of(scene).vertices(), first, count, xyz))
      xyz = std::copy_n(x.data(), 3, xyz);
  });
}
shadowcut_status shadowcut_scene_edges(const shadowcut_scene* scene, uint32_t first, uint32_t count,
                                       shadowcut_edge* edges) {
  return guarded([&] {
    copy_out(value_of(scene).edges(), first, count, edges, [](const Edge& e) {
      return shadowcut_edge{e.a, e.b};
    });
  });
}
shadowcut_status shadowcut_scene_planes(const shadowcut_scene* scene, uint32_t first,
                                        uint32_t count, shadowcut_plane* planes) {
  return guarded([&] {
    copy_out(value_of(scene).planes(), first, count, planes, [](const Plane& p) {
      shadowcut_plane out{};
      copy(p.normal, out.normal), copy(p.point, out.point), copy(p.exact_normal, out.exact_normal);
      out.flatness = p.flatness, out.tilt = p.tilt;
      return out;
    });
  });
}

shadowcut_status shadowcut_scene_issues(const shadowcut_scene* scene, uint32_t first,
                                        uint32_t count, shadowcut_issue* issues) {
  return guarded([&] {
    copy_out(value_of(scene).issues(), first, count, issues, [](const Issue& i) {
      return shadowcut_issue{i.object, i.face, static_cast<std::int32_t>(i.reason),
                             i.detail.c_str()};
    });
  });
}

const char* shadowcut_reason_text(int32_t reason) {
  return reason >= 0 && reason <= SHADOWCUT_NOT_FLAT ? reason_text(static_cast<Reason>(reason))
                                                     : "";
}
int32_t shadowcut_is_refusal(int32_t reason) {
  return reason >= 0 && reason <= SHADOWCUT_NOT_FLAT && is_refusal(static_cast<Reason>(reason)) ? 1
                                                                                                : 0;
}
