// The command compare: runs published algorithms on one scene.
#include "compare/compare.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "inputs.hpp"
#include "outputs.hpp"
#include "report.hpp"

namespace shadowcut::cli {

namespace {

using compare::Algorithm;
using nlohmann::ordered_json;

struct Row {
  std::string algorithm, light;
  compare::Result result;
};

std::vector<Algorithm> parse_algorithms(const std::string& list) {
  std::vector<Algorithm> algorithms;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    const std::string name = list.substr(begin, end - begin);
    bool known = false;
    for (const Algorithm a :
         {Algorithm::brute, Algorithm::ordered, Algorithm::tiling, Algorithm::unordered}) {
      if (name != compare::name_of(a)) continue;
      known = true;
      if (std::find(algorithms.begin(), algorithms.end(), a) != algorithms.end())
        throw Error("--algorithms: '" + name + "' is given twice");
      algorithms.push_back(a);
    }
    if (!known)
      throw Error("--algorithms: '" + name + "' is not one of brute, ordered, tiling, unordered");
    begin = end + 1;
  }
  return algorithms;
}

std::vector<Row> run(const Scene& scene, const std::vector<NamedLight>& lights,
                     const std::vector<Algorithm>& algorithms, const compare::Settings& settings) {
  std::vector<Row> rows;
  for (const Algorithm a : algorithms) {
    std::vector<compare::Result> results = compare::cast(scene, scene.lights(), a, settings);
    for (std::size_t k = 0; k < results.size(); ++k) {
      results[k].fragments = {};  // only their counts are reported
      rows.push_back({compare::name_of(a), lights[k].spec, std::move(results[k])});
    }
  }
  return rows;
}

std::string json_text(const std::vector<Row>& rows) {
  ordered_json document = ordered_json::array();
  for (const Row& row : rows) {
    const compare::Result& r = row.result;
    document.push_back({{"algorithm", row.algorithm},
                        {"light", row.light},
                        {"faces_in", r.faces_in},
                        {"faces_after_bsp", r.faces_after_bsp},
                        {"lit_area", r.lit_area},
                        {"shadowed_area", r.shadowed_area},
                        {"lit_fragments", r.lit_fragments},
                        {"shadowed_fragments", r.shadowed_fragments},
                        {"order_ms", r.order_ms},
                        {"shadow_ms", r.shadow_ms},
                        {"memory_bytes", r.memory_bytes}});
  }
  return document.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string table(const std::vector<Row>& rows) {
  Table table({"algorithm", "light", "faces", "after BSP", "lit area", "lit", "shadowed",
               "order ms", "shadow ms", "bytes"});
  for (const Row& row : rows) {
    const compare::Result& r = row.result;
    table.add({row.algorithm, row.light, std::to_string(r.faces_in),
               std::to_string(r.faces_after_bsp), significant(r.lit_area),
               std::to_string(r.lit_fragments), std::to_string(r.shadowed_fragments),
               thousandths(r.order_ms), thousandths(r.shadow_ms), std::to_string(r.memory_bytes)});
  }
  return table.text();
}

}  // namespace

void compare_algorithms(const CompareArguments& a) {
  const std::vector<Algorithm> algorithms = parse_algorithms(a.algorithms);
  if (!a.json.empty() && a.json != "-") check_folder(a.json);
  const std::vector<NamedLight> given = parse_lights(a.lights);
  Scene scene = read({a.scene, a.reading, false, a.quiet});
  const std::vector<NamedLight> lights = set_lights(scene, given, a.scene);
  const std::vector<Row> rows = run(scene, lights, algorithms, a.settings);
  Outputs outputs;
  if (!a.json.empty()) outputs.write(a.json, [&] { io::write_text(a.json, json_text(rows)); });
  if (!a.quiet && a.json != "-") outputs.write("-", [&] { io::write_text("-", table(rows)); });
}

}  // namespace shadowcut::cli
