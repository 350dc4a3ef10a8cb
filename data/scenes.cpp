// Generated scenes; see scenes.hpp. Furniture is modelled with its back at y = 0 and its feet at z
// = 0, then posed against a wall.
#include "scenes.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <string_view>

namespace shadowcut::scenes {

double to_grid(double x) { return std::nearbyint(x * 0x1p20) * 0x1p-20; }

std::uint64_t Random::next() {
  std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

double Random::unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }

double Random::in(double lo, double hi) { return to_grid(lo + (hi - lo) * unit()); }

Vec3 Random::in_cube(double lo, double hi) {
  // One statement each, because the order of evaluation of arguments is unspecified.
  const double x = in(lo, hi);
  const double y = in(lo, hi);
  const double z = in(lo, hi);
  return {x, y, z};
}

Vec3 Random::in_ball(double radius) {
  while (true) {
    const Vec3 p = in_cube(-radius, radius);
    if (p.squaredNorm() <= radius * radius) return p;
  }
}

Scene build(const SceneData& data) {
  Scene scene;
  for (const auto& [mesh, settings] : data.objects) scene.add(mesh, settings);
  scene.add(data.light);
  return scene;
}

std::size_t polygon_count(const SceneData& data) {
  std::size_t n = 0;
  for (const auto& object : data.objects) n += object.first.face_count();
  return n;
}

Mesh box(const Vec3& lo, const Vec3& hi) {
  Mesh mesh;
  for (int k = 0; k < 8; ++k)
    mesh.vertices.emplace_back(k & 1 ? hi.x() : lo.x(), k & 2 ? hi.y() : lo.y(),
                               k & 4 ? hi.z() : lo.z());
  mesh.add_face({0, 2, 3, 1});
  mesh.add_face({4, 5, 7, 6});
  mesh.add_face({0, 1, 5, 4});
  mesh.add_face({2, 6, 7, 3});
  mesh.add_face({0, 4, 6, 2});
  mesh.add_face({1, 3, 7, 5});
  return mesh;
}

Mesh prism(const std::vector<Vec3>& base, const Vec3& along) {
  Mesh mesh;
  const auto n = static_cast<std::uint32_t>(base.size());
  std::vector<std::uint32_t> bottom, top;
  mesh.vertices = base;
  for (std::uint32_t i = 0; i < n; ++i) {
    mesh.vertices.push_back(base[i] + along);
    bottom.push_back(i);
    top.push_back(2 * n - 1 - i);
  }
  mesh.add_face(bottom);
  mesh.add_face(top);
  for (std::uint32_t i = 0; i < n; ++i) mesh.add_face({(i + 1) % n, i, n + i, n + (i + 1) % n});
  return mesh;
}

Mesh rectangle(const Vec3& corner, const Vec3& u, const Vec3& v) {
  Mesh mesh;
  mesh.vertices = {corner, corner + u, corner + u + v, corner + v};
  mesh.add_face({0, 1, 2, 3});
  return mesh;
}

Mesh uv_sphere(const Vec3& centre, double radius, std::uint32_t segments, std::uint32_t rings) {
  Mesh mesh;
  const auto point = [&](double polar, double turn) -> Vec3 {
    const Vec3 unit(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn),
                    std::cos(polar));
    return centre + unit.unaryExpr([&](double x) { return to_grid(radius * x); });
  };
  mesh.vertices = {point(0, 0), point(std::numbers::pi, 0)};
  for (std::uint32_t r = 1; r < rings; ++r)
    for (std::uint32_t s = 0; s < segments; ++s)
      mesh.vertices.push_back(
          point(std::numbers::pi * r / rings, 2 * std::numbers::pi * s / segments));
  const auto at = [&](std::uint32_t r, std::uint32_t s) {
    return 2 + (r - 1) * segments + s % segments;
  };
  for (std::uint32_t s = 0; s < segments; ++s) {
    mesh.add_face({0, at(1, s), at(1, s + 1)});
    mesh.add_face({1, at(rings - 1, s + 1), at(rings - 1, s)});
    for (std::uint32_t r = 1; r + 1 < rings; ++r) {
      mesh.add_face({at(r, s), at(r + 1, s), at(r + 1, s + 1)});
      mesh.add_face({at(r, s), at(r + 1, s + 1), at(r, s + 1)});
    }
  }
  return mesh;
}

