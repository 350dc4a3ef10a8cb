// Measures time against error, for the engine and for two methods that sample.
//
//   shadowcut_bench_dial --json bench/baseline/dial.json [--only TEXT]... [--seconds S]
//
// A row is a scene, a light and a method:
//
//   shadowcut  kernels and forms, as one-off casts on one thread; for models also with coplanar
//              groups at 1e-6
//   rays       Embree, 1 to 4 096 shadow rays per face; "by area": large faces get more rays
//   map        a shadow map of 256 to 8 192 texels per side, sampled at 1 024 points per face
//   edits      Engine after a script of 100 moves: kernels and join thresholds
//
// Time is processor time of one thread for the whole job, the minimum of its repeats. For rays and
// maps it runs from the scene to the lit area of every face.
//
// Errors are measured against the result of the exact kernel, over the faces turned to the light:
//
//   symmetric_difference  area of the symmetric difference of the lit regions. For a map: the area
//                         of the sample points at which it differs from a ray. Rays have none,
//                         because they give areas only
//   area_error            sum over faces of | lit area - exact lit area |
//   undecided_area        kernel fast: the sum of Engine::uncertain_area; and the number of faces
//                         whose areas are off by more than their uncertain area
//   dropped_area          with min_feature: area that is neither lit nor shadowed
//   wrong faces           lit (over 1e-6 of the face) although wholly shadowed (to 1e-9), and the
//                         reverse; "missed": over a hundredth of the face is lit, or shadowed, and
//                         the method reports none of it
//
// A row that would take longer than --seconds, judged by the row before, is left out and marked
// "skipped" with the estimate.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <shadowcut/io.hpp>

#include "difference.hpp"
#include "json_file.hpp"
#include "samplers.hpp"
#include "scenes.hpp"

namespace {

using namespace shadowcut;
using namespace shadowcut::bench;
using nlohmann::ordered_json;

struct Arguments {
  std::vector<std::string> only;
  std::string json;
  double seconds = 5;
};

// Processor time: all jobs run on one thread, and on a shared machine the wall clock would favour
// short jobs.
class Stopwatch {
 public:
  double ms() const { return 1e-6 * static_cast<double>(now() - start_); }

 private:
  static std::int64_t now() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return t.tv_sec * std::int64_t{1'000'000'000} + t.tv_nsec;
  }
  std::int64_t start_ = now();
};

// ---- scenes

struct Setup {
  std::string name;
  std::function<Scene(double coplanarity)> make;  // with its light
  bool sun;                                       // once more, under a sun
  std::string path;                               // of a file, which may not be installed
};

// A light above and beside a model, in general position.
Light lamp_over(const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : scene.vertices()) box.extend(v);
  return Light::point(box.center() + Vec3(0.7131, 0.4177, 1.3519).cwiseProduct(box.sizes()) +
                      0.017 * box.diagonal().norm() * Vec3(1, 2, 3));
}

Setup made(const std::string& name, bool sun = false) {
  return {name, [name](double) { return scenes::build(scenes::named(name)); }, sun, {}};
}

Setup model(const std::string& name, const std::string& path, bool sun = false) {
  const auto read = [path](double coplanarity) {
    io::ReadOptions options;
    options.coplanarity_tolerance = coplanarity;
    Scene scene = io::read_scene(path, options);
    scene.replace_lights(std::vector<Light>{lamp_over(scene)});
    return scene;
  };
  return {name, read, sun, path};
}

std::vector<Setup> setups() {
  return {made("room:4"),
          made("furnished_room"),
          made("city:18"),
          made("city:57", true),
          made("tetrahedron:4", true),
          made("spheres:12"),
          made("triangles:3000"),
          model("house", "/usr/share/assimp/models/IFC/AC14-FZK-Haus.ifc", true),
          model("bunny", "/usr/share/glmark2/models/bunny.obj")};
}

// ---- methods

struct Setting {
  std::string name;
  ordered_json parameters;
  Options options;
};

constexpr const char* kReference = "exact pieces";

Options single_thread(Kernel kernel, Form form) {
  Options o;
  o.kernel = kernel;
  o.form = form;
  o.threads = 1;
  return o;
}

