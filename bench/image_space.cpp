// Measures the tables of three papers that draw with graphics hardware again: Batagelo & Costa
// 1999, tables 2 and 3 and figure 10; Kolic et al. 2004, table 1; Oh & Shin 2005, figures 7 and 8.
// Each is compared with the fragments of the engine.
//
//   LP_NUM_THREADS=0 shadowcut_bench_image_space --processor-time
//     --json bench/baseline/image_space.json [--only batagelo|kolic|oh]... [--quick]
//
// Frames are drawn offscreen. With Mesa's llvmpipe, LP_NUM_THREADS=0 keeps all of the driver's work
// on the calling thread, and --processor-time counts the time of the program's threads (the engine
// has two), not of other processes. bench/papers_report.py writes docs/papers.md.
//
// All techniques draw the same frames, one after the other. In every frame a light moves to one of
// ten positions, or objects move, so that every technique does its work on the processor in every
// frame. update_ms is that work, draw_ms the drawing up to glFinish, frame_ms the sum. The edit of
// the scene and the upload of moved vertices come before and are not counted. The result is the
// mean over the frames of the smallest time of each frame.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "json_file.hpp"
#include "offscreen.hpp"
#include "scenes.hpp"
#include "shadow_texture.hpp"

namespace {

using namespace shadowcut;
using nlohmann::ordered_json;
using render::Camera;
using render::Model;
using render::ShadowTexture;
using render::Technique;

struct Arguments {
  std::vector<std::string> only;
  std::string json;
  bool quick = false, processor_time = false;
};

// Waits until all drawing is done.
class Stopwatch {
 public:
  Stopwatch() : start_(now()) {}
  double ms() const {
    glFinish();
    return now() - start_;
  }
  static inline bool processor_time = false;

 private:
  static double now() {
    if (processor_time) return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
    return std::chrono::duration<double, std::milli>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }
  double start_;
};

// ---- scenes

// All objects on the ground; the first object of every scene is the ground.
Eigen::AlignedBox3d box_above_ground(const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (const Facet& facet : scene.facets()) {
    if (scene.faces()[facet.face].object == 0) continue;
    for (const Corner& corner : scene.corners_of(facet))
      box.extend(scene.vertices()[corner.vertex]);
  }
  return box;
}

struct Stage {
  explicit Stage(const scenes::SceneData& data) : scene(scenes::build(data)), model(scene) {
    const Eigen::AlignedBox3d box = box_above_ground(scene);
    middle = box.center(), radius = box.diagonal().norm() / 2;
  }

  // The camera is outside every shadow.
  Camera camera() const {
    return {middle + 2.2 * radius * Vec3(0.5, -0.6, 0.62), middle, 1.0, Vec3::UnitZ()};
  }

  // Ten positions on a dome: each a golden angle farther, from 72 degrees above the horizon down to
  // 36.
  Light light_at(int k) const {
    const double turn = 2.399963229728653 * k, height = 0.95 - 0.04 * k,
                 across = std::sqrt(1 - height * height);
    return Light::point(
        middle + 2.5 * radius * Vec3(across * std::cos(turn), across * std::sin(turn), height));
  }

  Scene scene;
  Model model;
  Vec3 middle;
  double radius;
};

void require_done(Status edit) {
  if (edit != Status::ok) throw Error("the scene did not accept an edit");
}

struct Motion {
  const char* name;
  int steps;
  std::function<void(Stage&, int)> make;
};

const Motion moving_light{"light", 10, [](Stage& s, int k) {
                            require_done(s.scene.set_light(s.scene.light_id(0), s.light_at(k)));
                          }};

void move_to(Stage& s, std::size_t object, const Vec3& place) {
  require_done(s.scene.set_pose(s.scene.object_id(object), Pose(Eigen::Translation3d(place))));
}

const Motion moving_object{"object", 10, [](Stage& s, int k) {
                             move_to(s, s.scene.objects().size() - 1,
                                     s.radius / 256 * Vec3(0, 0, (k + 1) % 10));
                           }};

// Nothing moves; all frames are equal.
Motion standing(int steps) {
  return {"none", steps, [](Stage&, int) {}};
}

// A number of objects above the ground move at random, with the same moves in every round.
Motion moving_crowd(std::size_t moving, int steps) {
  return {"crowd", steps, [moving](Stage& s, int k) {
            for (std::size_t i = 1; i <= moving; ++i)
              move_to(
                  s, i,
                  scenes::Random(1000 * i + static_cast<std::size_t>(k)).in_cube(-0.125, 0.125));
          }};
}

// ---- techniques

// The scene without shadows: in ambient light only, or lit too.
class Unshadowed : public Technique {
 public:
  Unshadowed(const Stage& stage, bool lit) : stage_(stage), lit_(lit) {}
  void update() override {}
  void add_light(const render::Frame& frame, std::size_t k) override {
    if (lit_)
      stage_.model.add_light(frame, stage_.scene.lights()[k], stage_.scene.lights().size(), true);
  }

