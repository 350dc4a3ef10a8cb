// What is behind the handles of c.h, and the one way in which its functions fail.
#pragma once

#include <shadowcut/c.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <deque>
#include <memory>
#include <new>
#include <shadowcut/buffers.hpp>
#include <shadowcut/shadows.hpp>
#include <span>
#include <string>

struct shadowcut_mesh {
  shadowcut::Mesh mesh;
  bool whole = true;  // false: it ran out of memory half-way
};

struct shadowcut_scene {
  std::shared_ptr<shadowcut::Scene> own;  // null: an engine's, to be read only
  const shadowcut::Scene* scene = nullptr;
};

struct shadowcut_shadows {
  shadowcut::Shadows own;
  const shadowcut::Shadows* shadows = nullptr;  // own, or an engine's, or null: none (now)
};

struct shadowcut_light_partition {
  shadowcut::LightPartition partition;
};

struct shadowcut_engine {
  shadowcut_engine(std::shared_ptr<const shadowcut::Scene> followed, shadowcut::Options options)
      : scene(std::move(followed)), engine(*scene, report_to(*this, std::move(options))) {
    view.scene = &engine.scene();
  }
  static shadowcut::Options report_to(shadowcut_engine& engine, shadowcut::Options options) {
    options.progress = [&engine](double share) {
      engine.progress.store(share, std::memory_order_relaxed);
    };
    return options;
  }

  const std::uint64_t serial = ++made;  // no two engines have the same
  std::atomic<double> progress{0};
  std::shared_ptr<const shadowcut::Scene> scene;
  shadowcut::Engine engine;
  // of the engine's own scene, which stays where it is
  shadowcut_scene view;
  std::deque<shadowcut_shadows> lights;         // by index
  const shadowcut::Changes* changes = nullptr;  // of the last update; null: none, or it failed

 private:
  inline static std::atomic<std::uint64_t> made{0};
};

struct shadowcut_buffers {
  shadowcut::FragmentBuffers buffers;
  std::uint64_t engine = 0;  // the serial of the one they follow
};

namespace shadowcut::c {

// What a function throws to return another status than SHADOWCUT_OK.
struct Failure {
  shadowcut_status status;
  std::string message;
};
[[noreturn]] void fail(shadowcut_status status, std::string message);
inline void require(bool holds, const char* message) {
  if (!holds) fail(SHADOWCUT_INVALID_ARGUMENT, message);
}
template <class... T>
void require_pointers(const T*... pointers) {
  require((... && (pointers != nullptr)), "a pointer is null");
}

// The status for the exception being handled; keeps its message.
shadowcut_status status_of_exception() noexcept;

template <class Body>
shadowcut_status guarded(const Body& body) noexcept {
  try {
    body();
    return SHADOWCUT_OK;
  } catch (...) {
    return status_of_exception();
  }
}

// Structs that begin with their size.
template <class T>
void require_size(const T* value) {
  require_pointers(value);
  require(value->size == sizeof(T),
          "wrong struct size: its *_init function was not called, or is of another version");
}
template <class T>
shadowcut_status initialise(T* out, T value) noexcept {
  return guarded([&] {
    require_pointers(out);
    value.size = sizeof(T);
    *out = value;
  });
}

inline bool flag(std::int32_t value) {
  require(value == 0 || value == 1, "a flag is neither 0 nor 1");
  return value == 1;
}
// The enums here and in C++ have the same values; the largest is given.
template <class Enum>
Enum enum_of(std::int32_t value, Enum last) {
  require(value >= 0 && value <= static_cast<std::int32_t>(last), "invalid enum value");
  return static_cast<Enum>(value);
}

// What stands at `data`, which may be null if there is nothing.
template <class T>
std::span<const T> span_of(const T* data, std::int64_t count) {
  require(count >= 0, "a count is negative");
  require(data != nullptr || count == 0, "a pointer is null");
  return {data, static_cast<std::size_t>(count)};
}

// A part of an array, to be copied out.
template <class In, class Out>
std::span<In> part_of(std::span<In> from, std::uint32_t first, std::uint32_t count,
                      const Out* out) {
  require(first <= from.size() && count <= from.size() - first, "range out of bounds");
  require(out != nullptr || count == 0, "a pointer is null");
  return from.subspan(first, count);
}
template <class In, class Out, class Convert>
void copy_out(std::span<In> from, std::uint32_t first, std::uint32_t count, Out* out,
              const Convert& convert) {
  for (const auto& value : part_of(from, first, count, out)) *out++ = convert(value);
}

inline void copy(const Vec3& x, double* out) { std::copy_n(x.data(), 3, out); }
std::uint32_t count_of(std::size_t size);  // throws beyond 32 bits
inline const double* numbers_of(const std::vector<Vec3>& points) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  return points.empty() ? nullptr : points.front().data();
}

const Scene& value_of(const shadowcut_scene* scene);
const Shadows& value_of(const shadowcut_shadows* shadows);
shadowcut_fragment fragment_of(const Fragment& fragment);
shadowcut_face_area area_of(const FaceArea& area);
Light light_of(const shadowcut_light* light);
Options options_of(const shadowcut_options* options);  // null: the defaults
// Throws Failure when it must be compacted.
const shadowcut_engine& whole(const shadowcut_engine* engine);
const Changes& changes_of(const shadowcut_engine* engine);

}  // namespace shadowcut::c
