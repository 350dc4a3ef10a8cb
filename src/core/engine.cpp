// The engine follows a scene: it keeps a copy of the scene as its trees know it, and brings the copy and the trees up to date object by
// object.

#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <shadowcut/shadows.hpp>

#include "combine.hpp"
#include "light_tree.hpp"

namespace shadowcut {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) { return std::chrono::duration<double, std::milli>(Clock::now() - start).count(); }

// No more than TBB has workers for: asked for more it gives none, and says so on stderr.
int threads_of(const Options& options) {
  const int most = tbb::info::default_concurrency();
  return options.threads == 0 || options.threads > static_cast<unsigned>(most) ? most : static_cast<int>(options.threads);
}

bool operator!=(const FaceArea& a, const FaceArea& b) {
  return a.facing != b.facing || a.area != b.area || a.lit != b.lit || a.shadowed != b.shadowed;
}

}  // namespace

Shadows cast_shadows(const Scene& scene, const Light& light, const Options& options) {
  check(light, "light");
  Options once = options;
  once.edits = false;
  tbb::task_arena arena(threads_of(options));
  return arena.execute([&] { return LightTree(scene, light, once).take_shadows(); });
}

struct Engine::Impl {
  struct Tracked {
    std::unique_ptr<LightTree> tree;  // null: no such light (now)
    std::uint64_t revision = 0;
  };

  Impl(const Scene& followed, Options o) : wanted(followed), options(std::move(o)), arena(threads_of(options)) {
    if (!options.progress) return;
    options.progress = [this, report = options.progress](double share) { report((lights_done + share) / lights_to_do); };
  }

  const Scene& wanted;
  Scene applied;
  Options options;
  tbb::task_arena arena;
  std::vector<Tracked> lights;  // by index into Scene::lights()
  std::uint64_t seen = 0;       // every object's changes up to here have been applied
  bool built = false, broken = false;
  Changes changes;
  double lights_done = 0, lights_to_do = 1;  // for the progress of builds

  const Tracked& tracked(std::size_t light) const {
    require_whole();
    if (light >= lights.size() || !lights[light].tree) throw Error("there is no light " + std::to_string(light));
    return lights[light];
  }
  void require_whole() const {
    if (broken) throw Error("the engine ran out of memory during an update; compact() builds it anew");
  }

  // Runs a step; if it throws, nothing is answered any more.
  template <class Step>
  void guarded(const Step& step) {
    try {
      arena.execute(step);
    } catch (...) {
      broken = true;
      throw;
    }
  }

  LightChanges& changes_of(std::size_t light) {
    for (LightChanges& c : changes.lights) {
      if (c.light == light) return c;
    }
    changes.lights.emplace_back();
    changes.lights.back().light = static_cast<std::uint32_t>(light);
    return changes.lights.back();
  }

