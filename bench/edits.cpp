// Measures the time of updates.
//
//   shadowcut_bench_edits --json bench/baseline/edits.json [--only TEXT]... [--moves N]
//     [--long MOVES]
//
// Every row moves one object or several objects to and fro, and measures two times with a steady
// clock: Engine::update() alone, and the edit of the scene with the update. A *first* move is the
// first move of an object after a build; all later moves are *next* moves. Rows:
//
//   table2   the scenes and objects of Chrysanthou & Slater 1995, table 2
//   city     a building moves by 0.05, in cities of 64 to 99 856 buildings; nine buildings in turn
//   spheres  a sphere of median size moves by 0.05, among 6 to 100 spheres
//   desk     a desk of the furnished room
//   ground   the face under 1 024 buildings
//   frame    200 prisms of 20 faces, known as dynamic, move at once in the streets of the city of
//            10 000 buildings, on one and on two threads
//   long     (with --long) buildings move in turn in the city of 1 024; size of the tree and time
//            of updates at intervals
//
// Times are the minimum, the median and the 99.9 % quantile. The speed of a shared machine drifts,
// so compare ratios of one run.
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <shadowcut/shadows.hpp>

#include "json_file.hpp"
#include "scenes.hpp"

namespace {

using namespace shadowcut;
using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Arguments {
  std::vector<std::string> only;
  std::string json;
  std::size_t moves = 2000, builds = 5, long_moves = 0;
  std::uint32_t largest_city = 316, largest_spheres = 100;
  unsigned threads = 1;
  std::uint32_t join_threshold = Options().tuning.join_threshold;
};

double ms_between(Clock::time_point a, Clock::time_point b) {
  return std::chrono::duration<double, std::milli>(b - a).count();
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::max<std::size_t>(rank, 1) - 1];
}

ordered_json times(const std::vector<double>& ms) {
  return {{"count", ms.size()},
          {"min", quantile(ms, 0)},
          {"median", quantile(ms, 0.5)},
          {"p999", quantile(ms, 0.999)}};
}

// Some objects that move together.
struct Party {
  std::vector<ObjectId> objects;
  std::vector<Pose> homes;
  std::uint64_t faces = 0;

  void add(const Scene& scene, std::size_t index) {
    objects.push_back(scene.object_id(index));
    homes.push_back(scene.objects()[index].pose);
    faces += scene.objects()[index].face_count;
  }
};

Party party_named(const Scene& scene, const std::vector<std::string>& names) {
  Party party;
  for (const std::string& name : names) {
    const auto objects = scene.objects();
    const auto it = std::find_if(objects.begin(), objects.end(),
                                 [&](const Object& o) { return o.name == name; });
    if (it == objects.end()) throw Error("the scene has no object " + name);
    party.add(scene, static_cast<std::size_t>(it - objects.begin()));
  }
  return party;
}

void place(Scene& scene, const Party& party, const Vec3& by) {
  for (std::size_t i = 0; i < party.objects.size(); ++i) {
    if (scene.set_pose(party.objects[i], Eigen::Translation3d(by) * party.homes[i]) != Status::ok)
      throw Error("the scene did not accept a pose");
  }
}

// Times and counts of a series of moves.
struct Series {
  std::vector<double> update, total, gone, fresh;  // total: with the edit of the scene

  void move(Scene& scene, Engine& engine, const Party& party, const Vec3& by) {
    const Clock::time_point start = Clock::now();
    place(scene, party, by);
    const Clock::time_point edited = Clock::now();
    const Changes& changes = engine.update();
    const Clock::time_point end = Clock::now();
    update.push_back(ms_between(edited, end));
    total.push_back(ms_between(start, end));
    std::size_t g = 0, f = 0;
    for (const LightChanges& light : changes.lights)
      g += light.gone.size(), f += light.added.size();
    gone.push_back(static_cast<double>(g)), fresh.push_back(static_cast<double>(f));
  }

  ordered_json json() const {
    return {{"update_ms", times(update)},
            {"edit_and_update_ms", times(total)},
            {"gone", quantile(gone, 0.5)},
            {"new", quantile(fresh, 0.5)}};
  }
};

double build_ms(Engine& engine) {
  const Clock::time_point start = Clock::now();
  engine.update();
  return ms_between(start, Clock::now());
}

