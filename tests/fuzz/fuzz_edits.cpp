// libFuzzer: bytes make a small scene and a history of edits. All coordinates are multiples of an
// eighth, mostly whole, so that everything degenerate happens, and exactly. After every update the
// trees must be valid, areas those of shadows cast again, and the changes emitted must lead from
// the fragments before to the fragments after.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <shadowcut/shadows.hpp>
#include <vector>

#include "source.hpp"

namespace {

using namespace shadowcut;
using fuzz::require;

class Source : public fuzz::Bytes {
 public:
  using Bytes::Bytes;
  double coordinate() {
    const std::uint8_t b = byte();
    return b & 128 ? (b & 63) / 8.0 - 2 : b % 8 - 2;
  }
  Vec3 point() {
    const double x = coordinate(), y = coordinate(), z = coordinate();
    return {x, y, z};
  }
};

Mesh some_mesh(Source& source, std::uint8_t kind) {
  return fuzz::some_mesh(kind, [&] { return source.point(); });
}

Light some_light(Source& source, std::uint8_t kind) {
  Light light = kind & 1 ? Light::directional(source.point()) : Light::point(source.point());
  if (light.kind == Light::Kind::directional && light.direction.isZero()) light.direction.z() = -1;
  // nothing lies at such a distance exactly
  if (light.kind == Light::Kind::point && kind & 2) light.range = 1.53125 + source.byte() % 8;
  return light;
}

// A scene, an engine that follows it, and the ids that the engine's changes have made known.
class History {
 public:
  explicit History(Source& source) : source_(source), engine_(scene_, options(source)) {
    scene_.add(some_light(source, source.byte()));
    for (int k = source.byte() % 6; k >= 0; --k) add();
  }

  void run() {
    update();
    for (int k = 0; k < 16 && !source_.empty(); ++k) {
      const std::uint8_t how = source_.byte();
      edit(how);
      if (how < 192) update();
    }
    update();
  }

 private:
  static Options options(Source& source) {
    const std::uint8_t choice = source.byte();
    Options o;
    o.threads = 1;
    o.form = static_cast<Form>(choice % 3);
    o.tuning.order = static_cast<Order>(choice / 4 % 3);
    o.tuning.facets_per_cell = choice & 16 ? 2 : choice & 32 ? 0 : 64;
    o.tuning.join_threshold = choice & 64 ? 0 : choice & 128 ? 1000000 : 16;
    return o;
  }

  void add() {
    const std::uint8_t kind = source_.byte();
    ObjectSettings settings;
    settings.sides = kind & 16 ? Sides::open : Sides::automatic;
    settings.casts_shadows = !(kind & 32) || !(kind & 64);
    settings.dynamic = kind & 128;
    meshes_.push_back(some_mesh(source_, kind));
    objects_.push_back(scene_.add(meshes_.back(), settings));
  }

  void edit(std::uint8_t how) {
    const std::size_t k = source_.byte() % objects_.size();
    const ObjectId id = objects_[k];
    const Object* object = scene_.find(id);
    Pose pose = object ? object->pose : Pose::Identity();
    Status done = Status::ok;
    switch (how % 12) {
      case 0:
      case 1:
        pose.translation() = source_.point();
        done = scene_.set_pose(id, pose);
        break;
      case 2:
        pose.prerotate(quarter(source_.byte()));
        done = scene_.set_pose(id, pose);
        break;
      case 3:
        pose.linear() *= source_.byte() % 2 ? 2 : 0.5;
        if (std::abs(std::log2(std::abs(pose.linear().determinant()))) < 7)
          done = scene_.set_pose(id, pose);
        break;
      case 4:
        done = scene_.remove(id);
        break;
      case 5:
        if (objects_.size() < 10) add();
        break;
      case 6:
        done = scene_.set_casts_shadows(id, source_.byte() & 1);
        break;
      case 7:
        done = scene_.set_receives_shadows(id, source_.byte() & 1);
        break;
      case 8: {
        std::vector<Vec3>& vertices = meshes_[k].vertices;
        vertices[source_.byte() % vertices.size()] = source_.point();
        done = scene_.set_vertices(id, vertices);
        break;
      }
      case 9:
        done = scene_.set_light(scene_.light_id(0), some_light(source_, source_.byte()));
        break;
      case 10:
        if (scene_.lights().size() < 2 || scene_.light_id(1).index == invalid_index)
          scene_.add(some_light(source_, source_.byte()));
        else done = scene_.remove(scene_.light_id(1));
        break;
      default:
        objects_[k] = scene_.find(id) ? id : scene_.add(meshes_[k], {});
    }
    require(done == Status::ok || (done == Status::stale && !object), "an edit was refused");
  }

