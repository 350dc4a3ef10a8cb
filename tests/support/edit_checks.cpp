// See edit_checks.hpp.
#include "edit_checks.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <set>
#include <tuple>

#include "text.hpp"

namespace shadowcut::testing {
namespace {

std::string name_of(const FragmentId& id) {
  return text("fragment (", id.cell, ", ", id.piece, ", ", id.place, ")");
}

bool same_bits(const Vec3& a, const Vec3& b) {
  return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0;
}
bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same_bits(const FaceArea& a, const FaceArea& b) {
  return a.facing == b.facing && same_bits(a.area, b.area) && same_bits(a.lit, b.lit) &&
         same_bits(a.shadowed, b.shadowed) && same_bits(a.dropped, b.dropped);
}

bool same_fields(const Object& a, const Object& b) {
  return a.name == b.name && a.sides == b.sides && a.casts_shadows == b.casts_shadows &&
         a.receives_shadows == b.receives_shadows && a.dynamic == b.dynamic &&
         a.first_face == b.first_face && a.face_count == b.face_count &&
         a.first_vertex == b.first_vertex && a.vertex_count == b.vertex_count &&
         same_bits(a.signed_volume, b.signed_volume) && a.pose.matrix() == b.pose.matrix() &&
         a.first_facet == b.first_facet && a.facet_count == b.facet_count &&
         a.first_edge == b.first_edge && a.edge_count == b.edge_count && a.aligned == b.aligned &&
         same_bits(a.aligned_by, b.aligned_by);
}

bool same_facet(const Scene& a, const Scene& b, std::uint32_t index) {
  const Facet &x = a.facets()[index], &y = b.facets()[index];
  if (x.face != y.face || x.plane != y.plane || x.first_corner != y.first_corner ||
      x.corner_count != y.corner_count)
    return false;
  const Plane &p = a.planes()[x.plane], &q = b.planes()[x.plane];
  if (!same_bits(p.normal, q.normal) || !same_bits(p.point, q.point) || p.flatness != q.flatness ||
      p.tilt != q.tilt)
    return false;
  const auto own = a.corners_of(x), other = b.corners_of(y);
  return std::equal(own.begin(), own.end(), other.begin(), [](const Corner& c, const Corner& d) {
    return c.vertex == d.vertex && c.edge == d.edge;
  });
}

// Which entries of an array some object has.
class Taken {
 public:
  Taken(const char* array, std::size_t size) : array_(array), of_(size, invalid_index) {}
  std::string take(std::uint32_t first, std::uint32_t count, std::uint32_t object) {
    if (std::size_t{first} + count > of_.size())
      return text(array_, " of object ", object, " are out of range\n");
    for (std::uint32_t i = first; i < first + count; ++i) {
      if (of_[i] != invalid_index)
        return text(array_, " ", i, " is both object ", of_[i], "'s and ", object, "'s\n");
      of_[i] = object;
    }
    return {};
  }
  bool is_of(std::size_t i, std::uint32_t object) const {
    return i < of_.size() && of_[i] == object;
  }
  std::uint32_t operator[](std::size_t i) const { return of_[i]; }

