// A window with an OpenGL 3.3 core context, made by GLFW, and text over its picture, drawn by Dear
// ImGui. Of GLFW nothing but the names of keys is known beyond this.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gl.hpp"

struct GLFWwindow;

namespace shadowcut::view {

struct Event {
  enum class Kind { key, left_down, left_up, right_down, right_up, cursor, changed } kind;
  int key = 0;                                       // GLFW's
  Eigen::Vector2d cursor = Eigen::Vector2d::Zero();  // in pixels of the picture
};

struct Size {
  int width = 0, height = 0;
  bool empty() const { return width <= 0 || height <= 0; }
  friend bool operator==(const Size&, const Size&) = default;
};

// One at a time. Its context is current from its making to its end.
class Window {
 public:
  // Throws Error where there is no display, or no driver for it that gives such a context.
  Window(Size size, const std::string& title);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  // What has happened since the last call; with `wait`, not before something has.
  std::vector<Event> events(bool wait);
  bool is_closed() const;
  void close();
  bool is_held(int key) const;
  void set_title(const std::string& title);
  // Hides the cursor and lets it go on without end, for looking around.
  void capture_cursor(bool capture);
  // Of the picture, in pixels; empty where the window is minimised.
  Size picture() const;
  // How large text is to be, in pixels of the picture, for one at the usual density.
  float text_scale() const;
  // Throws Error when the context is lost.
  void show_picture();

 private:
  struct Library {  // GLFW itself
    Library();
    ~Library();
  };
  void happened(Event::Kind kind, int key = 0);

  Library library_;
  GLFWwindow* window_ = nullptr;
  std::vector<Event> events_;
  // as events have it: where it is now may be beyond those still to come
  Eigen::Vector2d cursor_ = Eigen::Vector2d::Zero();
  bool tells_resets_arb_ = false, tells_resets_khr_ = false;
};

// Text and marks over the picture. Takes no input.
class Overlay {
 public:
  explicit Overlay(float text_scale);
  ~Overlay();
  Overlay(const Overlay&) = delete;
  Overlay& operator=(const Overlay&) = delete;

  // `describe` calls Dear ImGui, and is called twice: the first time finds how large everything
  // becomes.
  void draw(Size picture, const std::function<void()>& describe);
};

}  // namespace shadowcut::view
