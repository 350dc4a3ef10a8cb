// The program shadowcut: parses the arguments and runs a command. Every error is one line on
// standard error and exit status 2. A replay whose verification fails has exit status 1.
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

// The word in `choices` for a value.
template <typename T>
std::string word_for(const std::map<std::string, T>& choices, T value) {
  for (const auto& [word, choice] : choices)
    if (choice == value) return word;
  return "";
}

// An option that takes one of several words. The target's value is the default.
template <typename T>
CLI::Option* add_choice(CLI::App& command, const std::string& name, T& target,
                        const std::map<std::string, T>& choices, const std::string& help) {
  std::string words;
  for (const auto& [word, value] : choices) words += (words.empty() ? "" : "|") + word;
  const auto set = [&target, choices, name, words](const std::string& word) {
    const auto place = choices.find(word);
    if (place == choices.end())
      throw CLI::ValidationError(name, "'" + word + "' is not one of " + words);
    target = place->second;
  };
  return command.add_option_function<std::string>(name, set, help)
      ->type_name(words)
      ->default_str(word_for(choices, target));
}

// An option with a number. The target's value is the default.
template <typename T>
CLI::Option* add_number(CLI::App& command, const std::string& name, T& target,
                        const std::string& help) {
  return command.add_option(name, target, help)
      ->type_name("N")
      ->default_str(std::to_string(target));
}

CLI::Option* add_list(CLI::App& command, const std::string& name, std::vector<std::string>& target,
                      const std::string& help) {
  return command.add_option(name, target, help)->type_size(1)->allow_extra_args(false);
}

const std::map<std::string, Sides> sides{
    {"auto", Sides::automatic}, {"closed", Sides::closed}, {"open", Sides::open}};

void add_reading(CLI::App& command, io::ReadOptions& reading) {
  add_choice<Sides>(command, "--sides", reading.sides, sides,
                    "Treat objects as closed solids or as open sheets; auto = decide per object");
  const auto set = [&reading](const std::string& text) {
    reading.coplanarity_tolerance = parse_share("--coplanar", text);
  };
  command
      .add_option_function<std::string>("--coplanar", set,
                                        "Snap nearly coplanar faces of an object to one plane; "
                                        "tolerance relative to its largest coordinate; 0 = off")
      ->type_name("TOL")
      ->default_str(number_text(reading.coplanarity_tolerance));
}

template <typename Arguments>
void add_scene(CLI::App& command, Arguments& a) {
  command
      .add_option("SCENE", a.scene,
                  "Scene file: .obj .ply .off .stl .gltf .glb .dae .fbx .ifc and others")
      ->type_name("FILE")
      ->required();
  add_list(command, "--light", a.lights,
           "A light: point:x,y,z, or directional:dx,dy,dz (also sun:dx,dy,dz) with the direction "
           "of its rays; may be repeated; without it the lights of the scene file are used")
      ->type_name("SPEC");
  add_reading(command, a.reading);
  command.add_flag("--quiet", a.quiet, "Print nothing except errors");
}

// Options of all commands that cast shadows or draw them without a window.
template <typename Arguments>
void add_lit_scene(CLI::App& command, Arguments& a) {
  add_scene(command, a);
  command.add_option("--json", a.json, "Write a summary as JSON; - = standard output")
      ->type_name("FILE");
}

// Options of render and view. Those of view are all optional.
template <typename Arguments>
void add_picture(CLI::App& command, Arguments& a, bool required) {
  std::string names;
  for (const std::string& name : render::technique_names())
    names += (names.empty() ? "" : ", ") + name;
  command.add_option("--technique", a.technique, "How shadows are drawn: " + names)
      ->required(required)
      ->type_name("T")
      ->default_str(a.technique);
  command
      .add_option("--camera", a.camera,
                  "Eye, target and vertical field of view in degrees: ex,ey,ez,tx,ty,tz[,fov]")
      ->required(required)
      ->type_name("CAMERA");
  const auto set_size = [&a](const std::string& text) {
    std::tie(a.width, a.height) = parse_size(text);
  };
  command.add_option_function<std::string>("--size", set_size, "Width and height in pixels")
      ->type_name("WxH")
      ->default_str(std::to_string(a.width) + "x" + std::to_string(a.height));
}

// Options of cast and replay.
template <typename Arguments>
void add_casting(CLI::App& command, Arguments& a) {
  add_lit_scene(command, a);
  add_choice<Kernel>(command, "--kernel", a.options.kernel, kernels(),
                     "Arithmetic: fast = double with error bounds, exact = exact signs");
  command
      .add_option_function<std::string>(
          "--min-feature",
          [&a](const std::string& text) { a.options.min_feature = parse_min_feature(text); },
          "Leave out fragments smaller than SIZE: an area, or a solid angle such as 1e-6sr; "
          "0 keeps all")
      ->type_name("SIZE")
      ->default_str("0");
  add_number(command, "--threads", a.options.threads, "Number of threads; 0 = one per processor")
      ->check(CLI::Range(0, 4096).description(""));
}

