// Measures one-off casts of generated scenes of growing size.
//
//   shadowcut_bench --benchmark_repetitions=5 --benchmark_out=bench/baseline/cast.json
//     --benchmark_out_format=json
//
// A row is one call of cast_shadows, on one or on two threads. Counters: nanoseconds per facing
// face; build and emission (minimum over the iterations, in ms); nodes, fragments and bytes; and a
// hash of every fragment, which is the same for any number of threads. The speed of a shared
// machine drifts, so compare ratios of one run and minima of repeats.

#include <benchmark/benchmark.h>
#include <malloc.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <map>
#include <memory>
#include <shadowcut/shadows.hpp>

#include "scenes.hpp"

namespace {

using namespace shadowcut;

// The scene of the current rows. It is generated once and replaced when a row needs another scene.
const std::pair<Scene, Light>& scene_of(const std::string& name,
                                        const std::function<scenes::SceneData()>& make) {
  static std::string held;
  static std::unique_ptr<std::pair<Scene, Light>> scene;
  if (held != name) {
    scene.reset();
    const scenes::SceneData data = make();
    scene = std::make_unique<std::pair<Scene, Light>>(scenes::build(data), data.light);
    held = name;
  }
  return *scene;
}

std::uint64_t hash_of(const Shadows& shadows) {
  std::uint64_t h = 14695981039346656037ull;
  const auto add = [&h](std::uint64_t v) { h = (h ^ v) * 1099511628211ull; };
  for (const Block& b : shadows.blocks) {
    for (const Fragment& f : b.fragments) {
      add(f.face), add(f.caster), add(f.lit);
      for (const Vec3& x : b.corners_of(f)) {
        for (int i = 0; i < 3; ++i) add(std::bit_cast<std::uint64_t>(x[i] + 0.0));
      }
    }
  }
  return h;
}

void cast(benchmark::State& state, const std::string& name,
          const std::function<scenes::SceneData()>& make, unsigned threads) {
  const auto& [scene, light] = scene_of(name, make);
  Options options;
  options.threads = threads;
  Stats stats;
  double build = 1e300, emit = 1e300;
  std::uint64_t hash = 0;
  for (auto _ : state) {
    const Shadows shadows = cast_shadows(scene, light, options);
    stats = shadows.stats;
    build = std::min(build, stats.build_ms), emit = std::min(emit, stats.emit_ms);
    state.PauseTiming();
    hash = hash_of(shadows);
    state.ResumeTiming();
  }
  const auto count = [](std::uint64_t n) { return static_cast<double>(n); };
  state.counters["faces"] = count(stats.facing_faces);
  state.counters["ns_per_face"] = (build + emit) * 1e6 / count(stats.facing_faces);
  state.counters["build_ms"] = build;
  state.counters["emit_ms"] = emit;
  state.counters["nodes"] = count(stats.nodes);
  state.counters["lit"] = count(stats.lit_fragments);
  state.counters["shadowed"] = count(stats.shadowed_fragments);
  state.counters["bytes"] = count(stats.bytes);
  state.counters["predicates"] = count(stats.predicates);
  state.counters["hash48"] = count(hash >> 16);  // a counter is a double: 48 bits fit
}

void add(const std::string& name, const std::function<scenes::SceneData()>& make) {
  for (const unsigned threads : {1u, 2u}) {
    benchmark::RegisterBenchmark((name + "/threads:" + std::to_string(threads)).c_str(),
                                 [=](benchmark::State& s) { cast(s, name, make, threads); })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  }
}

}  // namespace

int main(int argc, char** argv) {
  // Freed memory stays in the process, so that repeats measure the engine and not the operating
  // system, which clears new pages.
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  add("furnished_room", [] { return scenes::furnished_room(); });
  for (int level = 1; level <= 4; ++level)
    add("room:" + std::to_string(level), [=] { return scenes::room(level); });
  for (int depth = 2; depth <= 6; ++depth)
    add("tetrahedron:" + std::to_string(depth), [=] { return scenes::tetrahedron(depth); });
  for (const std::uint32_t n : {18u, 32u, 57u, 100u, 178u, 316u})
    add("city:" + std::to_string(n), [=] { return scenes::city(n); });
  for (const std::uint32_t n : {6u, 12u, 25u, 50u, 100u})
    add("spheres:" + std::to_string(n), [=] { return scenes::spheres(n, 64, 33); });
  for (const std::uint32_t n : {1000u, 3000u, 10000u, 30000u, 100000u})
    add("triangles:" + std::to_string(n), [=] { return scenes::triangles(n); });
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
