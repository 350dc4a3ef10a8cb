// See random_scenes.hpp.
#include "random_scenes.hpp"

#include <array>
#include <cmath>
#include <ostream>

namespace shadowcut::testing {
namespace {

using scenes::Random;
using scenes::SceneData;

void add(SceneData& data, Mesh mesh, const char* what, const Pose& pose = Pose::Identity()) {
  ObjectSettings settings;
  settings.name = std::string(what) + "." + std::to_string(data.objects.size());
  settings.pose = pose;
  data.objects.emplace_back(std::move(mesh), std::move(settings));
}

double whole(Random& random, int lo, int hi) {
  return lo + static_cast<double>(random.below(static_cast<std::uint64_t>(hi - lo + 1)));
}

Vec3 grid_point(Random& random, int lo, int hi) {
  const double x = whole(random, lo, hi), y = whole(random, lo, hi), z = whole(random, lo, hi);
  return {x, y, z};
}

// Full-range doubles, not multiples of anything.
Vec3 any_point(Random& random, double lo, double hi) {
  const double x = lo + (hi - lo) * random.unit(), y = lo + (hi - lo) * random.unit(),
               z = lo + (hi - lo) * random.unit();
  return {x, y, z};
}

void add_ground(SceneData& data, double half) {
  add(data, scenes::rectangle({-half, -half, 0}, {2 * half, 0, 0}, {0, 2 * half, 0}), "ground");
}

// Parallelograms are flat exactly where coordinates are whole.
Mesh sheet(const Vec3& a, const Vec3& b, const Vec3& c, bool four) {
  Mesh mesh;
  mesh.vertices = {a, b, c};
  if (four) mesh.vertices.push_back(a + (c - b));
  if (four) mesh.add_face({0, 1, 2, 3});
  else mesh.add_face({0, 1, 2});
  return mesh;
}

void add_soup(SceneData& data, Random& random) {
  const std::uint64_t n = 3 + random.below(14);
  if (random.below(2) == 0) add_ground(data, 3);
  for (std::uint64_t k = 0; k < n; ++k) {
    const Vec3 a = any_point(random, -1, 1) + Vec3(0, 0, 1), b = a + any_point(random, -1, 1),
               c = a + any_point(random, -1, 1);
    add(data, sheet(a, b, c, random.below(2) == 0), "sheet");
  }
}

void add_grid_soup(SceneData& data, Random& random) {
  const std::uint64_t n = 2 + random.below(12);
  for (std::uint64_t k = 0; k < n; ++k) {
    const Vec3 a = grid_point(random, 0, 3), b = grid_point(random, 0, 3),
               c = grid_point(random, 0, 3);
    if ((b - a).cross(c - a).norm() > 0.5) add(data, sheet(a, b, c, random.below(2) == 0), "sheet");
  }
  if (data.objects.empty()) add_ground(data, 2);
}

Mesh tetrahedron(const std::array<Vec3, 4>& p) {
  Mesh mesh;
  mesh.vertices.assign(p.begin(), p.end());
  const bool turned = (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]) < 0;
  if (turned) std::swap(mesh.vertices[0], mesh.vertices[1]);
  for (const std::array<std::uint32_t, 3>& t :
       {std::array{0u, 2u, 1u}, {0u, 1u, 3u}, {1u, 2u, 3u}, {2u, 0u, 3u}})
    mesh.add_face({t[0], t[1], t[2]});
  return mesh;
}

void add_solids(SceneData& data, Random& random) {
  add_ground(data, 4);
  const std::uint64_t n = 1 + random.below(7);
  for (std::uint64_t k = 0; k < n; ++k) {
    const Vec3 at = any_point(random, -1, 1) + Vec3(0, 0, 1.5);
    std::array<Vec3, 4> p;
    for (Vec3& v : p) v = at + any_point(random, -1, 1);
    if (std::abs((p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0])) > 0.05)
      add(data, tetrahedron(p), "solid");
  }
}

Mesh grid_box(Random& random, int size) {
  const Vec3 lo = grid_point(random, 0, size - 1);
  const Vec3 reach = grid_point(random, 1, 3);
  return scenes::box(lo, lo + reach);
}

void add_grid_boxes(SceneData& data, Random& random) {
  if (random.below(2) == 0)
    add(data, scenes::rectangle({-1, -1, 0}, {9, 0, 0}, {0, 9, 0}), "ground");
  const std::uint64_t n = 1 + random.below(7);
  for (std::uint64_t k = 0; k < n; ++k) add(data, grid_box(random, 4), "box");
}

