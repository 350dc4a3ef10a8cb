// Measures two ways of joining subtrees in the published tree: the filter of CS95, and the general
// merge of BSP trees that the paper rejected.
//
//   shadowcut_bench_joining [--only SCENE]... [--moves N] [--objects N] [--json FILE]
//
// In each scene up to --objects movable objects, spread evenly over the object list, move in turn
// (the first object, a shell or the ground, stays). A *first* move is the first move of an object
// after the build. The first move and some *next* moves to and fro are measured, remove() and
// insert() together, with a tree for each way of joining. The published tree then holds the shadow
// volumes; it computes no areas or fragments, which the update of the engine does. The size of the
// tree after all moves is reported as a share of a fresh build.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <shadowcut/shadows.hpp>

#include "compare/published_tree.hpp"
#include "json_file.hpp"
#include "scenes.hpp"

namespace {

using namespace shadowcut;
using compare::Joining;
using compare::PublishedTree;
using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Arguments {
  std::vector<std::string> only;
  std::string json;
  std::size_t moves = 200, objects = 40;
};

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

struct Series {
  std::vector<double> ms, visits, partitions, joins;
  ordered_json json() const {
    return {{"count", ms.size()},     {"median_ms", median(ms)},
            {"mean_ms", mean(ms)},    {"worst_ms", *std::max_element(ms.begin(), ms.end())},
            {"visits", mean(visits)}, {"partitions", mean(partitions)},
            {"joins", mean(joins)}};
  }
};

void place(Scene& scene, ObjectId id, const Pose& home, const Vec3& by) {
  if (scene.set_pose(id, Eigen::Translation3d(by) * home) != Status::ok)
    throw Error("the scene did not accept a pose");
}

// Moves every object in turn, a first time and then to and fro. move(object) updates the measured
// tree.
template <class Move>
void for_each_move(Scene& scene, const Arguments& a, const Move& move) {
  std::vector<std::uint32_t> objects;
  const std::size_t count = scene.objects().size() - 1, taken = std::min(a.objects, count);
  for (std::size_t k = 0; k < taken; ++k)
    objects.push_back(static_cast<std::uint32_t>(1 + k * count / taken));
  const std::size_t next = std::max<std::size_t>(1, a.moves / objects.size());
  for (const std::uint32_t object : objects) {
    const ObjectId id = scene.object_id(object);
    const Pose home = scene.objects()[object].pose;
    for (std::size_t k = 0; k <= next; ++k) {
      place(scene, id, home, k % 2 == 0 ? Vec3(0.05, 0.03, 0) : Vec3(0, 0, 0));
      move(object, k == 0);
    }
  }
}

ordered_json published(const scenes::SceneData& data, Joining joining, const Arguments& a) {
  Scene scene = scenes::build(data);
  const Clock::time_point start = Clock::now();
  PublishedTree tree(scene, scene.lights()[0], joining);
  const double build = ms_since(start);
  Series first, next;
  for_each_move(scene, a, [&](std::uint32_t object, bool is_first) {
    const compare::TreeCounts before = tree.counts();
    const Clock::time_point begin = Clock::now();
    tree.remove(object);
    tree.insert(object);
    Series& series = is_first ? first : next;
    series.ms.push_back(ms_since(begin));
    const compare::TreeCounts& after = tree.counts();
    series.visits.push_back(static_cast<double>(after.visits - before.visits));
    series.partitions.push_back(
        static_cast<double>(after.partitions + after.bounded - before.partitions - before.bounded));
    series.joins.push_back(static_cast<double>(after.joins - before.joins));
  });
  const PublishedTree fresh(scene, scene.lights()[0], joining);
  const double growth =
      static_cast<double>(tree.counts().nodes()) / static_cast<double>(fresh.counts().nodes());
  return {{"joining", compare::name_of(joining)},
          {"build_ms", build},
          {"first", first.json()},
          {"next", next.json()},
          {"nodes_fresh", fresh.counts().nodes()},
          {"nodes", tree.counts().nodes()},
          {"growth", growth},
          {"marked", tree.counts().marked}};
}

ordered_json engine(const scenes::SceneData& data, const Arguments& a) {
  Scene scene = scenes::build(data);
  Options options;
  options.threads = 1;
  Engine engine(scene, options);
  const Clock::time_point start = Clock::now();
  engine.update();
  const double build = ms_since(start);
  Series first, next;
  for_each_move(scene, a, [&](std::uint32_t, bool is_first) {
    const Clock::time_point begin = Clock::now();
    engine.update();
    Series& series = is_first ? first : next;
    series.ms.push_back(ms_since(begin));
  });
  Engine fresh(scene, options);
  fresh.update();
  const std::uint64_t nodes = engine.shadows(0).stats.nodes,
                      new_nodes = fresh.shadows(0).stats.nodes;
  return {{"joining", "engine"},
          {"build_ms", build},
          {"first", first.json()},
          {"next", next.json()},
          {"nodes_fresh", new_nodes},
          {"nodes", nodes},
          {"growth", static_cast<double>(nodes) / static_cast<double>(new_nodes)}};
}

void print(const std::string& scene, const ordered_json& row) {
  const auto number = [&](const char* series, const char* what) {
    return row[series].contains(what) ? row[series][what].get<double>() : 0.0;
  };
  std::printf(
      "%-15s %-9s build %9.3f  first %8.4f (mean %8.4f) next %8.4f (mean %8.4f) ms  visits %8.0f "
      "partitions %8.0f (first, mean)  growth "
      "%.2f\n",
      scene.c_str(), row["joining"].get<std::string>().c_str(), row["build_ms"].get<double>(),
      number("first", "median_ms"), number("first", "mean_ms"), number("next", "median_ms"),
      number("next", "mean_ms"), number("first", "visits"), number("first", "partitions"),
      row["growth"].get<double>());
  std::fflush(stdout);
}

void run(const Arguments& a) {
  ordered_json rows = ordered_json::array();
  for (const char* name : {"room:1", "room:2", "room:3", "room:4", "furnished_room", "city:30",
                           "spheres:12", "triangles:500"}) {
    if (!a.only.empty() && std::find(a.only.begin(), a.only.end(), name) == a.only.end()) continue;
    const scenes::SceneData data = scenes::named(name);
    ordered_json row{{"scene", name},
                     {"polygons", scenes::polygon_count(data)},
                     {"ways", ordered_json::array()}};
    for (const Joining joining : {Joining::filter, Joining::merge, Joining::reinsert})
      row["ways"].push_back(published(data, joining, a));
    row["ways"].push_back(engine(data, a));
    for (const ordered_json& way : row["ways"]) print(name, way);
    rows.push_back(std::move(row));
  }
  bench::write_json(a.json, {{"moves", a.moves}, {"objects", a.objects}, {"rows", rows}});
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  CLI::App app("What joining subtrees costs in the published tree", "shadowcut_bench_joining");
  app.add_option("--only", a.only, "Scenes to measure (all)")
      ->type_size(1)
      ->allow_extra_args(false);
  app.add_option("--moves", a.moves, "Next moves per scene (200)")->check(CLI::PositiveNumber);
  app.add_option("--objects", a.objects, "Largest number of objects that move per scene (40)")
      ->check(CLI::PositiveNumber);
  app.add_option("--json", a.json)->type_name("FILE");
  CLI11_PARSE(app, argc, argv);
  try {
    run(a);
  } catch (const Error& error) {
    std::cerr << "shadowcut_bench_joining: " << error.what() << "\n";
    return 2;
  }
}
