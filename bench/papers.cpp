// Measures the tables of the papers again: Slater 1992, tables 1 to 3; Chrysanthou & Slater 1995,
// table 1 (bench/edits.cpp measures table 2). Also measures how the same algorithms grow with the
// scene, beside clipping face by face, Embree's rays, and CGAL.
//
//   shadowcut_bench_papers --json bench/baseline/papers.json [--only slater|cs95|growth]...
//     [--seconds S]
//
// The printed figures come from a SPARCstation, so only ratios compare. bench/papers_report.py sets
// them beside ours and writes docs/papers.md. In the tables all algorithms are as published: the
// first polygon is the root of each subtree of the scene BSP (Slater 1992, section 6), and the
// ordered tree does not merge its fragments. In the growth rows the scene BSP chooses among eight
// candidates, and fragments are merged.
//
// Times are the smallest of some runs, in milliseconds on one thread. The tables exclude the scene
// BSP, as Slater's do.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "cgal_oracle.hpp"
#include "clipping.hpp"
#include "compare.hpp"
#include "json_file.hpp"
#include "samplers.hpp"
#include "scenes.hpp"

namespace {

using namespace shadowcut;
using compare::Algorithm;
using compare::Result;
using compare::Settings;
using nlohmann::ordered_json;

struct Arguments {
  std::vector<std::string> only;
  std::string json;
  double seconds = 10;
};

// Whether to run once more: several runs, but only one run that takes long.
bool again(int runs, double spent_ms) {
  return runs < 25 && (runs < 2 || spent_ms < 300) && spent_ms < 2000;
}

// The smallest times. Counts are the same in all runs.
std::vector<Result> best_of(const Scene& scene, std::span<const Light> lights, Algorithm algorithm,
                            const Settings& settings) {
  std::vector<Result> best;
  double spent = 0;
  for (int run = 0; again(run, spent); ++run) {
    std::vector<Result> results = compare::cast(scene, lights, algorithm, settings);
    for (std::size_t k = 0; k < results.size(); ++k) {
      results[k].fragments = {};
      spent += results[k].order_ms + results[k].shadow_ms;
      if (run == 0) continue;
      results[k].order_ms = std::min(results[k].order_ms, best[k].order_ms);
      results[k].shadow_ms = std::min(results[k].shadow_ms, best[k].shadow_ms);
    }
    best = std::move(results);
  }
  return best;
}

ordered_json row_of(const std::vector<Result>& results) {
  double shadow_ms = 0, order_ms = 0;
  std::uint64_t shadow_polygons = 0;
  for (const Result& r : results)
    shadow_ms += r.shadow_ms, order_ms += r.order_ms, shadow_polygons += r.shadow_polygons;
  const Result& last = results.back();
  return {{"faces_in", last.faces_in},
          {"faces_after_bsp", last.faces_after_bsp},
          {"order_ms", order_ms},
          {"shadow_ms", shadow_ms},
          {"shadow_polygons", shadow_polygons},
          {"lit_fragments", last.lit_fragments},
          {"shadowed_fragments", last.shadowed_fragments},
          {"memory_bytes", last.memory_bytes}};
}

ordered_json run(const Scene& scene, std::span<const Light> lights, Algorithm algorithm,
                 const Settings& settings) {
  std::vector<Result> results = best_of(scene, lights, algorithm, settings);
  if (algorithm == Algorithm::brute || algorithm == Algorithm::tiling) {
    Settings counting = settings;
    counting.count_shadow_polygons = true;
    const std::vector<Result> counted = compare::cast(scene, lights, algorithm, counting);
    for (std::size_t k = 0; k < results.size(); ++k)
      results[k].shadow_polygons = counted[k].shadow_polygons;
  }
  return row_of(results);
}

Settings as_published() {
  Settings settings;
  settings.candidates = 1;
  settings.reunite = false;
  return settings;
}

ordered_json slater_row(const scenes::SceneData& data, std::span<const Light> lights) {
  const Scene scene = scenes::build(data);
  ordered_json row{{"scene", data.name}, {"lights", lights.size()}};
  row["basic"] = run(scene, lights, Algorithm::brute, as_published());
  row["tiling"] = run(scene, lights, Algorithm::tiling, as_published());
  row["svbsp"] = run(scene, lights, Algorithm::ordered, as_published());
  row["engine"] = run(scene, lights, Algorithm::unordered, {});
  std::cout << "slater 1992: " << data.name << ", " << lights.size() << " lights" << std::endl;
  return row;
}

// Slater 1992, section 6: "the figures in the next section are all based on an array size 128 x
// 128. This turned out to be the optimal resolution amongst the range considered".
ordered_json resolutions() {
  ordered_json rows = ordered_json::array();
  for (const scenes::SceneData& data :
       {scenes::slater_room(10), scenes::tetrahedron(3), scenes::tetrahedron(4)}) {
    const Scene scene = scenes::build(data);
    for (const std::uint32_t tiles : {4u, 8u, 16u, 32u, 64u, 128u, 256u}) {
      Settings settings = as_published();
      settings.tiles = tiles;
      ordered_json row = run(scene, {&data.light, 1}, Algorithm::tiling, settings);
      row["scene"] = data.name, row["tiles"] = tiles;
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

ordered_json slater() {
  ordered_json rows = ordered_json::array();
  for (std::size_t count = 1; count <= 2; ++count) {
    for (int k = 1; k <= 10; ++k) {
      const scenes::SceneData data = scenes::slater_room(k);
      const std::vector<Light> lights{data.light, scenes::light_at_the_door()};
      rows.push_back(slater_row(data, std::span(lights).first(count)));
    }
  }
  for (int depth = 2; depth <= 4; ++depth) {
    const scenes::SceneData data = scenes::tetrahedron(depth);
    rows.push_back(slater_row(data, {&data.light, 1}));
  }
  return rows;
}

ordered_json cs95() {
  ordered_json rows = ordered_json::array();
  for (int level = 1; level <= 4; ++level) {
    const scenes::SceneData data = scenes::room(level);
    const Scene scene = scenes::build(data);
    const std::span<const Light> light(&data.light, 1);
    Settings after_bsp = as_published(), united;
    after_bsp.after_bsp = true;
    Settings united_after_bsp = after_bsp;
    united_after_bsp.reunite = true;
    ordered_json row{{"scene", data.name}};
    row["s_svbsp"] = run(scene, light, Algorithm::ordered, as_published());
    row["s_svbsp_reunited"] = run(scene, light, Algorithm::ordered, united);
    row["u_svbsp_after_bsp"] = run(scene, light, Algorithm::unordered, after_bsp);
    row["u_svbsp_after_bsp_reunited"] = run(scene, light, Algorithm::unordered, united_after_bsp);
    row["u_svbsp"] = run(scene, light, Algorithm::unordered, as_published());
    row["u_svbsp_reunited"] = run(scene, light, Algorithm::unordered, united);
    rows.push_back(std::move(row));
    std::cout << "chrysanthou and slater 1995: " << data.name << std::endl;
  }
  return rows;
}

// ---- growth

struct Family {
  const char* name;
  // sizes: the first; each next size has about this many times the faces
  std::uint32_t first, factor;
  scenes::SceneData (*make)(std::uint32_t size);
};

constexpr Family families[] = {
    {"tetrahedron", 1, 4, [](std::uint32_t n) { return scenes::tetrahedron(static_cast<int>(n)); }},
    {"city", 3, 2, [](std::uint32_t n) { return scenes::city(n); }},
    {"triangles", 50, 2, [](std::uint32_t n) { return scenes::triangles(n); }},
};

std::uint32_t next_size(const Family& family, std::uint32_t size) {
  if (family.factor == 4) return size + 1;  // a level
  return std::string_view(family.name) == "city"
             ? static_cast<std::uint32_t>(std::ceil(size * std::sqrt(2.0)))
             : size * 2;
}

struct Contestant {
  const char* name;
  ordered_json (*run)(const Scene& scene, const Light& light);
};

ordered_json timed(Algorithm algorithm, const Scene& scene, const Light& light) {
  return row_of(best_of(scene, {&light, 1}, algorithm, {}));
}

// The lit area of the scene by another method, and the time.
template <class LitArea>
ordered_json timed(const LitArea& lit_area) {
  double best = std::numeric_limits<double>::infinity(), spent = 0, area = 0;
  for (int run = 0; again(run, spent); ++run) {
    const auto start = std::chrono::steady_clock::now();
    area = lit_area();
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    best = std::min(best, ms), spent += ms;
  }
  return {{"order_ms", 0}, {"shadow_ms", best}, {"lit_area", area}};
}

ordered_json clipped(const Scene& scene, const Light& light) {
  return timed([&] { return bench::clip_every_face(scene, light).lit_area; });
}

// 256 rays per face. The time of choosing the faces is not counted.
ordered_json with_rays(const Scene& scene, const Light& light) {
  const bench::Receivers receivers(scene, light, cast_shadows(scene, light).areas);
  static const bench::RayDevice device;
  return timed([&] {
    const bench::Rays rays(device, scene, light);
    const auto is_lit = [&](const Vec3& x, const Vec3& normal) { return rays.is_lit(x, normal); };
    const std::vector<double> areas =
        bench::areas_where(receivers, receivers.strata(256, false), is_lit);
    return std::accumulate(areas.begin(), areas.end(), 0.0);
  });
}

// The oracle of the tests: every face against every other face, with CGAL's exact numbers.
ordered_json exactly(const Scene& scene, const Light& light) {
  return timed([&] {
    double sum = 0;
    for (const testing::CgalOracle::Area& area : testing::CgalOracle(scene, light).areas())
      sum += area.lit;
    return sum;
  });
}

constexpr Contestant contestants[] = {
    {"brute", [](const Scene& s, const Light& l) { return timed(Algorithm::brute, s, l); }},
    {"tiling", [](const Scene& s, const Light& l) { return timed(Algorithm::tiling, s, l); }},
    {"ordered", [](const Scene& s, const Light& l) { return timed(Algorithm::ordered, s, l); }},
    {"unordered", [](const Scene& s, const Light& l) { return timed(Algorithm::unordered, s, l); }},
    {"clipper", clipped},
    {"rays", with_rays},
    {"cgal", exactly},
};

ordered_json growth(double seconds) {
  ordered_json rows = ordered_json::array();
  for (const Family& family : families) {
    std::map<std::string, bool> too_slow;
    for (std::uint32_t size = family.first; too_slow.size() < std::size(contestants);
         size = next_size(family, size)) {
      const scenes::SceneData data = family.make(size);
      const Scene scene = scenes::build(data);
      for (const Contestant& contestant : contestants) {
        if (too_slow.contains(contestant.name)) continue;
        ordered_json row{{"family", family.name},
                         {"size", size},
                         {"faces", scene.faces().size()},
                         {"algorithm", contestant.name}};
        row.update(contestant.run(scene, data.light));
        const double ms = row["order_ms"].get<double>() + row["shadow_ms"].get<double>();
        if (ms > 1000 * seconds) too_slow[contestant.name] = true;
        std::printf("growth: %s %u, %zu faces, %s: %.3f ms\n", family.name, size,
                    scene.faces().size(), contestant.name, ms);
        std::fflush(stdout);
        rows.push_back(std::move(row));
      }
    }
  }
  return rows;
}

void run(const Arguments& a) {
  const auto wanted = [&](const char* group) {
    return a.only.empty() || std::find(a.only.begin(), a.only.end(), group) != a.only.end();
  };
  ordered_json document;
  if (wanted("slater")) document["slater1992"] = slater(), document["resolutions"] = resolutions();
  if (wanted("cs95")) document["cs95"] = cs95();
  if (wanted("growth")) document["growth"] = growth(a.seconds);
  bench::write_json(a.json, document);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  CLI::App app("The papers' tables, made again", "shadowcut_bench_papers");
  app.add_option("--only", a.only, "slater, cs95, growth")
      ->check(CLI::IsMember({"slater", "cs95", "growth"}))
      ->allow_extra_args(false);
  app.add_option("--json", a.json, "Results")->type_name("FILE");
  app.add_option("--seconds", a.seconds,
                 "growth: time after which an algorithm gets no larger scenes (10)");
  CLI11_PARSE(app, argc, argv);
  try {
    run(a);
  } catch (const std::exception& error) {
    std::cerr << "shadowcut_bench_papers: " << error.what() << std::endl;
    return 2;
  }
}
