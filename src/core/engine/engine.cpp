// The engine follows a scene: it keeps a copy of the scene as its trees know it, and brings the
// copy and the trees up to date object by object.

#include <algorithm>
#include <shadowcut/shadows.hpp>

#include "engine/light_state.hpp"
#include "fragments/point_query.hpp"
#include "scene/scene_access.hpp"
#include "support/clock.hpp"
#include "support/parallel.hpp"

namespace shadowcut {
namespace {

void check(const Options& options) {
  const MinFeature& least = options.min_feature;
  if (!(least.area >= 0) || !(least.solid_angle >= 0))
    throw Error("the smallest feature must not be negative");
  if (options.constructions &&
      (options.kernel != Kernel::exact || options.form == Form::conforming))
    throw Error("constructions need the exact kernel and the form pieces or merged");
}

void check(const Options& options, const Light& light) {
  const MinFeature& least = options.min_feature;
  if (least.solid_angle > 0 && light.kind == Light::Kind::directional)
    throw Error(
        "a directional light sees nothing under a solid angle: give the smallest feature as an "
        "area");
}

}  // namespace

Shadows cast_shadows(const Scene& scene, const Light& light, const Options& options) {
  check(options);
  light.check("light");
  check(options, light);
  Options once = options;
  once.tuning.incremental = false;
  Shadows out;
  Threads(options.threads).run([&] { out = LightState(scene, light, once).take_shadows(); });
  return out;
}

struct Engine::Impl {
  struct Tracked {
    std::unique_ptr<LightState> state;  // null: no such light (now)
    std::uint64_t revision = 0;
  };

  Impl(const Scene& followed, Options o)
      : wanted(followed), options(std::move(o)), threads(options.threads) {
    check(options);
    if (!options.progress) return;
    options.progress = [this, report = options.progress](double share) {
      report((lights_done + share) / lights_to_do);
    };
  }

  const Scene& wanted;
  Scene applied;
  Options options;
  Threads threads;
  std::vector<Tracked> lights;  // by index into Scene::lights()
  std::uint64_t seen = 0;       // every object's changes up to here have been applied
  bool built = false, broken = false;
  std::uint64_t updates = 0;  // begun
  Changes changes;
  double lights_done = 0, lights_to_do = 1;  // for the progress of builds

  const Tracked& tracked(std::size_t light) const {
    require_whole();
    if (light >= lights.size() || !lights[light].state)
      throw Error("there is no light " + std::to_string(light));
    return lights[light];
  }
  void require_whole() const {
    if (broken) throw Error("the engine ran out of memory during an update: call compact()");
  }

  // Before anything is touched.
  void check_lights() const {
    for (std::size_t k = 0; k < wanted.lights().size(); ++k) {
      if (wanted.light_id(k).index != invalid_index) check(options, wanted.lights()[k]);
    }
  }

  // Runs a step. If the step throws, every later question throws until compact().
  template <class Step>
  void guarded(const Step& step) {
    try {
      threads.run(step);
    } catch (...) {
      broken = true;
      throw;
    }
  }

  // Rebuilds a light's state, adds it, or removes it.
  void rebuild(std::size_t light) {
    Tracked& t = lights[light];
    t.revision = SceneAccess::light_revision(wanted, light);
    ++changes.applied;
    const bool alive = wanted.light_id(light).index != invalid_index;
    if (alive && t.state) {
      t.state->rebuild(wanted.lights()[light]);
    } else if (alive) {
      t.state = std::make_unique<LightState>(applied, wanted.lights()[light], options);
    } else if (t.state) {
      LightChanges c;
      t.state->remove_light(c);
      c.light = static_cast<std::uint32_t>(light);
      changes.lights.push_back(std::move(c));
      t.state.reset();
    }
  }

  void rebuild_all() {
    lights_done = 0, lights_to_do = static_cast<double>(std::max<std::size_t>(lights.size(), 1));
    for (std::size_t k = 0; k < lights.size(); ++k) {
      rebuild(k);
      lights_done += 1;
    }
    lights_done = 0, lights_to_do = 1;
  }

  // Everything of the scene at once.
  void take_all() {
    applied = wanted;
    seen = SceneAccess::revision(wanted);
    changes.applied += static_cast<std::uint32_t>(wanted.objects().size());
    lights.resize(wanted.lights().size());
    rebuild_all();
    built = true;
  }

