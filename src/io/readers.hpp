// The readers behind read_scene, one for each family of formats. Each takes the file's bytes, so
// that none opens files its own way; `name` stands for the file in messages. All throw Error on a
// file that is not of their format; a face with a bad coordinate or index is not their matter: it
// goes to Scene::add, which reports it.
#pragma once

#include <shadowcut/io.hpp>
#include <string>
#include <string_view>

namespace shadowcut::io {

// The file's name without folder and extension: the name of the one object of a format without
// names.
std::string stem_of(const std::string& path);

// A scene for a reader to fill.
Scene empty_scene(const ReadOptions& options);

// Corner index that is out of range in every mesh.
inline constexpr std::uint32_t bad_index = invalid_index;

Scene read_ply(std::string_view bytes, const std::string& name, const ReadOptions& options);
Scene read_off(std::string_view text, const std::string& name, const ReadOptions& options);
Scene read_stl(std::string_view bytes, const std::string& name, const ReadOptions& options);
Scene read_with_assimp(const std::string& path, const ReadOptions& options);

}  // namespace shadowcut::io
