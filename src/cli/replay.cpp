// The command replay: applies a script of edits to a scene and reports cost and effect of every
// update.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "changes.hpp"
#include "commands.hpp"
#include "difference.hpp"
#include "edits.hpp"
#include "inputs.hpp"
#include "io/text.hpp"
#include "outputs.hpp"
#include "report.hpp"
#include "specs.hpp"

namespace shadowcut::cli {

namespace {

using nlohmann::ordered_json;

// The effect of one update. Fragments, areas and nodes are sums over the lights.
struct Record {
  std::size_t update = 0, edits = 0;
  double edit_ms = 0, update_ms = 0;  // in Scene, and in Engine::update()
  std::uint64_t gone = 0, fresh = 0;
  // after the update; joined and deferred: since the build
  std::uint64_t fragments = 0, nodes = 0, marked = 0, joined = 0, deferred = 0;
  double lit_area = 0;
  std::size_t issues = 0;  // of the scene, after the update
  bool complete = true;
};

Record record_of(const Engine& engine, const Changes& changes) {
  Record r;
  r.complete = changes.complete;
  for (const LightChanges& light : changes.lights) {
    r.gone += light.gone.size();
    r.fresh += light.added.size();
  }
  for (std::size_t k = 0; k < engine.light_count(); ++k) {
    const Shadows& shadows = engine.shadows(k);
    for (const Block& block : shadows.blocks) r.fragments += block.fragments.size();
    r.nodes += shadows.stats.nodes;
    r.marked += shadows.stats.marked_nodes;
    r.joined += shadows.stats.joined;
    r.deferred += shadows.stats.deferred;
    r.lit_area += shadows.stats.lit_area;
  }
  return r;
}

class Replay {
 public:
  Replay(Scene& scene, const std::vector<Step>& steps, const ReplayArguments& a)
      : scene_(scene),
        steps_(steps),
        arguments_(a),
        bar_(!a.quiet),
        player_(scene, a.edits),
        engine_(scene, with_progress(a.options)) {
    if (!a.changes.empty()) changes_.emplace(a.changes);
  }

  void run() {
    update();
    Record group;
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      if (steps_[i].op != Step::Op::update) {
        const Clock::time_point start = Clock::now();
        player_.apply(steps_[i]);
        group.edit_ms += milliseconds_since(start);
        ++group.edits;
        if (i + 1 < steps_.size()) continue;
      }
      update();
      records_.back().edits = group.edits;
      records_.back().edit_ms = group.edit_ms;
      group = {};
      bar_.show(static_cast<double>(i + 1) / static_cast<double>(steps_.size()));
    }
    rebuild();
  }

  // The build, and then a record for each update.
  const std::vector<Record>& records() const { return records_; }
  double rebuild_ms() const { return rebuild_ms_; }
  const Record& rebuilt() const { return rebuilt_; }
  double max_area_error() const { return max_area_error_; }
  std::optional<ChangesFile>& changes() { return changes_; }

  std::string difference() const {
    if (first_difference_.empty()) return {};
    return arguments_.edits + ": " + first_difference_ +
           "; greatest difference of all updates: " + significant(max_area_error_);
  }

 private:
  Options with_progress(Options options) {
    options.progress = [this](double share) {
      if (records_.empty()) bar_.show(share);  // during the build
    };
    return options;
  }

  void update() {
    const Clock::time_point start = Clock::now();
    const Changes& changes = engine_.update();
    const double ms = milliseconds_since(start);
    Record r = record_of(engine_, changes);
    r.update = records_.size();
    r.update_ms = ms;
    r.issues = scene_.issues().size();
    if (changes_) changes_->write(r.update, engine_, changes);
    records_.push_back(r);
    if (arguments_.verify) verify();
  }

