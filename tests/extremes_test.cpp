// The extremes: coordinates from 1e-30 to 1e30 and mixed, scenes 1e12 away from the origin, lights on planes, edges and vertices or one ulp
// off, grazing suns, needles, stacks of sheets one ulp apart, everything coplanar, everything through one vertex or one line.
// exact_test.cpp holds the exact kernel against the oracle there, fragment by fragment; here the fast kernel's true error is held against
// the bound that it states, and what is too large for the oracle has an answer known beforehand.
//
// SHADOWCUT_SOAK=n runs about n scenes instead of some thousands, and a million faces in one cell; SHADOWCUT_SEED=k other scenes;
// SHADOWCUT_SCENE=seed one alone. SHADOWCUT_RECORD=file writes what was seen, for docs/accuracy.md.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iomanip>
#include <limits>
#include <map>

#include "check.hpp"
#include "exact_oracle.hpp"
#include "exact_scenes.hpp"
#include "settings.hpp"

namespace shadowcut::testing {
namespace {

// Of one kind of scene and one kernel.
struct Seen {
  std::uint64_t scenes = 0, faces = 0;
  std::uint64_t wrong_faces = 0;                     // wholly lit and said to be wholly shadowed, or the reverse
  std::uint64_t beyond = 0;                          // whose error is more than the bound
  double area = 0, error = 0, bound = 0, worst = 0;  // sums; and the largest error of a face as a share of its area
};

std::map<std::string, std::map<std::string, Seen>>& record() {
  static std::map<std::string, std::map<std::string, Seen>> all;
  return all;
}

// As JSON: it has no infinity, which an error is as a share of a face without area.
struct Number {
  double x;
  friend std::ostream& operator<<(std::ostream& out, Number n) { return std::isfinite(n.x) ? out << n.x : out << "null"; }
};

class Recorder : public ::testing::Environment {
 public:
  void TearDown() override {
    const char* file = std::getenv("SHADOWCUT_RECORD");
    if (!file) return;
    std::ofstream out(file);
    out << std::setprecision(6) << "[";
    const char* comma = "";
    for (const auto& [kind, kernels] : record()) {
      for (const auto& [kernel, s] : kernels) {
        out << comma << "\n  {\"kind\": \"" << kind << "\", \"kernel\": \"" << kernel << "\", \"scenes\": " << s.scenes
            << ", \"faces\": " << s.faces << ", \"wrong_faces\": " << s.wrong_faces << ", \"error\": " << Number{s.error / s.area}
            << ", \"bound\": " << Number{s.bound / s.area} << ", \"beyond\": " << s.beyond << ", \"worst_face\": " << Number{s.worst}
            << "}";
        comma = ",";
      }
    }
    out << "\n]\n";
  }
};
const auto* const recorder = ::testing::AddGlobalTestEnvironment(new Recorder);

double exact_lit_area(const ExactOracle& oracle, const Face& face) {
  double sum = 0;
  for (std::uint32_t f = face.first_facet; f < face.first_facet + face.facet_count; ++f) {
    if (oracle.role(f) != ExactOracle::Role::takes_part) continue;
    sum += std::abs(oracle.area(f, oracle.lit(f)).get_d()) * oracle.stretch(f).second;
  }
  return sum;
}

// The lit area of every face against the exact one, and the difference against the bound.
void check_bound(const char* kind, std::uint64_t seed, const ExactScene& made, const Scene& scene, const ExactOracle& oracle, Kernel kernel,
                 const char* name) {
  Options options;
  options.kernel = kernel;
  options.threads = 1;
  options.edits = seed % 2 == 0;
  options.form = static_cast<Form>(seed % 3);
  options.facets_per_cell = seed % 5 == 0 ? 2 : 128;
  Scene lone = scene;
  lone.replace_lights({&made.light, 1});
  Engine engine(lone, options);
  engine.update();
  const std::vector<double> undecided = engine.undecided(0);
  const Shadows& shadows = engine.shadows(0);
  Seen& seen = record()[kind][name];
  ++seen.scenes;
  for (std::uint32_t f = 0; f < scene.faces().size(); ++f) {
    const FaceArea& got = shadows.areas[f];
    if (got.facing == Facing::refused || got.facing == Facing::ignored) continue;
    const double want = exact_lit_area(oracle, scene.faces()[f]), error = std::abs(got.lit - want);
    ++seen.faces;
    seen.area += got.area, seen.error += error, seen.bound += undecided[f];
    seen.worst = std::max(seen.worst, error / got.area);
    seen.wrong_faces += (want == 0 && got.shadowed == 0) || (got.lit == 0 && want >= got.area);
    if (error <= undecided[f]) continue;
    ++seen.beyond;
    // The single kernel's errors are recorded; the fast kernel's bound is a promise.
    if (kernel == Kernel::single) continue;
    ASSERT_LE(error, undecided[f]) << kind << ", seed " << seed << ", kernel " << name << ", " << describe(options) << ", face " << f
                                   << ": lit " << got.lit << ", should be " << want << " of " << got.area << "\n"
                                   << describe(made);
  }
}

class Extremes : public ::testing::TestWithParam<ExactKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, Extremes, ::testing::ValuesIn(kAllExactKinds), [](const auto& info) { return name_of(info.param); });

TEST_P(Extremes, ErrorsStayWithinWhatIsUndecided) {
  std::uint64_t first = 1000000 * environment("SHADOWCUT_SEED").value_or(0);
  std::uint64_t count = environment("SHADOWCUT_SOAK").value_or(120 * std::size(kAllExactKinds)) / std::size(kAllExactKinds) + 1;
  if (const auto one = environment("SHADOWCUT_SCENE")) first = *one, count = 1;
  for (std::uint64_t seed = first; seed < first + count && !HasFatalFailure(); ++seed) {
    const ExactScene made = exact_scene(GetParam(), seed);
    const Scene scene = build(made);
    const ExactOracle oracle(scene, made.light);
    if (!oracle.defined()) continue;
    check_bound(name_of(GetParam()), seed, made, scene, oracle, Kernel::fast, "fast");
    if (!HasFatalFailure()) check_bound(name_of(GetParam()), seed, made, scene, oracle, Kernel::single, "single");
  }
}

}  // namespace
}  // namespace shadowcut::testing
