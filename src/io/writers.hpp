// The writers behind write_fragments, one for each family of formats.
#pragma once

#include <shadowcut/io.hpp>
#include <string>

#include "pieces.hpp"

namespace shadowcut::io {

void write_obj(const std::string& path, const Scene& scene, const Pieces& pieces);
void write_ply(const std::string& path, const Scene& scene, const Pieces& pieces);
void write_gltf(const std::string& path, const Scene& scene, const Pieces& pieces, bool binary);
void write_svg(const std::string& path, const Scene& scene, const Engine& engine, const View& view);

// The colour of a material that a share `brightness` of the lights reaches: from a cool dark grey
// to a pale warm white. sRGB, 0 to 1.
Vec3 colour_of(double brightness);

}  // namespace shadowcut::io
