// Reads a scene from memory with the installed library.
#include <shadowcut/io.hpp>

int main() {
  const auto scene =
      shadowcut::io::read_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "triangle.obj");
  return scene.faces().size() == 1 && scene.faces()[0].area == 0.5 ? 0 : 1;
}