  void verify() {
    for (std::size_t k = 0; k < scene_.lights().size(); ++k) {
      const Light& light = scene_.lights()[k];
      const std::vector<double> shares = difference_shares(
          scene_, engine_.shadows(k), cast_shadows(scene_, light, arguments_.options));
      for (std::uint32_t face = 0; face < shares.size(); ++face) {
        max_area_error_ = std::max(max_area_error_, shares[face]);
        // The tolerance is at least 1e-12.
        if (shares[face] > 1e-12 && first_difference_.empty() &&
            shares[face] > tolerance_of(scene_, light, face, arguments_.options.kernel))
          first_difference_ = sentence(k, {shares[face], face});
      }
    }
  }

  std::string sentence(std::size_t light, const Difference& d) const {
    const Face& face = scene_.faces()[d.face];
    return "update " + std::to_string(records_.back().update) + ", light " + std::to_string(light) +
           ", object '" + io::printable(scene_.objects()[face.object].name) + "', face " +
           std::to_string(face.number) + ": the lit region differs from that of a rebuild by " +
           significant(d.share) + " of the face's area";
  }

  void rebuild() {
    Engine fresh(scene_, arguments_.options);
    const Clock::time_point start = Clock::now();
    const Changes& changes = fresh.update();
    rebuild_ms_ = milliseconds_since(start);
    rebuilt_ = record_of(fresh, changes);
  }

  Scene& scene_;
  const std::vector<Step>& steps_;
  const ReplayArguments& arguments_;
  ProgressBar bar_;
  Player player_;
  Engine engine_;
  std::optional<ChangesFile> changes_;
  std::vector<Record> records_;
  Record rebuilt_;
  double rebuild_ms_ = 0, max_area_error_ = 0;
  std::string first_difference_;
};

void check_outputs(const ReplayArguments& a) {
  if (!a.json.empty() && a.json != "-") check_folder(a.json);
  if (a.changes.empty()) return;
  check_folder(a.changes);
  if (a.changes == "-") throw Error("--changes: '-' is not a file name");
  if (a.changes == a.json) throw Error("--changes and --json: both name the file " + a.json);
}

// The smallest value that is not below a share of all; 0 when there is none.
template <typename Value>
double quantile(std::span<const Record> records, double share, const Value& value) {
  if (records.empty()) return 0;
  std::vector<double> values;
  for (const Record& r : records) values.push_back(static_cast<double>(value(r)));
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::max<std::size_t>(rank, 1) - 1];
}

double update_ms(const Record& r) { return r.update_ms; }

ordered_json json_of(const Record& r) {
  return {{"update", r.update},       {"edits", r.edits},         {"edit_ms", r.edit_ms},
          {"update_ms", r.update_ms}, {"fragments_gone", r.gone}, {"fragments_new", r.fresh},
          {"fragments", r.fragments}, {"lit_area", r.lit_area},   {"tree_nodes", r.nodes},
          {"marked_nodes", r.marked}, {"joined", r.joined},       {"deferred", r.deferred},
          {"issues", r.issues},       {"complete", r.complete}};
}