 private:
  const char* array_;
  std::vector<std::uint32_t> of_;
};

}  // namespace

bool same_object(const Scene& a, const Scene& b, std::size_t index) {
  const bool in_a = index < a.objects().size() && a.objects()[index].alive,
             in_b = index < b.objects().size() && b.objects()[index].alive;
  if (!in_a || !in_b) return in_a == in_b;
  const Object& o = a.objects()[index];
  if (!same_fields(o, b.objects()[index]) || a.object_id(index) != b.object_id(index)) return false;
  // The arrays may differ in length, while one scene is behind the other.
  const auto holds = [&o](const Scene& s) {
    const auto within = [](std::size_t first, std::size_t count, const auto& array) {
      return first + count <= array.size();
    };
    return within(o.first_face, o.face_count, s.faces()) &&
           within(o.first_facet, o.facet_count, s.facets()) &&
           within(o.first_vertex, o.vertex_count, s.vertices()) &&
           within(o.first_edge, o.edge_count, s.edges());
  };
  if (!holds(a) || !holds(b)) return false;
  for (std::uint32_t i = o.first_vertex; i < o.first_vertex + o.vertex_count; ++i) {
    if (!same_bits(a.vertices()[i], b.vertices()[i])) return false;
  }
  for (std::uint32_t i = o.first_edge; i < o.first_edge + o.edge_count; ++i) {
    if (a.edges()[i].a != b.edges()[i].a || a.edges()[i].b != b.edges()[i].b) return false;
  }
  for (std::uint32_t i = o.first_facet; i < o.first_facet + o.facet_count; ++i) {
    if (!same_facet(a, b, i)) return false;
  }
  for (std::uint32_t i = o.first_face; i < o.first_face + o.face_count; ++i) {
    const Face &x = a.faces()[i], &y = b.faces()[i];
    if (x.object != y.object || x.number != y.number || x.first_facet != y.first_facet ||
        x.facet_count != y.facet_count || !same_bits(x.area, y.area))
      return false;
  }
  return true;
}

bool same_light(const Scene& a, const Scene& b, std::size_t index) {
  if (a.light_id(index) != b.light_id(index)) return false;
  if (a.light_id(index).index == invalid_index) return true;
  const Light &x = a.lights()[index], &y = b.lights()[index];
  if (x.spot.has_value() != y.spot.has_value()) return false;
  if (x.spot &&
      (!same_bits(x.spot->axis, y.spot->axis) || x.spot->half_angle != y.spot->half_angle))
    return false;
  return x.kind == y.kind && same_bits(x.position, y.position) &&
         same_bits(x.direction, y.direction) && x.name == y.name && x.range == y.range;
}

std::string check_same_scene(const Scene& a, const Scene& b) {
  const auto sizes = [](const Scene& s) {
    return std::array{s.objects().size(), s.lights().size(),  s.faces().size(),
                      s.facets().size(),  s.corners().size(), s.vertices().size(),
                      s.edges().size(),   s.planes().size(),  s.issues().size()};
  };
  const auto of_a = sizes(a), of_b = sizes(b);
  constexpr std::array names{"objects",  "lights", "faces",  "facets", "corners",
                             "vertices", "edges",  "planes", "issues"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (of_a[k] != of_b[k]) return text("scenes: ", of_a[k], " and ", of_b[k], " ", names[k], "\n");
  }
  if (a.flatness_tolerance != b.flatness_tolerance)
    return "scenes: different flatness tolerances\n";
  for (std::size_t i = 0; i < a.objects().size(); ++i) {
    if (!same_object(a, b, i))
      return text("scenes: object ", i, " (", a.objects()[i].name, ") differs\n");
  }
  for (std::size_t i = 0; i < a.lights().size(); ++i) {
    if (!same_light(a, b, i)) return text("scenes: light ", i, " differs\n");
  }
  for (std::size_t i = 0; i < a.faces().size(); ++i) {
    if (a.faces()[i].object != b.faces()[i].object)
      return text("scenes: face ", i, " is not the same object's\n");
  }
  for (std::size_t i = 0; i < a.facets().size(); ++i) {
    if (a.facets()[i].corner_count != b.facets()[i].corner_count)
      return text("scenes: facet ", i, " differs\n");
  }
  const auto key = [](const Issue& i) { return std::tuple(i.object, i.face, i.reason, i.detail); };
  const auto sorted = [&](const Scene& s) {
    std::multiset<std::tuple<std::uint32_t, std::uint32_t, Reason, std::string>> all;
    for (const Issue& i : s.issues()) all.insert(key(i));
    return all;
  };
  return sorted(a) == sorted(b) ? "" : "scenes: different issues\n";
}

std::string check_arrays(const Scene& scene) {
  Taken faces("faces", scene.faces().size()), facets("facets", scene.facets().size()),
      vertices("vertices", scene.vertices().size()), edges("edges", scene.edges().size()),
      corners("corners", scene.corners().size()), planes("planes", scene.planes().size());
  std::string what;
  for (std::uint32_t i = 0; i < scene.objects().size() && what.empty(); ++i) {
    const Object& o = scene.objects()[i];
    if (!o.alive && (o.face_count || o.facet_count || o.vertex_count || o.edge_count))
      return text("object ", i, " is removed, and not empty\n");
    if (o.alive != (scene.object_id(i).index == i))
      return text("object ", i, ": its id does not tell whether it lives\n");
    what += faces.take(o.first_face, o.face_count, i) +
            facets.take(o.first_facet, o.facet_count, i) +
            vertices.take(o.first_vertex, o.vertex_count, i) +
            edges.take(o.first_edge, o.edge_count, i);
  }
  if (!what.empty()) return what;
  for (std::uint32_t i = 0; i < scene.edges().size(); ++i) {
    const Edge& e = scene.edges()[i];
    if (edges[i] == invalid_index) continue;
    if (e.a >= e.b || !vertices.is_of(e.a, edges[i]) || !vertices.is_of(e.b, edges[i]))
      return text("edge ", i, ": its ends\n");
  }
  std::set<std::uint32_t> planes_seen;
  for (std::uint32_t i = 0; i < scene.facets().size(); ++i) {
    const Facet& f = scene.facets()[i];
    if ((facets[i] == invalid_index) != (f.corner_count == 0))
      return text("facet ", i, " is no object's and has corners, or the other way round\n");
    if (facets[i] == invalid_index) continue;
    if (!faces.is_of(f.face, facets[i]))
      return text("facet ", i, ": its face is not its object's\n");
    const Face& face = scene.faces()[f.face];
    if (i < face.first_facet || i >= face.first_facet + face.facet_count)
      return text("facet ", i, ": its face has other facets\n");
    what = corners.take(f.first_corner, f.corner_count, facets[i]);
    if (planes_seen.insert(f.plane).second) what += planes.take(f.plane, 1, facets[i]);
    else if (!planes.is_of(f.plane, facets[i]))
      what += text("facet ", i, ": its plane is another object's\n");
    if (!what.empty()) return what;
    const auto loop = scene.corners_of(f);
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const auto [vertex, edge] = loop[k];
      if (!vertices.is_of(vertex, facets[i]) || !edges.is_of(edge >> 1, facets[i]))
        return text("facet ", i, ": corner ", k, "\n");
      const Edge& e = scene.edges()[edge >> 1];
      const std::uint32_t next = loop[(k + 1) % loop.size()].vertex;
      if ((edge & 1 ? e.b : e.a) != vertex || (edge & 1 ? e.a : e.b) != next)
        return text("facet ", i, ": its edge ", k, "\n");
    }
  }
  for (std::uint32_t i = 0; i < scene.faces().size(); ++i) {
    const Face& f = scene.faces()[i];
    if (f.object != faces[i])
      return text("face ", i, " names object ", f.object, ", and is ", faces[i], "'s\n");
    if (f.object == invalid_index && (f.facet_count != 0 || f.area != 0))
      return text("face ", i, " is no object's, and has facets\n");
    if (f.object != invalid_index && f.number != i - scene.objects()[f.object].first_face)
      return text("face ", i, " has another number\n");
    if ((f.facet_count == 0) != (f.area == 0))
      return text("face ", i, ": area ", f.area, " of ", f.facet_count, " facets\n");
  }
  for (const Issue& i : scene.issues()) {
    if (i.object >= scene.objects().size() || !scene.objects()[i.object].alive ||
        i.face >= scene.objects()[i.object].face_count)
      return text("an issue of object ", i.object, ", face ", i.face, ", which does not exist\n");
  }
  return {};
}

