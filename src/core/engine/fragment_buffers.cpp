// FragmentBuffers, the public class, over its state.

#include "engine/vertex_buffers.hpp"

namespace shadowcut {

FragmentBuffers::FragmentBuffers(std::uint32_t light, const BufferLayout& layout)
    : impl_(std::make_unique<Impl>(light, layout)) {}
FragmentBuffers::~FragmentBuffers() = default;
FragmentBuffers::FragmentBuffers(const FragmentBuffers& other)
    : impl_(std::make_unique<Impl>(*other.impl_)) {}
FragmentBuffers& FragmentBuffers::operator=(const FragmentBuffers& other) {
  if (this != &other) impl_ = std::make_unique<Impl>(*other.impl_);
  return *this;
}
FragmentBuffers::FragmentBuffers(FragmentBuffers&&) noexcept = default;
FragmentBuffers& FragmentBuffers::operator=(FragmentBuffers&&) noexcept = default;

void FragmentBuffers::update(const Engine& engine, const Changes& changes) {
  impl_->update(engine, changes);
}
void FragmentBuffers::fill(const Engine& engine) { impl_->fill(engine); }
void FragmentBuffers::fill(const Scene& scene, const Shadows& shadows) {
  impl_->fill(scene, shadows);
}
void FragmentBuffers::fill(const Scene& scene, const LightPartition& partition) {
  impl_->fill(scene, partition);
}
void FragmentBuffers::forget() { impl_->seen_ = 0; }
void FragmentBuffers::set_origin(const Vec3& origin) { impl_->set_origin(origin); }

std::uint32_t FragmentBuffers::light() const { return impl_->light_; }
const BufferLayout& FragmentBuffers::layout() const { return impl_->layout_; }
std::uint32_t FragmentBuffers::vertex_count() const { return impl_->vertex_count_; }
std::uint32_t FragmentBuffers::vertex_capacity() const { return impl_->vertex_capacity_; }
std::uint32_t FragmentBuffers::index_count() const { return impl_->index_count_; }
std::uint32_t FragmentBuffers::index_capacity() const { return impl_->index_capacity_; }
std::uint32_t FragmentBuffers::fragment_count() const { return impl_->fragment_count_; }
std::uint32_t FragmentBuffers::hole_vertices() const { return impl_->hole_vertices_; }
std::uint32_t FragmentBuffers::mask_words() const { return impl_->mask_words_; }
bool FragmentBuffers::grown() const { return impl_->grown_; }
std::span<const FragmentBuffers::Range> FragmentBuffers::changed_vertices() const {
  return impl_->changed_vertices_;
}
std::span<const FragmentBuffers::Range> FragmentBuffers::changed_indices() const {
  return impl_->changed_indices_;
}
std::span<const float> FragmentBuffers::positions() const { return impl_->positions_; }
std::span<const double> FragmentBuffers::double_positions() const {
  return impl_->double_positions_;
}
std::span<const float> FragmentBuffers::normals() const { return impl_->normals_; }
std::span<const std::uint32_t> FragmentBuffers::faces() const { return impl_->faces_; }
std::span<const std::uint32_t> FragmentBuffers::objects() const { return impl_->objects_; }
std::span<const std::uint8_t> FragmentBuffers::states() const { return impl_->states_; }
std::span<const std::uint32_t> FragmentBuffers::masks() const { return impl_->masks_; }
std::span<const std::uint32_t> FragmentBuffers::indices() const { return impl_->indices_; }

}  // namespace shadowcut