 private:
  const Stage& stage_;
  const bool lit_;
};

// An engine that is updated and draws nothing, in the merged form. Drawing uses the conforming
// form, which emits all fragments again in every update.
class MergedEngine : public Technique {
 public:
  explicit MergedEngine(const Stage& stage) : engine_(stage.scene, Options{}) {}
  void update() override { static_cast<void>(engine_.update()); }
  void add_light(const render::Frame&, std::size_t) override {}

 private:
  Engine engine_;
};

std::unique_ptr<Technique> technique_of(const std::string& name, const Stage& s) {
  using Method = ShadowTexture::Method;
  if (name == "ambient" || name == "unshadowed")
    return std::make_unique<Unshadowed>(s, name == "unshadowed");
  if (name == "engine-merged") return std::make_unique<MergedEngine>(s);
  if (name == "quadratic")
    return std::make_unique<ShadowTexture>(s.scene, s.model,
                                           ShadowTexture::Choices{Method::quadratic, false});
  if (name == "sz-buffer")
    return std::make_unique<ShadowTexture>(s.scene, s.model,
                                           ShadowTexture::Choices{Method::sz_buffer, false});
  if (name == "sz-buffer-coherent")
    return std::make_unique<ShadowTexture>(s.scene, s.model,
                                           ShadowTexture::Choices{Method::sz_buffer, true});
  return render::make_technique(name, s.scene, s.model);
}

// ---- measurement

using Figures = std::map<std::string, double>;

// The smaller times. Counts are the same in all rounds.
void keep_best(Figures& best, const Figures& now) {
  for (const auto& [name, value] : now) {
    const auto [at, is_new] = best.try_emplace(name, value);
    if (!is_new && name.ends_with("_ms")) at->second = std::min(at->second, value);
  }
}

ordered_json mean_of(const std::vector<Figures>& steps) {
  ordered_json means = ordered_json::object();
  for (const auto& [name, value] : steps.front()) {
    double sum = 0;
    for (const Figures& step : steps) sum += step.at(name);
    means[name] = sum / static_cast<double>(steps.size());
  }
  return means;
}

struct Size {
  int width, height;
};

struct Contest {
  Stage& stage;
  std::string scene;
  std::vector<std::string> techniques;
  std::vector<Size> sizes;
  Motion motion;
  double seconds;  // rounds go on until then; there are two at least
};

// Measures the update of a technique, once per frame, for any number of pictures of the frame.
class Timed : public Technique {
 public:
  explicit Timed(std::unique_ptr<Technique> technique) : technique_(std::move(technique)) {}
  void expect_update() { due_ = true; }
  void update() override {
    if (!std::exchange(due_, false)) return;
    const Stopwatch watch;
    technique_->update();
    update_ms_ = watch.ms();
  }
  void add_light(const render::Frame& frame, std::size_t k) override {
    technique_->add_light(frame, k);
  }
  render::Figures figures() const override { return technique_->figures(); }
  double update_ms() const { return update_ms_; }