// The one-off cast, which keeps no data for updates.
double cast_ms(const Scene& scene, const Options& o) {
  const Clock::time_point start = Clock::now();
  const Shadows shadows = cast_shadows(scene, scene.lights()[0], o);
  return ms_between(start, Clock::now());
}

// The rows; each is printed when it is complete.
class Bench {
 public:
  explicit Bench(const Arguments& a) : arguments_(a) {}

  Options options(unsigned threads) const {
    Options o;
    o.threads = threads;
    o.tuning.join_threshold = arguments_.join_threshold;
    return o;
  }
  Options options() const { return options(arguments_.threads); }

  bool wanted(const std::string& group) const {
    const auto holds = [&group](const std::string& text) {
      return group.find(text) != std::string::npos;
    };
    return arguments_.only.empty() ||
           std::any_of(arguments_.only.begin(), arguments_.only.end(), holds);
  }

  // Each group of objects makes a first move after a build, and its share of the next moves after
  // the last build.
  void row(const std::string& group, const std::string& name, Scene& scene,
           const std::vector<Party>& parties, const Vec3& step, const Options& o) {
    std::vector<double> builds, plain;
    Series first, next;
    const std::size_t turns = std::max<std::size_t>(arguments_.builds, 1);
    Stats before, after;
    for (std::size_t turn = 0; turn < turns; ++turn) {
      Engine engine(scene, o);
      builds.push_back(build_ms(engine));
      plain.push_back(cast_ms(scene, o));
      before = engine.shadows(0).stats;
      const bool is_last = turn + 1 == turns;
      for (const Party& party : parties) {
        first.move(scene, engine, party, step);
        const std::size_t share =
            is_last ? std::max<std::size_t>(1, arguments_.moves / parties.size()) : 0;
        for (std::size_t k = 0; k < share; ++k)
          next.move(scene, engine, party, k % 2 == 0 ? Vec3(Vec3::Zero()) : step);
        place(scene, party, Vec3::Zero());
        engine.update();
      }
      after = engine.shadows(0).stats;
    }
    std::uint64_t moved = 0, faces = 0;
    for (const Object& object : scene.objects()) faces += object.face_count;
    for (const Party& party : parties) moved += party.faces;
    ordered_json entry{{"group", group},
                       {"name", name},
                       {"threads", o.threads},
                       {"faces", faces},
                       {"facing_faces", before.facing_faces},
                       {"moved_faces", moved / parties.size()},
                       {"rebuild_ms", times(builds)},
                       {"cast_ms", times(plain)},
                       {"first", first.json()},
                       {"next", next.json()},
                       {"nodes", before.nodes},
                       {"nodes_after", after.nodes},
                       {"marked_nodes", after.marked_nodes},
                       {"longest_location_list", after.longest_location_list},
                       {"joined", after.joined},
                       {"deferred", after.deferred}};
    const double rebuild = quantile(builds, 0.5);
    entry["first_share"] = quantile(first.update, 0.5) / rebuild;
    entry["next_share"] = quantile(next.update, 0.5) / rebuild;
    std::printf(
        "%-10s %-26s %8llu faces  rebuild %9.3f  first %9.4f  next %9.4f  99.9 %% %9.4f ms  gone "
        "%6.0f new %6.0f\n",
        group.c_str(), name.c_str(), static_cast<unsigned long long>(faces), rebuild,
        quantile(first.update, 0.5), quantile(next.update, 0.5), quantile(next.update, 0.999),
        quantile(next.gone, 0.5), quantile(next.fresh, 0.5));
    std::fflush(stdout);
    rows_.push_back(std::move(entry));
  }

  void add_long(ordered_json points) { long_ = std::move(points); }

  ordered_json json() const {
    ordered_json document{{"moves", arguments_.moves},
                          {"builds", arguments_.builds},
                          {"join_threshold", arguments_.join_threshold},
                          {"rows", rows_}};
    if (!long_.is_null()) document["long"] = long_;
    return document;
  }

  const Arguments& arguments() const { return arguments_; }

 private:
  const Arguments& arguments_;
  ordered_json rows_ = ordered_json::array(), long_;
};

// ---- the rows

