// Engines of c.h.
#include <chrono>

#include "handles.hpp"

namespace shadowcut::c {
namespace {

bool is_whole(const shadowcut_engine& engine) {
  try {
    engine.engine.light_count();
    return true;
  } catch (const Error&) {
    return false;
  }
}

// Runs an update, unless a check throws. What was lent of the last one is gone before; the lights'
// handles are made room for before too, so that an update that went well cannot fail afterwards.
template <class Check, class Step>
shadowcut_status advance(shadowcut_engine* engine, const Check& check, const Step& step) noexcept {
  return guarded([&] {
    require_pointers(engine);
    check();
    if (engine->lights.size() < engine->scene->lights().size())
      engine->lights.resize(engine->scene->lights().size());
    engine->changes = nullptr;
    for (shadowcut_shadows& light : engine->lights) light.shadows = nullptr;
    engine->progress = 0;
    const Changes* changes = nullptr;
    std::exception_ptr error;
    try {
      changes = &step(engine->engine);
    } catch (...) {
      error = std::current_exception();
    }
    if (is_whole(*engine)) {
      const Scene& scene = engine->engine.scene();
      for (std::size_t k = 0; k < engine->engine.light_count(); ++k) {
        if (scene.light_id(k).index != invalid_index)
          engine->lights[k].shadows = &engine->engine.shadows(k);
      }
    }
    if (error) std::rethrow_exception(error);
    engine->changes = changes;
    engine->progress = 1;
  });
}

const LightChanges& light_changes(const shadowcut_engine* engine, std::uint32_t i) {
  const Changes& changes = changes_of(engine);
  require(i < changes.lights.size(), "light change index out of range");
  return changes.lights[i];
}

const Engine& with_light(const shadowcut_engine* engine, std::uint32_t light) {
  const Engine& e = whole(engine).engine;
  if (light >= engine->lights.size() || !engine->lights[light].shadows)
    fail(SHADOWCUT_NOT_FOUND, "there is no such light");
  return e;
}

shadowcut_fragment_id id_of(const FragmentId& id) { return {id.cell, id.piece, id.place}; }

}  // namespace

const shadowcut_engine& whole(const shadowcut_engine* engine) {
  require_pointers(engine);
  if (!is_whole(*engine))
    fail(SHADOWCUT_MUST_COMPACT,
         "the engine ran out of memory during an update: it must be compacted");
  return *engine;
}

const Changes& changes_of(const shadowcut_engine* engine) {
  if (!whole(engine).changes)
    fail(SHADOWCUT_NOT_FOUND, "there has been no update, or the last update failed");
  return *engine->changes;
}

}  // namespace shadowcut::c

using namespace shadowcut;
using namespace shadowcut::c;

shadowcut_status shadowcut_engine_create(const shadowcut_scene* scene,
                                         const shadowcut_options* options,
                                         shadowcut_engine** engine) {
  return guarded([&] {
    require_pointers(scene, engine);
    require(scene->own != nullptr, "an engine cannot follow another engine's scene: copy it");
    *engine = new shadowcut_engine(scene->own, options_of(options));
  });
}
void shadowcut_engine_destroy(shadowcut_engine* engine) { delete engine; }

shadowcut_status shadowcut_engine_update(shadowcut_engine* engine) {
  return advance(
      engine, [&] { whole(engine); }, [](Engine& e) -> const Changes& { return e.update(); });
}
shadowcut_status shadowcut_engine_update_within(shadowcut_engine* engine, double ms) {
  const auto check = [&] {
    require(ms >= 0, "the time is negative or not a number");
    whole(engine);
  };
  return advance(engine, check, [ms](Engine& e) -> const Changes& {
    constexpr double most = 1e12;  // some thirty years, and fits into the clock's nanoseconds
    return e.update(std::chrono::nanoseconds(static_cast<std::int64_t>(std::min(ms, most) * 1e6)));
  });
}
shadowcut_status shadowcut_engine_compact(shadowcut_engine* engine) {
  return advance(
      engine, [] {}, [](Engine& e) -> const Changes& { return e.compact(); });
}
shadowcut_status shadowcut_engine_progress(const shadowcut_engine* engine, double* share) {
  return guarded([&] {
    require_pointers(engine);
    require_pointers(share);
    *share = engine->progress.load(std::memory_order_relaxed);
  });
}

shadowcut_status shadowcut_changes_init(shadowcut_changes* changes) {
  return initialise(changes, shadowcut_changes{});
}
shadowcut_status shadowcut_light_changes_init(shadowcut_light_changes* changes) {
  return initialise(changes, shadowcut_light_changes{});
}

