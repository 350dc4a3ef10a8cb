// See walkthrough.hpp.
//
// The picture is drawn beside the window and copied into it, so it is what `render` draws, pixel
// for pixel; it is drawn again only when the camera or the scene has changed. What changed in the
// scene goes to the technique and to the engine at once; `fragments` and the overlay's figures
// share one engine, which follows whatever technique draws.
#include "walkthrough.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <filesystem>

#include "arrangement.hpp"
#include "fragment_marks.hpp"
#include "offscreen.hpp"
#include "pick.hpp"
#include "scene/scene_access.hpp"
#include "technique.hpp"
#include "walk.hpp"
#include "window.hpp"

namespace shadowcut::view {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// The last hundred times of something, in milliseconds.
class Times {
 public:
  void add(double seconds) {
    if (times_.size() == 100) times_.pop_front();
    times_.push_back(1000 * seconds);
  }
  double last() const { return times_.empty() ? 0 : times_.back(); }
  double median() const {
    std::vector<double> sorted(times_.begin(), times_.end());
    if (sorted.empty()) return 0;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    return *middle;
  }

 private:
  std::deque<double> times_;
};

struct Selection {
  bool is_light;
  std::uint32_t index;
};

// What the left button holds.
struct Drag {
  Vec3 grabbed, held;  // the point of it that is under the cursor: at first, and now
  Pose pose;           // at first; of an object
  Light light;         // at first; of a light
  Eigen::Vector2d pressed;
  bool moved = false;
};

constexpr double marker_radius = 9;  // pixels, times the text's scale
constexpr double click = 3;          // pixels that the cursor may move in a click

class Walkthrough {
 public:
  Walkthrough(Scene& scene, const Settings& settings);
  void run();

 private:
  void handle(const Event& event);
  void press(int key);
  void press_left(const Eigen::Vector2d& cursor);
  void move_cursor(const Eigen::Vector2d& cursor);
  void follow_cursor();
  void put_back();
  void remove_selected();
  void bring_back();
  void set_technique(const std::string& name);
  void toggle_wind();
  void let_blow(double seconds);
  void write_screenshot(bool with_overlay);
  Steps steps() const;

  void follow_scene();
  void draw_scene();
  void show();
  void describe();
  ImVec2 describe_figures();
  void describe_selection();
  void describe_keys(const ImVec2& below_figures);
  void draw_markers();
  void draw_box_of_selected();

  render::Technique& technique() { return other_ ? *other_ : *fragments_; }
  const Engine& engine() const { return *fragments_->engine(); }
  std::uint32_t shown_light() const;
  Screen screen() const {
    return {walker_.camera(), size_.width, size_.height,
            model_.frame(walker_.camera(), size_.width, size_.height).near};
  }

  Scene& scene_;
  const Settings& settings_;
  const Eigen::AlignedBox3d box_;  // of the scene at first
  Arrangement arrangement_;
  const Walker first_walker_;
  Walker walker_;
  Window window_;
  Overlay overlay_;
  render::Model model_;
  // the one that draws, if it is not `fragments`
  std::unique_ptr<render::Technique> fragments_, other_;
  std::optional<render::Target> target_;
  FragmentMarks marks_;