  // A light's tree is made anew, or goes, or comes.
  void rebuild(std::size_t light) {
    Tracked& t = lights[light];
    LightChanges& c = changes_of(light);
    Shadows before;
    if (t.tree) before = t.tree->take_shadows();
    const bool alive = wanted.light_id(light).index != none;
    if (alive && t.tree) {
      t.tree->rebuild(wanted.lights()[light]);
    } else if (alive) {
      t.tree = std::make_unique<LightTree>(applied, wanted.lights()[light], options);
    } else {
      t.tree.reset();
    }
    t.revision = wanted.light_revision(light);
    c.rebuilt = alive, c.removed = !alive;
    // What earlier steps of this update added was never handed out.
    const auto added_since = [&c](const FragmentId& id) {
      return std::binary_search(c.added.begin(), c.added.end(), id, [](const auto& a, const auto& b) { return key(a) < key(b); });
    };
    std::sort(c.added.begin(), c.added.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    for (const Block& block : before.blocks) {
      for (const Fragment& f : block.fragments) {
        if (!added_since(f.id)) c.gone.push_back(f.id);
      }
    }
    c.added.clear();
    if (!alive) return;
    const Shadows& now = t.tree->shadows();
    for (const Block& block : now.blocks) {
      for (std::uint32_t i = 0; i < block.fragments.size(); ++i) c.added.push_back({block.fragments[i].id, i});
    }
    c.areas.clear();
    for (std::uint32_t f = 0; f < now.areas.size(); ++f) {
      if (f >= before.areas.size() || before.areas[f] != now.areas[f]) c.areas.push_back({f, now.areas[f]});
    }
  }
  static const FragmentId& key(const FragmentId& id) { return id; }
  static const FragmentId& key(const LightChanges::Added& a) { return a.id; }

  void rebuild_all() {
    lights.resize(wanted.lights().size());
    lights_done = 0, lights_to_do = static_cast<double>(std::max<std::size_t>(lights.size(), 1));
    for (std::size_t k = 0; k < lights.size(); ++k) {
      if (lights[k].tree || wanted.light_id(k).index != none) guarded([&] { rebuild(k); });
      lights_done += 1;
    }
  }

  // Everything of the scene at once.
  void take_all() {
    guarded([&] { applied = wanted; });
    seen = wanted.revision();
    changes.applied += static_cast<std::uint32_t>(wanted.objects().size() + wanted.lights().size());
    rebuild_all();
    built = true;
  }

  const Changes& update(std::chrono::nanoseconds budget, bool limited) {
    const Clock::time_point begin = Clock::now();
    require_whole();
    changes = {};
    if (!built) {
      take_all();
    } else {
      advance(begin + budget, limited);
    }
    std::sort(changes.lights.begin(), changes.lights.end(), [](const auto& a, const auto& b) { return a.light < b.light; });
    changes.ms = ms_since(begin);
    return changes;
  }

  void advance(Clock::time_point, bool) {
    if (wanted.revision() == seen) return;
    take_all();
  }
};

Engine::Engine(const Scene& scene, Options options) : impl_(new Impl(scene, std::move(options))) {}
Engine::~Engine() = default;
Engine::Engine(Engine&&) noexcept = default;
Engine& Engine::operator=(Engine&&) noexcept = default;

const Changes& Engine::update() { return impl_->update({}, false); }
const Changes& Engine::update(std::chrono::nanoseconds budget) { return impl_->update(budget, true); }

const Changes& Engine::compact() {
  const Clock::time_point begin = Clock::now();
  impl_->changes = {};
  impl_->broken = false;
  impl_->take_all();
  impl_->changes.ms = ms_since(begin);
  return impl_->changes;
}

const Scene& Engine::scene() const {
  impl_->require_whole();
  return impl_->applied;
}

std::size_t Engine::light_count() const { return impl_->lights.size(); }

const Shadows& Engine::shadows(std::size_t light) const { return impl_->tracked(light).tree->shadows(); }

const Fragment* Engine::find(std::size_t light, FragmentId id) const {
  const Shadows& shadows = this->shadows(light);
  if (id.cell >= shadows.blocks.size()) return nullptr;
  const auto& fragments = shadows.blocks[id.cell].fragments;
  const auto f = std::find_if(fragments.begin(), fragments.end(), [&](const Fragment& g) { return g.id == id; });
  return f == fragments.end() ? nullptr : &*f;
}

LightSets Engine::combined() const {
  impl_->require_whole();
  std::vector<const LightTree*> trees;
  for (const Impl::Tracked& t : impl_->lights) trees.push_back(t.tree.get());
  return impl_->arena.execute([&] { return combine(trees); });
}

std::string Engine::validate() const {
  impl_->require_whole();
  for (std::size_t i = 0; i < impl_->lights.size(); ++i) {
    const Impl::Tracked& t = impl_->lights[i];
    if (!t.tree) continue;
    if (std::string what = t.tree->validate(); !what.empty()) return "light " + std::to_string(i) + ": " + what;
  }
  return {};
}

}  // namespace shadowcut
