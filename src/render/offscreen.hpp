// OpenGL without a window: an EGL context that needs neither display nor GPU (Mesa's llvmpipe
// serves where there is none), and a target to draw into.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "gl.hpp"

namespace shadowcut::render {

// An OpenGL 3.3 core context, current on this thread from its making to its end. Throws Error where
// there is no driver that gives one.
class OffscreenContext {
 public:
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

 private:
  void* display_ = nullptr;
  void* context_ = nullptr;
};

// Rows from the top; red, green, blue, alpha.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;
  const std::uint8_t* at(int x, int y) const {
    return rgba.data() + 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                              static_cast<std::size_t>(x));
  }
};

// Throws Error when the file cannot be written, and leaves none behind.
void write_png(const std::string& path, const Picture& picture);

// A framebuffer with colour, 24 bits of depth and 8 of stencil.
class Target {
 public:
  // Throws Error when a side is not positive, or larger than the driver can draw.
  Target(int width, int height);
  void bind() const;
  void copy_to_window() const;  // whose framebuffer must be as large
  Picture read() const;
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  int width_, height_;
  Framebuffer framebuffer_;
  Renderbuffer colour_, depth_stencil_;
};

}  // namespace shadowcut::render