void add_turned_boxes(SceneData& data, Random& random) {
  Pose pose = Pose::Identity();
  pose.rotate(Eigen::AngleAxisd(6.3 * random.unit(), any_point(random, -1, 1).normalized()));
  pose.pretranslate(any_point(random, -1, 1));
  add(data, scenes::rectangle({-3, -3, 0}, {6, 0, 0}, {0, 6, 0}), "ground", pose);
  const std::uint64_t n = 1 + random.below(5);
  for (std::uint64_t k = 0; k < n; ++k) {
    const Vec3 lo = any_point(random, -2, 1);
    double z = 0;
    const std::uint64_t high = 1 + random.below(3);
    for (std::uint64_t i = 0; i < high; ++i) {
      const double top = z + 0.2 + 0.5 * random.unit();
      const double inset = 0.1 * static_cast<double>(i * random.below(2));
      add(data,
          scenes::box({lo.x() + inset, lo.y() + inset, z},
                      {lo.x() + 1 - inset, lo.y() + 0.8 - inset, top}),
          "box", pose);
      z = top;
    }
  }
}

// A comb, a ring and a star, in whole coordinates.
Mesh outline(Random& random) {
  Mesh mesh;
  const auto vertices = [&](std::initializer_list<std::array<int, 2>> list) {
    for (const auto& p : list) mesh.vertices.emplace_back(p[0], p[1], 0);
  };
  switch (random.below(4)) {
    case 0:
      vertices({{0, 0},
                {5, 0},
                {5, 3},
                {4, 3},
                {4, 1},
                {3, 1},
                {3, 3},
                {2, 3},
                {2, 1},
                {1, 1},
                {1, 3},
                {0, 3}});
      mesh.add_face({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
      break;
    case 1: {
      vertices({{0, 0}, {4, 0}, {4, 4}, {0, 4}, {1, 1}, {3, 1}, {3, 3}, {1, 3}});
      mesh.add_face({0, 1, 2, 3});
      constexpr std::array<std::uint32_t, 4> hole{4, 7, 6, 5};
      mesh.add_hole(hole);
      break;
    }
    case 2: {
      vertices(
          {{0, 0}, {6, 0}, {6, 4}, {3, 5}, {0, 4}, {1, 1}, {2, 2}, {1, 3}, {4, 1}, {5, 1}, {5, 3}});
      mesh.add_face({0, 1, 2, 3, 4});
      constexpr std::array<std::uint32_t, 3> left{5, 6, 7}, right{8, 9, 10};
      mesh.add_hole(left);
      mesh.add_hole(right);
      break;
    }
    default:
      vertices({{0, 3}, {-1, 1}, {-3, 0}, {-1, -1}, {0, -3}, {1, -1}, {3, 0}, {1, 1}});
      mesh.add_face({0, 1, 2, 3, 4, 5, 6, 7});
  }
  return mesh;
}

void add_outlines(SceneData& data, Random& random) {
  add_ground(data, 8);
  const std::uint64_t n = 1 + random.below(4);
  for (std::uint64_t k = 0; k < n; ++k) {
    Pose pose = Pose::Identity();
    const Vec3 u = any_point(random, -1, 1), v = any_point(random, -1, 1);
    if (random.below(3) == 0) pose.linear() << 1, 0, 0, 0, 1, 0, 0, 0, 1;
    else pose.linear() << u, v, u.cross(v);
    if (std::abs(pose.linear().determinant()) < 0.05) continue;
    pose.translation() = any_point(random, -2, 2) + Vec3(0, 0, 3);
    add(data, outline(random), "outline", pose);
  }
}

// Tiles of one plane spanned by whole vectors; posters lie upon them, a fence of upright faces
// stands on their edges.
void add_tiles(SceneData& data, Random& random) {
  const Vec3 u = grid_point(random, -2, 2), v = grid_point(random, -2, 2);
  if (u.cross(v).norm() < 0.5) return add_grid_soup(data, random);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) add(data, scenes::rectangle(i * u + j * v, u, v), "tile");
  for (std::uint64_t k = random.below(3); k > 0; --k) {
    const Vec3 at = (0.5 * whole(random, 0, 3)) * u + (0.5 * whole(random, 0, 3)) * v;
    add(data, scenes::rectangle(at, random.below(2) == 0 ? u : Vec3(1.5 * u), v), "poster");
  }
  const Vec3 up = grid_point(random, -2, 2);
  if (std::abs(up.dot(u.cross(v))) < 0.5) return;
  for (std::uint64_t k = random.below(3); k > 0; --k)
    add(data, scenes::rectangle(whole(random, 0, 2) * u, v, up), "fence");
}

void add_room(SceneData& data, Random& random) {
  Mesh shell;
  const Mesh box = scenes::box({0, 0, 0}, {6, 5, 3});
  shell.vertices = box.vertices;
  for (std::size_t f = 0; f < box.face_count(); ++f) {
    const auto loop = box.loop(f, 0);
    shell.add_face(std::vector<std::uint32_t>(loop.rbegin(), loop.rend()));
  }
  add(data, shell, "room");
  const std::uint64_t n = 1 + random.below(5);
  for (std::uint64_t k = 0; k < n; ++k) {
    const double x = 0.1 * whole(random, 0, 40), y = 0.1 * whole(random, 0, 30);
    const double w = 0.1 * whole(random, 1, 20), d = 0.1 * whole(random, 1, 20),
                 h = 0.1 * whole(random, 1, 15);
    add(data, scenes::box({x, y, 0}, {x + w, y + d, h}), "desk");
    if (random.below(2) == 0)
      add(data, scenes::box({x, y, h}, {x + w / 2, y + d / 2, h + 0.3}), "thing");
  }
}

}  // namespace

