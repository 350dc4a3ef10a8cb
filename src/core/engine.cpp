#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <shadowcut/shadows.hpp>

#include "combine.hpp"
#include "light_tree.hpp"

namespace shadowcut {
namespace {

// No more than TBB has workers for: asked for more it gives none, and says so on stderr.
int threads_of(const Options& options) {
  const int most = tbb::info::default_concurrency();
  return options.threads == 0 || options.threads > static_cast<unsigned>(most) ? most : static_cast<int>(options.threads);
}

}  // namespace

Shadows cast_shadows(const Scene& scene, const Light& light, const Options& options) {
  check(light, "light");
  tbb::task_arena arena(threads_of(options));
  return arena.execute([&] { return LightTree(scene, light, options).take_shadows(); });
}

struct Engine::Impl {
  const Scene& scene;
  Options options;
  std::vector<std::unique_ptr<LightTree>> lights;
};

Engine::Engine(const Scene& scene, Options options) : impl_(new Impl{scene, std::move(options), {}}) {}
Engine::~Engine() = default;
Engine::Engine(Engine&&) noexcept = default;
Engine& Engine::operator=(Engine&&) noexcept = default;

std::size_t Engine::add_light(const Light& light) {
  check(light, "light " + std::to_string(impl_->lights.size()));
  tbb::task_arena arena(threads_of(impl_->options));
  arena.execute([&] { impl_->lights.push_back(std::make_unique<LightTree>(impl_->scene, light, impl_->options)); });
  return impl_->lights.size() - 1;
}

std::size_t Engine::light_count() const { return impl_->lights.size(); }

const Shadows& Engine::shadows(std::size_t light) const {
  if (light >= impl_->lights.size()) throw Error("there is no light " + std::to_string(light));
  return impl_->lights[light]->shadows();
}

LightSets Engine::combined() const {
  tbb::task_arena arena(threads_of(impl_->options));
  return arena.execute([&] { return combine(impl_->lights); });
}

std::string Engine::validate() const {
  for (std::size_t i = 0; i < impl_->lights.size(); ++i) {
    if (std::string what = impl_->lights[i]->validate(); !what.empty()) return "light " + std::to_string(i) + ": " + what;
  }
  return {};
}

}  // namespace shadowcut