constexpr std::pair<Kernel, const char*> kKernels[] = {{Kernel::fast, "fast"},
                                                       {Kernel::exact, "exact"}};

// Areas are shares of the mean facing face; solid angles need a point light.
std::vector<Setting> settings(double mean_face, Light::Kind light) {
  constexpr std::pair<Form, const char*> kForms[] = {
      {Form::pieces, "pieces"}, {Form::merged, "merged"}, {Form::conforming, "conforming"}};
  std::vector<Setting> all;
  for (const auto& [kernel, kernel_name] : kKernels)
    for (const auto& [form, form_name] : kForms)
      all.push_back({std::string(kernel_name) + " " + form_name,
                     {{"kernel", kernel_name}, {"form", form_name}},
                     single_thread(kernel, form)});
  for (const double share : {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1}) {
    Setting s{"fast min-feature",
              {{"kernel", "fast"}, {"form", "merged"}, {"min_area_share", share}},
              single_thread(Kernel::fast, Form::merged)};
    s.options.min_feature.area = share * mean_face;
    all.push_back(s);
  }
  for (const double solid_angle : {1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3}) {
    Setting s{"fast min-feature",
              {{"kernel", "fast"}, {"form", "merged"}, {"min_solid_angle", solid_angle}},
              single_thread(Kernel::fast, Form::merged)};
    s.options.min_feature.solid_angle = solid_angle;
    if (light == Light::Kind::point) all.push_back(s);
  }
  // The same regions from another tree: the resolution of the comparison itself.
  Setting floor{"exact pieces, another order",
                {{"kernel", "exact"}, {"form", "pieces"}, {"order", "random"}},
                {}};
  floor.options = single_thread(Kernel::exact, Form::pieces);
  floor.options.tuning.order = Order::random;
  all.push_back(floor);
  return all;
}

// For coordinates that were stored as float: faces meant to be coplanar share a plane.
constexpr double kFloatCoplanarity = 1e-6;

// Repeats a job for some time and keeps the shortest time.
template <class Job>
auto quickest(const Job& job) {
  const Stopwatch watch;
  auto best = job();
  for (int k = 1; watch.ms() < (k < 9 ? 400 : 100); ++k) {
    auto next = job();
    if (next.ms < best.ms) best = std::move(next);
  }
  return best;
}

// ---- errors

// By face, for the tree of the one-off cast. No row includes the time of this step.
std::vector<double> uncertain_area(const Scene& scene, Options options) {
  options.tuning.incremental = false;
  Engine engine(scene, options);
  engine.update();
  return engine.uncertain_area(0);
}

class Errors {
 public:
  Errors(const Scene& scene, const Shadows& exact) : scene_(scene), exact_(exact) {}

  // Given the lit area of every face.
  ordered_json json(std::span<const double> lit) const {
    double sum = 0, greatest = 0, greatest_share = 0;
    std::size_t lit_where_shadowed = 0, shadowed_where_lit = 0, missed = 0;
    for (std::size_t f = 0; f < exact_.areas.size(); ++f) {
      const FaceArea& is = exact_.areas[f];
      if (is.facing != Facing::toward) continue;
      const double error = std::abs(lit[f] - is.lit);
      sum += error, greatest = std::max(greatest, error),
                    greatest_share = std::max(greatest_share, error / is.area);
      const double dark = is.area - lit[f];
      if (is.lit <= 1e-9 * is.area && lit[f] > 1e-6 * is.area) ++lit_where_shadowed;
      if (is.shadowed <= 1e-9 * is.area && dark > 1e-6 * is.area) ++shadowed_where_lit;
      if ((is.lit > 1e-2 * is.area && lit[f] <= 1e-6 * is.area) ||
          (is.shadowed > 1e-2 * is.area && dark <= 1e-6 * is.area))
        ++missed;
    }
    const Stats& stats = exact_.stats;
    return {{"area_error", sum},
            {"area_error_share", sum / stats.facing_area},
            {"mean_abs_area_error", sum / static_cast<double>(stats.facing_faces)},
            {"max_abs_area_error", greatest},
            {"max_share_of_a_face", greatest_share},
            {"lit_where_shadowed", lit_where_shadowed},
            {"shadowed_where_lit", shadowed_where_lit},
            {"missed", missed}};
  }