shadowcut_status shadowcut_engine_changes(const shadowcut_engine* engine,
                                          shadowcut_changes* changes) {
  return guarded([&] {
    require_size(changes);
    const Changes& c = changes_of(engine);
    *changes = {changes->size, count_of(c.lights.size()), c.update,
                c.applied,     c.complete ? 1 : 0,        c.ms};
  });
}
shadowcut_status shadowcut_engine_light_changes(const shadowcut_engine* engine, uint32_t i,
                                                shadowcut_light_changes* changes) {
  return guarded([&] {
    require_size(changes);
    const LightChanges& c = light_changes(engine, i);
    *changes = {changes->size,           c.light,
                c.rebuilt ? 1 : 0,       c.removed ? 1 : 0,
                count_of(c.gone.size()), count_of(c.added.size()),
                count_of(c.areas.size())};
  });
}
shadowcut_status shadowcut_engine_gone(const shadowcut_engine* engine, uint32_t i, uint32_t first,
                                       uint32_t count, shadowcut_fragment_id* gone) {
  return guarded(
      [&] { copy_out(std::span(light_changes(engine, i).gone), first, count, gone, id_of); });
}
shadowcut_status shadowcut_engine_added(const shadowcut_engine* engine, uint32_t i, uint32_t first,
                                        uint32_t count, shadowcut_added* added) {
  return guarded([&] {
    copy_out(std::span(light_changes(engine, i).added), first, count, added,
             [](const LightChanges::Added& a) {
               return shadowcut_added{id_of(a.id), a.index};
             });
  });
}
shadowcut_status shadowcut_engine_changed_areas(const shadowcut_engine* engine, uint32_t i,
                                                uint32_t first, uint32_t count,
                                                shadowcut_changed_area* areas) {
  return guarded([&] {
    copy_out(std::span(light_changes(engine, i).areas), first, count, areas,
             [](const LightChanges::Area& a) {
               return shadowcut_changed_area{a.face, area_of(a.area)};
             });
  });
}

shadowcut_status shadowcut_engine_scene(const shadowcut_engine* engine,
                                        const shadowcut_scene** scene) {
  return guarded([&] {
    require_pointers(scene);
    *scene = &whole(engine).view;
  });
}
shadowcut_status shadowcut_engine_light_count(const shadowcut_engine* engine,
                                              uint32_t* light_count) {
  return guarded([&] {
    require_pointers(light_count);
    *light_count = count_of(whole(engine).engine.light_count());
  });
}
shadowcut_status shadowcut_engine_shadows(const shadowcut_engine* engine, uint32_t light,
                                          const shadowcut_shadows** shadows) {
  return guarded([&] {
    require_pointers(shadows);
    with_light(engine, light);
    *shadows = &engine->lights[light];
  });
}
shadowcut_status shadowcut_engine_find(const shadowcut_engine* engine, uint32_t light,
                                       const shadowcut_fragment_id* id,
                                       shadowcut_fragment* fragment) {
  return guarded([&] {
    require_pointers(id);
    require_pointers(fragment);
    const Fragment* found = with_light(engine, light).find(light, {id->cell, id->piece, id->place});
    if (!found) fail(SHADOWCUT_NOT_FOUND, "there is no such fragment");
    *fragment = fragment_of(*found);
  });
}
shadowcut_status shadowcut_engine_uncertain_area(const shadowcut_engine* engine, uint32_t light,
                                                 uint32_t face_count, double* areas) {
  return guarded([&] {
    const std::vector<double> all = with_light(engine, light).uncertain_area(light);
    require(all.size() <= face_count, "the array has no room for all faces");
    require(areas != nullptr || all.empty(), "a pointer is null");
    std::copy(all.begin(), all.end(), areas);
  });
}
shadowcut_status shadowcut_engine_is_lit(const shadowcut_engine* engine, uint32_t light,
                                         uint32_t face, const double* point, int32_t* lit) {
  return guarded([&] {
    require_pointers(point);
    require_pointers(lit);
    const Engine& e = with_light(engine, light);
    require(face < e.scene().faces().size(), "there is no such face");
    *lit = e.is_lit(light, face, Vec3(point)) ? 1 : 0;
  });
}
shadowcut_status shadowcut_engine_validate(const shadowcut_engine* engine) {
  return guarded([&] {
    if (std::string what = whole(engine).engine.validate(); !what.empty())
      fail(SHADOWCUT_INTERNAL_ERROR, std::move(what));
  });
}

shadowcut_status shadowcut_engine_overlay(const shadowcut_engine* engine,
                                          shadowcut_light_partition** partition) {
  return guarded([&] {
    require_pointers(partition);
    *partition = new shadowcut_light_partition{whole(engine).engine.overlay()};
  });
}
shadowcut_status shadowcut_engine_overlay_faces(const shadowcut_engine* engine,
                                                const uint32_t* faces, int32_t face_count,
                                                shadowcut_light_partition** partition) {
  return guarded([&] {
    require_pointers(partition);
    const std::span<const std::uint32_t> chosen = span_of(faces, face_count);
    *partition = new shadowcut_light_partition{whole(engine).engine.overlay(chosen)};
  });
}
