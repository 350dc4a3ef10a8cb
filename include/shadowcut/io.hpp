// Scene files in, fragments out. Part of the library target shadowcut::io.
//
// Errors: every function throws shadowcut::Error with one line that names the file, and leaves no
// half-written file behind (output is written beside the target and renamed).
#pragma once

#include <limits>
#include <shadowcut/scene.hpp>
#include <shadowcut/shadows.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace shadowcut::io {

struct ReadOptions {
  Sides sides = Sides::automatic;                      // for every object
  double coplanarity_tolerance = default_coplanarity;  // Scene::coplanarity_tolerance
};

// Reads a scene. By extension: .obj .ply .off .stl, whose coordinates are the doubles nearest to
// the file's numbers; anything else by Assimp, which holds coordinates as float. Objects and groups
// of an OBJ, solids of an STL, nodes of a glTF, DAE, FBX or IFC become objects with their names; a
// mesh that several nodes share becomes one object each. Lights of the file (KHR_lights_punctual
// and Assimp's) become the scene's. Points and lines are not faces and are left out.
Scene read_scene(const std::string& path, const ReadOptions& options = {});

// Reads an OBJ from memory; `name` stands for the file in messages. For tests and fuzzing.
Scene read_obj(std::string_view text, const std::string& name, const ReadOptions& options = {});

// One line for an issue: file, object, face, reason.
std::string describe(const Scene& scene, const Issue& issue, const std::string& file);

// A drawing's point of view.
struct View {
  // plan: from above, along -up, upper surfaces over lower ones, with a scale bar. face: one face,
  // flat on the page, seen from its front, with a scale bar. camera: in perspective, hidden
  // surfaces removed exactly (by the engine itself, with the eye as a light).
  enum class Kind { plan, face, camera } kind = Kind::plan;
  Vec3 up = Vec3::UnitZ();
  // plan and camera: the engine's lights in its order, removed ones included, which say what side
  // of an open sheet is lit. Empty: the scene's.
  std::vector<Light> lights;
  // plan: what lies higher along up is taken off, a ceiling for one
  double cut = std::numeric_limits<double>::infinity();
  std::uint32_t face = none;                       // face: index into Scene::faces()
  Vec3 eye = Vec3::Zero(), target = Vec3::Zero();  // camera
  double fov = 1.0471975511965976;                 // camera: vertical field of view, radians
  // camera: for the engine that finds what the eye sees; 0: one for each processor
  unsigned threads = 0;
  double width = 1024, height = 768;  // page, in px
};

// Writes the fragments by the path's extension: .obj .ply .gltf .glb (each object keeps its name,
// lit and shadowed are materials; with several lights, one material for each set of lights), .svg
// (a drawing).
void write_fragments(const std::string& path, const Scene& scene, const Engine& engine,
                     const View& view = {});

// Columns: light,object,face,facing,area,lit_area,shadowed_area; a row for each face and light,
// numbers with all their digits.
void write_areas(const std::string& path, const Scene& scene, const Engine& engine);

// Writes text to path through a temporary beside it; "-" is standard output.
void write_text(const std::string& path, std::string_view text);

}  // namespace shadowcut::io