  ordered_json json(const Shadows& shadows) const {
    std::vector<double> lit;
    for (const FaceArea& a : shadows.areas) lit.push_back(a.lit);
    const std::vector<double> regions = cli::lit_differences(scene_, shadows, exact_);
    return with_difference(json(lit), std::accumulate(regions.begin(), regions.end(), 0.0));
  }

  ordered_json with_difference(ordered_json errors, double difference) const {
    errors["symmetric_difference"] = difference;
    errors["symmetric_share"] = difference / exact_.stats.facing_area;
    return errors;
  }

  // The error bound of the kernel beside its true errors.
  ordered_json bound(const Shadows& shadows, const Options& options) const {
    const std::vector<double> by_face = uncertain_area(scene_, options);
    double sum = 0;
    std::size_t beyond = 0;
    for (std::size_t f = 0; f < exact_.areas.size(); ++f) {
      sum += by_face[f];
      const FaceArea& is = exact_.areas[f];
      if (is.facing == Facing::toward && std::abs(shadows.areas[f].lit - is.lit) > by_face[f])
        ++beyond;
    }
    return {{"undecided_area", sum}, {"beyond_undecided", beyond}};
  }

  const Shadows& exact() const { return exact_; }

 private:
  const Scene& scene_;
  const Shadows& exact_;
};

// From an index of Receivers to a face index of the scene.
std::vector<double> by_face(const Scene& scene, const Receivers& receivers,
                            std::span<const double> lit) {
  std::vector<double> all(scene.faces().size(), 0);
  for (std::size_t i = 0; i < lit.size(); ++i) all[receivers.target(i).face] = lit[i];
  return all;
}

// ---- rows

// The rows of one scene and light.
class Bench {
 public:
  explicit Bench(const Arguments& a) : arguments_(a) {}

  // `coplanar`: for models, the same scene with kFloatCoplanarity.
  void run(const std::string& name, const Scene& scene, const Scene* coplanar);

  ordered_json json() const { return {{"seconds", arguments_.seconds}, {"rows", rows_}}; }

 private:
  struct Cast {
    double ms;
    Shadows shadows;

    ordered_json json() const {
      const Stats& stats = shadows.stats;
      return {{"ms", ms},
              {"build_ms", stats.build_ms},
              {"emit_ms", stats.emit_ms},
              {"nodes", stats.nodes},
              {"lit_fragments", stats.lit_fragments},
              {"fragments", stats.lit_fragments + stats.shadowed_fragments},
              {"bytes", stats.bytes}};
    }
  };
  struct Sampled {
    double ms, structure_ms;
    std::vector<double> lit;  // by face
    std::size_t points, images, bytes;

    ordered_json json() const {
      ordered_json figures{{"ms", ms},
                           {"structure_ms", structure_ms},
                           {"sample_ms", ms - structure_ms},
                           {"points", points}};
      if (images > 0) figures.update({{"images", images}, {"bytes", bytes}});
      return figures;
    }
  };

  bool wanted(const std::string& method) const {
    const std::string row = scene_name_ + " " + method;
    const auto holds = [&row](const std::string& text) {
      return row.find(text) != std::string::npos;
    };
    return arguments_.only.empty() ||
           std::any_of(arguments_.only.begin(), arguments_.only.end(), holds);
  }

  static Cast cast(const Scene& scene, const Options& options) {
    const Stopwatch watch;
    Shadows shadows = cast_shadows(scene, scene.lights()[0], options);
    return {watch.ms(), std::move(shadows)};
  }

  void ours(const Scene& scene, const Errors& errors);
  void with_shared_planes(const Scene& coplanar, const Errors& errors);
  void rays(const Scene& scene, const Errors& errors);
  void maps(const Scene& scene, const Errors& errors);
  void edits(const Scene& scene);
  bool skipped(const std::string& method, ordered_json parameters, double estimate_ms);
  void add(const std::string& method, ordered_json parameters, ordered_json times,
           const ordered_json& errors);

