// Fragments in the writers' shape; see pieces.hpp.
#include "pieces.hpp"

#include <algorithm>
#include <bit>
#include <map>

namespace shadowcut::io {

namespace {

void take_one_light(std::uint32_t light, const Shadows& shadows, Pieces& out) {
  out.sets = {{{light}, "lit"}, {{}, "shadowed"}};
  for (const Block& block : shadows.blocks) {
    const std::size_t base = out.corners.size();
    out.corners.insert(out.corners.end(), block.corners.begin(), block.corners.end());
    for (const Fragment& f : block.fragments)
      out.pieces.push_back(
          {f.face, f.facet, f.lit ? 0u : 1u, f.corner_count, base + f.first_corner});
  }
}

std::string name_of(const std::vector<std::uint32_t>& lights) {
  if (lights.empty()) return "shadowed";
  std::string name = "lit by ";
  for (std::size_t i = 0; i < lights.size(); ++i)
    name.append(i == 0 ? "" : "+").append(std::to_string(lights[i]));
  return name;
}

void take_several(const std::vector<std::uint32_t>& engine_lights, LightPartition&& all,
                  Pieces& out) {
  std::map<std::vector<std::uint32_t>, std::uint32_t> sets;
  std::vector<std::uint32_t> lights;
  const auto lights_of = [&](std::size_t fragment) -> const std::vector<std::uint32_t>& {
    lights.clear();
    for (const std::uint32_t k : engine_lights)
      if (all.reaches(fragment, k)) lights.push_back(k);
    return lights;
  };
  for (std::size_t i = 0; i < all.fragments.size(); ++i) sets.try_emplace(lights_of(i), 0);
  for (auto& [key, number] : sets) {
    number = static_cast<std::uint32_t>(out.sets.size());
    out.sets.push_back({key, name_of(key)});
  }
  for (std::size_t i = 0; i < all.fragments.size(); ++i) {
    const LightPartition::Fragment& f = all.fragments[i];
    out.pieces.push_back({f.face, f.facet, sets.at(lights_of(i)), f.corner_count, f.first_corner});
  }
  out.corners = std::move(all.corners);
}

}  // namespace

std::vector<std::uint32_t> lights_of(const Engine& engine) {
  std::vector<std::uint32_t> lights;
  for (std::uint32_t k = 0; k < engine.light_count(); ++k)
    if (engine.scene().light_id(k).index != invalid_index) lights.push_back(k);
  return lights;
}

Pieces pieces_of(const Scene& scene, const Engine& engine) {
  Pieces out;
  const std::vector<std::uint32_t> lights = lights_of(engine);
  out.light_count = lights.size();
  if (lights.empty()) throw Error("the scene has no light");
  if (lights.size() == 1) take_one_light(lights.front(), engine.shadows(lights.front()), out);
  else take_several(lights, engine.overlay(), out);
  std::stable_sort(out.pieces.begin(), out.pieces.end(), [&](const Piece& a, const Piece& b) {
    const std::uint32_t object_a = scene.faces()[a.face].object,
                        object_b = scene.faces()[b.face].object;
    return object_a != object_b ? object_a < object_b : a.set < b.set;
  });
  return out;
}

std::size_t VertexPool::Hash::operator()(const Vec3& position) const {
  std::uint64_t hash = 0;
  for (const double x : position)
    hash = (std::rotl(hash, 27) ^ std::bit_cast<std::uint64_t>(x)) * 0x9E3779B97F4A7C15u;
  return hash ^ hash >> 29;
}

bool VertexPool::SameBits::operator()(const Vec3& a, const Vec3& b) const {
  return std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  });
}

std::uint32_t VertexPool::add(const Vec3& position) {
  const auto [found, fresh] =
      numbers_.try_emplace(position, static_cast<std::uint32_t>(positions_.size()));
  if (fresh) positions_.push_back(position);
  return found->second;
}

void VertexPool::clear() {
  positions_.clear();
  numbers_.clear();
}

}  // namespace shadowcut::io