  // One update: a step of any size, and what it changed.
  template <class Step>
  const Changes& run(const Step& step) {
    const Clock::time_point begin = Clock::now();
    ++updates;
    guarded([&] {
      changes = {};
      changes.update = updates;
      for (Tracked& t : lights) {
        if (t.state) t.state->begin_update();
      }
      step(begin);
      list_changes();
    });
    changes.ms = ms_since(begin);
    return changes;
  }

  const Changes& update(std::chrono::nanoseconds budget, bool limited) {
    require_whole();
    check_lights();
    return run([&](Clock::time_point begin) {
      if (!built) {
        take_all();
      } else if (SceneAccess::revision(wanted) != seen) {
        advance(begin + budget, limited);
      }
    });
  }

  // All faces, or those chosen.
  LightPartition overlay(const std::vector<bool>* faces) {
    require_whole();
    std::vector<LightView> views;
    views.reserve(lights.size());
    std::vector<const LightView*> all;
    for (const Tracked& t : lights) {
      if (t.state) views.push_back(t.state->view());
      all.push_back(t.state ? &views.back() : nullptr);
    }
    LightPartition out;
    threads.run([&] { out = shadowcut::overlay(all, faces); });
    return out;
  }

  const Changes& compact() {
    check_lights();
    if (broken) lights.clear();
    broken = false;
    return run([&](Clock::time_point) { take_all(); });
  }

  void list_changes() {
    for (std::size_t k = 0; k < lights.size(); ++k) {
      if (!lights[k].state) continue;
      LightChanges c;
      c.light = static_cast<std::uint32_t>(k);
      lights[k].state->finish_update(c);
      if (c.rebuilt || !c.gone.empty() || !c.added.empty() || !c.areas.empty())
        changes.lights.push_back(std::move(c));
    }
    std::sort(changes.lights.begin(), changes.lights.end(),
              [](const auto& a, const auto& b) { return a.light < b.light; });
  }

  bool is_pending(std::uint32_t object) const {
    return object >= applied.objects().size() || SceneAccess::object_revision(applied, object) !=
                                                     SceneAccess::object_revision(wanted, object);
  }
  bool is_stale(std::size_t light) const {
    return lights[light].revision != SceneAccess::light_revision(wanted, light);
  }

  void advance(Clock::time_point deadline, bool limited) {
    lights.resize(wanted.lights().size());
    std::vector<std::uint32_t> pending = SceneAccess::changed_since(wanted, seen);
    std::erase_if(pending, [this](std::uint32_t o) { return !is_pending(o); });
    if (!limited && (!options.tuning.incremental || is_most_of_it(pending))) {
      take_all();
      return;
    }
    if (limited) {
      advance_step_by_step(pending, deadline);
    } else {
      apply(pending, true);
      rebuild_stale({}, false);
      seen = SceneAccess::revision(wanted);
    }
  }

  // Whether a rebuild costs no more than the edits.
  bool is_most_of_it(const std::vector<std::uint32_t>& objects) const {
    std::size_t facets = 0;
    for (const std::uint32_t o : objects) {
      if (o < applied.objects().size()) facets += applied.objects()[o].facet_count;
      facets += wanted.objects()[o].facet_count;
    }
    return facets > wanted.facets().size();
  }

  // False: out of time.
  bool rebuild_stale(Clock::time_point deadline, bool limited) {
    for (std::size_t k = 0; k < lights.size(); ++k) {
      if (!is_stale(k)) continue;
      SceneAccess::copy_light(applied, wanted, static_cast<std::uint32_t>(k));
      rebuild(k);
      if (limited && Clock::now() >= deadline) return false;
    }
    return true;
  }