  const Arguments& arguments_;
  const RayDevice device_;
  std::string scene_name_;  // with its light
  ordered_json scene_;
  ordered_json rows_ = ordered_json::array();
};

void Bench::add(const std::string& method, ordered_json parameters, ordered_json times,
                const ordered_json& errors) {
  ordered_json row = scene_;
  row["method"] = method;
  row["parameters"] = std::move(parameters);
  row.update(times);
  row.update(errors);
  const bool has_difference = row.contains("symmetric_share");
  std::printf(
      "%-22s %-9s %-40s %10.3f ms  area error %8.2e  difference %8.2e  wrong %d + %d  missed %d\n",
      scene_name_.c_str(), method.c_str(), row["parameters"].dump().c_str(),
      row["ms"].get<double>(), row["area_error_share"].get<double>(),
      has_difference ? row["symmetric_share"].get<double>() : NAN,
      row["lit_where_shadowed"].get<int>(), row["shadowed_where_lit"].get<int>(),
      row["missed"].get<int>());
  std::fflush(stdout);
  rows_.push_back(std::move(row));
}

// Whether the method would take too long; writes a row marked "skipped" then.
bool Bench::skipped(const std::string& method, ordered_json parameters, double estimate_ms) {
  if (estimate_ms <= 1e3 * arguments_.seconds) return false;
  ordered_json row = scene_;
  row["method"] = method;
  row["parameters"] = std::move(parameters);
  row["skipped"] = {{"estimate_ms", estimate_ms}};
  std::printf("%-22s %-9s %-40s skipped: about %.0f s\n", scene_name_.c_str(), method.c_str(),
              row["parameters"].dump().c_str(), 1e-3 * estimate_ms);
  rows_.push_back(std::move(row));
  return true;
}

void Bench::ours(const Scene& scene, const Errors& errors) {
  const Stats& exact = errors.exact().stats;
  for (const Setting& s : settings(exact.facing_area / static_cast<double>(exact.facing_faces),
                                   scene.lights()[0].kind)) {
    if (!wanted("shadowcut " + s.name)) continue;
    const Cast c = quickest([&] { return cast(scene, s.options); });
    ordered_json parameters = s.parameters;
    if (s.name == kReference) parameters["reference"] = true;
    ordered_json figures = c.json();
    const MinFeature& smallest = s.options.min_feature;
    if (smallest.area > 0 || smallest.solid_angle > 0)
      figures["dropped_area"] = c.shadows.stats.dropped_area;
    else if (s.options.kernel != Kernel::exact) figures.update(errors.bound(c.shadows, s.options));
    add("shadowcut", parameters, figures, errors.json(c.shadows));
  }
}

// Errors are measured against the scene without shared planes.
void Bench::with_shared_planes(const Scene& coplanar, const Errors& errors) {
  for (const auto& [kernel, name] : kKernels) {
    if (!wanted(std::string("shadowcut ") + name + " coplanar")) continue;
    const Options options = single_thread(kernel, Form::merged);
    const Cast c = quickest([&] { return cast(coplanar, options); });
    ordered_json figures = c.json();
    std::uint32_t aligned = 0;
    for (const Object& object : coplanar.objects()) aligned += object.aligned;
    figures["aligned_facets"] = aligned;
    add("shadowcut",
        {{"kernel", name}, {"form", "merged"}, {"coplanarity_tolerance", kFloatCoplanarity}},
        figures, errors.json(c.shadows));
  }
}