void append(Mesh& mesh, const Mesh& other) {
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (std::size_t f = 0; f < other.face_count(); ++f) {
    for (std::size_t k = 0; k < other.loop_count(f); ++k) {
      std::vector<std::uint32_t> loop;
      for (const std::uint32_t v : other.loop(f, k)) loop.push_back(base + v);
      if (k == 0) mesh.add_face(loop);
      else mesh.add_hole(loop);
    }
  }
}

namespace {

constexpr double kDeskWidth = 1.6, kDeskDepth = 0.8, kDeskHeight = 0.73;
constexpr double kCaseWidth = 0.9, kCaseDepth = 0.32, kCaseHeight = 1.9, kBoard = 0.025;

void add(SceneData& data, Mesh mesh, std::string name, const Pose& pose = Pose::Identity()) {
  ObjectSettings settings;
  settings.name = std::move(name);
  settings.pose = pose;
  data.objects.emplace_back(std::move(mesh), std::move(settings));
}

std::string numbered(const char* what, std::size_t k) {
  return std::string(what) + "." + std::to_string(k);
}

// A turn by (c, s) about z, then a shift. Quarter turns are exact.
Pose placed(double c, double s, double x, double y) {
  Pose pose = Pose::Identity();
  pose.linear() << c, -s, 0, s, c, 0, 0, 0, 1;
  pose.translation() = Vec3(x, y, 0);
  return pose;
}

// Furniture against the walls of a room of w by d: its back touches the wall, its left end is
// `along` from the wall's beginning.
struct Walls {
  double w, d;
  Pose south(double along) const { return placed(1, 0, along, 0); }
  Pose east(double along) const { return placed(0, 1, w, along); }
  Pose north(double along) const { return placed(-1, 0, w - along, d); }
  Pose west(double along) const { return placed(0, -1, 0, d - along); }
};

// 30 faces: a top on four legs that are flush with its corners.
Mesh desk() {
  constexpr double leg = 0.06, under = kDeskHeight - 0.03;
  Mesh mesh = box({0, 0, under}, {kDeskWidth, kDeskDepth, kDeskHeight});
  for (const double x : {0.0, kDeskWidth - leg})
    for (const double y : {0.0, kDeskDepth - leg})
      append(mesh, box({x, y, 0}, {x + leg, y + leg, under}));
  return mesh;
}

// 23 faces: base unit, stand and monitor upon it, and a keyboard that is a wedge. The screen is an
// object of its own.
Mesh computer(double x) {
  constexpr double z = kDeskHeight, stand = z + 0.12, screen = stand + 0.06;
  Mesh mesh = box({x, 0.1, z}, {x + 0.42, 0.5, stand});
  append(mesh, box({x + 0.13, 0.2, stand}, {x + 0.29, 0.36, screen}));
  append(mesh, box({x + 0.02, 0.12, screen}, {x + 0.4, 0.46, screen + 0.31}));
  append(mesh, prism({{x, 0.54, z}, {x, 0.54, z + 0.04}, {x, 0.72, z}}, {0.42, 0, 0}));
  return mesh;
}

// One face, in the plane of the monitor's front.
Mesh screen(double x) {
  constexpr double z = kDeskHeight + 0.18;
  return rectangle({x + 0.37, 0.46, z + 0.03}, {-0.32, 0, 0}, {0, 0, 0.25});
}

// 36 faces: two sides, a back and three boards. The back ends short of top and bottom, so that no
// two boards share a whole edge.
Mesh bookcase() {
  constexpr double in = kCaseWidth - kBoard;
  Mesh mesh = box({0, 0, 0}, {kBoard, kCaseDepth, kCaseHeight});
  append(mesh, box({in, 0, 0}, {kCaseWidth, kCaseDepth, kCaseHeight}));
  append(mesh, box({kBoard, 0, 0.04}, {in, kBoard, kCaseHeight - 0.01}));
  for (const double z : {0.1, 0.95, kCaseHeight - kBoard})
    append(mesh, box({kBoard, kBoard, z}, {in, kCaseDepth, z + kBoard}));
  return mesh;
}

// A book on the middle board, its back to the case's back.
Mesh book(double x, double thick, double depth, double high) {
  constexpr double board = 0.95 + kBoard;
  return box({x, kBoard, board}, {x + thick, kBoard + depth, board + high});
}

// 36 faces. Legs flush with the seat; the back stands on it.
Mesh chair() {
  constexpr double leg = 0.04, side = 0.45, seat = 0.46;
  Mesh mesh = box({0, 0, seat - 0.04}, {side, side, seat});
  append(mesh, box({0.02, 0, seat}, {side - 0.02, 0.04, 0.95}));
  for (const double x : {0.0, side - leg})
    for (const double y : {0.0, side - leg})
      append(mesh, box({x, y, 0}, {x + leg, y + leg, seat - 0.04}));
  return mesh;
}

// Counts the placed objects, to give each a name.
struct Furnisher {
  SceneData& data;
  std::size_t desks = 0, computers = 0, bookcases = 0, books = 0, chairs = 0;

