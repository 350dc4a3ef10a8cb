// See exact_scenes.hpp.
#include "exact_scenes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <ostream>
#include <utility>

#include "light_vector.hpp"

namespace shadowcut::testing {
namespace {

using scenes::Random;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::array<double, 4> kScales{1e-30, 1e-9, 1e9, 1e30};

Vec3 grid_point(Random& random) {
  const std::uint64_t n = random.below(64);
  return {static_cast<double>(n % 4), static_cast<double>(n / 4 % 4), static_cast<double>(n / 16)};
}

Vec3 any_point(Random& random, double lo, double hi) {
  const double x = lo + (hi - lo) * random.unit(), y = lo + (hi - lo) * random.unit(),
               z = lo + (hi - lo) * random.unit();
  return {x, y, z};
}

Vec3 any_direction(Random& random) {
  while (true) {
    const Vec3 v = any_point(random, -1, 1);
    if (v.norm() > 0.1) return v;
  }
}

bool in_line(const Vec3& a, const Vec3& b, const Vec3& c) { return (b - a).cross(c - a).isZero(0); }

std::vector<std::uint32_t> loop(std::uint32_t first, std::uint32_t count, bool turned) {
  std::vector<std::uint32_t> out;
  for (std::uint32_t i = 0; i < count; ++i) out.push_back(first + (turned ? count - 1 - i : i));
  return out;
}

void add_face(ExactObject& object, const std::vector<Vec3>& corners, bool turned) {
  const auto first = static_cast<std::uint32_t>(object.vertices.size());
  object.vertices.insert(object.vertices.end(), corners.begin(), corners.end());
  object.faces.push_back(loop(first, static_cast<std::uint32_t>(corners.size()), turned));
}

ExactObject sheet(std::vector<Vec3> corners, Random& random) {
  ExactObject object;
  add_face(object, corners, random.below(2) == 0);
  return object;
}

// Three corners on the grid, not in line; four where they make a parallelogram.
std::vector<Vec3> grid_corners(Random& random) {
  while (true) {
    const Vec3 a = grid_point(random), b = grid_point(random), c = grid_point(random);
    if (in_line(a, b, c)) continue;
    const Vec3 d = a + (c - b);
    if (random.below(2) == 0) return {a, b, c};
    if (d.minCoeff() >= 0 && d.maxCoeff() <= 3) return {a, b, c, d};
  }
}

ExactObject tetrahedron(const std::array<Vec3, 4>& p, bool turned) {
  ExactObject object;
  object.vertices.assign(p.begin(), p.end());
  if ((p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]) < 0)
    std::swap(object.vertices[0], object.vertices[1]);
  object.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  if (turned) std::swap(object.vertices[0], object.vertices[1]);
  return object;
}

ExactObject box(const Vec3& lo, const Vec3& hi, bool turned) {
  const Mesh mesh = scenes::box(lo, hi);
  ExactObject object;
  object.vertices = mesh.vertices;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto l = mesh.loop(f, 0);
    if (turned) object.faces.emplace_back(l.rbegin(), l.rend());
    else object.faces.emplace_back(l.begin(), l.end());
  }
  return object;
}

ExactObject grid_solid(Random& random) {
  const bool turned = random.below(4) == 0;
  ExactObject object;
  while (object.faces.empty()) {
    if (random.below(2) == 0) {
      const Vec3 a = grid_point(random), b = grid_point(random);
      if ((a - b).cwiseAbs().minCoeff() > 0) object = box(a.cwiseMin(b), a.cwiseMax(b), turned);
    } else {
      const std::array<Vec3, 4> p{grid_point(random), grid_point(random), grid_point(random),
                                  grid_point(random)};
      if ((p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]) != 0) object = tetrahedron(p, turned);
    }
  }
  object.closed = random.below(4) != 0;
  return object;
}

std::size_t face_count(const ExactScene& scene) {
  std::size_t n = 0;
  for (const ExactObject& object : scene.objects) n += object.faces.size();
  return n;
}

std::size_t some_count(Random& random) { return 5 + random.below(8); }

Light some_light(Random& random) {
  if (random.below(3) == 0) return Light::directional(any_direction(random));
  return Light::point(random.below(3) == 0 ? any_point(random, 0, 1) : any_point(random, -3, 4));
}

std::vector<Vec3> any_corners(Random& random) {
  const Vec3 a = any_point(random, 0, 1), b = any_point(random, 0, 1), c = any_point(random, 0, 1);
  if (random.below(2) == 0) return {a, b, c};
  return {a, b, c, a + (c - b)};
}