std::string check_identical(const Changes& a, const Changes& b) {
  if (a.applied != b.applied || a.complete != b.complete || a.lights.size() != b.lights.size())
    return "changes: different updates\n";
  for (std::size_t k = 0; k < a.lights.size(); ++k) {
    const LightChanges &x = a.lights[k], &y = b.lights[k];
    if (x.light != y.light || x.rebuilt != y.rebuilt || x.removed != y.removed)
      return "changes: different lights\n";
    if (x.gone != y.gone) return text("changes of light ", x.light, ": different fragments gone\n");
    if (!std::equal(
            x.added.begin(), x.added.end(), y.added.begin(), y.added.end(),
            [](const auto& p, const auto& q) { return p.id == q.id && p.index == q.index; }))
      return text("changes of light ", x.light, ": different fragments added\n");
    if (!std::equal(x.areas.begin(), x.areas.end(), y.areas.begin(), y.areas.end(),
                    [](const auto& p, const auto& q) {
                      return p.face == q.face && same_bits(p.area, q.area);
                    }))
      return text("changes of light ", x.light, ": different areas\n");
  }
  return {};
}

bool Mirror::same(const Copy& copy, const Fragment& f, std::span<const Vec3> corners) {
  return copy.face == f.face && copy.facet == f.facet && copy.caster == f.caster &&
         copy.lit == f.lit && same_bits(copy.area, f.area) &&
         std::equal(copy.corners.begin(), copy.corners.end(), corners.begin(), corners.end(),
                    [](const Vec3& a, const Vec3& b) { return same_bits(a, b); });
}