  void add_desk(const Pose& pose, int how_many_computers) {
    add(data, desk(), numbered("desk", ++desks), pose);
    for (int k = 0; k < how_many_computers; ++k) {
      const double x = 0.2 + 0.76 * k;
      add(data, computer(x), numbered("computer", ++computers), pose);
      add(data, screen(x), numbered("screen", computers), pose);
    }
  }

  void add_empty_bookcase(const Pose& pose) {
    add(data, bookcase(), numbered("bookcase", ++bookcases), pose);
  }

  // At most three books, in contact with each other and with the case.
  void add_books(const Pose& pose, int how_many) {
    double x = kBoard + 0.07 * static_cast<double>(bookcases);
    for (const Vec3& b : {Vec3(0.05, 0.2, 0.28), Vec3(0.035, 0.17, 0.24), Vec3(0.04, 0.18, 0.26)}) {
      if (how_many-- <= 0) return;
      add(data, book(x, b.x(), b.y(), b.z()), numbered("book", ++books), pose);
      x += b.x();
    }
  }

  void add_bookcase(const Pose& pose) {
    add_empty_bookcase(pose);
    add_books(pose, 2);
  }

  void add_chair(const Pose& pose) { add(data, chair(), numbered("chair", ++chairs), pose); }
};

// The six faces of a room, facing inward, with a doorway in the northern wall.
Mesh shell(double w, double d, double h) {
  Mesh mesh;
  for (int k = 0; k < 8; ++k)
    mesh.vertices.emplace_back(k & 1 ? w : 0, k & 2 ? d : 0, k & 4 ? h : 0);
  constexpr double hinge = 0.4, lock = 1.3, lintel = 2.05;
  for (const Vec3& v :
       {Vec3(hinge, d, 0), Vec3(hinge, d, lintel), Vec3(lock, d, lintel), Vec3(lock, d, 0)})
    mesh.vertices.push_back(v);
  mesh.add_face({0, 1, 3, 2});
  mesh.add_face({4, 6, 7, 5});
  mesh.add_face({0, 4, 5, 1});
  mesh.add_face({2, 8, 9, 10, 11, 3, 7, 6});
  mesh.add_face({0, 2, 6, 4});
  mesh.add_face({1, 5, 7, 3});
  return mesh;
}

void add_poster(SceneData& data, const std::string& name, double y, double wide = 0.9) {
  add(data, rectangle({0, y, 1.2}, {0, wide, 0}, {0, 0, 0.65}), name);
}

}  // namespace

SceneData room(int level) {
  SceneData data;
  data.name = "room" + std::to_string(level);
  const bool big = level >= 4;
  const Walls walls{big ? 12.0 : 6.0, big ? 8.0 : 5.0};
  data.light = Light::point(big ? Vec3(5.3613, 3.7171, 2.43) : Vec3(2.61, 2.23, 2.41));
  data.light.name = "lamp";
  add(data, shell(walls.w, walls.d, 2.7), "room");
  add_poster(data, "poster", 2.1);
  Furnisher f{data};
  f.add_desk(walls.south(0.5), 2);
  f.add_bookcase(walls.east(1.0));
  if (level >= 2) f.add_desk(walls.west(3.2), 2);
  if (level >= 3) {
    f.add_desk(walls.north(0.3), 1);
    f.add_bookcase(walls.east(1.0 + kCaseWidth));  // side by side
  }
  if (level >= 4) {
    f.add_desk(walls.south(0.5 + kDeskWidth), 2);
    f.add_desk(walls.south(5.1), 1);
    f.add_desk(placed(0.8, 0.6, 6.3, 4.1), 1);  // askew in the middle: its corners are rounded
    f.add_desk(placed(-0.28, 0.96, 3.9, 4.7), 1);
    for (const double along : {3.0, 4.1, 5.0}) f.add_bookcase(walls.north(along));
    f.add_bookcase(walls.east(4.5));
  }
  return data;
}

