// See gl.hpp.
#include "gl.hpp"

#include <shadowcut/scene.hpp>
#include <vector>

namespace shadowcut::render {
namespace {

template <class Owner>
Owner generated(void (*generate)(GLsizei, GLuint*)) {
  GLuint name = 0;
  generate(1, &name);
  return Owner(name);
}

std::string without_line_ends(std::string text) {
  for (char& c : text)
    if (c == '\n') c = ' ';
  return text;
}

void attach(GLuint program, GLenum kind, const std::string& text) {
  const GLuint shader = glCreateShader(kind);
  const std::string whole = "#version 330 core\n" + text;
  const char* source = whole.c_str();
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  glAttachShader(program, shader);
  glDeleteShader(shader);  // lives as long as the program
  GLint compiled = 0, length = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled) return;
  glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length) + 1, '\0');
  glGetShaderInfoLog(shader, length, nullptr, log.data());
  throw Error("OpenGL does not compile a shader: " + without_line_ends(log.c_str()));
}

}  // namespace

Buffer make_buffer() { return generated<Buffer>(glGenBuffers); }
VertexArray make_vertex_array() { return generated<VertexArray>(glGenVertexArrays); }
Texture make_texture() { return generated<Texture>(glGenTextures); }
Framebuffer make_framebuffer() { return generated<Framebuffer>(glGenFramebuffers); }
Renderbuffer make_renderbuffer() { return generated<Renderbuffer>(glGenRenderbuffers); }

Program::Program(const std::string& vertex, const std::string& fragment)
    : program_(glCreateProgram()) {
  attach(program_.get(), GL_VERTEX_SHADER, vertex);
  attach(program_.get(), GL_FRAGMENT_SHADER, fragment);
  glLinkProgram(program_.get());
  GLint linked = 0;
  glGetProgramiv(program_.get(), GL_LINK_STATUS, &linked);
  if (linked) return;
  GLint length = 0;
  glGetProgramiv(program_.get(), GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length) + 1, '\0');
  glGetProgramInfoLog(program_.get(), length, nullptr, log.data());
  throw Error("OpenGL does not link a program: " + without_line_ends(log.c_str()));
}

void require_no_error(const char* what) {
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  const char* name = error == GL_OUT_OF_MEMORY  ? "out of memory"
                     : error == GL_CONTEXT_LOST ? "the context was lost"
                                                : "an invalid operation";
  throw Error(std::string("OpenGL: ") + what + ": " + name + " (error " + std::to_string(error) +
              ")");
}

}  // namespace shadowcut::render