void Bench::rays(const Scene& scene, const Errors& errors) {
  const Light& light = scene.lights()[0];
  for (const bool by_area : {false, true}) {
    const std::string method = by_area ? "rays by area" : "rays";
    double last = 0;
    for (const std::uint32_t samples : {1u, 4u, 16u, 64u, 256u, 1024u, 4096u}) {
      if (!wanted(method + " " + std::to_string(samples))) continue;
      last *= 4;
      if (skipped(method, {{"samples", samples}}, last)) continue;
      const Sampled s = quickest([&]() -> Sampled {
        const Stopwatch watch;
        const Rays sampler(device_, scene, light);
        const double structure_ms = watch.ms();
        const Receivers receivers(scene, light, errors.exact().areas);
        const std::vector<std::uint32_t> strata = receivers.strata(samples, by_area);
        std::vector<double> lit = areas_where(
            receivers, strata,
            [&](const Vec3& x, const Vec3& normal) { return sampler.is_lit(x, normal); });
        const double ms = watch.ms();
        const std::size_t points =
            std::transform_reduce(strata.begin(), strata.end(), std::size_t{0}, std::plus<>(),
                                  [](std::uint32_t n) { return std::size_t{n} * n; });
        return {ms, structure_ms, by_face(scene, receivers, lit), points, 0, 0};
      });
      last = s.ms;
      add(method, {{"samples", samples}}, s.json(), errors.json(s.lit));
    }
  }
}

void Bench::maps(const Scene& scene, const Errors& errors) {
  const Light& light = scene.lights()[0];
  const std::uint32_t points = 1024;  // a face
  double last_structure = 0, last_samples = 0;
  const Rays truth(device_, scene, light);
  for (const std::uint32_t side : {256u, 512u, 1024u, 2048u, 4096u, 8192u}) {
    if (!wanted("map " + std::to_string(side))) continue;
    last_structure *= 4;
    if (skipped("map", {{"side", side}}, last_structure + last_samples)) continue;
    double wrong = 0;
    const Sampled s = quickest([&]() -> Sampled {
      const Stopwatch watch;
      const ShadowMap map(scene, light, side);
      const double structure_ms = watch.ms();
      const Receivers receivers(scene, light, errors.exact().areas);
      const std::vector<std::uint32_t> strata = receivers.strata(points, false);
      const std::vector<double> lit =
          areas_where(receivers, strata,
                      [&](const Vec3& x, const Vec3& normal) { return map.is_lit(x, normal); });
      const double ms = watch.ms();
      if (wrong == 0) {
        const std::vector<double> differ =
            areas_where(receivers, strata, [&](const Vec3& x, const Vec3& normal) {
              return map.is_lit(x, normal) != truth.is_lit(x, normal);
            });
        wrong = std::accumulate(differ.begin(), differ.end(), 0.0);
      }
      return {ms,           structure_ms, by_face(scene, receivers, lit), receivers.size() * points,
              map.images(), map.bytes()};
    });
    last_structure = s.structure_ms, last_samples = s.ms - s.structure_ms;
    add("map", {{"side", side}}, s.json(), errors.with_difference(errors.json(s.lit), wrong));
  }
}

// ---- edits

// 100 moves: an object moves horizontally by about a tenth of its size; every tenth move returns
// the object to its first position.
template <class Update>
void move_about(Scene& scene, const Update& update) {
  scenes::Random random(100);
  std::vector<Pose> homes;
  std::vector<std::size_t> movable;
  for (std::size_t i = 0; i < scene.objects().size(); ++i) {
    const Object& object = scene.objects()[i];
    homes.push_back(object.pose);
    // the first is the ground, or the walls
    if (object.alive && object.face_count > 0 && i > 0) movable.push_back(i);
  }
  for (int k = 0; k < 100; ++k) {
    const std::size_t i = movable[random.below(movable.size())];
    const Object& object = scene.objects()[i];
    Eigen::AlignedBox3d box;
    for (std::uint32_t v = 0; v < object.vertex_count; ++v)
      box.extend(scene.vertices()[object.first_vertex + v]);
    const Vec3 by = 0.1 * box.diagonal().norm() * random.in_ball(1);
    const bool goes_home = random.below(10) == 0;
    const Pose pose = goes_home ? homes[i] : Eigen::Translation3d(by.x(), by.y(), 0) * object.pose;
    if (scene.set_pose(scene.object_id(i), pose) != Status::ok)
      throw Error("the scene did not accept a pose");
    update();
  }
}