SceneData slater_room(int number) {
  // Desks and bookcases beyond the first, in the order of Slater's table; the third from last also
  // has some books.
  struct Furniture {
    int desks, bookcases, polygons;
  };
  constexpr Furniture rooms[] = {{0, 0, 138}, {0, 1, 174}, {1, 0, 192}, {0, 2, 210}, {1, 1, 228},
                                 {1, 2, 264}, {2, 0, 246}, {2, 0, 264}, {2, 1, 282}, {2, 2, 318}};
  const Furniture& furniture = rooms[number - 1];
  SceneData data;
  data.name = "slater" + std::to_string(number);
  const Walls walls{6.0, 5.0};
  data.light = Light::point({3.1, 2.4, 2.55});
  data.light.name = "lamp";
  add(data, shell(walls.w, walls.d, 2.7), "room");
  for (std::size_t k = 0; k < 6; ++k)
    add_poster(data, numbered("poster", k + 1), 0.15 + 0.8 * static_cast<double>(k), 0.7);
  Furnisher f{data};
  f.add_chair(placed(-0.96, 0.28, 1.6, 1.5));
  constexpr double desks[] = {0.5, 0.5 + kDeskWidth, 0.5 + 2 * kDeskWidth};
  for (int k = 0; k <= furniture.desks; ++k) f.add_desk(walls.south(desks[k]), 1);
  for (int k = 0; k <= furniture.bookcases; ++k)
    f.add_empty_bookcase(walls.east(1.0 + k * kCaseWidth));
  if (number == 8) f.add_books(walls.east(1.0), 3);
  return data;
}

Light light_at_the_door() {
  Light light = Light::point({0.93, 7.3, 1.62});
  light.name = "outside";
  return light;
}

SceneData furnished_room() {
  SceneData data;
  data.name = "furnished_room";
  const Walls walls{10, 7};
  data.light = Light::point({4.33, 3.29, 2.47});
  data.light.name = "lamp";
  Mesh shell_mesh;
  {
    // The southern wall has a window.
    const Mesh plain = shell(walls.w, walls.d, 2.7);
    shell_mesh.vertices = plain.vertices;
    for (const Vec3& v : {Vec3(6, 0, 0.9), Vec3(8, 0, 0.9), Vec3(8, 0, 2.1), Vec3(6, 0, 2.1)})
      shell_mesh.vertices.push_back(v);
    for (std::size_t face = 0; face < plain.face_count(); ++face) {
      shell_mesh.add_face(plain.loop(face, 0));
      constexpr std::array<std::uint32_t, 4> window{12, 13, 14, 15};
      if (face == 2) shell_mesh.add_hole(window);
    }
  }
  add(data, std::move(shell_mesh), "room");
  add_poster(data, "poster", 1.7);
  Furnisher f{data};
  f.add_desk(walls.south(0.6), 2);
  f.add_desk(walls.south(0.6 + kDeskWidth), 1);
  f.add_desk(walls.west(4.4), 2);
  f.add_desk(walls.north(0.5), 2);
  f.add_desk(placed(0.8, 0.6, 5.4, 3.9), 1);
  for (const double along : {1.2, 1.2 + kCaseWidth, 4.0}) f.add_bookcase(walls.east(along));
  f.add_bookcase(walls.north(3.2));
  f.add_chair(placed(-1, 0, 1.6, 1.3));
  f.add_chair(placed(-0.96, 0.28, 3.3, 1.5));
  f.add_chair(placed(-0.6, -0.8, 6.1, 5.6));
  f.add_chair(placed(0, 1, 7.4, 2.2));
  return data;
}

namespace {

void divide(Mesh& mesh, const std::array<Vec3, 4>& corners, int depth) {
  if (depth == 0) {
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), corners.begin(), corners.end());
    for (const std::array<std::uint32_t, 3>& t :
         {std::array{0u, 2u, 1u}, {0u, 1u, 3u}, {1u, 2u, 3u}, {2u, 0u, 3u}})
      mesh.add_face({base + t[0], base + t[1], base + t[2]});
    return;
  }
  for (const Vec3& c : corners) {
    std::array<Vec3, 4> part;
    std::transform(corners.begin(), corners.end(), part.begin(),
                   [&](const Vec3& v) -> Vec3 { return (v + c) / 2; });
    divide(mesh, part, depth - 1);
  }
}

}  // namespace

SceneData tetrahedron(int depth) {
  SceneData data;
  data.name = "tetrahedron" + std::to_string(depth);
  data.light = Light::point({2.71, -0.43, 3.37});
  // Regular to six digits. Coordinates are multiples of 2^-20, so that halving is exact and the
  // parts share their vertices to the bit.
  const std::array<Vec3, 4> corners{
      Vec3(to_grid(0.942809), 0, 0), Vec3(to_grid(-0.471405), to_grid(0.816497), 0),
      Vec3(to_grid(-0.471405), to_grid(-0.816497), 0), Vec3(0, 0, to_grid(1.333333))};
  Mesh mesh;
  divide(mesh, corners, depth);
  add(data, rectangle({-3, -3, 0}, {6, 0, 0}, {0, 6, 0}), "ground");
  add(data, std::move(mesh), "tetrahedron");
  return data;
}