  // Lights first, so that no step leaves a light's shadows behind the objects; then the objects
  // changed longest ago.
  void advance_step_by_step(const std::vector<std::uint32_t>& pending, Clock::time_point deadline) {
    changes.complete = false;
    if (!rebuild_stale(deadline, true)) return;
    std::size_t at_once = 1;
    for (std::size_t i = 0; i < pending.size();) {
      const Clock::time_point begin = Clock::now();
      std::vector<std::uint32_t> group;
      for (; i < pending.size() && group.size() < at_once; ++i) add_to_group(pending[i], group);
      if (options.tuning.incremental) {
        apply(group, false);
      } else {
        SceneAccess::copy_objects(applied, wanted, group);
        changes.applied += static_cast<std::uint32_t>(group.size());
        for (std::size_t k = 0; k < lights.size(); ++k) {
          if (lights[k].state) lights[k].state->rebuild(wanted.lights()[k]);
        }
      }
      const Clock::time_point now = Clock::now();
      if (now >= deadline) break;
      at_once = deadline - now > 4 * (now - begin) ? 2 * at_once : 1;
    }
    if (std::any_of(pending.begin(), pending.end(),
                    [this](std::uint32_t o) { return is_pending(o); }))
      return;
    changes.complete = true;
    seen = SceneAccess::revision(wanted);
  }

  // An object may have been given an allocation that another object, which has changed too, still
  // owns here: they go together.
  void add_to_group(std::uint32_t object, std::vector<std::uint32_t>& group) const {
    std::vector<std::uint32_t> more{object};
    while (!more.empty()) {
      const std::uint32_t o = more.back();
      more.pop_back();
      if (o == invalid_index || !is_pending(o) ||
          std::find(group.begin(), group.end(), o) != group.end())
        continue;
      group.push_back(o);
      more.push_back(SceneAccess::owner_of_allocation(applied, wanted, o));
    }
  }

  // Brings objects up to date in the applied scene and in the trees; not in those of lights that
  // will be built anew.
  void apply(const std::vector<std::uint32_t>& objects, bool but_stale) {
    if (objects.empty()) return;
    const auto for_lights = [&](const auto& edit) {
      for (std::size_t k = 0; k < lights.size(); ++k) {
        if (lights[k].state && !(but_stale && is_stale(k))) edit(*lights[k].state);
      }
    };
    for_lights([&](LightState& state) { state.remove_objects(objects); });
    SceneAccess::copy_objects(applied, wanted, objects);
    for_lights([&](LightState& state) { state.insert_objects(objects); });
    changes.applied += static_cast<std::uint32_t>(objects.size());
  }
};

Engine::Engine(const Scene& scene, Options options) : impl_(new Impl(scene, std::move(options))) {}
Engine::~Engine() = default;
Engine::Engine(Engine&&) noexcept = default;
Engine& Engine::operator=(Engine&&) noexcept = default;

const Changes& Engine::update() { return impl_->update({}, false); }
const Changes& Engine::update(std::chrono::nanoseconds budget) {
  return impl_->update(budget, true);
}

const Changes& Engine::compact() { return impl_->compact(); }

const Scene& Engine::scene() const {
  impl_->require_whole();
  return impl_->applied;
}

std::size_t Engine::light_count() const {
  impl_->require_whole();
  return impl_->lights.size();
}

const Shadows& Engine::shadows(std::size_t light) const {
  return impl_->tracked(light).state->shadows();
}

const Fragment* Engine::find(std::size_t light, FragmentId id) const {
  return impl_->tracked(light).state->find(id);
}

std::vector<double> Engine::uncertain_area(std::size_t light) const {
  const LightState& state = *impl_->tracked(light).state;
  std::vector<double> out;
  impl_->threads.run([&] { out = state.error_bound(); });
  return out;
}

LightPartition Engine::overlay() const { return impl_->overlay(nullptr); }

LightPartition Engine::overlay(std::span<const std::uint32_t> faces) const {
  impl_->require_whole();
  std::vector<bool> chosen(impl_->applied.faces().size());
  for (const std::uint32_t f : faces) {
    if (f < chosen.size()) chosen[f] = true;
  }
  return impl_->overlay(&chosen);
}

bool Engine::is_lit(std::size_t light, std::uint32_t face, const Vec3& point) const {
  const LightState& state = *impl_->tracked(light).state;
  if (face >= impl_->applied.faces().size())
    throw Error("there is no face " + std::to_string(face));
  if (!point.allFinite()) throw Error("the point is not finite");
  return shadowcut::is_lit(state.view(), face, point);
}

std::string Engine::validate() const {
  impl_->require_whole();
  for (std::size_t i = 0; i < impl_->lights.size(); ++i) {
    const Impl::Tracked& t = impl_->lights[i];
    if (!t.state) continue;
    if (std::string what = t.state->validate(); !what.empty())
      return "light " + std::to_string(i) + ": " + what;
  }
  return {};
}

}  // namespace shadowcut