std::string summary(const Replay& run, const ReplayArguments& a, double load_ms,
                    const Alignment& alignment) {
  const std::span<const Record> updates = std::span(run.records()).subspan(1);
  const std::span<const Record> later = updates.subspan(std::min<std::size_t>(1, updates.size()));
  ordered_json document{{"scene", a.scene},
                        {"script", a.edits},
                        {"kernel", kernel_name(a.options.kernel)},
                        {"threads", a.options.threads},
                        {"load_ms", load_ms},
                        {"aligned", alignment.facets},
                        {"build", json_of(run.records().front())},
                        {"updates", ordered_json::array()}};
  for (const Record& r : updates) document["updates"].push_back(json_of(r));
  document["first_ms"] = updates.empty() ? ordered_json() : ordered_json(updates.front().update_ms);
  document["next_median_ms"] =
      later.empty() ? ordered_json() : ordered_json(quantile(later, 0.5, update_ms));
  document["next_p999_ms"] =
      later.empty() ? ordered_json() : ordered_json(quantile(later, 0.999, update_ms));
  document["rebuild_ms"] = run.rebuild_ms();
  document["rebuild_nodes"] = run.rebuilt().nodes;
  document["max_area_error"] = a.verify ? ordered_json(run.max_area_error()) : ordered_json();
  return document.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

void add_row(Table& table, const std::string& what, const Record& r) {
  table.add({what, thousandths(r.update_ms), std::to_string(r.gone), std::to_string(r.fresh),
             std::to_string(r.fragments), significant(r.lit_area), std::to_string(r.nodes),
             std::to_string(r.marked)});
}

void add_quantile(Table& table, const std::string& what, std::span<const Record> records,
                  double share) {
  const double gone = quantile(records, share, [](const Record& r) { return r.gone; });
  const double fresh = quantile(records, share, [](const Record& r) { return r.fresh; });
  table.add({what, thousandths(quantile(records, share, update_ms)), significant(gone),
             significant(fresh), "", "", "", ""});
}

std::string table(const Replay& run, const Scene& scene, const ReplayArguments& a) {
  const std::span<const Record> updates = std::span(run.records()).subspan(1);
  Table table({"", "ms", "gone", "new", "fragments", "lit area", "nodes", "marked"});
  add_row(table, "build", run.records().front());
  if (!updates.empty()) add_row(table, "first update", updates.front());
  if (updates.size() > 1) {
    add_quantile(table, "next, median", updates.subspan(1), 0.5);
    add_quantile(table, "next, 99.9 %", updates.subspan(1), 0.999);
    add_row(table, "last update", updates.back());
  }
  Record rebuilt = run.rebuilt();
  rebuilt.update_ms = run.rebuild_ms();
  add_row(table, "rebuild", rebuilt);
  std::size_t edits = 0;
  for (const Record& r : updates) edits += r.edits;
  const auto objects = std::count_if(scene.objects().begin(), scene.objects().end(),
                                     [](const Object& o) { return o.alive; });
  std::string text = a.scene + ": " + std::to_string(objects) + " objects, " +
                     std::to_string(scene.lights().size()) +
                     (scene.lights().size() == 1 ? " light" : " lights") + "; " + a.edits + ": " +
                     std::to_string(edits) + " edits, " + std::to_string(updates.size()) +
                     " updates; " + std::to_string(a.options.threads) +
                     (a.options.threads == 1 ? " thread\n" : " threads\n") + table.text();
  const std::size_t before = run.records().front().issues, after = run.records().back().issues;
  if (before != after)
    text += "refused or repaired faces: " + std::to_string(before) + " before the edits, " +
            std::to_string(after) + " after\n";
  if (a.verify)
    text += "greatest difference from a rebuild: " + significant(run.max_area_error()) +
            " of a face's area\n";
  return text;
}

}  // namespace

std::string replay(const ReplayArguments& arguments) {
  ReplayArguments a = arguments;
  a.options.threads = threads_of(a.options.threads);
  // An edited tree cuts faces otherwise than a rebuilt one, so a size leaves out other fragments.
  if (a.verify && !a.options.min_feature.keeps_all())
    throw Error("--verify compares whole regions: it does not go with --min-feature");
  check_outputs(a);
  const std::vector<NamedLight> given = parse_lights(a.lights);
  const std::vector<Step> steps = parse_edits(io::read_bytes(a.edits), a.edits);

  const Clock::time_point start = Clock::now();
  Scene scene = read({a.scene, a.reading, false, a.quiet});
  const double load_ms = milliseconds_since(start);
  const Alignment alignment = alignment_of(scene);
  set_lights(scene, given, a.scene);
  Replay run(scene, steps, a);
  run.run();

  Outputs outputs;
  if (run.changes()) outputs.write(a.changes, [&] { run.changes()->commit(); });
  if (!a.json.empty())
    outputs.write(a.json, [&] { io::write_text(a.json, summary(run, a, load_ms, alignment)); });
  if (!a.quiet && a.json != "-")
    outputs.write("-", [&] { io::write_text("-", sentence(alignment) + table(run, scene, a)); });
  return run.difference();
}

}  // namespace shadowcut::cli