ExactScene soup(Random& random) {
  ExactScene scene;
  for (std::size_t n = some_count(random); n > 0; --n)
    scene.objects.push_back(sheet(any_corners(random), random));
  scene.light = some_light(random);
  return scene;
}

ExactScene grid(Random& random) {
  ExactScene scene;
  for (const std::size_t n = some_count(random); face_count(scene) < n;)
    scene.objects.push_back(grid_object(random));
  scene.light = grid_light(random);
  return scene;
}

ExactScene grid_solids(Random& random) {
  ExactScene scene;
  scene.objects.push_back(grid_solid(random));
  for (const std::size_t n = some_count(random); face_count(scene) < n;)
    scene.objects.push_back(random.below(2) == 0 ? grid_solid(random) : grid_object(random));
  scene.light = grid_light(random);
  return scene;
}

// A concave outline in a plane of the grid.
std::vector<Vec3> outline(Random& random) {
  static const std::vector<std::vector<std::array<int, 2>>> outlines{
      {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}},
      {{0, 0}, {3, 1}, {0, 3}, {1, 1}},
      {{0, 0}, {2, 0}, {3, 3}, {1, 1}, {0, 2}}};
  const std::uint64_t x = random.below(3), z = random.below(4), lift = random.below(2);
  std::vector<Vec3> out;
  for (const auto& p : outlines[random.below(outlines.size())]) {
    Vec3 v;
    v[static_cast<Eigen::Index>(x)] = p[0];
    v[static_cast<Eigen::Index>((x + 1) % 3)] = p[1];
    // leaves the grid at times; stays whole
    v[static_cast<Eigen::Index>((x + 2) % 3)] = static_cast<double>(z) + (lift ? p[0] : 0);
    out.push_back(v);
  }
  return out;
}

ExactScene folded(Random& random) {
  ExactScene scene;
  for (const std::size_t n = some_count(random); face_count(scene) < n;) {
    switch (random.below(3)) {
      case 0: {
        const Vec3 a = grid_point(random), b = grid_point(random), c = grid_point(random),
                   d = grid_point(random);
        scene.objects.push_back(sheet({a, b, c, d}, random));
        break;
      }
      case 1:
        scene.objects.push_back(sheet(outline(random), random));
        break;
      default:
        scene.objects.push_back(grid_object(random));
    }
  }
  scene.light = grid_light(random);
  return scene;
}

ExactScene coplanar(Random& random) {
  ExactScene scene;
  const std::uint64_t axis = random.below(3), tilted = random.below(2);
  for (const std::size_t n = some_count(random); face_count(scene) < n;) {
    std::vector<Vec3> corners = grid_corners(random);
    const double height = static_cast<double>(random.below(2));
    for (Vec3& v : corners) {
      const auto z = static_cast<Eigen::Index>(axis), x = static_cast<Eigen::Index>((axis + 1) % 3);
      v[z] = height + (tilted ? v[x] : 0);
    }
    if (in_line(corners[0], corners[1], corners[2])) continue;
    scene.objects.push_back(sheet(std::move(corners), random));
    if (random.below(4) == 0)
      scene.objects.push_back(scene.objects[random.below(scene.objects.size())]);
  }
  scene.light = grid_light(random);
  return scene;
}

ExactScene fan(Random& random) {
  ExactScene scene;
  const Vec3 hub = grid_point(random);
  ExactObject one;
  const bool apart = random.below(2) == 0;
  for (std::size_t n = some_count(random); n > 0;) {
    std::vector<Vec3> corners = grid_corners(random);
    corners.resize(3);
    corners[0] = hub;
    if (in_line(corners[0], corners[1], corners[2])) continue;
    if (apart) scene.objects.push_back(sheet(std::move(corners), random));
    else add_face(one, corners, random.below(2) == 0);
    --n;
  }
  if (!apart) scene.objects.push_back(one);
  scene.light = grid_light(random);
  return scene;
}