void table2(Bench& bench) {
  struct Row {
    int level;
    const char* what;
    std::vector<std::string> objects;
  };
  const std::vector<Row> rows{{1, "computer", {"computer.1", "screen.1"}},
                              {2, "computer", {"computer.1", "screen.1"}},
                              {2, "bookcase", {"bookcase.1", "book.1", "book.2"}},
                              {3, "computer", {"computer.1", "screen.1"}},
                              {4, "computer", {"computer.1", "screen.1"}},
                              {4, "computer and desk", {"desk.5", "computer.8", "screen.8"}}};
  for (const Row& r : rows) {
    Scene scene = scenes::build(scenes::room(r.level));
    const Party party = party_named(scene, r.objects);
    bench.row("table2", "room:" + std::to_string(r.level) + " " + r.what, scene, {party},
              {0.05, 0.03, 0}, bench.options());
  }
}

void desk(Bench& bench) {
  Scene scene = scenes::build(scenes::furnished_room());
  for (const char* name : {"desk.5", "chair.4"})
    bench.row("desk", std::string("furnished_room ") + name, scene, {party_named(scene, {name})},
              {0.05, 0.03, 0}, bench.options());
}

void city(Bench& bench) {
  for (const std::uint32_t n : {8u, 16u, 32u, 57u, 100u, 178u, 316u}) {
    if (n > bench.arguments().largest_city) continue;
    Scene scene = scenes::build(scenes::city(n));
    std::vector<Party> parties;
    for (const std::uint32_t y : {1u, 4u, 7u})
      for (const std::uint32_t x : {1u, 4u, 7u})
        parties.push_back(party_named(
            scene, {"house." + std::to_string(x * n / 8) + "." + std::to_string(y * n / 8)}));
    bench.row("city", "city:" + std::to_string(n), scene, parties, {0.05, 0, 0}, bench.options());
  }
}

void ground(Bench& bench) {
  Scene scene = scenes::build(scenes::city(32));
  bench.row("ground", "city:32 ground", scene, {party_named(scene, {"ground"})}, {0.05, 0, 0},
            bench.options());
}

void spheres(Bench& bench) {
  for (const std::uint32_t n : {6u, 12u, 25u, 50u, 100u}) {
    if (n > bench.arguments().largest_spheres) continue;
    Scene scene = scenes::build(scenes::spheres(n, 64, 33));
    std::vector<std::size_t> by_volume;
    // the first object is the ground
    for (std::size_t i = 1; i < scene.objects().size(); ++i) by_volume.push_back(i);
    const auto middle = by_volume.begin() + n / 2;
    std::nth_element(by_volume.begin(), middle, by_volume.end(), [&](std::size_t a, std::size_t b) {
      return scene.objects()[a].signed_volume < scene.objects()[b].signed_volume;
    });
    Party party;
    party.add(scene, *middle);
    bench.row("spheres", "spheres:" + std::to_string(n), scene, {party}, {0.05, 0, 0},
              bench.options());
  }
}

// A prism of 20 faces that stands in the middle of a crossing.
Mesh pillar(double x, double y) {
  std::vector<Vec3> base;
  for (int k = 0; k < 18; ++k) {  // clockwise from above, which is counter-clockwise from below
    const double turn = -2 * std::numbers::pi * k / 18;
    base.emplace_back(scenes::to_grid(x + 0.05 * std::cos(turn)),
                      scenes::to_grid(y + 0.05 * std::sin(turn)), 0);
  }
  return scenes::prism(base, {0, 0, 0.25});
}

void frame(Bench& bench) {
  const std::uint32_t n = std::min(100u, bench.arguments().largest_city);
  Scene scene = scenes::build(scenes::city(n));
  scenes::Random random(200);
  std::set<std::uint64_t> crossings;
  while (crossings.size() < std::min<std::size_t>(200, (n - 1) * (n - 1)))
    crossings.insert(random.below((n - 1) * (n - 1)));
  Party party;
  for (const std::uint64_t c : crossings) {
    const Mesh mesh =
        pillar(static_cast<double>(1 + c % (n - 1)), static_cast<double>(1 + c / (n - 1)));
    const ObjectId id = scene.add(mesh, {.name = "pillar." + std::to_string(c), .dynamic = true});
    party.add(scene, id.index);
  }
  for (const unsigned threads : {1u, 2u}) {
    const std::string name =
        "city:" + std::to_string(n) + " 200 x 20, threads:" + std::to_string(threads);
    bench.row("frame", name, scene, {party}, {0, 0.03, 0}, bench.options(threads));
  }
}

