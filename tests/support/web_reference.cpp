// Writes scenes, random edits, and what the engine makes of them after every edit, as JSON for
// web/shadowcut/test: numbers with as many digits as bring every bit back, fragments as a sum of
// hashes of all their corners' bits.
//
//   web_reference OUT.json
#include <bit>
#include <cinttypes>
#include <cstdio>
#include <shadowcut/shadows.hpp>
#include <string>

#include "light_vector.hpp"
#include "random_scenes.hpp"
#include "scenes.hpp"

using namespace shadowcut;

namespace {

std::FILE* out;

void write(const char* separator, double x) { std::fprintf(out, "%s%.17g", separator, x); }
void write(const Pose& pose) {
  for (int k = 0; k < 16; ++k) write(k == 0 ? "[" : ",", pose.matrix()(k / 4, k % 4));
  std::fputs("]", out);
}
void write(const Vec3& x) { std::fprintf(out, "[%.17g,%.17g,%.17g]", x[0], x[1], x[2]); }
void write(const Light& light) {
  const bool point = light.kind == Light::Kind::point;
  std::fprintf(out, R"({"kind":"%s","%s":)", point ? "point" : "directional",
               point ? "position" : "direction");
  write(point ? light.position : light.direction);
  std::fputs("}", out);
}
void write(const Mesh& mesh, const ObjectSettings& settings) {
  constexpr const char* sides[] = {"automatic", "closed", "open"};
  std::fputs(R"({"mesh":{"positions":)", out);
  const char* separator = "[";
  for (const Vec3& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) write(separator, v[k]), separator = ",";
  }
  std::fputs(R"(],"faces":[)", out);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    for (std::size_t k = 0; k < mesh.loop_count(f); ++k) {
      separator = k > 0 ? ",[" : f > 0 ? ",[[" : "[[";
      for (const std::uint32_t corner : mesh.loop(f, k))
        std::fprintf(out, "%s%" PRIu32, separator, corner), separator = ",";
      std::fputs("]", out);
    }
    std::fputs("]", out);
  }
  std::fprintf(out, R"(]},"settings":{"sides":"%s","pose":)",
               sides[static_cast<int>(settings.sides)]);
  write(settings.pose);
  std::fputs("}}", out);
}

std::uint32_t hash_of(const Block& block, const Fragment& f) {
  std::uint32_t h = 2166136261u;
  const auto add = [&h](std::uint64_t v) {
    h = (h ^ static_cast<std::uint32_t>(v)) * 16777619u;
    h = (h ^ static_cast<std::uint32_t>(v >> 32)) * 16777619u;
  };
  add(f.face), add(f.lit);
  for (const Vec3& x : block.corners_of(f)) {
    for (int k = 0; k < 3; ++k) add(std::bit_cast<std::uint64_t>(x[k]));
  }
  return h;
}

void write(const Engine& engine) {
  std::fputs(R"("lights":[)", out);
  for (std::size_t light = 0; light < engine.light_count(); ++light) {
    const Shadows& shadows = engine.shadows(light);
    std::size_t fragments = 0;
    std::uint32_t hashes = 0;
    for (const Block& block : shadows.blocks) {
      fragments += block.fragments.size();
      for (const Fragment& f : block.fragments) hashes += hash_of(block, f);
    }
    std::fprintf(out, R"(%s{"fragments":%zu,"hashes":%)" PRIu32 R"(,"areas":)",
                 light == 0 ? "" : ",", fragments, hashes);
    const char* separator = "[";
    for (const FaceArea& area : shadows.areas)
      write(separator, area.lit), write(",", area.shadowed), separator = ",";
    double uncertain = 0;
    for (const double bound : engine.uncertain_area(light)) uncertain += bound;
    std::fprintf(out, R"(],"uncertain":%.17g})", uncertain);
  }
  std::fputs("]", out);
}

struct Item {
  const Mesh* mesh;
  ObjectSettings settings;
  ObjectId id;
  bool present = true;
};