  static Eigen::Matrix3d quarter(std::uint8_t axis) {
    const int w = axis % 3, u = (w + 1) % 3, v = (w + 2) % 3;
    Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
    turn(w, w) = 1, turn(u, v) = -1, turn(v, u) = 1;
    return turn;
  }

  void update() {
    const Changes& changes = engine_.update();
    require(changes.complete, "an update without a budget is not complete");
    for (const LightChanges& c : changes.lights) {
      std::set<FragmentId>& ids = ids_[c.light];
      for (const FragmentId& id : c.gone) require(ids.erase(id) == 1, "gone, but was not there");
      for (const LightChanges::Added& a : c.added) {
        require(ids.insert(a.id).second, "added, but was there");
        require(engine_.shadows(c.light).blocks.at(a.id.cell).fragments.at(a.index).id == a.id,
                "added at another place");
      }
      if (c.removed) require(ids.empty(), "a light is gone, and not all its fragments");
    }
    const std::string complaint = engine_.validate();
    require(complaint.empty(), complaint.c_str());
    for (std::size_t k = 0; k < scene_.lights().size(); ++k) {
      if (scene_.light_id(k).index != invalid_index) check(k);
    }
  }

  void check(std::size_t k) {
    const Shadows& shadows = engine_.shadows(k);
    Options once;
    once.threads = 1;
    const Shadows fresh = cast_shadows(scene_, scene_.lights()[k], once);
    require(shadows.areas.size() == fresh.areas.size(), "areas of other faces");
    for (std::size_t i = 0; i < fresh.areas.size(); ++i) {
      const FaceArea &a = shadows.areas[i], &b = fresh.areas[i];
      require(a.facing == b.facing, "facing differs");
      if (a.facing == Facing::refused) continue;
      const double size = size_of(scene_.faces()[i]), tolerance = 1e-7 * (b.area + size * size);
      const double most = std::max(
          {std::abs(a.area - b.area), std::abs(a.lit - b.lit), std::abs(a.shadowed - b.shadowed)});
      require(most <= tolerance, "areas differ");
    }
    std::size_t count = 0;
    for (const Block& block : shadows.blocks) {
      for (const Fragment& f : block.fragments) {
        ++count;
        const Fragment* found = engine_.find(k, f.id);
        require(ids_[static_cast<std::uint32_t>(k)].count(f.id) == 1,
                "a fragment was never announced");
        require(found && found->id == f.id && found->face == f.face, "a fragment is not found");
        for (const Vec3& c : block.corners_of(f)) require(c.allFinite(), "a corner is not finite");
      }
    }
    require(count == ids_[static_cast<std::uint32_t>(k)].size(),
            "a fragment was announced, and is not there");
  }

  // Fragments lie within a face, so areas are compared with the size of the face, not with what a
  // needle's area happens to be.
  double size_of(const Face& face) const {
    double size = 0;
    for (std::uint32_t k = 0; k < face.facet_count; ++k) {
      const Facet& facet = scene_.facets()[face.first_facet + k];
      const Vec3& first = scene_.vertices()[scene_.corners_of(facet)[0].vertex];
      for (const Corner& c : scene_.corners_of(facet))
        size = std::max(size, (scene_.vertices()[c.vertex] - first).norm());
    }
    return size;
  }

  Source& source_;
  Scene scene_;
  Engine engine_;
  std::vector<Mesh> meshes_;
  std::vector<ObjectId> objects_;
  std::map<std::uint32_t, std::set<FragmentId>> ids_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Source source(data, size);
  History(source).run();
  return 0;
}