Mirror::Copy Mirror::copied(const Block& block, const Fragment& f) {
  const auto corners = block.corners_of(f);
  return {f.face, f.facet, f.caster, f.lit, f.area, {corners.begin(), corners.end()}};
}

std::string Mirror::apply(const LightChanges& changes, const Engine& engine) {
  OfLight& mine = lights_[changes.light];
  const std::string who = text("changes of light ", changes.light, ": ");
  if (!changes.rebuilt && !changes.removed && changes.gone.empty() && changes.added.empty() &&
      changes.areas.empty())
    return who + "nothing changed\n";
  for (const FragmentId& id : changes.gone) {
    if (mine.fragments.erase(id) == 0) return who + name_of(id) + " is gone, but was not there\n";
    mine.gone_lately.push_back(id);
  }
  if (mine.gone_lately.size() > 400)
    mine.gone_lately.erase(mine.gone_lately.begin(), mine.gone_lately.end() - 200);
  if (changes.removed) {
    const bool all = mine.fragments.empty() && changes.added.empty();
    lights_.erase(changes.light);
    return all ? "" : who + "the light is gone, and not all its fragments\n";
  }
  const Shadows& shadows = engine.shadows(changes.light);
  for (const LightChanges::Added& a : changes.added) {
    if (a.id.cell >= shadows.blocks.size() || a.index >= shadows.blocks[a.id.cell].fragments.size())
      return who + name_of(a.id) + " is added, at a place that does not exist\n";
    const Block& block = shadows.blocks[a.id.cell];
    const Fragment& f = block.fragments[a.index];
    if (f.id != a.id)
      return who + name_of(a.id) + " is added, but at its place is " + name_of(f.id) + "\n";
    if (!mine.fragments.emplace(a.id, copied(block, f)).second)
      return who + name_of(a.id) + " is added, but was there already\n";
  }
  const std::size_t known = mine.areas.size();
  std::set<std::uint32_t> seen;
  for (const LightChanges::Area& a : changes.areas) {
    if (a.face >= engine.scene().faces().size())
      return who + text("area of face ", a.face, ", which does not exist\n");
    if (!seen.insert(a.face).second)
      return who + text("area of face ", a.face, " is listed twice\n");
    if (a.face >= mine.areas.size()) mine.areas.resize(a.face + 1);
    if (a.face < known && same_bits(mine.areas[a.face], a.area))
      return who + text("area of face ", a.face, " is listed, and is what it was\n");
    mine.areas[a.face] = a.area;
  }
  return {};
}