SceneData city(std::uint32_t n) {
  SceneData data;
  data.name = "city" + std::to_string(n);
  Random random(2094 + n);
  add(data, rectangle({-1, -1, 0}, {n + 2.0, 0, 0}, {0, n + 2.0, 0}), "ground");
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const double margin[4] = {random.in(0.1, 0.25), random.in(0.1, 0.25), random.in(0.7, 0.9),
                                random.in(0.7, 0.9)};
      const double u = random.unit(), height = to_grid(0.3 + 2.2 * u * u * u);
      // Every fourth house stands on the building line, so that facades along a street are
      // coplanar.
      const bool aligned = random.below(4) == 0;
      const double x0 = aligned ? 0.125 : margin[0], y0 = aligned ? 0.125 : margin[1];
      add(data, box({x + x0, y + y0, 0}, {x + margin[2], y + margin[3], height}),
          "house." + std::to_string(x) + "." + std::to_string(y));
    }
  }
  // Above a street, but so near to its houses that some stand below the light and lose a facade.
  const double column = std::floor(0.31 * n), row = std::floor(0.64 * n);
  data.light = Light::point({column + 0.876, row + 0.957, 0.4 * n + 4.19});
  return data;
}

SceneData spheres(std::uint32_t count, std::uint32_t segments, std::uint32_t rings) {
  SceneData data;
  data.name = "spheres" + std::to_string(count);
  Random random(77 + count);
  const double side = std::cbrt(static_cast<double>(count)) * 2;
  add(data, rectangle({-side, -side, 0}, {3 * side, 0, 0}, {0, 3 * side, 0}), "ground");
  for (std::uint32_t k = 0; k < count; ++k) {
    const Vec3 centre = random.in_cube(0.75, to_grid(side + 0.75));
    const double radius = random.in(0.25, 0.75);
    add(data, uv_sphere(centre, radius, segments, rings), "sphere." + std::to_string(k));
  }
  data.light = Light::point({to_grid(1.07 * side), to_grid(-0.24 * side), to_grid(1.94 * side)});
  return data;
}

SceneData triangles(std::uint32_t n) {
  SceneData data;
  data.name = "triangles" + std::to_string(n);
  Random random(4242 + n);
  // As large as the mean distance between them: most cast shadows on others, and a few per cent
  // cross.
  const double reach = 0.75 * std::pow(n, -1.0 / 3);
  add(data, rectangle({-1, -1, 0}, {3, 0, 0}, {0, 3, 0}), "ground");
  for (std::uint32_t k = 0; k < n; ++k) {
    const Vec3 centre = random.in_cube(0, 1) + Vec3(0, 0, 0.25);
    Mesh mesh;
    do {
      mesh.vertices.clear();
      for (int i = 0; i < 3; ++i) mesh.vertices.push_back(centre + random.in_ball(reach));
    } while (
        (mesh.vertices[1] - mesh.vertices[0]).cross(mesh.vertices[2] - mesh.vertices[0]).norm() <
        0.1 * reach * reach);
    mesh.add_face({0, 1, 2});
    add(data, std::move(mesh), "triangle." + std::to_string(k));
  }
  data.light = Light::point({0.713, 0.367, 3.19});
  return data;
}

namespace {

Vec3 to_grid(const Vec3& v) {
  return v.unaryExpr([](double x) { return scenes::to_grid(x); });
}

// The same faces, each as a fan of triangles.
Mesh triangulated(const Mesh& mesh) {
  Mesh parts;
  parts.vertices = mesh.vertices;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto loop = mesh.loop(f, 0);
    for (std::size_t i = 2; i < loop.size(); ++i) parts.add_face({loop[0], loop[i - 1], loop[i]});
  }
  return parts;
}

struct Twig {
  SceneData& data;
  bool triangles = false;  // of the wood; leaves always are
  std::size_t most_leaves = std::string::npos;
  Random random{31};
  std::size_t twigs = 0, leaves = 0;