const char* name_of(Kind kind) {
  constexpr std::array<const char*, 8> names{"soup",         "grid_soup", "solids", "grid_boxes",
                                             "turned_boxes", "outlines",  "tiles",  "room"};
  return names[static_cast<std::size_t>(kind)];
}

void PrintTo(Kind kind, std::ostream* out) { *out << name_of(kind); }

Light random_light(Kind kind, Random& random) {
  const bool sun = random.below(3) == 0;
  switch (kind) {
    case Kind::grid_soup:
    case Kind::grid_boxes:
    case Kind::tiles: {
      if (sun) {
        Vec3 direction = grid_point(random, -2, 2);
        if (direction.isZero()) direction = -Vec3::UnitZ();
        return Light::directional(direction);
      }
      // Half the lights stand among the faces, and often in their planes.
      const Vec3 at = random.below(2) == 0 ? grid_point(random, 0, 4) : grid_point(random, -2, 9);
      return Light::point(random.below(3) == 0 ? Vec3(at + Vec3(0.5, 0.25, 0.5)) : at);
    }
    case Kind::room:
      return Light::point(Vec3(3, 2.5, 2.5) + Vec3(any_point(random, -0.4, 0.4)));
    default: {
      if (sun) return Light::directional(any_point(random, -1, 1) - Vec3(0, 0, 1.2));
      return Light::point(random.below(4) == 0 ? any_point(random, -1, 1) + Vec3(0, 0, 1)
                                               : any_point(random, -3, 3) + Vec3(0, 0, 7));
    }
  }
}

SceneData random_scene(Kind kind, std::uint64_t seed) {
  SceneData data;
  data.name = std::string(name_of(kind)) + ", seed " + std::to_string(seed);
  Random random(seed * 8 + static_cast<std::uint64_t>(kind));
  switch (kind) {
    case Kind::soup:
      add_soup(data, random);
      break;
    case Kind::grid_soup:
      add_grid_soup(data, random);
      break;
    case Kind::solids:
      add_solids(data, random);
      break;
    case Kind::grid_boxes:
      add_grid_boxes(data, random);
      break;
    case Kind::turned_boxes:
      add_turned_boxes(data, random);
      break;
    case Kind::outlines:
      add_outlines(data, random);
      break;
    case Kind::tiles:
      add_tiles(data, random);
      break;
    case Kind::room:
      add_room(data, random);
      break;
  }
  data.light = random_light(kind, random);
  return data;
}

SceneData scaled(const SceneData& data, double factor, const Vec3& shift) {
  SceneData out = data;
  for (auto& object : out.objects)
    object.second.pose = Eigen::Translation3d(shift) * Eigen::Scaling(factor) * object.second.pose;
  if (out.light.kind == Light::Kind::point)
    out.light.position = factor * out.light.position + shift;
  return out;
}

}  // namespace shadowcut::testing