// Corners light + k (g - light) for few g: with the light and g on the grid they are whole numbers.
ExactScene pencil(Random& random) {
  ExactScene scene;
  scene.light = grid_light(random);
  const bool sun = scene.light.kind == Light::Kind::directional;
  std::array<Vec3, 4> ends;
  for (Vec3& g : ends) g = grid_point(random);
  const auto corner = [&] {
    const Vec3& g = ends[random.below(4)];
    const double k = static_cast<double>(1 + random.below(4));
    return sun ? Vec3(g + k * scene.light.direction)
               : Vec3(scene.light.position + k * (g - scene.light.position));
  };
  for (int tries = 0; face_count(scene) < 8 && tries < 100; ++tries) {
    const Vec3 a = corner(), b = corner(), c = random.below(3) == 0 ? grid_point(random) : corner();
    if (!in_line(a, b, c)) scene.objects.push_back(sheet({a, b, c}, random));
  }
  if (scene.objects.empty()) scene.objects.push_back(grid_object(random));
  return scene;
}

double nudged(double x, Random& random) {
  const double to = random.below(2) == 0 ? -kInfinity : kInfinity;
  for (std::uint64_t n = 1 + random.below(3); n > 0; --n) x = std::nextafter(x, to);
  return x;
}

ExactScene on_grid(Random& random) {
  switch (random.below(6)) {
    case 0:
      return grid_solids(random);
    case 1:
      return folded(random);
    case 2:
      return coplanar(random);
    case 3:
      return fan(random);
    case 4:
      return pencil(random);
    default:
      return grid(random);
  }
}

// Off zero, some ulps are denormal numbers: those have kinds of their own, and here the grid begins
// at 1.
ExactScene nudged_scene(Random& random) {
  ExactScene scene = on_grid(random);
  const std::uint64_t one_in = 1 + random.below(8);
  const auto nudge = [&](Vec3& v) {
    for (double& x : v) {
      if (random.below(one_in) == 0) x = nudged(x, random);
    }
  };
  for (ExactObject& object : scene.objects) {
    for (Vec3& v : object.vertices) v += Vec3::Ones(), nudge(v);
  }
  if (scene.light.kind == Light::Kind::point) scene.light.position += Vec3::Ones();
  if (random.below(2) == 0) {
    Vec3& v = vector_of(scene.light);
    nudge(v);
    v = v.unaryExpr([](double c) { return std::abs(c) < 1e-300 ? 0.0 : c; }).eval();
  }
  return scene;
}

ExactScene needles(Random& random) {
  ExactScene scene = random.below(2) == 0 ? soup(random) : grid(random);
  for (std::size_t n = 2 + random.below(4); n > 0; --n) {
    const bool whole = random.below(2) == 0;
    const Vec3 a = whole ? grid_point(random) : any_point(random, 0, 1),
               b = whole ? grid_point(random) : any_point(random, 0, 1);
    if (a == b) continue;
    const Vec3 beside = a + random.unit() * (b - a) + 1e-12 * any_direction(random);
    if (random.below(2) == 0) scene.objects.push_back(sheet({a, b, beside}, random));
    else scene.objects.push_back(sheet({a, b, b + (beside - a), a + (beside - a)}, random));
  }
  return scene;
}

ExactScene stack(Random& random) {
  ExactScene scene;
  const std::vector<Vec3> corners =
      random.below(2) == 0 ? grid_corners(random) : any_corners(random);
  const auto axis = static_cast<Eigen::Index>(random.below(3));
  std::vector<Vec3> sheet_corners = corners;
  for (Vec3& v : sheet_corners) v += Vec3::Ones();
  const bool level = random.below(2) == 0;
  if (level) {
    for (Vec3& v : sheet_corners) v[axis] = 1.5;
  }
  for (std::size_t n = some_count(random); n > 0; --n) {
    for (Vec3& v : sheet_corners) v[axis] = std::nextafter(v[axis], kInfinity);
    if (in_line(sheet_corners[0], sheet_corners[1], sheet_corners[2])) continue;
    std::vector<Vec3> shifted = sheet_corners;
    const Vec3 shift = grid_point(random) / 4;
    for (Vec3& v : shifted) {
      for (Eigen::Index i = 0; i < 3; ++i) {
        if (level && i != axis) v[i] += shift[i];
      }
    }
    scene.objects.push_back(sheet(random.below(2) == 0 ? shifted : sheet_corners, random));
  }
  if (scene.objects.empty()) return soup(random);
  scene.light = some_light(random);
  return scene;
}

void scale(ExactObject& object, double factor) {
  for (Vec3& v : object.vertices) v *= factor;
}

ExactScene any_scene(Random& random) {
  switch (random.below(4)) {
    case 0:
      return soup(random);
    case 1:
      return nudged_scene(random);
    case 2:
      return needles(random);
    default:
      return on_grid(random);
  }
}