  // A hexagonal prism whose outline is u, v and v-u about the start: flat to the bit.
  void add_wood(const Vec3& from, const Vec3& along, double radius) {
    const Vec3 side =
        along.cross(std::abs(along.z()) < 0.8 * along.norm() ? Vec3(0, 0, 1) : Vec3(1, 0, 0))
            .normalized() *
        radius;
    const Vec3 other = along.cross(side).normalized() * radius;
    const Vec3 u = to_grid(side), v = to_grid(Vec3(0.5 * side + 0.8660254 * other));
    // Seen along the twig, the outline turns left. The base of a prism must turn left seen from
    // outside, from behind the start.
    const Mesh wood =
        prism({from + u, from + u - v, from - v, from - u, from + v - u, from + v}, along);
    add(data, triangles ? triangulated(wood) : wood, numbered("twig", ++twigs));
  }

  // Two triangles folded along the midrib.
  void add_leaf(const Vec3& from, const Vec3& along) {
    if (leaves == most_leaves) return;
    const Vec3 across =
        to_grid(Vec3(along.cross(random.in_ball(1)).normalized() * (0.3 * along.norm())));
    const Vec3 lift = to_grid(Vec3(along.cross(across).normalized() * (0.12 * along.norm())));
    Mesh mesh;
    const Vec3 middle = from + to_grid(Vec3(0.45 * along));
    mesh.vertices = {from, middle + across + lift, from + along, middle - across + lift};
    mesh.add_face({0, 2, 1});
    mesh.add_face({0, 3, 2});
    add(data, std::move(mesh), numbered("leaf", ++leaves));
  }

  void grow(const Vec3& from, const Vec3& along, double radius, int levels) {
    add_wood(from, along, radius);
    for (int k = 0; k < 3; ++k) {
      const Vec3 bent = along.normalized() + random.in_ball(1) * 0.9;
      const Vec3 start = from + to_grid(Vec3(along * (0.5 + 0.22 * k)));
      const Vec3 step = to_grid(Vec3(bent.normalized() * (along.norm() * 0.62)));
      if (levels > 1) grow(start, step, 0.6 * radius, levels - 1);
      else add_leaf(start, step);
    }
  }
};

}  // namespace

SceneData branch(int levels) {
  SceneData data;
  data.name = "branch" + std::to_string(levels);
  data.light = Light::point({1.13, -0.91, 4.7});
  add(data, rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}), "ground");
  Twig{data}.grow({0, 0, 0}, {0.125, 0.0625, 1}, 0.0625, levels);
  return data;
}

namespace {

// Four quads around the middle, or as many as n says along a side.
Mesh tiled_ground(double reach, double z, int n = 2) {
  Mesh mesh;
  const double step = 2 * reach / n;
  for (int k = 0; k < n * n; ++k)
    append(mesh, rectangle({-reach + k % n * step, -reach + k / n * step, z}, {step, 0, 0},
                           {0, step, 0}));
  return mesh;
}

// A convex solid of points whose faces are given as loops, seen from outside counter-clockwise.
Mesh solid(const Vec3& at, double scale, const std::vector<Vec3>& points,
           const std::vector<std::vector<std::uint32_t>>& faces) {
  Mesh mesh;
  for (const Vec3& p : points) mesh.vertices.push_back(at + scale * p);
  for (const std::vector<std::uint32_t>& face : faces) mesh.add_face(face);
  return mesh;
}

// The hull of points whose faces lie in planes normal . p = greatest, for each of the normals;
// exact for whole numbers.
Mesh hull(const Vec3& at, double scale, const std::vector<Vec3>& points,
          const std::vector<Vec3>& normals) {
  std::vector<std::vector<std::uint32_t>> faces;
  for (const Vec3& normal : normals) {
    double greatest = normal.dot(points[0]);
    for (const Vec3& p : points) greatest = std::max(greatest, normal.dot(p));
    std::vector<std::uint32_t> face;
    Vec3 middle = Vec3::Zero();
    for (std::uint32_t i = 0; i < points.size(); ++i)
      if (normal.dot(points[i]) == greatest) face.push_back(i), middle += points[i];
    middle /= static_cast<double>(face.size());
    const Vec3 u = points[face[0]] - middle, v = normal.cross(u);
    std::sort(face.begin(), face.end(), [&](std::uint32_t a, std::uint32_t b) {
      const auto turn = [&](std::uint32_t i) {
        const Vec3 d = points[i] - middle;
        return std::atan2(d.dot(v) / v.norm(), d.dot(u) / u.norm());
      };
      return turn(a) < turn(b);
    });
    faces.push_back(std::move(face));
  }
  return solid(at, scale, points, faces);
}

// All points (or normals) that follow from one by changes of sign and permutations of coordinates.
std::vector<Vec3> all_of(const Vec3& one) {
  std::vector<Vec3> all;
  std::array<double, 3> x{one.x(), one.y(), one.z()};
  std::sort(x.begin(), x.end());
  do {
    for (int signs = 0; signs < 8; ++signs) {
      const Vec3 p(signs & 1 ? -x[0] : x[0], signs & 2 ? -x[1] : x[1], signs & 4 ? -x[2] : x[2]);
      if (std::find(all.begin(), all.end(), p) == all.end()) all.push_back(p);
    }
  } while (std::next_permutation(x.begin(), x.end()));
  return all;
}

std::vector<Vec3> together(std::vector<Vec3> a, const std::vector<Vec3>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// Twelve vertices at (0, 1, golden ratio) and its turns; triangles, so that rounding leaves them
// flat.
Mesh icosahedron(const Vec3& at, double scale) {
  constexpr double g = 1.6180339887498949;
  std::vector<Vec3> points;
  for (int k = 0; k < 3; ++k)
    for (int signs = 0; signs < 4; ++signs) {
      Vec3 p = Vec3::Zero();
      p[(k + 1) % 3] = signs & 1 ? -1 : 1, p[(k + 2) % 3] = signs & 2 ? -g : g;
      points.push_back(to_grid(p));
    }
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t a = 0; a < 12; ++a)
    for (std::uint32_t b = a + 1; b < 12; ++b)
      for (std::uint32_t c = a + 1; c < 12; ++c) {
        const auto near = [&](std::uint32_t i, std::uint32_t j) {
          return (points[i] - points[j]).norm() < 2.1;
        };
        if (b == c || !near(a, b) || !near(b, c) || !near(c, a)) continue;
        if ((points[b] - points[a]).cross(points[c] - points[a]).dot(points[a]) > 0)
          faces.push_back({a, b, c});
      }
  return solid(at, scale, points, faces);
}

}  // namespace

