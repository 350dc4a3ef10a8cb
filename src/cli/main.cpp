// The program shadowcut: reads its arguments, runs a command, and turns whatever goes wrong into
// one line and exit status 2; a replay that does not verify ends with 1.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <iostream>
#include <map>
#include <new>
#include <tuple>

#include "commands.hpp"
#include "specs.hpp"
#include "technique.hpp"

namespace shadowcut::cli {

namespace {

template <typename T>
CLI::Option* add_choice(CLI::App& command, const std::string& name, T& target,
                        const std::map<std::string, T>& choices, const std::string& help) {
  std::string words;
  for (const auto& [word, value] : choices) words += (words.empty() ? "" : "|") + word;
  const auto set = [&target, choices, name, words](const std::string& word) {
    const auto place = choices.find(word);
    if (place == choices.end())
      throw CLI::ValidationError(name, "'" + word + "' is none of " + words);
    target = place->second;
  };
  return command.add_option_function<std::string>(name, set, help)->type_name(words);
}

CLI::Option* add_list(CLI::App& command, const std::string& name, std::vector<std::string>& target,
                      const std::string& help) {
  return command.add_option(name, target, help)->type_size(1)->allow_extra_args(false);
}

const std::map<std::string, Sides> sides{
    {"auto", Sides::automatic}, {"closed", Sides::closed}, {"open", Sides::open}};

void add_reading(CLI::App& command, io::ReadOptions& reading) {
  add_choice<Sides>(command, "--sides", reading.sides, sides, "Which sides of faces count (auto)");
  const auto set = [&reading](const std::string& text) {
    reading.coplanarity_tolerance = parse_share("--coplanar", text);
  };
  command
      .add_option_function<std::string>("--coplanar", set,
                                        "Faces of an object within this share of its largest "
                                        "coordinate of one plane get that plane; 0: none "
                                        "do (1e-12)")
      ->type_name("TOL");
}

template <typename Arguments>
void add_scene(CLI::App& command, Arguments& a) {
  command
      .add_option("SCENE", a.scene,
                  "Scene file: .obj .ply .off .stl .gltf .glb .dae .fbx .ifc and others")
      ->required();
  add_list(command, "--light", a.lights,
           "point:x,y,z or directional:dx,dy,dz, also sun:dx,dy,dz (the direction of the rays); "
           "without one: the scene's own lights")
      ->type_name("SPEC");
  add_reading(command, a.reading);
  command.add_flag("--quiet", a.quiet, "Say nothing but errors");
}

// What all commands that cast have in common.
template <typename Arguments>
void add_lit_scene(CLI::App& command, Arguments& a) {
  add_scene(command, a);
  command.add_option("--json", a.json, "Summary; - is standard output")->type_name("FILE");
}

// What render and view have in common: `view` can do without any of it.
template <typename Arguments>
void add_picture(CLI::App& command, Arguments& a, bool required) {
  std::string names;
  for (const std::string& name : render::technique_names())
    names += (names.empty() ? "" : ", ") + name;
  command.add_option("--technique", a.technique, names)->required(required)->type_name("T");
  command
      .add_option("--camera", a.camera,
                  "ex,ey,ez,tx,ty,tz[,fov in degrees]: from where to where it looks")
      ->required(required)
      ->type_name("CAMERA");
  const auto set_size = [&a](const std::string& text) {
    std::tie(a.width, a.height) = parse_size(text);
  };
  const std::string size = std::to_string(a.width) + "x" + std::to_string(a.height);
  command.add_option_function<std::string>("--size", set_size, "Pixels (" + size + ")")
      ->type_name("WxH");
}

// What cast and replay have in common.
template <typename Arguments>
void add_casting(CLI::App& command, Arguments& a) {
  add_lit_scene(command, a);
  add_choice<Kernel>(command, "--kernel", a.options.kernel, kernels(),
                     "Arithmetic: fast (double, with error bounds), or exact (fast)");
  command
      .add_option_function<std::string>(
          "--min-feature",
          [&a](const std::string& text) { a.options.min_feature = parse_min_feature(text); },
          "Fragments below this are left out: an area, or a solid angle such as 1e-6sr (0)")
      ->type_name("SIZE");
  command.add_option("--threads", a.options.threads, "0: one for each processor")
      ->check(CLI::Range(0, 4096));
}

void add_cast(CLI::App& app, CastArguments& a) {
  CLI::App& command =
      *app.add_subcommand("cast", "Cut the faces of a scene into lit and shadowed fragments");
  add_casting(command, a);
  add_choice<Form>(
      command, "--form", a.options.form,
      {{"pieces", Form::pieces}, {"merged", Form::merged}, {"conforming", Form::conforming}},
      "Form of the fragments (merged)");
  add_list(command, "-o", a.outputs, "Fragments: .obj .ply .gltf .glb, or a drawing: .svg")
      ->type_name("FILE");
  command.add_option("--areas", a.areas, "Areas of every face, as comma separated values")
      ->type_name("FILE");
  command.add_flag("--strict", a.strict, "Refuse a scene with refused or repaired faces");
  add_list(command, "--svg", a.drawings,
           "Drawing for .svg: plan, plan:HEIGHT (cut there), OBJECT:FACE, or "
           "ex,ey,ez,tx,ty,tz[,fov]; one for each .svg, or one for all")
      ->type_name("VIEW");
  command.add_option("--up", a.up, "Axis that points up in drawings (z)")
      ->check(CLI::IsMember({"x", "y", "z"}));
  add_choice<Order>(command, "--order", a.options.tuning.order,
                    {{"solid-angle", Order::solid_angle},
                     {"as-given", Order::as_given},
                     {"random", Order::random}},
                    "Order of insertion (solid-angle)");
  command.add_option("--seed", a.options.tuning.seed, "For --order random");
  command.add_option("--facets-per-cell", a.options.tuning.facets_per_cell,
                     "Where the balanced prefix stops dividing; 0: no prefix");
}

void add_inspect(CLI::App& app, InspectArguments& a) {
  CLI::App& command = *app.add_subcommand(
      "inspect", "List a scene's objects, lights, and refused or repaired faces");
  command.add_option("SCENE", a.scene, "Scene file")->required();
  command.add_option("--json", a.json, "The same as JSON; - is standard output")->type_name("FILE");
  add_reading(command, a.reading);
}

void add_replay(CLI::App& app, ReplayArguments& a) {
  CLI::App& command = *app.add_subcommand(
      "replay", "Apply a script of edits to a scene, and follow its shadows update by update");
  add_casting(command, a);
  command
      .add_option("EDITS", a.edits,
                  "One edit a line, as JSON: move, pose, remove, add, light, update")
      ->required()
      ->type_name("FILE");
  command.add_flag("--verify", a.verify,
                   "Compare every update with a rebuild; exit status 1 on a difference");
  command
      .add_option("--changes", a.changes,
                  "What each update changed, one JSON object a line for each light")
      ->type_name("FILE");
  command.add_option("--join-threshold", a.options.tuning.join_threshold,
                     "Planes left behind go when a side has no more nodes than this (16)");
}

void add_compare(CLI::App& app, CompareArguments& a) {
  CLI::App& command =
      *app.add_subcommand("compare", "Run the published algorithms on a scene, side by side");
  add_lit_scene(command, a);
  command
      .add_option("--algorithms", a.algorithms,
                  "Some of brute, ordered, tiling, unordered, with commas between (all)")
      ->type_name("LIST");
  command
      .add_option("--tiles", a.settings.tiles,
                  "tiling: tiles along a side of the cube around the light (128)")
      ->check(CLI::Range(1, 4096));
  command
      .add_option("--candidates", a.settings.candidates,
                  "Polygons tried for each root of the scene BSP (8)")
      ->check(CLI::PositiveNumber);
}

void add_render(CLI::App& app, RenderArguments& a) {
  CLI::App& command = *app.add_subcommand(
      "render", "Draw a scene with OpenGL, its shadows by one of several techniques");
  add_lit_scene(command, a);
  add_picture(command, a, true);
  command
      .add_option("--map-size", a.map_side,
                  "Pixels a side, of a shadow map or a light's view of shadow textures (2048)")
      ->type_name("N");
  command
      .add_option("--bias", a.bias,
                  "Of a shadow map: per slope, steps of depth, texels off the face (1.1,4,0.5)")
      ->type_name("SLOPE,UNITS,TEXELS");
  command
      .add_option("--wind", a.wind,
                  "Bends the scene in the vertex shader: x,y by which what is one unit above the "
                  "lowest point is carried")
      ->type_name("X,Y");
  command.add_option("-o", a.output, "The picture, .png")->required()->type_name("FILE");
}

void add_view(CLI::App& app, ViewArguments& a) {
  CLI::App& command = *app.add_subcommand(
      "view", "Walk through a scene in a window, and move its objects and lights");
  add_scene(command, a);
  command.get_option("SCENE")->required(false)->description("Scene file; none: a furnished room");
  add_picture(command, a, false);
}

int fail(std::string message, int status) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::cerr << "shadowcut: " << message << std::endl;
  return status;
}

int run(int argc, char** argv) {
  CLI::App app("Exact shadow geometry", "shadowcut");
  app.set_version_flag("--version", "shadowcut " SHADOWCUT_VERSION);
  app.require_subcommand(1);
  CastArguments cast_arguments;
  InspectArguments inspect_arguments;
  ReplayArguments replay_arguments;
  CompareArguments compare_arguments;
  RenderArguments render_arguments;
  ViewArguments view_arguments;
  add_cast(app, cast_arguments);
  add_inspect(app, inspect_arguments);
  add_replay(app, replay_arguments);
  add_compare(app, compare_arguments);
  add_render(app, render_arguments);
  add_view(app, view_arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    throw Error(error.what());
  }
  if (app.got_subcommand("cast")) cast(cast_arguments);
  if (app.got_subcommand("inspect")) inspect(inspect_arguments);
  if (app.got_subcommand("compare")) compare_algorithms(compare_arguments);
  if (app.got_subcommand("render")) render_picture(render_arguments);
  if (app.got_subcommand("view")) view_scene(view_arguments);
  if (!app.got_subcommand("replay")) return 0;
  const std::string difference = replay(replay_arguments);
  return difference.empty() ? 0 : fail(difference, 1);
}

}  // namespace

}  // namespace shadowcut::cli

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is an output that cannot be written, and said so
  try {
    return shadowcut::cli::run(argc, argv);
  } catch (const std::bad_alloc&) {
    return shadowcut::cli::fail("out of memory", 2);
  } catch (const std::exception& error) {
    return shadowcut::cli::fail(error.what(), 2);
  }
}
