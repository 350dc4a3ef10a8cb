// See window.hpp.
#include "window.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <shadowcut/scene.hpp>

// Xlib comes last: it defines words such as Status as macros.
#include <X11/Xlib.h>

namespace shadowcut::view {
namespace {

std::string words;  // GLFW's, of its last error

const char* const elsewhere = "; 'shadowcut render' needs no display";

bool is_set(const char* variable) {
  const char* value = std::getenv(variable);
  return value != nullptr && *value != '\0';
}

[[noreturn]] void no_display() {
  if (!is_set("DISPLAY") && !is_set("WAYLAND_DISPLAY"))
    throw Error(
        std::string("view: there is no display: neither DISPLAY nor WAYLAND_DISPLAY is set") +
        elsewhere);
  throw Error("view: the display cannot be used: " + words + elsewhere);
}

// Xlib ends a program whose display goes away or refuses a request, with its own words and status.
// Nothing of the display may be used then, so there is no way back but this.
[[noreturn]] void end(const std::string& what) {
  const std::string line = "shadowcut: view: " + what + "\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, line.data(), line.size());
  _exit(2);
}

int display_lost(Display*) { end("the display is gone"); }

int request_refused(Display* display, XErrorEvent* error) {
  char text[200] = "";
  XGetErrorText(display, error->error_code, text, sizeof text);
  end(std::string("the display refuses a request: ") + text);
}

}  // namespace

Window::Library::Library() {
  glfwSetErrorCallback([](int, const char* text) { words = text; });
  XSetIOErrorHandler(display_lost);
  XSetErrorHandler(request_refused);
  if (!glfwInit()) no_display();
}

Window::Library::~Library() { glfwTerminate(); }

Window::Window(Size size, const std::string& title) {
  constexpr int most = 16384;  // more than any screen, and X takes no picture much larger
  if (size.width > most || size.height > most)
    throw Error("view: a window of " + std::to_string(size.width) + "x" +
                std::to_string(size.height) + " pixels is too large: " + std::to_string(most) +
                " a side at most");
  glfwWindowHint(GLFW_CLIENT_API, GLFW_OPENGL_API);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  // where the driver knows how
  glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
  // the picture is drawn beside the window, and copied
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  window_ = glfwCreateWindow(size.width, size.height, title.c_str(), nullptr, nullptr);
  if (window_ == nullptr)
    throw Error("view: this display's driver gives no OpenGL 3.3 core context: " + words +
                elsewhere);
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  tells_resets_arb_ = epoxy_has_gl_extension("GL_ARB_robustness");
  tells_resets_khr_ = epoxy_has_gl_extension("GL_KHR_robustness");
  glfwSetWindowUserPointer(window_, this);
  static constexpr auto self = [](GLFWwindow* window) -> Window& {
    return *static_cast<Window*>(glfwGetWindowUserPointer(window));
  };
  glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int) {
    if (action != GLFW_REPEAT)
      self(window).happened(action == GLFW_PRESS ? Event::Kind::key : Event::Kind::changed, key);
  });
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int) {
    const bool down = action == GLFW_PRESS;
    if (button == GLFW_MOUSE_BUTTON_LEFT)
      self(window).happened(down ? Event::Kind::left_down : Event::Kind::left_up);
    if (button == GLFW_MOUSE_BUTTON_RIGHT)
      self(window).happened(down ? Event::Kind::right_down : Event::Kind::right_up);
  });
  glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
    self(window).cursor_ = {x, y};
    self(window).happened(Event::Kind::cursor);
  });
  glfwSetFramebufferSizeCallback(
      window_, [](GLFWwindow* window, int, int) { self(window).happened(Event::Kind::changed); });
  glfwSetWindowRefreshCallback(
      window_, [](GLFWwindow* window) { self(window).happened(Event::Kind::changed); });
  glfwSetWindowIconifyCallback(
      window_, [](GLFWwindow* window, int) { self(window).happened(Event::Kind::changed); });
}

Window::~Window() { glfwDestroyWindow(window_); }

void Window::happened(Event::Kind kind, int key) {
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  const Size size = picture();
  Event event{kind, key};
  if (width > 0 && height > 0)
    event.cursor = {cursor_.x() * size.width / width, cursor_.y() * size.height / height};
  events_.push_back(event);
}

std::vector<Event> Window::events(bool wait) {
  wait ? glfwWaitEvents() : glfwPollEvents();
  return std::exchange(events_, {});
}

bool Window::is_closed() const { return glfwWindowShouldClose(window_) != 0; }
void Window::close() { glfwSetWindowShouldClose(window_, GLFW_TRUE); }
bool Window::is_held(int key) const { return glfwGetKey(window_, key) == GLFW_PRESS; }
void Window::set_title(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }
void Window::capture_cursor(bool capture) {
  glfwSetInputMode(window_, GLFW_CURSOR, capture ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
}

Size Window::picture() const {
  Size size;
  if (!glfwGetWindowAttrib(window_, GLFW_ICONIFIED))
    glfwGetFramebufferSize(window_, &size.width, &size.height);
  return size;
}

float Window::text_scale() const {
  float x = 1, y = 1;
  glfwGetWindowContentScale(window_, &x, &y);
  return std::max(x, 1.f);
}

void Window::show_picture() {
  const bool lost = (tells_resets_arb_ && glGetGraphicsResetStatusARB() != GL_NO_ERROR) ||
                    (tells_resets_khr_ && glGetGraphicsResetStatusKHR() != GL_NO_ERROR);
  if (lost) throw Error("view: the OpenGL context was lost: its driver was reset");
  render::require_no_error("showing the picture");
  glfwSwapBuffers(window_);
}

Overlay::Overlay(float text_scale) {
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // leaves no file behind
  ImFontConfig font;
  font.SizePixels = std::round(13 * text_scale);
  io.Fonts->AddFontDefault(&font);
  ImGui::StyleColorsDark();
  ImGui::GetStyle().ScaleAllSizes(text_scale);
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

Overlay::~Overlay() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext();
}

void Overlay::draw(Size picture, const std::function<void()>& describe) {
  ImGui::GetIO().DisplaySize =
      ImVec2(static_cast<float>(picture.width), static_cast<float>(picture.height));
  for (int pass = 0; pass < 2; ++pass) {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui::NewFrame();
    describe();
    ImGui::Render();
  }
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace shadowcut::view