std::string Mirror::compare(std::uint32_t light, const Shadows& shadows) const {
  const auto it = lights_.find(light);
  if (it == lights_.end()) return text("light ", light, " was never announced\n");
  const OfLight& mine = it->second;
  std::size_t count = 0;
  for (std::size_t cell = 0; cell < shadows.blocks.size(); ++cell) {
    const Block& block = shadows.blocks[cell];
    for (const Fragment& f : block.fragments) {
      ++count;
      if (f.id.cell != cell)
        return text("light ", light, ": ", name_of(f.id), " is in block ", cell, "\n");
      const auto own = mine.fragments.find(f.id);
      if (own == mine.fragments.end())
        return text("light ", light, ": ", name_of(f.id), " was never announced\n");
      if (!same(own->second, f, block.corners_of(f)))
        return text("light ", light, ": ", name_of(f.id), " has changed and keeps its id\n");
    }
  }
  if (count != mine.fragments.size())
    return text("light ", light, ": ", mine.fragments.size(), " fragments announced, ", count,
                " listed\n");
  for (std::size_t i = 0; i < shadows.areas.size(); ++i) {
    if (!same_bits(i < mine.areas.size() ? mine.areas[i] : FaceArea{}, shadows.areas[i]))
      return text("light ", light, ": the area of face ", i,
                  " has changed, and was not announced\n");
  }
  return mine.areas.size() > shadows.areas.size()
             ? text("light ", light, ": areas of faces that do not exist\n")
             : "";
}

std::string Mirror::apply(const Changes& changes, const Engine& engine) {
  for (std::size_t k = 0; k < changes.lights.size(); ++k) {
    if (k > 0 && changes.lights[k].light <= changes.lights[k - 1].light)
      return "changes: lights out of order\n";
    if (std::string what = apply(changes.lights[k], engine); !what.empty()) return what;
  }
  std::size_t alive = 0;
  for (std::uint32_t light = 0; light < engine.light_count(); ++light) {
    if (engine.scene().light_id(light).index == invalid_index) continue;
    ++alive;
    if (std::string what = compare(light, engine.shadows(light)); !what.empty()) return what;
  }
  return alive == lights_.size() ? "" : "changes: a light is gone, and was not announced\n";
}

std::string Mirror::check_find(const Engine& engine, std::size_t stride) const {
  for (const auto& [light, mine] : lights_) {
    std::size_t i = 0;
    FragmentId beyond{0, 0, 0};
    for (const auto& [id, copy] : mine.fragments) {
      beyond = {std::max(beyond.cell, id.cell), std::max(beyond.piece, id.piece),
                std::max(beyond.place, id.place)};
      if (i++ % stride != 0) continue;
      const Fragment* f = engine.find(light, id);
      if (!f || f->id != id) return text("light ", light, ": ", name_of(id), " is not found\n");
      if (!same(copy, *f, engine.shadows(light).blocks[id.cell].corners_of(*f)))
        return text("light ", light, ": ", name_of(id), " is found as another\n");
    }
    for (const FragmentId& id : mine.gone_lately) {
      if (!mine.fragments.count(id) && engine.find(light, id))
        return text("light ", light, ": ", name_of(id), " is gone, and found\n");
    }
    for (const FragmentId& id :
         {FragmentId{beyond.cell + 1, 0, 0}, FragmentId{0, beyond.piece + 1, 0},
          FragmentId{0, 0, beyond.place + 1},
          FragmentId{invalid_index, invalid_index, invalid_index}, FragmentId{0, invalid_index, 0},
          FragmentId{beyond.cell, 0, invalid_index}}) {
      if (!mine.fragments.count(id) && engine.find(light, id))
        return text("light ", light, ": ", name_of(id), " never was, and is found\n");
    }
  }
  return {};
}

}  // namespace shadowcut::testing