void must(Status edit) {
  if (edit != Status::ok) throw Error("an edit was not done");
}

void edit(Scene& scene, std::vector<Item>& items, const Light& lamp, double size,
          scenes::Random& random) {
  const std::size_t which = random.below(items.size());
  Item& item = items[which];
  if (!item.present) {
    std::fprintf(out, R"({"add":%zu,)", which);
    item.id = scene.add(*item.mesh, item.settings), item.present = true;
    return;
  }
  switch (random.below(8)) {
    case 0:
      std::fprintf(out, R"({"remove":%zu,)", which);
      must(scene.remove(item.id)), item.present = false;
      return;
    case 1: {
      Light moved = lamp;
      testing::vector_of(moved) += size / 16 * random.in_cube(-1, 1);
      std::fputs(R"({"light":)", out);
      write(moved), std::fputs(",", out);
      must(scene.set_light(scene.light_id(0), moved));
      return;
    }
    case 2: {
      const bool casts = random.below(2) == 0;
      std::fprintf(out, R"({"object":%zu,"castsShadows":%s,)", which, casts ? "true" : "false");
      must(scene.set_casts_shadows(item.id, casts));
      item.settings.casts_shadows = casts;
      return;
    }
    default:
      item.settings.pose =
          Eigen::Translation3d(size / 16 * random.in_cube(-1, 1)) * item.settings.pose;
      if (random.below(2) == 0)
        item.settings.pose =
            item.settings.pose * Eigen::AngleAxisd(random.in(-0.5, 0.5), Vec3::UnitZ());
      std::fprintf(out, R"({"object":%zu,"pose":)", which);
      write(item.settings.pose), std::fputs(",", out);
      must(scene.set_pose(item.id, item.settings.pose));
  }
}

void write_history(const scenes::SceneData& data, Kernel kernel) {
  constexpr const char* kernels[] = {"fast", "exact"};
  std::fprintf(out, R"({"name":"%s","kernel":"%s","objects":[)", data.name.c_str(),
               kernels[static_cast<int>(kernel)]);
  Scene scene;
  std::vector<Item> items;
  Eigen::AlignedBox3d box;
  for (const auto& [mesh, settings] : data.objects) {
    if (!items.empty()) std::fputs(",", out);
    write(mesh, settings);
    items.push_back({&mesh, settings, scene.add(mesh, settings)});
    for (const Vec3& v : mesh.vertices) box.extend(settings.pose * v);
  }
  const Light lights[] = {data.light, Light::directional({0.3, -0.45, -1})};
  std::fputs(R"(],"lights":[)", out);
  write(lights[0]), std::fputs(",", out), write(lights[1]);
  for (const Light& light : lights) scene.add(light);
  Options options;
  options.kernel = kernel;
  Engine engine(scene, options);
  engine.update();
  std::fputs(R"(],"steps":[{)", out);
  write(engine);
  scenes::Random random(7);
  for (int step = 0; step < 50; ++step) {
    std::fputs("},\n", out);
    edit(scene, items, data.light, box.diagonal().norm(), random);
    engine.update();
    write(engine);
  }
  std::fputs("}]}", out);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 2 || !(out = std::fopen(argv[1], "w")))
      throw Error("usage: web_reference OUT.json");
    std::vector<scenes::SceneData> all;
    for (const char* name : {"room:1", "city:4", "triangles:60", "spheres:3,8,5", "branch:2"})
      all.push_back(scenes::named(name));
    for (const testing::Kind kind : testing::kAllKinds)
      all.push_back(testing::random_scene(kind, 5));
    const char* separator = "[";
    for (const scenes::SceneData& data : all) {
      for (const Kernel kernel : {Kernel::exact, Kernel::fast}) {
        std::fputs(separator, out), separator = ",\n";
        write_history(data, kernel);
      }
    }
    std::fputs("]\n", out);
    if (std::fclose(out) != 0) throw Error("cannot write");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