SceneData sphere256() {
  SceneData data;
  data.name = "sphere256";
  data.light = Light::point({1.73, -1.21, 3.93});
  add(data, tiled_ground(3, 0), "ground");
  add(data, uv_sphere({0, 0, 1.25}, 0.75, 14, 10), "sphere");
  return data;
}

SceneData solids96() {
  SceneData data;
  data.name = "solids96";
  data.light = Light::point({0.87, -1.13, 4.71});
  const std::vector<Vec3> axes = all_of({1, 0, 0}), corners = all_of({1, 1, 1});
  add(data, rectangle({-3, -3, 0}, {6, 0, 0}, {0, 6, 0}), "ground");
  add(data, hull({-1.75, -1.5, 0.5}, 0.5, corners, axes), "cube");
  add(data, hull({0, -1.75, 0.75}, 0.75, axes, corners), "octahedron");
  const std::vector<Vec3> four{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  const std::vector<Vec3> against{{-1, -1, -1}, {-1, 1, 1}, {1, -1, 1}, {1, 1, -1}};
  add(data, hull({1.75, -1.5, 0.625}, 0.5, four, against), "tetrahedron.1");
  add(data, hull({0.125, 1.875, 0.375}, 0.375, against, four), "tetrahedron.2");
  add(data, hull({-2, 0.25, 0.5}, 0.5, all_of({1, 1, 0}), together(axes, corners)),
      "cuboctahedron");
  add(data, hull({0, 0, 1.25}, 0.5, together(corners, all_of({2, 0, 0})), all_of({1, 1, 0})),
      "rhombic_dodecahedron");
  add(data, hull({1.75, 0.25, 0.75}, 0.25, all_of({2, 1, 0}), together(axes, corners)),
      "truncated_octahedron");
  add(data, icosahedron({-1.5, 1.75, 1}, 0.375), "icosahedron");
  const std::vector<Vec3> ring{{2, 1, 0},   {1, 2, 0},   {-1, 1, 0},
                               {-2, -1, 0}, {-1, -2, 0}, {1, -1, 0}};
  std::vector<Vec3> base;
  for (const Vec3& p : ring) base.push_back(Vec3(2, 1.875, 0) + 0.25 * p);
  std::reverse(base.begin(), base.end());
  add(data, prism(base, {0, 0, 1.25}), "prism");
  add(data,
      solid({1.125, 1, 0}, 0.375, {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 2}},
            {{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}),
      "pyramid");
  return data;
}

SceneData tetrahedra752(int number) {
  SceneData data = tetrahedron(3);
  data.name = "tetrahedra752_" + std::to_string(number);
  Mesh whole = std::move(data.objects[1].first), mesh;
  data.objects.clear();
  // 64 parts; 41 of them, taken evenly, become four each: 187 of four faces.
  for (std::uint32_t k = 0; k < 64; ++k) {
    const std::array<Vec3, 4> corners{whole.vertices[4 * k], whole.vertices[4 * k + 1],
                                      whole.vertices[4 * k + 2], whole.vertices[4 * k + 3]};
    divide(mesh, corners, (k + 1) * 41 / 64 > k * 41 / 64 ? 1 : 0);
  }
  add(data, tiled_ground(3, number == 1 ? -0.25 : 1), "ground");
  add(data, std::move(mesh), "tetrahedron");
  return data;
}

SceneData cubes1502() {
  SceneData data;
  data.name = "cubes1502";
  data.light = Light::point({2.37, -3.19, 7.53});
  add(data, triangulated(rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0})), "ground");
  for (int k = 0; k < 125; ++k) {
    const Vec3 lo = Vec3(k % 5, k / 5 % 5, k / 25) * 0.75 + Vec3(-1.75, -1.75, 0.5);
    add(data, triangulated(box(lo, lo + Vec3(0.5, 0.5, 0.5))),
        numbered("cube", static_cast<std::size_t>(k + 1)));
  }
  return data;
}