void Bench::edits(const Scene& home) {
  if (home.objects().size() < 3) return;
  std::vector<std::pair<const char*, std::uint32_t>> rows;
  for (const std::uint32_t threshold : {0u, 2u, 6u, 16u}) rows.emplace_back("fast", threshold);
  rows.emplace_back("exact", Options().tuning.join_threshold);
  Scene moved = home;
  move_about(moved, [] {});
  std::optional<Cast> exact;
  for (const auto& [kernel, threshold] : rows) {
    if (!wanted(std::string("edits ") + kernel + " " + std::to_string(threshold))) continue;
    if (!exact) exact = cast(moved, single_thread(Kernel::exact, Form::pieces));
    Options o =
        single_thread(kernel == std::string("exact") ? Kernel::exact : Kernel::fast, Form::merged);
    o.tuning.join_threshold = threshold;
    Engine fresh(moved, o);
    fresh.update();
    struct Run {
      double ms, greatest_ms;
      ordered_json found, errors;
    };
    const Run best = quickest([&]() -> Run {
      Scene scene = home;
      Engine engine(scene, o);
      engine.update();
      std::vector<double> ms;
      move_about(scene, [&] {
        const Stopwatch watch;
        engine.update();
        ms.push_back(watch.ms());
      });
      std::sort(ms.begin(), ms.end());
      const Stats& stats = engine.shadows(0).stats;
      const ordered_json found{
          {"nodes", stats.nodes}, {"marked_nodes", stats.marked_nodes}, {"bytes", stats.bytes}};
      return {ms[ms.size() / 2], ms.back(), found,
              Errors(moved, exact->shadows).json(engine.shadows(0))};
    });
    ordered_json figures{{"ms", best.ms},
                         {"greatest_ms", best.greatest_ms},
                         {"fresh_nodes", fresh.shadows(0).stats.nodes}};
    figures.update(best.found);
    add("edits", {{"kernel", kernel}, {"join_threshold", threshold}}, figures, best.errors);
  }
}

void Bench::run(const std::string& name, const Scene& scene, const Scene* coplanar) {
  const Light& light = scene.lights()[0];
  const char* kind = light.kind == Light::Kind::point ? "point" : "sun";
  scene_name_ = name + " " + kind;
  const Shadows exact = cast_shadows(scene, light, single_thread(Kernel::exact, Form::pieces));
  scene_ = {{"scene", name},
            {"light", kind},
            {"facing_faces", exact.stats.facing_faces},
            {"facing_area", exact.stats.facing_area},
            {"lit_area", exact.stats.lit_area}};
  const Errors errors(scene, exact);
  ours(scene, errors);
  if (coplanar) with_shared_planes(*coplanar, errors);
  rays(scene, errors);
  maps(scene, errors);
  if (light.kind == Light::Kind::point) edits(scene);
}

void run(const Arguments& a) {
  Bench bench(a);
  for (const Setup& setup : setups()) {
    if (!setup.path.empty() && !std::filesystem::exists(setup.path)) {
      std::printf("%s left out: %s is not installed\n", setup.name.c_str(), setup.path.c_str());
      continue;
    }
    std::vector<Scene> scenes{setup.make(default_coplanarity)};
    if (!setup.path.empty()) scenes.push_back(setup.make(kFloatCoplanarity));
    const Scene* coplanar = setup.path.empty() ? nullptr : &scenes[1];
    bench.run(setup.name, scenes[0], coplanar);
    if (!setup.sun) continue;
    for (Scene& scene : scenes)
      scene.replace_lights(std::vector<Light>{Light::directional({0.4131, 0.2713, -1})});
    bench.run(setup.name, scenes[0], coplanar);
  }
  write_json(a.json, bench.json());
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  CLI::App app("Time against error, for every way to shadows", "shadowcut_bench_dial");
  app.add_option(
         "--only", a.only,
         "Measure only rows (scene light method parameters) that contain TEXT: \"city:57 point\", "
         "\"rays 256\", edits")
      ->type_size(1)
      ->allow_extra_args(false);
  app.add_option("--seconds", a.seconds, "Leave out rows that would take longer (5)")
      ->check(CLI::PositiveNumber);
  app.add_option("--json", a.json)->type_name("FILE");
  CLI11_PARSE(app, argc, argv);
  try {
    run(a);
  } catch (const Error& error) {
    std::cerr << "shadowcut_bench_dial: " << error.what() << "\n";
    return 2;
  }
}