ExactScene scaled_scene(Random& random) {
  ExactScene scene = any_scene(random);
  const double factor = kScales[random.below(4)];
  for (ExactObject& object : scene.objects) scale(object, factor);
  vector_of(scene.light) *= factor;
  return scene;
}

ExactScene mixed_scales(Random& random) {
  ExactScene scene = any_scene(random);
  const bool with_one = random.below(2) == 0;
  const auto factor = [&] {
    return with_one && random.below(2) == 0 ? 1.0 : kScales[random.below(4)];
  };
  for (ExactObject& object : scene.objects) scale(object, factor());
  vector_of(scene.light) *= factor();
  return scene;
}

ExactScene far_away(Random& random) {
  ExactScene scene = any_scene(random);
  const double distance = std::pow(10, 6 + 6 * random.unit());
  const Vec3 shift =
      distance * (random.below(2) == 0 ? any_direction(random) : grid_point(random)).eval();
  for (ExactObject& object : scene.objects) {
    for (Vec3& v : object.vertices) v += shift;
  }
  if (scene.light.kind == Light::Kind::point) scene.light.position += shift;
  return scene;
}

const Vec3& corner(const ExactObject& object, std::size_t k) {
  return object.vertices[object.faces[0][k]];
}

ExactScene special_light(Random& random) {
  ExactScene scene = random.below(2) == 0 ? soup(random) : on_grid(random);
  const ExactObject& object = scene.objects[random.below(scene.objects.size())];
  const Vec3 &a = corner(object, 0), &b = corner(object, 1), &c = corner(object, 2);
  const double s =
      random.below(2) == 0 ? 4 * random.unit() - 2 : static_cast<double>(random.below(7)) - 3;
  const double t =
      random.below(2) == 0 ? 4 * random.unit() - 2 : static_cast<double>(random.below(7)) - 3;
  const bool sun = random.below(3) == 0;
  switch (random.below(3)) {
    case 0:
      scene.light = sun ? Light::directional(s * (b - a) + t * (c - a))
                        : Light::point(a + s * (b - a) + t * (c - a));
      break;
    case 1:
      scene.light = sun ? Light::directional(b - a) : Light::point(a + s * (b - a));
      break;
    default:
      scene.light = Light::point(a);
  }
  if (scene.light.kind == Light::Kind::directional && scene.light.direction.isZero(0))
    scene.light.direction = -Vec3::UnitZ();
  if (random.below(2) == 0) {
    double& x = vector_of(scene.light)[static_cast<Eigen::Index>(random.below(3))];
    if (x != 0) x = std::nextafter(x, random.below(2) == 0 ? -kInfinity : kInfinity);
  }
  return scene;
}

ExactScene far_light(Random& random) {
  ExactScene scene = any_scene(random);
  scene.light = Light::point(1e12 * any_direction(random));
  return scene;
}

ExactScene near_light(Random& random) {
  ExactScene scene = random.below(2) == 0 ? soup(random) : on_grid(random);
  const ExactObject& object = scene.objects[random.below(scene.objects.size())];
  const Vec3 &a = corner(object, 0), &b = corner(object, 1), &c = corner(object, 2);
  const double s = 0.5 * random.unit(), t = 0.5 * random.unit();
  scene.light = Light::point(a + s * (b - a) + t * (c - a) + 1e-9 * any_direction(random));
  return scene;
}

ExactScene grazing(Random& random) {
  ExactScene scene = any_scene(random);
  const ExactObject& object = scene.objects[random.below(scene.objects.size())];
  const Vec3 &a = corner(object, 0), &b = corner(object, 1), &c = corner(object, 2);
  const double angle = std::pow(10, -3 - 9 * random.unit());
  const Vec3 along = (2 * random.unit() - 1) * (b - a) + (2 * random.unit() - 1) * (c - a),
             across = (b - a).cross(c - a);
  const Vec3 direction = along.stableNormalized() + angle * across.stableNormalized();
  scene.light = Light::directional(direction.allFinite() && !direction.isZero(0) ? direction
                                                                                 : -Vec3::UnitZ());
  return scene;
}

// Some objects only cast, or only receive.
void vary(ExactScene& scene, Random& random) {
  for (ExactObject& object : scene.objects) {
    object.casts_shadows = random.below(12) != 0;
    object.receives_shadows = random.below(12) != 0;
  }
}

}  // namespace

