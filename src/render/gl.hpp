// OpenGL objects that end with their owners. All need the context that they were made in to be
// current, from first to last.
#pragma once

#include <epoxy/gl.h>

#include <Eigen/Core>
#include <span>
#include <string>
#include <utility>

namespace shadowcut::render {

using Vec3f = Eigen::Vector3f;
using Mat4f = Eigen::Matrix4f;

// One name of OpenGL's, freed by Free.
template <void (*Free)(GLuint)>
class Name {
 public:
  Name() = default;
  explicit Name(GLuint name) : name_(name) {}
  Name(Name&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  Name& operator=(Name&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~Name() {
    if (name_ != 0) Free(name_);
  }
  GLuint get() const { return name_; }

 private:
  GLuint name_ = 0;
};

inline void free_buffer(GLuint n) { glDeleteBuffers(1, &n); }
inline void free_vertex_array(GLuint n) { glDeleteVertexArrays(1, &n); }
inline void free_texture(GLuint n) { glDeleteTextures(1, &n); }
inline void free_framebuffer(GLuint n) { glDeleteFramebuffers(1, &n); }
inline void free_renderbuffer(GLuint n) { glDeleteRenderbuffers(1, &n); }
inline void free_program(GLuint n) { glDeleteProgram(n); }

using Buffer = Name<free_buffer>;
using VertexArray = Name<free_vertex_array>;
using Texture = Name<free_texture>;
using Framebuffer = Name<free_framebuffer>;
using Renderbuffer = Name<free_renderbuffer>;

Buffer make_buffer();
VertexArray make_vertex_array();
Texture make_texture();
Framebuffer make_framebuffer();
Renderbuffer make_renderbuffer();

// A vertex and a fragment shader, linked. Uniforms are set by name while the program is in use.
class Program {
 public:
  Program() = default;
  // GLSL 3.30 without the version line. Throws Error with the compiler's words.
  Program(const std::string& vertex, const std::string& fragment);
  void use() const { glUseProgram(program_.get()); }
  void set(const char* name, float value) const { glUniform1f(at(name), value); }
  void set(const char* name, int value) const { glUniform1i(at(name), value); }
  void set(const char* name, const Vec3f& v) const { glUniform3fv(at(name), 1, v.data()); }
  void set(const char* name, const Eigen::Vector4f& v) const {
    glUniform4fv(at(name), 1, v.data());
  }
  void set(const char* name, const Mat4f& m) const {
    glUniformMatrix4fv(at(name), 1, GL_FALSE, m.data());
  }

 private:
  GLint at(const char* name) const { return glGetUniformLocation(program_.get(), name); }
  Name<free_program> program_;
};

// Throws Error, naming what was done, when OpenGL has reported an error or the context is lost.
void require_no_error(const char* what);

}  // namespace shadowcut::render
