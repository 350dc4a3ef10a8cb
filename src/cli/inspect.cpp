// The command inspect: lists the objects and lights of a scene file, and its refused or repaired
// faces.
#include <cmath>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "report.hpp"
#include "specs.hpp"

namespace shadowcut::cli {

namespace {

using nlohmann::ordered_json;

struct Count {
  std::size_t facets = 0, refused = 0, repaired = 0;
};

std::vector<Count> counts_of(const Scene& scene) {
  std::vector<Count> counts(scene.objects().size());
  for (const Face& face : scene.faces()) counts[face.object].facets += face.facet_count;
  for (const Issue& issue : scene.issues())
    ++(issue.is_refusal() ? counts[issue.object].refused : counts[issue.object].repaired);
  return counts;
}

const char* name_of(Sides sides) { return sides == Sides::closed ? "closed" : "open"; }

ordered_json json_of(const Light& light) {
  ordered_json entry{{"light", light_spec(light)}, {"name", light.name}};
  if (std::isfinite(light.range)) entry["range"] = light.range;
  if (light.spot) {
    entry["spot"] = {{"axis", {light.spot->axis.x(), light.spot->axis.y(), light.spot->axis.z()}},
                     {"half_angle", light.spot->half_angle}};
  }
  return entry;
}

std::string json_text(const Scene& scene, const std::string& file, double load_ms) {
  ordered_json document{{"scene", file},
                        {"load_ms", load_ms},
                        {"objects", ordered_json::array()},
                        {"lights", ordered_json::array()},
                        {"issues", ordered_json::array()}};
  const std::vector<Count> counts = counts_of(scene);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const Object& o = scene.objects()[i];
    document["objects"].push_back({{"name", o.name},
                                   {"sides", name_of(o.sides)},
                                   {"faces", o.face_count},
                                   {"facets", counts[i].facets},
                                   {"refused", counts[i].refused},
                                   {"repaired", counts[i].repaired},
                                   {"aligned", o.aligned},
                                   {"aligned_by", o.aligned_by},
                                   {"volume", o.signed_volume},
                                   {"casts", o.casts_shadows},
                                   {"receives", o.receives_shadows}});
  }
  for (const Light& light : scene.lights()) document["lights"].push_back(json_of(light));
  for (const Issue& issue : scene.issues()) {
    document["issues"].push_back({{"object", scene.objects()[issue.object].name},
                                  {"face", issue.face},
                                  {"refused", issue.is_refusal()},
                                  {"reason", issue.text()},
                                  {"detail", issue.detail}});
  }
  return document.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string plain_text(const Scene& scene, const std::string& file, double load_ms) {
  Table objects({"object", "sides", "faces", "facets", "refused", "repaired", "aligned", "volume"});
  const std::vector<Count> counts = counts_of(scene);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const Object& o = scene.objects()[i];
    objects.add({o.name, name_of(o.sides), std::to_string(o.face_count),
                 std::to_string(counts[i].facets), std::to_string(counts[i].refused),
                 std::to_string(counts[i].repaired), std::to_string(o.aligned),
                 significant(o.signed_volume)});
  }
  std::string text = file + ": " + std::to_string(scene.objects().size()) + " objects, " +
                     std::to_string(scene.faces().size()) + " faces, " +
                     std::to_string(scene.lights().size()) + " lights, " +
                     std::to_string(scene.issues().size()) + " issues, read in " + tenths(load_ms) +
                     " ms\n" + sentence(alignment_of(scene)) + "\n" + objects.text();
  if (!scene.lights().empty()) {
    Table lights({"light", "name", "range", "half angle"});
    for (const Light& l : scene.lights())
      lights.add({light_spec(l), l.name, significant(l.range),
                  l.spot ? significant(l.spot->half_angle) : "-"});
    text.append("\n").append(lights.text());
  }
  if (!scene.issues().empty()) text += '\n';
  for (const Issue& issue : scene.issues()) text += io::describe(scene, issue, file) + "\n";
  return text;
}

}  // namespace

void inspect(const InspectArguments& a) {
  const Clock::time_point start = Clock::now();
  const Scene scene = io::read_scene(a.scene, a.reading);
  const double load_ms = milliseconds_since(start);
  if (!a.json.empty()) io::write_text(a.json, json_text(scene, a.scene, load_ms));
  if (a.json != "-") io::write_text("-", plain_text(scene, a.scene, load_ms));
}

}  // namespace shadowcut::cli