const char* name_of(ExactKind kind) {
  constexpr std::array names{
      "soup",     "grid",          "grid_solids", "folded",     "coplanar", "fan",
      "pencil",   "nudged",        "needles",     "stack",      "scaled",   "mixed_scales",
      "far_away", "special_light", "far_light",   "near_light", "grazing"};
  return names[static_cast<std::size_t>(kind)];
}

void PrintTo(ExactKind kind, std::ostream* out) { *out << name_of(kind); }

ExactObject grid_object(Random& random) {
  if (random.below(8) == 0) return grid_solid(random);
  ExactObject object;
  for (std::uint64_t n = 1 + random.below(3); n > 0; --n)
    add_face(object, grid_corners(random), random.below(2) == 0);
  object.closed = random.below(8) == 0;
  return object;
}

Light grid_light(Random& random) {
  if (random.below(3) == 0) {
    if (random.below(4) == 0) return Light::directional(any_direction(random));
    Vec3 direction = grid_point(random) - grid_point(random);
    if (direction.isZero(0)) direction = -Vec3::UnitZ();
    return Light::directional(direction);
  }
  switch (random.below(5)) {
    case 0:
      return Light::point(grid_point(random));
    case 1:
      return Light::point(0.5 * grid_point(random) + 0.5 * grid_point(random));
    case 2:
      return Light::point(any_point(random, 0, 3));
    default:
      return Light::point(2 * grid_point(random) - Vec3(2, 2, -4));
  }
}

ExactScene exact_scene(ExactKind kind, std::uint64_t seed) {
  constexpr std::array<ExactScene (*)(Random&), 17> makers{
      soup,     grid,          grid_solids, folded,     coplanar,     fan,
      pencil,   nudged_scene,  needles,     stack,      scaled_scene, mixed_scales,
      far_away, special_light, far_light,   near_light, grazing};
  Random random(seed * 32 + static_cast<std::uint64_t>(kind));
  ExactScene scene = makers[static_cast<std::size_t>(kind)](random);
  vary(scene, random);
  return scene;
}

Mesh mesh_of(const ExactObject& object) {
  Mesh mesh;
  mesh.vertices = object.vertices;
  for (const auto& face : object.faces) mesh.add_face(face);
  return mesh;
}

ObjectSettings settings_of(const ExactObject& object) {
  ObjectSettings settings;
  settings.sides = object.closed ? Sides::closed : Sides::open;
  settings.casts_shadows = object.casts_shadows;
  settings.receives_shadows = object.receives_shadows;
  return settings;
}

Scene build(const ExactScene& from) {
  Scene scene;
  for (const ExactObject& object : from.objects) scene.add(mesh_of(object), settings_of(object));
  scene.add(from.light);
  return scene;
}

ExactScene reduced_scene(ExactScene scene, const std::function<bool(const ExactScene&)>& fails) {
  for (bool again = true; again;) {
    again = false;
    for (std::size_t o = scene.objects.size(); o-- > 0;) {
      for (std::size_t f = scene.objects[o].faces.size(); f-- > 0;) {
        ExactScene smaller = scene;
        auto& faces = smaller.objects[o].faces;
        faces.erase(faces.begin() + static_cast<std::ptrdiff_t>(f));
        if (faces.empty())
          smaller.objects.erase(smaller.objects.begin() + static_cast<std::ptrdiff_t>(o));
        if (!fails(smaller)) continue;
        scene = std::move(smaller);
        again = true;
      }
    }
  }
  return scene;
}

std::string describe(const ExactObject& object) {
  std::string out = std::string(object.closed ? "closed" : "open") +
                    (object.casts_shadows ? "" : ", does not cast") +
                    (object.receives_shadows ? "" : ", does not receive") + "\n";
  for (const auto& face : object.faces) {
    out += "  face";
    for (const std::uint32_t v : face) {
      char buffer[100];
      const Vec3& x = object.vertices[v];
      std::snprintf(buffer, sizeof buffer, " {%.17g, %.17g, %.17g}", x.x(), x.y(), x.z());
      out += buffer;
    }
    out += '\n';
  }
  return out;
}

std::string describe(const Light& light) {
  char buffer[120];
  std::snprintf(buffer, sizeof buffer, "%s light {%.17g, %.17g, %.17g}\n",
                light.kind == Light::Kind::point ? "point" : "directional", vector_of(light).x(),
                vector_of(light).y(), vector_of(light).z());
  return buffer;
}

std::string describe(const ExactScene& scene) {
  std::string out = describe(scene.light);
  for (const ExactObject& object : scene.objects) out += describe(object);
  return out;
}

}  // namespace shadowcut::testing