// Buildings move at random; every tenth move returns a building to its first position.
void long_run(Bench& bench) {
  Scene scene = scenes::build(scenes::city(std::min(32u, bench.arguments().largest_city)));
  std::vector<Party> houses;
  for (std::size_t i = 1; i < scene.objects().size(); ++i) {
    houses.emplace_back();
    houses.back().add(scene, i);
  }
  scenes::Random random(100000);
  Engine engine(scene, bench.options());
  engine.update();
  const std::size_t interval = std::max<std::size_t>(1, bench.arguments().long_moves / 20);
  ordered_json points = ordered_json::array();
  Series series;
  for (std::size_t k = 1; k <= bench.arguments().long_moves; ++k) {
    const Party& house = houses[random.below(houses.size())];
    const Vec3 by = random.in_ball(0.25);
    series.move(scene, engine, house,
                random.below(10) == 0 ? Vec3(Vec3::Zero()) : Vec3(by.x(), by.y(), 0));
    if (k % interval != 0) continue;
    Engine fresh(scene, bench.options());
    const double rebuild = build_ms(fresh);
    const Stats &now = engine.shadows(0).stats, &new_one = fresh.shadows(0).stats;
    points.push_back({{"moves", k},
                      {"update_ms", times(series.update)},
                      {"nodes", now.nodes},
                      {"marked_nodes", now.marked_nodes},
                      {"bytes", now.bytes},
                      {"pieces", now.pieces},
                      {"fragments", now.lit_fragments + now.shadowed_fragments},
                      {"rebuild_ms", rebuild},
                      {"rebuild_nodes", new_one.nodes},
                      {"rebuild_bytes", new_one.bytes},
                      {"rebuild_fragments", new_one.lit_fragments + new_one.shadowed_fragments}});
    std::printf(
        "long %9zu moves: median %9.4f ms, 99.9 %% %9.4f ms, nodes %8llu (%.3f of a rebuild's), "
        "marked %llu\n",
        k, quantile(series.update, 0.5), quantile(series.update, 0.999),
        static_cast<unsigned long long>(now.nodes),
        static_cast<double>(now.nodes) / static_cast<double>(new_one.nodes),
        static_cast<unsigned long long>(now.marked_nodes));
    std::fflush(stdout);
    series = {};
  }
  bench.add_long(std::move(points));
}

void run(const Arguments& a) {
  Bench bench(a);
  const std::pair<const char*, void (*)(Bench&)> groups[] = {
      {"table2", table2}, {"desk", desk},   {"city", city},
      {"ground", ground}, {"frame", frame}, {"spheres", spheres}};
  for (const auto& [name, group] : groups)
    if (bench.wanted(name)) group(bench);
  if (a.long_moves > 0) long_run(bench);
  bench::write_json(a.json, bench.json());
}

}  // namespace

int main(int argc, char** argv) {
  // Freed memory stays in the process, so that repeats measure the engine and not the operating
  // system, which clears new pages.
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  Arguments a;
  CLI::App app("What updates cost", "shadowcut_bench_edits");
  app.add_option(
         "--only", a.only,
         "Measure only groups whose names contain TEXT: table2, desk, city, ground, frame, spheres")
      ->type_size(1)
      ->allow_extra_args(false);
  app.add_option("--moves", a.moves, "Next moves per row (2000)")->check(CLI::PositiveNumber);
  app.add_option("--builds", a.builds, "Builds, and first moves of each object, per row (5)")
      ->check(CLI::PositiveNumber);
  app.add_option("--threads", a.threads, "Threads of all rows except frame (1)");
  app.add_option("--largest-city", a.largest_city, "Leave out cities with more buildings per side")
      ->check(CLI::Range(8, 316));
  app.add_option("--largest-spheres", a.largest_spheres, "Leave out scenes with more spheres")
      ->check(CLI::Range(6, 100));
  app.add_option("--join-threshold", a.join_threshold, "Options::Tuning::join_threshold");
  app.add_option("--long", a.long_moves, "Also make this number of moves in one engine");
  app.add_option("--json", a.json)->type_name("FILE");
  CLI11_PARSE(app, argc, argv);
  try {
    run(a);
  } catch (const Error& error) {
    std::cerr << "shadowcut_bench_edits: " << error.what() << "\n";
    return 2;
  }
}