SceneData branch2878() {
  SceneData data;
  data.name = "branch2878";
  data.light = Light::point({1.13, -0.91, 4.7});
  add(data, rectangle({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}), "ground");
  Twig{data, true, 229}.grow({0, 0, 0}, {0.125, 0.0625, 1}, 0.0625, 5);
  return data;
}

SceneData spheres2037(std::uint32_t count) {
  SceneData data = spheres(count, 55, 38);
  data.name = "spheres2037_" + std::to_string(count);
  return data;
}

const std::vector<std::string>& image_space_scenes() {
  static const std::vector<std::string> names{
      "sphere256", "solids96",   "tetrahedra752:1", "tetrahedra752:2",
      "cubes1502", "branch2878", "spheres2037:100", "spheres2037:300"};
  return names;
}

namespace {

// Whole numbers separated by commas, or nullopt.
std::vector<std::uint32_t> sizes_of(std::string_view text) {
  std::vector<std::uint32_t> sizes;
  const char *at = text.data(), *const end = at + text.size();
  while (at != end) {
    std::uint32_t size = 0;
    const auto [rest, error] = std::from_chars(at, end, size);
    if (error != std::errc() || size == 0 || (rest != end && (*rest != ',' || rest + 1 == end)))
      return {};
    sizes.push_back(size);
    at = rest == end ? end : rest + 1;
  }
  return sizes;
}

}  // namespace

SceneData named(const std::string& name) {
  const std::size_t colon = std::min(name.find(':'), name.size());
  const std::string kind = name.substr(0, colon);
  const std::vector<std::uint32_t> n =
      sizes_of(std::string_view(name).substr(std::min(colon + 1, name.size())));
  if (name == "furnished_room") return furnished_room();
  if (name == "sphere256") return sphere256();
  if (name == "solids96") return solids96();
  if (name == "cubes1502") return cubes1502();
  if (name == "branch2878") return branch2878();
  if (kind == "tetrahedra752" && n.size() == 1 && n[0] <= 2)
    return tetrahedra752(static_cast<int>(n[0]));
  if (kind == "spheres2037" && n.size() == 1) return spheres2037(n[0]);
  if (kind == "spheres" && n.size() == 3) return spheres(n[0], n[1], n[2]);
  if (kind == "spheres" && n.size() == 1) return spheres(n[0], 64, 33);
  if (kind == "slater" && n.size() == 1 && n[0] >= 1 && n[0] <= 10)
    return slater_room(static_cast<int>(n[0]));
  if (kind == "room" && n.size() == 1 && n[0] <= 4) return room(static_cast<int>(n[0]));
  if (kind == "tetrahedron" && n.size() == 1 && n[0] <= 10)
    return tetrahedron(static_cast<int>(n[0]));
  if (kind == "city" && n.size() == 1) return city(n[0]);
  if (kind == "triangles" && n.size() == 1) return triangles(n[0]);
  if (kind == "branch" && n.size() == 1 && n[0] <= 10) return branch(static_cast<int>(n[0]));
  throw Error("there is no scene '" + name +
              "' (room:4, slater:10, furnished_room, tetrahedron:3, city:100, spheres:25, "
              "triangles:1000, branch:3, sphere256, solids96, "
              "tetrahedra752:1, cubes1502, "
              "branch2878, spheres2037:100)");
}

}  // namespace shadowcut::scenes