void add_cast(CLI::App& app, CastArguments& a) {
  CLI::App& command =
      *app.add_subcommand("cast", "Cut the faces of a scene into lit and shadowed fragments");
  add_casting(command, a);
  add_choice<Form>(
      command, "--form", a.options.form,
      {{"pieces", Form::pieces}, {"merged", Form::merged}, {"conforming", Form::conforming}},
      "Form of the fragments: as cut by the tree, merged, or without T-junctions");
  add_list(command, "-o", a.outputs,
           "Write fragments (.obj .ply .gltf .glb) or a drawing (.svg); may be repeated")
      ->type_name("FILE");
  command.add_option("--areas", a.areas, "Write the areas of every face as CSV")->type_name("FILE");
  command.add_flag("--strict", a.strict, "Fail if a face of the scene was refused or repaired");
  add_list(command, "--svg", a.drawings,
           "View of the .svg drawings: plan, plan:HEIGHT (cut at that height), OBJECT:FACE, or a "
           "camera ex,ey,ez,tx,ty,tz[,fov]; once for all drawings, or once for each")
      ->type_name("VIEW")
      ->default_str("plan");
  command.add_option("--up", a.up, "Upward axis of drawings")
      ->check(CLI::IsMember({"x", "y", "z"}).description(""))
      ->type_name("x|y|z")
      ->default_str(a.up);
  add_choice<Order>(command, "--order", a.options.tuning.order,
                    {{"solid-angle", Order::solid_angle},
                     {"as-given", Order::as_given},
                     {"random", Order::random}},
                    "Order of insertion into the tree; changes cost, never lit regions");
  add_number(command, "--seed", a.options.tuning.seed, "Seed of --order random");
  add_number(command, "--facets-per-cell", a.options.tuning.facets_per_cell,
             "Facets per cell at which the k-d tree stops dividing; 0 = no k-d tree");
}

void add_inspect(CLI::App& app, InspectArguments& a) {
  CLI::App& command = *app.add_subcommand(
      "inspect", "List the objects, the lights, and the refused or repaired faces of a scene");
  command.add_option("SCENE", a.scene, "Scene file")->type_name("FILE")->required();
  command.add_option("--json", a.json, "Write the list as JSON; - = standard output")
      ->type_name("FILE");
  add_reading(command, a.reading);
}

void add_replay(CLI::App& app, ReplayArguments& a) {
  CLI::App& command = *app.add_subcommand(
      "replay", "Apply a script of edits to a scene and update its shadows incrementally");
  add_casting(command, a);
  command
      .add_option("EDITS", a.edits,
                  "Script: one JSON object per line, with op move, pose, remove, add, light or "
                  "update")
      ->required()
      ->type_name("FILE");
  command.add_flag("--verify", a.verify,
                   "Compare every update with a rebuild; exit status 1 if they differ");
  command
      .add_option("--changes", a.changes,
                  "Write the changes of every update: one JSON object per line and light")
      ->type_name("FILE");
  add_number(command, "--join-threshold", a.options.tuning.join_threshold,
             "Remove a marked plane if its smaller side has at most N nodes");
}

void add_compare(CLI::App& app, CompareArguments& a) {
  CLI::App& command = *app.add_subcommand(
      "compare", "Run published shadow algorithms on a scene and compare times and counts");
  add_lit_scene(command, a);
  command.add_option("--algorithms", a.algorithms, "Algorithms, separated by commas")
      ->type_name("LIST")
      ->default_str(a.algorithms);
  add_number(command, "--tiles", a.settings.tiles,
             "Shadow tiling: tiles along a side of the cube around the light")
      ->check(CLI::Range(1, 4096).description(""));
  add_number(command, "--candidates", a.settings.candidates,
             "Scene BSP: polygons tried as the root of each subtree")
      ->check(CLI::PositiveNumber);
}

void add_render(CLI::App& app, RenderArguments& a) {
  CLI::App& command =
      *app.add_subcommand("render", "Draw a scene and its shadows with OpenGL, without a display");
  add_lit_scene(command, a);
  add_picture(command, a, true);
  const render::MapSettings map;
  command
      .add_option("--map-size", a.map_side,
                  "Pixels per side of a shadow map, or of a light's view of shadow textures")
      ->type_name("N")
      ->default_str(std::to_string(map.side));
  command
      .add_option("--bias", a.bias,
                  "Bias of a shadow map: factor of the slope, depth steps, texels along the normal")
      ->type_name("SLOPE,UNITS,TEXELS")
      ->default_str(number_text(map.slope_bias) + "," + number_text(map.unit_bias) + "," +
                    number_text(map.texel_bias));
  command
      .add_option(
          "--wind", a.wind,
          "Bend the scene in the vertex shader: displacement in x and y per unit of height; "
          "only with stencil-kolic and shadow-map")
      ->type_name("X,Y");
  command.add_option("-o", a.output, "Picture to write, .png")->required()->type_name("FILE");
}

void add_view(CLI::App& app, ViewArguments& a) {
  CLI::App& command = *app.add_subcommand(
      "view", "Walk through a scene in a window, and drag its objects and lights");
  add_scene(command, a);
  command.get_option("SCENE")->required(false)->description(
      "Scene file; without it a furnished room is shown");
  add_picture(command, a, false);
}

int fail(std::string message, int status) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::cerr << "shadowcut: " << message << std::endl;
  return status;
}

int run(int argc, char** argv) {
  CLI::App app("Exact shadow geometry", "shadowcut");
  app.get_formatter()->column_width(36);
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
  std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is reported as an error of writing
  try {
    return shadowcut::cli::run(argc, argv);
  } catch (const std::bad_alloc&) {
    return shadowcut::cli::fail("out of memory", 2);
  } catch (const std::exception& error) {
    return shadowcut::cli::fail(error.what(), 2);
  }
}