  std::string technique_name_, message_;
  Size size_;
  std::optional<Selection> selection_;
  std::optional<Drag> drag_;
  // where the cursor was last, while the right button is held
  std::optional<Eigen::Vector2d> looking_;
  Eigen::Vector2d cursor_ = Eigen::Vector2d::Zero();
  std::uint32_t light_ = 0;  // whose fragments are shown
  bool outlines_ = false, cells_ = false, keys_ = true;
  std::optional<double> wind_;  // for how long it has blown, in seconds
  bool picture_stale_ = true, window_stale_ = true, marks_stale_ = true;
  // revisions of the scene: the technique's and the engine's
  std::uint64_t known_ = 0, engine_known_ = 0;
  Times updates_, engine_updates_, draws_;
  double gone_ = 0, added_ = 0;
};

Walkthrough::Walkthrough(Scene& scene, const Settings& settings)
    : scene_(scene),
      settings_(settings),
      box_(box_of(scene)),
      arrangement_(scene),
      first_walker_(settings.camera, box_.diagonal().norm() / 6),
      walker_(first_walker_),
      window_({settings.width, settings.height}, "shadowcut - " + settings.scene_name),
      overlay_(window_.text_scale()),
      model_(scene),
      fragments_(render::make_technique("fragments", scene, model_)),
      size_(window_.picture()) {
  set_technique(settings.technique);
}

void Walkthrough::run() {
  Clock::time_point then = Clock::now();
  bool walking = false;
  while (!window_.is_closed()) {
    const bool waits = size_.empty() || (!walking && !wind_ && !picture_stale_ && !window_stale_);
    for (const Event& event : window_.events(waits)) handle(event);
    // Time spent waiting is not walked, nor is more than a fast walker's quarter of a second at
    // once.
    const double passed = waits ? 0 : std::min(seconds_since(then), 0.25);
    then = Clock::now();
    const Steps now = steps();
    walking = now.forward != 0 || now.right != 0 || now.up != 0 || now.turn_right != 0 ||
              now.turn_up != 0;
    if (walking) {
      walker_.walk(now, passed);
      if (drag_ && drag_->moved) follow_cursor();
      picture_stale_ = true;
    }
    if (wind_) let_blow(passed);
    const Size size = window_.picture();
    if (!(size == size_)) {
      size_ = size;
      target_.reset();
      picture_stale_ = true;
    }
    if (size_.empty()) continue;
    if (SceneAccess::revision(scene_) != known_) follow_scene();
    if (picture_stale_) draw_scene();
    if (window_stale_) show();
  }
}

void Walkthrough::handle(const Event& event) {
  switch (event.kind) {
    case Event::Kind::key:
      press(event.key);
      window_stale_ = true;
      break;
    case Event::Kind::left_down:
      press_left(event.cursor);
      break;
    case Event::Kind::left_up:
      drag_.reset();
      break;
    case Event::Kind::right_down:
      window_.capture_cursor(true);
      looking_ = event.cursor;
      break;
    case Event::Kind::right_up:
      window_.capture_cursor(false);
      looking_.reset();
      break;
    case Event::Kind::cursor:
      move_cursor(event.cursor);
      break;
    case Event::Kind::changed:
      window_stale_ = true;
      break;
  }
}

void Walkthrough::press(int key) {
  const auto& names = render::technique_names();
  if (key >= GLFW_KEY_1 && key < GLFW_KEY_1 + static_cast<int>(names.size()))
    return set_technique(names[static_cast<std::size_t>(key - GLFW_KEY_1)]);
  switch (key) {
    case GLFW_KEY_O:
      outlines_ = !outlines_, picture_stale_ = true;
      break;
    case GLFW_KEY_C:
      cells_ = !cells_, picture_stale_ = true;
      break;
    case GLFW_KEY_V:
      toggle_wind();
      break;
    case GLFW_KEY_H:
      keys_ = !keys_;
      break;
    case GLFW_KEY_R:
      drag_.reset(), selection_.reset();
      arrangement_.reset();
      message_ = "everything is back";
      break;
    case GLFW_KEY_HOME:
      walker_ = first_walker_;
      picture_stale_ = true;
      break;
    case GLFW_KEY_DELETE:
      remove_selected();
      break;
    case GLFW_KEY_INSERT:
    case GLFW_KEY_U:
      bring_back();
      break;
    case GLFW_KEY_F12:
      write_screenshot(false);
      break;
    case GLFW_KEY_P:
      write_screenshot(true);
      break;
    case GLFW_KEY_ESCAPE:
      drag_ ? put_back() : window_.close();
      break;
    default:
      break;
  }
}

Steps Walkthrough::steps() const {
  const auto axis = [&](int more, int less) {
    return static_cast<double>(window_.is_held(more)) - static_cast<double>(window_.is_held(less));
  };
  return {axis(GLFW_KEY_W, GLFW_KEY_S),
          axis(GLFW_KEY_D, GLFW_KEY_A),
          axis(GLFW_KEY_E, GLFW_KEY_Q),
          axis(GLFW_KEY_RIGHT, GLFW_KEY_LEFT),
          axis(GLFW_KEY_UP, GLFW_KEY_DOWN),
          window_.is_held(GLFW_KEY_LEFT_SHIFT) || window_.is_held(GLFW_KEY_RIGHT_SHIFT)};
}

void Walkthrough::press_left(const Eigen::Vector2d& cursor) {
  window_stale_ = true;
  drag_.reset(), selection_.reset();
  cursor_ = cursor;
  if (size_.empty()) return;
  const auto hit = pick(scene_, screen(), cursor, marker_radius * window_.text_scale(), box_);
  if (!hit) return;
  selection_ = Selection{hit->is_light, hit->index};
  if (hit->is_light) {
    drag_ = Drag{hit->at, hit->at, Pose::Identity(), scene_.lights()[hit->index], cursor};
    if (light_ != hit->index) picture_stale_ = marks_stale_ = true;
    light_ = hit->index;
  } else if (is_draggable(scene_, hit->index, box_, walker_.camera().eye)) {
    drag_ = Drag{hit->at, hit->at, scene_.objects()[hit->index].pose, {}, cursor};
  }
}

void Walkthrough::move_cursor(const Eigen::Vector2d& cursor) {
  if (looking_) {
    // a little more than the picture follows the cursor
    const double turn = 1.5 * walker_.camera().fov / std::max(size_.height, 1);
    walker_.turn(turn * (cursor.x() - looking_->x()), turn * (looking_->y() - cursor.y()));
    looking_ = cursor;
    picture_stale_ = true;
    return;
  }
  cursor_ = cursor;
  if (!drag_) return;
  if ((cursor - drag_->pressed).norm() > click) drag_->moved = true;
  if (drag_->moved) follow_cursor();
}

void Walkthrough::follow_cursor() {
  if (size_.empty()) return;
  const bool upright =
      window_.is_held(GLFW_KEY_LEFT_SHIFT) || window_.is_held(GLFW_KEY_RIGHT_SHIFT);
  // not out to the horizon
  const double reach = 2 * box_.diagonal().norm() + (drag_->held - walker_.camera().eye).norm();
  drag_->held = dragged(drag_->held, screen().ray(cursor_), walker_.camera(), upright, reach);
  if (selection_->is_light) {
    const Light to = moved_to(drag_->light, drag_->held, box_);
    if (to.kind == Light::Kind::point || to.direction.norm() > 0)
      arrangement_.set_light(selection_->index, to);
  } else {
    arrangement_.set_pose(selection_->index,
                          Eigen::Translation3d(drag_->held - drag_->grabbed) * drag_->pose);
  }
}

void Walkthrough::put_back() {
  if (selection_->is_light) arrangement_.set_light(selection_->index, drag_->light);
  else arrangement_.set_pose(selection_->index, drag_->pose);
  drag_.reset();
}

void Walkthrough::remove_selected() {
  if (!selection_) return;
  message_ =
      name_of(scene_, selection_->is_light, selection_->index) + " is gone: U brings it back";
  arrangement_.remove(selection_->is_light, selection_->index);
  drag_.reset(), selection_.reset();
}

void Walkthrough::bring_back() {
  const std::string name = arrangement_.bring_back();
  message_ = name.empty() ? "nothing has been removed" : name + " is back";
}

void Walkthrough::set_technique(const std::string& name) {
  if (name == technique_name_) return;
  other_.reset();
  if (name != "fragments") other_ = render::make_technique(name, scene_, model_);
  technique_name_ = name;
  if (wind_ && !technique().bends()) toggle_wind();
  updates_ = {}, draws_ = {};
  known_ = 0;
  picture_stale_ = true;
}

void Walkthrough::toggle_wind() {
  picture_stale_ = true;
  if (wind_) {
    wind_.reset();
    model_.set_wind({});
    message_ = "the wind has dropped";
  } else if (technique().bends()) {
    wind_ = 0;
    message_ = "a wind blows";
  } else {
    message_ =
        "no wind: shadows of " + technique_name_ + " do not follow what the vertex shader bends";
  }
}

// It carries what stands highest by up to a seventh of the scene's height, back and forth in two
// directions that never agree.
void Walkthrough::let_blow(double seconds) {
  *wind_ += seconds;
  const double height = box_.sizes().z();
  if (!(height > 0)) return;
  const Vec3 sway(0.1 * std::sin(1.7 * *wind_) + 0.03 * std::sin(5.3 * *wind_),
                  0.06 * std::sin(1.1 * *wind_), 0);
  model_.set_wind({(sway / height).cast<float>(), static_cast<float>(box_.min().z())});
  picture_stale_ = true;
}

// Brings everything that is drawn up to date with the scene.
void Walkthrough::follow_scene() {
  model_.scene_changed(scene_);
  const auto timed = [](render::Technique& technique, Times& times) {
    const Clock::time_point start = Clock::now();
    technique.update();
    glFinish();
    times.add(seconds_since(start));
  };
  if (other_) timed(*other_, updates_);
  timed(*fragments_, other_ ? engine_updates_ : updates_);
  // the scene has changed, not the technique alone
  if (std::exchange(engine_known_, SceneAccess::revision(scene_)) !=
      SceneAccess::revision(scene_)) {
    for (const auto& [name, value] : fragments_->figures()) {
      if (name == "fragments_gone") gone_ = value;
      if (name == "fragments_new") added_ = value;
    }
  }
  known_ = SceneAccess::revision(scene_);
  picture_stale_ = marks_stale_ = true;
}

// The light whose fragments are shown: the one picked last, or the first that is there; none when
// all are gone.
std::uint32_t Walkthrough::shown_light() const {
  if (scene_.light_id(light_).index != invalid_index) return light_;
  for (std::uint32_t k = 0; k < scene_.lights().size(); ++k)
    if (scene_.light_id(k).index != invalid_index) return k;
  return invalid_index;
}

void Walkthrough::draw_scene() {
  if (!target_) target_.emplace(size_.width, size_.height);
  target_->bind();
  const render::Frame frame = model_.frame(walker_.camera(), size_.width, size_.height);
  const Clock::time_point start = Clock::now();
  render::draw(frame, scene_, model_, technique());
  glFinish();
  draws_.add(seconds_since(start));
  const std::uint32_t light = shown_light();
  if ((outlines_ || cells_) && light != invalid_index) {
    if (marks_stale_) marks_.set(engine(), light, model_);
    marks_stale_ = false;
    if (cells_) marks_.draw_cells(frame);
    if (outlines_) marks_.draw_outlines(frame);
  }
  picture_stale_ = false;
  window_stale_ = true;
}

void Walkthrough::show() {
  target_->copy_to_window();
  glViewport(0, 0, size_.width, size_.height);
  overlay_.draw(size_, [&] { describe(); });
  window_.show_picture();
  window_stale_ = false;
  window_.set_title("shadowcut - " + settings_.scene_name + " - " + technique_name_);
}

// The first free number; through another file, so that nobody finds half of one.
void Walkthrough::write_screenshot(bool with_overlay) {
  if (size_.empty()) return;
  if (SceneAccess::revision(scene_) != known_) follow_scene();
  draw_scene();
  if (with_overlay) {
    target_->bind();
    overlay_.draw(size_, [&] { describe(); });
    picture_stale_ = true;
  }
  char name[64];
  for (int number = 1;; ++number) {
    std::snprintf(name, sizeof name, "shadowcut-%03d.png", number);
    if (!std::filesystem::exists(name)) break;
  }
  try {
    const std::string part = std::string(name) + ".part";
    render::write_png(part, target_->read());
    std::filesystem::rename(part, name);
    message_ = std::string("written: ") + name;
  } catch (const std::exception& error) {
    message_ = error.what();  // a full disk is no reason to end the walk
  }
}

void Walkthrough::describe() {
  draw_box_of_selected();
  draw_markers();
  const ImVec2 corner = describe_figures();
  if (keys_) describe_keys(corner);
}

constexpr ImGuiWindowFlags plain =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_AlwaysAutoResize |
    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;

// Returns the lower right corner.
ImVec2 Walkthrough::describe_figures() {
  ImGui::SetNextWindowPos(ImVec2(8, 8));
  ImGui::SetNextWindowBgAlpha(0.72f);
  ImGui::Begin("figures", nullptr, plain);
  ImGui::TextColored(ImVec4(1, 0.85f, 0.4f, 1), "%s", technique_name_.c_str());
  ImGui::SameLine();
  ImGui::Text("%s", settings_.scene_name.c_str());
  ImGui::Text("update %8.2f ms, median %8.2f", updates_.last(), updates_.median());
  if (other_)
    ImGui::Text("engine %8.2f ms, median %8.2f", engine_updates_.last(), engine_updates_.median());
  ImGui::Text("draw   %8.2f ms, median %8.2f", draws_.last(), draws_.median());
  ImGui::Text("fragments gone %.0f, new %.0f in the last update", gone_, added_);
  Stats sum;
  std::size_t lights = 0;
  for (std::uint32_t k = 0; k < scene_.lights().size(); ++k) {
    if (scene_.light_id(k).index == invalid_index) continue;
    const Stats& stats = engine().shadows(k).stats;
    sum.lit_fragments += stats.lit_fragments, sum.shadowed_fragments += stats.shadowed_fragments;
    sum.nodes += stats.nodes, sum.marked_nodes += stats.marked_nodes, sum.cells += stats.cells,
        sum.facing_faces += stats.facing_faces;
    ++lights;
  }
  const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  ImGui::Text("fragments %llu lit, %llu shadowed", number(sum.lit_fragments),
              number(sum.shadowed_fragments));
  ImGui::Text("tree nodes %llu (%llu marked), cells %llu", number(sum.nodes),
              number(sum.marked_nodes), number(sum.cells));
  ImGui::Text("facing faces %llu, lights %zu", number(sum.facing_faces), lights);
  const render::Camera& camera = walker_.camera();
  const Vec3 ahead = camera.target;
  ImGui::Text("eye %.2f, %.2f, %.2f to %.2f, %.2f, %.2f", camera.eye.x(), camera.eye.y(),
              camera.eye.z(), ahead.x(), ahead.y(), ahead.z());
  if (outlines_ || cells_) {
    const std::uint32_t light = shown_light();
    ImGui::Text("%s of %s",
                outlines_ && cells_ ? "outlines and cells"
                : outlines_         ? "outlines"
                                    : "cells",
                light == invalid_index ? "no light" : name_of(scene_, true, light).c_str());
  }
  describe_selection();
  if (!settings_.note.empty())
    ImGui::TextColored(ImVec4(1, 0.7f, 0.5f, 1), "%s", settings_.note.c_str());
  if (!message_.empty()) ImGui::TextColored(ImVec4(0.7f, 1, 0.7f, 1), "%s", message_.c_str());
  if (!keys_) ImGui::TextDisabled("H: keys");
  const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  ImGui::End();
  return {at.x + size.x, at.y + size.y};
}

void Walkthrough::describe_selection() {
  if (!selection_) return;
  const std::string name = name_of(scene_, selection_->is_light, selection_->index);
  if (selection_->is_light) {
    const Light& light = scene_.lights()[selection_->index];
    const bool point = light.kind == Light::Kind::point;
    const Vec3& v = point ? light.position : light.direction;
    ImGui::Text("selected: %s, %s %.3f, %.3f, %.3f", name.c_str(), point ? "at" : "direction",
                v.x(), v.y(), v.z());
    return;
  }
  const Object& object = scene_.objects()[selection_->index];
  const char* fast = is_shell(scene_, selection_->index, box_)
                         ? ": holds fast, it is the room or a part of it"
                     : !is_draggable(scene_, selection_->index, box_, walker_.camera().eye)
                         ? ": holds fast while you stand in it"
                         : "";
  ImGui::Text("selected: %s, %s, %u faces%s", name.c_str(),
              object.sides == Sides::closed ? "solid" : "open", object.face_count, fast);
}

// Beside the figures, whose lower right corner is given, or where there is no room for that below
// them.
void Walkthrough::describe_keys(const ImVec2& below_figures) {
  constexpr const char* keys[][2] = {{"W A S D", "walk"},
                                     {"Q E", "down, up"},
                                     {"shift", "faster; while dragging: upright"},
                                     {"right button", "look"},
                                     {"arrows", "look"},
                                     {"Home", "where you began"},
                                     {"left button", "pick; drag objects and lights"},
                                     {"Delete", "remove"},
                                     {"Insert or U", "bring back"},
                                     {"R", "put everything back"},
                                     {"1 to 7", "technique"},
                                     {"O", "fragment outlines"},
                                     {"C", "the tree's cells"},
                                     {"V", "wind"},
                                     {"F12", "picture as PNG"},
                                     {"P", "the same with this"},
                                     {"H", "hide this"},
                                     {"Esc", "end; a drag: undo it"}};
  const float right = static_cast<float>(size_.width) - 8;
  const bool beside = right - below_figures.x > 330 * window_.text_scale();
  ImGui::SetNextWindowPos(beside ? ImVec2(right, 8) : ImVec2(8, below_figures.y + 4),
                          ImGuiCond_Always, ImVec2(beside ? 1.f : 0.f, 0));
  ImGui::SetNextWindowBgAlpha(0.6f);
  ImGui::Begin("keys", nullptr, plain);
  for (const auto& [key, what] : keys) ImGui::Text("%-13s%s", key, what);
  ImGui::End();
}

ImVec2 on_screen(const Eigen::Vector2d& pixel) {
  return {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
}

// Lights, on top of everything; hollow where something hides them.
void Walkthrough::draw_markers() {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const Screen view = screen();
  const float radius = static_cast<float>(marker_radius) * window_.text_scale();
  for (std::uint32_t k = 0; k < scene_.lights().size(); ++k) {
    if (scene_.light_id(k).index == invalid_index) continue;
    const Vec3 at = marker_of(scene_.lights()[k], box_);
    const auto pixel = view.pixel(at);
    if (!pixel) continue;
    const auto hidden_by = pick_facet(scene_, view, *pixel);
    const Vec3& eye = view.camera.eye;
    const bool hidden = hidden_by && (hidden_by->at - eye).norm() < (1 - 1e-6) * (at - eye).norm();
    const bool selected = selection_ && selection_->is_light && selection_->index == k;
    const ImU32 yellow = selected ? IM_COL32(255, 255, 0, 255) : IM_COL32(255, 214, 64, 255);
    const ImVec2 middle = on_screen(*pixel);
    if (!hidden) list.AddCircleFilled(middle, 0.6f * radius, yellow);
    list.AddCircle(middle, 0.6f * radius, IM_COL32(60, 40, 0, 255), 0, 1.5f);
    list.AddCircle(middle, radius, yellow, 0, selected ? 3.f : 1.5f);
  }
}

// The selected object's box, in its own frame.
void Walkthrough::draw_box_of_selected() {
  if (!selection_ || selection_->is_light) return;
  const Object& object = scene_.objects()[selection_->index];
  const Pose local = object.pose.inverse();
  Eigen::AlignedBox3d box;
  for (std::uint32_t v = object.first_vertex; v < object.first_vertex + object.vertex_count; ++v)
    box.extend(local * scene_.vertices()[v]);
  const auto corner = [&](unsigned k) -> Vec3 {
    return object.pose * Vec3(k & 1 ? box.max().x() : box.min().x(),
                              k & 2 ? box.max().y() : box.min().y(),
                              k & 4 ? box.max().z() : box.min().z());
  };
  const Screen view = screen();
  for (unsigned k = 0; k < 8; ++k) {
    for (const unsigned axis : {1u, 2u, 4u}) {
      if (k & axis) continue;
      const auto line = view.line(corner(k), corner(k | axis));
      if (line)
        ImGui::GetBackgroundDrawList()->AddLine(on_screen(line->first), on_screen(line->second),
                                                IM_COL32(255, 255, 0, 255), 1.5f);
    }
  }
}

}  // namespace

Light light_for(const Scene& scene) {
  const Eigen::AlignedBox3d box = box_of(scene);
  Light light = Light::point(box.center());
  light.position.z() = is_room(scene) ? box.max().z() - 0.08 * box.sizes().z()
                                      : box.max().z() + 0.3 * box.diagonal().norm();
  light.name = "lamp";
  return light;
}

void walk_through(Scene scene, const Settings& settings) { Walkthrough(scene, settings).run(); }

}  // namespace shadowcut::view