 private:
  std::unique_ptr<Technique> technique_;
  bool due_ = false;
  double update_ms_ = 0;
};

// A technique's frames: by size, then by step.
struct Entrant {
  Timed technique;
  double first_update_ms = 0;  // from nothing
  std::vector<std::vector<Figures>> best;
};

// The frame in all sizes.
std::vector<Figures> draw_frame(Timed& technique, const Contest& contest,
                                const std::vector<render::Target>& targets) {
  const Model& model = contest.stage.model;
  std::vector<Figures> pictures;
  technique.expect_update();
  for (const render::Target& target : targets) {
    const render::Frame frame =
        model.frame(contest.stage.camera(), target.width(), target.height());
    target.bind();
    glFinish();
    const Stopwatch watch;
    render::draw(frame, contest.stage.scene, model, technique);
    const double ms = watch.ms(), update_ms = technique.update_ms(),
                 draw_ms = pictures.empty() ? ms - update_ms : ms;
    Figures& figures = pictures.emplace_back(
        Figures{{"update_ms", update_ms}, {"draw_ms", draw_ms}, {"frame_ms", update_ms + draw_ms}});
    for (const auto& [name, value] : technique.figures()) figures.try_emplace("its_" + name, value);
  }
  return pictures;
}

void next_step(const Contest& contest, int step) {
  contest.motion.make(contest.stage, step);
  contest.stage.model.scene_changed(contest.stage.scene);
}

ordered_json row_of(const Contest& contest, std::size_t k, const std::vector<Entrant>& entrants) {
  const Size& size = contest.sizes[k];
  ordered_json row{
      {"scene", contest.scene},        {"polygons", contest.stage.scene.faces().size()},
      {"motion", contest.motion.name}, {"width", size.width},
      {"height", size.height},         {"frames", contest.motion.steps}};
  for (std::size_t i = 0; i < entrants.size(); ++i) {
    ordered_json means = mean_of(entrants[i].best[k]);
    means["first_update_ms"] = entrants[i].first_update_ms;
    std::printf("%s, %s moves, %d x %d, %s: update %.3f, draw %.3f ms\n", contest.scene.c_str(),
                contest.motion.name, size.width, size.height, contest.techniques[i].c_str(),
                means["update_ms"].get<double>(), means["draw_ms"].get<double>());
    row["techniques"][contest.techniques[i]] = std::move(means);
  }
  std::fflush(stdout);
  return row;
}

// A row for each size.
std::vector<ordered_json> run(const Contest& contest) {
  std::vector<render::Target> targets;
  for (const Size& size : contest.sizes) targets.emplace_back(size.width, size.height);
  std::vector<Entrant> entrants;
  const std::vector<Figures> steps(static_cast<std::size_t>(contest.motion.steps));
  for (const std::string& name : contest.techniques)
    entrants.push_back({Timed(technique_of(name, contest.stage)), 0,
                        std::vector<std::vector<Figures>>(targets.size(), steps)});
  next_step(contest, contest.motion.steps - 1);
  for (Entrant& entrant : entrants) {
    draw_frame(entrant.technique, contest, targets);
    entrant.first_update_ms = entrant.technique.update_ms();
  }
  const Stopwatch watch;
  for (int round = 0; round < 2 || watch.ms() < 1000 * contest.seconds; ++round) {
    for (int step = 0; step < contest.motion.steps; ++step) {
      next_step(contest, step);
      for (Entrant& entrant : entrants) {
        const std::vector<Figures> pictures = draw_frame(entrant.technique, contest, targets);
        for (std::size_t k = 0; k < targets.size(); ++k)
          keep_best(entrant.best[k][static_cast<std::size_t>(step)], pictures[k]);
      }
    }
  }
  std::vector<ordered_json> rows;
  for (std::size_t k = 0; k < targets.size(); ++k) rows.push_back(row_of(contest, k, entrants));
  return rows;
}

// ---- the papers

using Rows = std::vector<ordered_json>;

void append(Rows& rows, Rows more) { rows.insert(rows.end(), more.begin(), more.end()); }

// The small size separates the time of filling pixels from the rest.
Rows batagelo(bool quick) {
  Rows rows;
  std::vector<std::string> names{"sphere256", "solids96", "tetrahedra752:1", "tetrahedra752:2",
                                 "cubes1502"};
  if (quick) names.resize(2);
  for (const std::string& name : names) {
    Stage stage(scenes::named(name));
    for (const Motion& motion : {moving_light, moving_object})
      append(rows, run({stage,
                        name,
                        {"ambient", "unshadowed", "stencil-standard", "stencil-hybrid", "fragments",
                         "engine-merged"},
                        {{640, 480}, {160, 120}},
                        motion,
                        quick ? 0.0 : 3.0}));
  }
  return rows;
}

Rows kolic(bool quick) {
  const scenes::SceneData data = scenes::named(quick ? "branch:1" : "branch2878");
  Stage stage(data);
  std::vector<Size> sizes{{640, 480}, {800, 600}, {1024, 768}, {160, 120}};
  Rows rows;
  for (const Motion& motion : {moving_light, moving_object})
    append(rows, run({stage,
                      data.name,
                      {"ambient", "unshadowed", "stencil-standard", "stencil-hybrid",
                       "stencil-kolic", "fragments", "engine-merged"},
                      sizes,
                      motion,
                      0}));
  return rows;
}

scenes::SceneData crowd_of(std::uint32_t count, bool quick) {
  return quick ? scenes::spheres(count, 12, 8) : scenes::spheres2037(count);
}

// These techniques keep nothing from frame to frame, so nothing needs to move.
Rows oh_growth(bool quick) {
  Rows rows;
  for (const std::uint32_t count : quick ? std::vector<std::uint32_t>{3, 6, 12}
                                         : std::vector<std::uint32_t>{25, 50, 100, 200, 300}) {
    const scenes::SceneData data = crowd_of(count, quick);
    Stage stage(data);
    append(rows, run({stage,
                      data.name,
                      {"unshadowed", "quadratic", "sz-buffer", "fragments"},
                      {{800, 600}},
                      standing(1),
                      0}));
    rows.back()["count"] = count;
  }
  return rows;
}

Rows oh_coherence(bool quick) {
  Rows rows;
  const std::uint32_t count = quick ? 10 : 100;
  const scenes::SceneData data = crowd_of(count, quick);
  for (const std::uint32_t share : {0, 10, 25, 50, 100}) {
    Stage stage(data);
    append(rows,
           run({stage,
                data.name,
                {"unshadowed", "sz-buffer", "sz-buffer-coherent", "fragments", "engine-merged"},
                {{800, 600}},
                moving_crowd(count * share / 100, 2),
                0}));
    rows.back()["count"] = count, rows.back()["dynamic_percent"] = share;
  }
  return rows;
}

std::string driver() { return reinterpret_cast<const char*>(glGetString(GL_RENDERER)); }

std::string threads_of_driver() {
  const char* threads = std::getenv("LP_NUM_THREADS");
  return threads == nullptr ? "" : threads;
}

void run(const Arguments& a) {
  const auto wanted = [&](const char* group) {
    return a.only.empty() || std::find(a.only.begin(), a.only.end(), group) != a.only.end();
  };
  const render::OffscreenContext context;
  Stopwatch::processor_time = a.processor_time;
  ordered_json document{{"driver", driver()},
                        {"lp_num_threads", threads_of_driver()},
                        {"clock", a.processor_time ? "processor" : "wall"}};
  if (wanted("batagelo")) document["batagelo1999"] = batagelo(a.quick);
  if (wanted("kolic")) document["kolic2004"] = kolic(a.quick);
  if (wanted("oh"))
    document["oh2005_growth"] = oh_growth(a.quick),
    document["oh2005_coherence"] = oh_coherence(a.quick);
  bench::write_json(a.json, document);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  CLI::App app("The tables of the papers that draw with graphics hardware, made again",
               "shadowcut_bench_image_space");
  app.add_option("--only", a.only, "batagelo, kolic, oh")
      ->check(CLI::IsMember({"batagelo", "kolic", "oh"}))
      ->allow_extra_args(false);
  app.add_option("--json", a.json, "Results")->type_name("FILE");
  app.add_flag("--processor-time", a.processor_time,
               "Count processor time; not for a driver with a graphics card");
  app.add_flag("--quick", a.quick, "Small scenes and two rounds, as a test of the program");
  CLI11_PARSE(app, argc, argv);
  try {
    run(a);
  } catch (const std::exception& error) {
    std::cerr << "shadowcut_bench_image_space: " << error.what() << std::endl;
    return 2;
  }
}
