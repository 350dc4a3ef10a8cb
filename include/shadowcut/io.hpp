/// @file
/// Scene files in, fragments out. Part of the library target shadowcut::io.
///
/// Errors: every function throws shadowcut::Error with one line that names the file. Output is
/// written to a temporary file beside the target, which is then renamed, so that no incomplete file
/// is left. Thread safety: functions are independent of each other.
#pragma once

#include <limits>
#include <shadowcut/scene.hpp>
#include <shadowcut/shadows.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace shadowcut::io {

struct ReadOptions {
  Sides sides = Sides::automatic;                      ///< of every object
  double coplanarity_tolerance = default_coplanarity;  ///< Scene::coplanarity_tolerance
};

/// Reads a scene; the extension of the path decides the format. Coordinates in .obj .ply .off .stl
/// become the nearest doubles; all other formats are read by Assimp, which stores coordinates as
/// float. Objects and groups of an OBJ, solids of an STL, and nodes of a glTF, DAE, FBX or IFC
/// become objects with their names; a mesh shared by several nodes becomes one object for each of
/// them. Lights of the file (KHR_lights_punctual and those of Assimp) become lights of the scene.
/// Points and lines are ignored.
Scene read_scene(const std::string& path, const ReadOptions& options = {});

/// Reads an OBJ from memory; messages name it `name`. For tests and fuzzing.
Scene read_obj(std::string_view text, const std::string& name, const ReadOptions& options = {});

/// One line about an issue: file, object, face, reason.
std::string describe(const Scene& scene, const Issue& issue, const std::string& file);

/// The point of view of a drawing.
struct View {
  enum class Kind {
    plan,    ///< from above, along -up; higher surfaces hide lower ones; with a scale bar
    face,    ///< one face, flat on the page, seen from its front; with a scale bar
    camera,  ///< in perspective; hidden surfaces are removed exactly, with the eye as a light
  } kind = Kind::plan;
  Vec3 up = Vec3::UnitZ();
  /// Plan and camera: the engine's lights in its order, removed ones included; they decide which
  /// side of an open sheet is lit. Empty: the lights of the scene.
  std::vector<Light> lights;
  /// Plan: everything higher along `up` is left out, for example a ceiling.
  double cut = std::numeric_limits<double>::infinity();
  std::uint32_t face = invalid_index;              ///< face: index into Scene::faces()
  Vec3 eye = Vec3::Zero(), target = Vec3::Zero();  ///< camera
  double fov = 1.0471975511965976;                 ///< camera: vertical field of view, radians
  /// Camera: threads of the engine that finds the visible surfaces; 0: one for each processor.
  unsigned threads = 0;
  double width = 1024, height = 768;  ///< of the page, in px
};

/// Writes the fragments; the extension of the path decides the format: .obj .ply .gltf .glb (each
/// object keeps its name; lit and shadowed are materials, with several lights there is one material
/// for each set of lights), or .svg (a drawing).
void write_fragments(const std::string& path, const Scene& scene, const Engine& engine,
                     const View& view = {});

/// Writes a CSV with the columns light,object,face,facing,area,lit_area,shadowed_area: a row for
/// each face and light, numbers with all digits.
void write_areas(const std::string& path, const Scene& scene, const Engine& engine);

/// Writes text to a file; "-" is standard output.
void write_text(const std::string& path, std::string_view text);

}  // namespace shadowcut::io
