// Pictures of every technique against one made by a ray for every pixel, in doubles and without a
// tree: they differ only within a pixel of the edge of a face or a shadow. And, named for what is
// wrong, the cases in which a published method is wrong by design.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "offscreen.hpp"
#include "random_scenes.hpp"
#include "technique.hpp"
#include "text.hpp"

namespace shadowcut::testing {
namespace {

using render::Camera;
using render::Frame;
using render::Picture;
using scenes::SceneData;

constexpr int width = 200, height = 150;

// A facet as seen from one point, or along one direction: the planes through its edges, and its
// own.
struct Seen {
  std::uint32_t facet;
  std::vector<Vec3> sides;  // positive inside
  Vec3 normal;
  double offset;
};

// The facets of one object, and a ball around it: most rays pass by most objects.
struct Group {
  std::size_t first, end;
  Vec3 centre;
  double radius;
  bool near_line(const Vec3& x, const Vec3& along) const {
    return (centre - x).cross(along).squaredNorm() <=
           1.0001 * radius * radius * along.squaredNorm();
  }
};

struct SeenFacets {
  std::vector<Seen> facets;
  std::vector<Group> groups;

  // visit(seen) for those whose object may be met by the line.
  template <class Visit>
  void near_line(const Vec3& x, const Vec3& along, const Visit& visit) const {
    for (const Group& group : groups) {
      if (!group.near_line(x, along)) continue;
      for (std::size_t i = group.first; i < group.end; ++i) visit(facets[i]);
    }
  }
};

std::vector<Seen> facets_seen_from(const Scene& scene, const Light& viewer, bool casting) {
  std::vector<Seen> all;
  for (std::uint32_t f = 0; f < scene.facets().size(); ++f) {
    const Object& object = scene.objects()[scene.faces()[scene.facets()[f].face].object];
    const Plane& plane = scene.planes()[scene.facets()[f].plane];
    const auto ray = [&](const Vec3& x) {
      return viewer.kind == Light::Kind::point ? Vec3(x - viewer.at) : viewer.at;
    };
    const double away = plane.normal.dot(ray(plane.point));
    if (casting && (!object.casts || away == 0 || (away > 0 && object.sides == Sides::closed)))
      continue;
    Seen seen{f, {}, plane.normal, plane.normal.dot(plane.point)};
    const auto corners = scene.corners_of(scene.facets()[f]);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec3 &a = scene.vertices()[corners[i].vertex],
                 &b = scene.vertices()[corners[(i + 1) % corners.size()].vertex];
      seen.sides.push_back(((b - a).cross(ray(a))) * (away > 0 ? -1 : 1));
    }
    all.push_back(std::move(seen));
  }
  return all;
}

SeenFacets seen_from(const Scene& scene, const Light& viewer, bool casting) {
  SeenFacets seen{facets_seen_from(scene, viewer, casting), {}};
  const auto object_of = [&](std::size_t i) {
    return scene.faces()[scene.facets()[seen.facets[i].facet].face].object;
  };
  for (std::size_t first = 0, end = 0; first < seen.facets.size(); first = end) {
    Eigen::AlignedBox3d box;
    for (; end < seen.facets.size() && object_of(end) == object_of(first); ++end)
      for (const Corner& corner : scene.corners_of(scene.facets()[seen.facets[end].facet]))
        box.extend(scene.vertices()[corner.vertex]);
    seen.groups.push_back({first, end, box.center(), box.diagonal().norm() / 2});
  }
  return seen;
}

// Whether the ray from the viewer passes through the facet; for a direction, the line through x.
bool through(const Seen& seen, const Scene& scene, const Light& viewer, const Vec3& x) {
  const auto corners = scene.corners_of(scene.facets()[seen.facet]);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 from =
        viewer.kind == Light::Kind::point ? viewer.at : scene.vertices()[corners[i].vertex];
    if (seen.sides[i].dot(x - from) <= 0) return false;
  }
  return true;
}

struct Pixel {
  std::uint32_t facet = none;
  bool ambiguous = false;  // two facets at one place
  std::vector<bool> lit;
  std::array<double, 3> colour{255, 255, 255};
  Vec3 place = Vec3::Zero();  // where it is on the facet
};

class RayPicture {
 public:
  RayPicture(const Scene& scene, const Camera& camera)
      : scene_(scene),
        camera_(camera),
        eye_(Light::point(camera.eye)),
        faces_(seen_from(scene, eye_, false)) {
    for (const Light& light : scene.lights()) casters_.push_back(seen_from(scene, light, true));
    const Pose world = camera.view().inverse(Eigen::Isometry);
    const double high = std::tan(camera.fov / 2), wide = high * width / height;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        pixels_.push_back(look(world.linear() * Vec3(wide * (2 * (x + 0.5) / width - 1),
                                                     high * (1 - 2 * (y + 0.5) / height), -1)));
    for (const Seen& seen : faces_.facets) mark_if_thin(seen.facet);
  }

  const Pixel& at(int x, int y) const { return pixels_[static_cast<std::size_t>(y * width + x)]; }

  // Whether another face, or another shadow, comes within a pixel; a shadow, within `reach` pixels.
  bool at_an_edge(int x, int y, int reach = 1) const {
    for (int j = std::max(y - reach, 0); j <= std::min(y + reach, height - 1); ++j) {
      for (int i = std::max(x - reach, 0); i <= std::min(x + reach, width - 1); ++i) {
        const bool near = std::abs(i - x) <= 1 && std::abs(j - y) <= 1;
        if (at(i, j).lit != at(x, y).lit ||
            (near && (at(i, j).facet != at(x, y).facet || at(i, j).ambiguous)))
          return true;
      }
    }
    return false;
  }

  // Pixels that a texel of a light's view of that many pixels a side may cover, from its middle on,
  // and one more. Where light grazes a face a texel is drawn out; beyond twenty times its width (3
  // degrees) such views say nothing, and no pixel is near enough to count.
  int reach_of_texels(int x, int y, int side) const {
    const Pixel& pixel = at(x, y);
    if (pixel.facet == none) return 1;
    const double size = 2 * std::tan(camera_.fov / 2) / height * (pixel.place - camera_.eye).norm();
    double reach = 0;
    for (const Light& light : scene_.lights()) {
      const Vec3 to_light = light.at - pixel.place;
      const double slant =
          std::abs(scene_.planes()[scene_.facets()[pixel.facet].plane].normal.dot(to_light)) /
          to_light.norm();
      reach = std::max(
          reach, slant < 0.05 ? width : 2 * std::sqrt(3.0) / side * to_light.norm() / slant / size);
    }
    return static_cast<int>(std::min<double>(width, std::ceil(reach))) + 1;
  }

  bool in_shadow(const Vec3& x) const {
    for (std::size_t k = 0; k < scene_.lights().size(); ++k)
      if (shadowed(k, none, x)) return true;
    return false;
  }

 private:
  Pixel look(const Vec3& ray) const {
    Pixel pixel;
    double nearest = std::numeric_limits<double>::infinity(), second = nearest;
    const Vec3 ahead = camera_.eye + ray;
    faces_.near_line(camera_.eye, ray, [&](const Seen& seen) {
      const double t = (seen.offset - seen.normal.dot(camera_.eye)) / seen.normal.dot(ray);
      if (!(t > 0) || t >= second || !through(seen, scene_, eye_, ahead)) return;
      second = t;
      if (t < nearest) second = nearest, nearest = t, pixel.facet = seen.facet;
    });
    if (pixel.facet == none) return pixel;
    pixel.ambiguous = second < nearest * 1.001;
    pixel.place = camera_.eye + nearest * ray;
    shade(pixel, pixel.place);
    return pixel;
  }

  // Where two edges of a facet are within a pixel it may lie between all pixels' middles: at its
  // corners, and where it is seen edge-on.
  void mark_if_thin(std::uint32_t facet) {
    const Pose view = camera_.view();
    const double pixel = 2 * std::tan(camera_.fov / 2) / height;
    std::vector<Eigen::Vector2d> outline;
    for (const Corner& corner : scene_.corners_of(scene_.facets()[facet])) {
      const Vec3 p = view * scene_.vertices()[corner.vertex];
      if (p.z() >= -1e-3) return;
      outline.emplace_back(width / 2.0 - p.x() / p.z() / pixel,
                           height / 2.0 + p.y() / p.z() / pixel);
    }
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& p : outline) box.extend(p);
    const auto whole = [](double v, int end) {
      return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(end)));
    };
    for (int y = whole(box.min().y() - 2, height); y < whole(box.max().y() + 2, height); ++y)
      for (int x = whole(box.min().x() - 2, width); x < whole(box.max().x() + 2, width); ++x)
        if (edges_near(outline, {x + 0.5, y + 0.5}) >= 2)
          pixels_[static_cast<std::size_t>(y * width + x)].ambiguous = true;
  }

  static int edges_near(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& p) {
    int near = 0;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Eigen::Vector2d &a = outline[i], d = outline[(i + 1) % outline.size()] - a;
      const double t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-12), 0.0, 1.0);
      near += (a + t * d - p).norm() < 1 ? 1 : 0;
    }
    return near;
  }

  void shade(Pixel& pixel, const Vec3& x) const {
    const Object& object =
        scene_.objects()[scene_.faces()[scene_.facets()[pixel.facet].face].object];
    const Vec3& normal = scene_.planes()[scene_.facets()[pixel.facet].plane].normal;
    double brightness = render::ambient_share;
    for (std::size_t k = 0; k < scene_.lights().size(); ++k) {
      const Light& light = scene_.lights()[k];
      const Vec3 to_light = light.kind == Light::Kind::point ? Vec3(light.at - x) : Vec3(-light.at);
      const double facing = normal.dot(to_light);
      const bool seen =
          facing * normal.dot(camera_.eye - x) > 0 && (object.sides == Sides::open || facing > 0);
      pixel.lit.push_back(seen && !shadowed(k, pixel.facet, x));
      if (pixel.lit.back())
        brightness += (1 - render::ambient_share) / static_cast<double>(scene_.lights().size()) *
                      (0.4 + 0.6 * std::abs(facing) / to_light.norm());
    }
    for (std::size_t c = 0; c < 3; ++c) pixel.colour[c] = render::colour_of(object)[c] * brightness;
  }

  bool shadowed(std::size_t k, std::uint32_t facet, const Vec3& x) const {
    const Light& light = scene_.lights()[k];
    const double contact = 1e-9 * (x.norm() + 1);
    bool some = false;
    casters_[k].near_line(x, light.kind == Light::Kind::point ? Vec3(light.at - x) : light.at,
                          [&](const Seen& caster) {
                            if (some || caster.facet == facet ||
                                (facet != none && scene_.facets()[caster.facet].plane ==
                                                      scene_.facets()[facet].plane))
                              return;
                            const double here = caster.normal.dot(x) - caster.offset;
                            const double there = light.kind == Light::Kind::point
                                                     ? caster.normal.dot(light.at) - caster.offset
                                                     : -caster.normal.dot(light.at);
                            some = std::abs(here) > contact && here * there < 0 &&
                                   through(caster, scene_, light, x);
                          });
    return some;
  }

  const Scene& scene_;
  Camera camera_;
  Light eye_;
  SeenFacets faces_;
  std::vector<SeenFacets> casters_;
  std::vector<Pixel> pixels_;
};

// One for all tests, from the first that draws.
void need_context() { static const render::OffscreenContext context; }

Picture picture_of(const Scene& scene, const std::string& technique, const Camera& camera) {
  need_context();
  const render::Target target(width, height);
  const render::Model model(scene);
  const auto t = render::make_technique(technique, scene, model);
  target.bind();
  render::draw(model.frame(camera, width, height), scene, model, *t);
  return target.read();
}

// Shadow maps and shadow textures show no more than their texels do.
constexpr int map_side = render::MapSettings{}.side;
bool has_texels(const std::string& technique) {
  return technique == "shadow-map" || technique == "shadow-texture";
}

struct Difference {
  int pixels = 0, covered = 0;
  std::string first;
};

// Pixels away from edges that are not as the rays have them.
Difference difference(const Picture& picture, const RayPicture& rays, bool texels = false) {
  Difference d;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (rays.at_an_edge(x, y) ||
          (texels && rays.at_an_edge(x, y, rays.reach_of_texels(x, y, map_side))))
        continue;
      ++d.covered;
      const Pixel& want = rays.at(x, y);
      double off = 0;
      for (std::size_t c = 0; c < 3; ++c)
        off = std::max(off, std::abs(want.colour[c] - picture.at(x, y)[c]));
      if (off <= 3) continue;
      if (d.pixels++ == 0)
        d.first =
            text("pixel ", x, ", ", y, " of facet ", want.facet, ": ", int{picture.at(x, y)[0]},
                 " ", int{picture.at(x, y)[1]}, " ", int{picture.at(x, y)[2]}, ", should be ",
                 want.colour[0], " ", want.colour[1], " ", want.colour[2]);
    }
  }
  return d;
}

struct Shot {
  std::string name;
  SceneData data;
  Camera camera;
  bool in_shadow = false;  // the camera is within a shadow volume
};

Camera looking(const Vec3& eye, const Vec3& target) { return {eye, target, 1.0, Vec3::UnitZ()}; }

SceneData with_sun(SceneData data, const Vec3& travel) {
  data.light = Light::directional(travel);
  return data;
}

std::vector<Shot> shots() {
  return {
      {"tetrahedron", scenes::tetrahedron(2), looking({3, -4, 3}, {0, 0, 0.4})},
      {"tetrahedron, from its shadow", scenes::tetrahedron(2),
       looking({-0.9, 0.3, 0.05}, {3, 1, 0.3}), true},
      {"room", scenes::room(1), looking({0.4, 0.4, 2.3}, {5, 4, 0.3})},
      {"room, under the desk", scenes::room(1), looking({1.2, 0.5, 0.4}, {4, 3, 0.8}), true},
      {"city", scenes::city(6), looking({-3, -5, 6}, {4, 4, 0})},
      {"city, from a street", scenes::city(6), looking({0.9, -0.4, 0.35}, {4, 6, 0.7})},
      {"city under a sun", with_sun(scenes::city(5), {1, 2, -2}), looking({9, -3, 5}, {3, 4, 0})},
      {"spheres", scenes::spheres(5, 16, 9), looking({4, -5, 4}, {0, 0, 1})},
      {"twig", scenes::branch(2), looking({2.2, -2.4, 1.6}, {0, 0, 0.9})},
      {"triangles", scenes::triangles(30), looking({2.2, -1.8, 1.9}, {0.5, 0.5, 0.4})},
  };
}

// Above a place on the ground, on its way to the light.
Vec3 raised(const Scene& scene, const Vec3& place) {
  return place + 0.1 * (scene.lights()[0].at - place);
}

bool on_ground(const Scene& scene, const Pixel& pixel) {
  return pixel.facet != none && scene.faces()[scene.facets()[pixel.facet].face].object == 0;
}

// Within a shadow that is seen on the ground, as far from its edge as there is any.
Vec3 some_place_in_shadow(const Scene& scene, const RayPicture& seen) {
  for (const int reach : {8, 4, 2, 1}) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const Pixel& pixel = seen.at(x, y);
        if (on_ground(scene, pixel) && !pixel.lit[0] && !seen.at_an_edge(x, y, reach) &&
            seen.in_shadow(raised(scene, pixel.place)))
          return raised(scene, pixel.place);
      }
  }
  throw Error("no shadow is seen");
}

// On the boundary of a shadow's volume.
Vec3 some_place_at_an_edge(const Scene& scene, const RayPicture& seen) {
  for (int y = 0; y < height; ++y)
    for (int x = 0; x + 1 < width; ++x) {
      if (!on_ground(scene, seen.at(x, y)) || !on_ground(scene, seen.at(x + 1, y))) continue;
      Vec3 a = raised(scene, seen.at(x, y).place), b = raised(scene, seen.at(x + 1, y).place);
      const bool dark = seen.in_shadow(a);
      if (dark == seen.in_shadow(b)) continue;
      for (int k = 0; k < 50; ++k) {
        const Vec3 middle = (a + b) / 2;
        (seen.in_shadow(middle) == dark ? a : b) = middle;
      }
      return a;
    }
  throw Error("no shadow is seen");
}

// The papers' scenes, each from three cameras: out of all shadow; in a shadow's volume; and with a
// volume's side across the near plane's window. The last two are where standard and Kolic are wrong
// (below).
void paper_scene(const std::string& name, const Camera& outside) {
  const Scene scene = scenes::build(scenes::named(name));
  const RayPicture rays(scene, outside);
  ASSERT_FALSE(rays.in_shadow(outside.eye));
  const Vec3 within = some_place_in_shadow(scene, rays), edge = some_place_at_an_edge(scene, rays);
  need_context();
  const double near = render::Model(scene).frame(outside, width, height).near;
  const std::vector<std::pair<std::string, Camera>> cameras{
      {"outside", outside},
      {"in a volume", looking(within, outside.target)},
      {"near plane cuts",
       looking(edge - near * (outside.target - edge).normalized(), outside.target)}};
  for (const auto& [where, camera] : cameras) {
    const RayPicture here(scene, camera);
    if (where == "in a volume") {
      EXPECT_TRUE(here.in_shadow(camera.eye));
    }
    for (const std::string& technique : render::technique_names()) {
      const bool from_light_only = technique == "stencil-standard" || technique == "stencil-kolic";
      if (from_light_only && where != "outside") continue;
      const Difference d =
          difference(picture_of(scene, technique, camera), here, has_texels(technique));
      EXPECT_EQ(d.pixels, 0) << name << ", " << where << ", " << technique << ": " << d.pixels
                             << " of " << d.covered << " pixels differ; " << d.first;
    }
  }
}

TEST(Render, PaperSceneSphere) { paper_scene("sphere256", looking({3.6, -4.4, 3.6}, {0, 0, 0.5})); }
TEST(Render, PaperSceneSolids) { paper_scene("solids96", looking({3.6, -4.4, 3.6}, {0, 0, 0.5})); }
TEST(Render, PaperSceneTetrahedra1) {
  paper_scene("tetrahedra752:1", looking({1.6, -2, 1.6}, {0, 0, 0.2}));
}
TEST(Render, PaperSceneTetrahedra2) {
  paper_scene("tetrahedra752:2", looking({0.9, -1.1, 1.8}, {0, 0, 1.1}));
}
TEST(Render, PaperSceneCubes) { paper_scene("cubes1502", looking({6, -6.4, 5.6}, {0, 0, 1.5})); }
TEST(Render, PaperSceneBranch) {
  paper_scene("branch2878", looking({2.2, -2.4, 2.6}, {0, 0, 0.9}));
}
TEST(Render, PaperSceneFiveSpheres) {
  paper_scene("spheres2037:5", looking({5, -3, 4}, {2, 1.7, 1.2}));
}
// All of their spheres take minutes.
void in_a_soak(const std::string& name, const Camera& outside) {
  if (std::getenv("SHADOWCUT_SOAK") == nullptr) GTEST_SKIP() << "runs where SHADOWCUT_SOAK is set";
  paper_scene(name, outside);
}
TEST(Render, PaperScene100Spheres) {
  in_a_soak("spheres2037:100", looking({13, -4, 9}, {5, 4, 3}));
}
TEST(Render, PaperScene300Spheres) {
  in_a_soak("spheres2037:300", looking({19, -5, 12}, {7, 6, 4}));
}

// A branch that the wind bends in the vertex shader, as rays see the same branch bent on the
// processor; and as it does not stand still.
TEST(Render, KolicsShadowsFollowTheWind) {
  scenes::SceneData data = scenes::named("branch2878");
  const Scene still = scenes::build(data);
  const render::Wind wind{{0.15f, -0.1f, 0}, 0};
  for (auto& [mesh, settings] : data.objects)
    for (Vec3& v : mesh.vertices) v += wind.sway.cast<double>() * std::pow(std::max(v.z(), 0.0), 2);
  const Scene bent = scenes::build(data);
  const Camera camera = looking({2.2, -2.4, 2.6}, {0.3, -0.2, 0.9});
  const RayPicture rays(bent, camera);
  need_context();
  const render::Target target(width, height);
  render::Model model(still);
  model.set_wind(wind);
  for (const std::string technique : {"stencil-kolic", "shadow-map"}) {
    const auto t = render::make_technique(technique, still, model);
    target.bind();
    render::draw(model.frame(camera, width, height), still, model, *t);
    const Difference d = difference(target.read(), rays, has_texels(technique));
    EXPECT_EQ(d.pixels, 0) << technique << ": " << d.pixels << " of " << d.covered
                           << " pixels differ; " << d.first;
    EXPECT_GT(difference(picture_of(still, technique, camera), rays, has_texels(technique)).pixels,
              200);
  }
  const auto fragments = render::make_technique("fragments", still, model);
  EXPECT_THROW(render::draw(model.frame(camera, width, height), still, model, *fragments), Error);
}

// Faces in one plane share pixels, and are lit once.
TEST(Render, OnePlaneIsLitOnce) {
  Scene scene;
  scene.add(scenes::rectangle({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}), {.name = "floor"});
  scene.add(scenes::rectangle({-1, -1, 0}, {2, 0.5, 0}, {-0.5, 2, 0}), {.name = "rug"});
  scene.add(Light::point({0.3, 0.2, 3}));
  for (const std::string& technique : render::technique_names()) {
    const Picture picture = picture_of(scene, technique, looking({0.5, -4, 2}, {0, 0, 0}));
    int brightest = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        if (picture.at(x, y)[0] < 255 || picture.at(x, y)[1] < 255)
          brightest = std::max({brightest, int{picture.at(x, y)[0]}, int{picture.at(x, y)[1]},
                                int{picture.at(x, y)[2]}});
    EXPECT_LE(brightest, 248) << technique;  // a colour is no brighter than 247
  }
}

// No driver here can be made to lose a context; this says what OpenGL says once it has.
TEST(Render, ALostContextIsSaid) {
  need_context();
  const render::Target target(4, 4);
  const auto real = epoxy_glGetError;
  epoxy_glGetError = []() -> GLenum { return GL_CONTEXT_LOST; };
  std::string said;
  try {
    target.read();
  } catch (const Error& error) {
    said = error.what();
  }
  epoxy_glGetError = real;
  EXPECT_EQ(said, "OpenGL: reading the picture: the context was lost (error 1287)");
}

TEST(Render, MapsHaveSizesTheDriverHas) {
  const Scene scene = scenes::build(scenes::room(1));
  need_context();
  const render::Model model(scene);
  for (const int side : {0, -4, 1 << 24}) {
    EXPECT_THROW(render::make_technique("shadow-map", scene, model, {.side = side}), Error);
    EXPECT_THROW(render::make_technique("shadow-texture", scene, model, {.side = side}), Error);
  }
}

// The near plane is not far from the camera: one that is out of all shadow may still cut a volume
// with it.
TEST(Render, EveryTechniqueDrawsWhatRaysSee) {
  for (const Shot& shot : shots()) {
    const Scene scene = scenes::build(shot.data);
    const RayPicture rays(scene, shot.camera);
    for (const std::string technique : {"fragments", "stencil-zfail", "stencil-hybrid",
                                        "shadow-map", "stencil-standard", "stencil-kolic"}) {
      // below
      if (shot.in_shadow && (technique == "stencil-standard" || technique == "stencil-kolic"))
        continue;
      const Difference d = difference(picture_of(scene, technique, shot.camera), rays);
      EXPECT_GT(d.covered, width * height / 5) << shot.name;
      // Kolic's count of a pixel on an edge of a volume may stay half done, and the next volume
      // before it then makes a shadow of it.
      EXPECT_LE(d.pixels, technique == "stencil-kolic" ? 2 : 0)
          << shot.name << ", " << technique << ": " << d.pixels << " of " << d.covered
          << " pixels differ; " << d.first;
    }
  }
}

TEST(Render, SeveralLights) {
  SceneData data = scenes::city(4);
  Scene scene = scenes::build(data);
  scene.add(Light::point({-1, 3, 3.5}));
  scene.add(Light::directional({-1, 1, -1.5}));
  const Camera camera = looking({-4, -5, 5}, {2, 2, 0});
  const RayPicture rays(scene, camera);
  for (const std::string technique : {"fragments", "stencil-zfail", "stencil-hybrid",
                                      "stencil-standard", "stencil-kolic", "shadow-map"}) {
    const Difference d = difference(picture_of(scene, technique, camera), rays);
    EXPECT_EQ(d.pixels, 0) << technique << ": " << d.pixels << " of " << d.covered
                           << " pixels differ; " << d.first;
  }
}

// Counting what passes begins at the near plane, and takes the camera to be in the light.
TEST(Render, StandardIsWrongWhereTheCameraIsInShadow) {
  for (const Shot& shot : shots()) {
    if (!shot.in_shadow) continue;
    const Scene scene = scenes::build(shot.data);
    EXPECT_GT(difference(picture_of(scene, "stencil-standard", shot.camera),
                         RayPicture(scene, shot.camera))
                  .pixels,
              1000)
        << shot.name;
  }
}

// Of a volume around the camera one side is seen, not two, and a pass or a failure alone is not a
// shadow.
TEST(Render, KolicIsWrongWhereTheCameraIsInAVolume) {
  const Shot shot = shots()[1];
  const Scene scene = scenes::build(shot.data);
  EXPECT_GT(
      difference(picture_of(scene, "stencil-kolic", shot.camera), RayPicture(scene, shot.camera))
          .pixels,
      1000);
}

// Objects that do not cast, or do not receive.
TEST(Render, OnlySomeCastAndReceive) {
  SceneData data = scenes::city(3);
  for (std::size_t i = 0; i < data.objects.size(); ++i) data.objects[i].second.casts = i % 3 != 1;
  const Scene scene = scenes::build(data);
  const Camera camera = looking({-3, -4, 4}, {1.5, 1.5, 0});
  const RayPicture rays(scene, camera);
  for (const std::string technique : {"fragments", "stencil-zfail", "stencil-hybrid",
                                      "stencil-standard", "stencil-kolic", "shadow-map"})
    EXPECT_EQ(difference(picture_of(scene, technique, camera), rays).pixels, 0) << technique;
}

// The fragments' buffers are brought up to date by what an update hands out.
TEST(Render, FragmentsFollowEdits) {
  Scene scene = scenes::build(scenes::room(1));
  const Camera camera = looking({0.4, 0.4, 2.3}, {5, 4, 0.3});
  need_context();
  const render::Target target(width, height);
  render::Model model(scene);
  const auto technique = render::make_technique("fragments", scene, model);
  scenes::Random random(5);
  for (int k = 0; k < 25; ++k) {
    const ObjectId id = scene.object_id(2 + random.below(scene.objects().size() - 2));
    const Pose pose =
        Eigen::Translation3d(random.in(-0.3, 0.3), random.in(-0.3, 0.3), random.in(0, 0.2)) *
        scene.find(id)->pose;
    ASSERT_EQ(scene.set_pose(id, pose), Edit::done);
    model.scene_changed(scene);
    target.bind();
    render::draw(model.frame(camera, width, height), scene, model, *technique);
    const Difference d = difference(target.read(), RayPicture(scene, camera));
    ASSERT_EQ(d.pixels, 0) << "move " << k << ": " << d.pixels << " pixels differ; " << d.first;
  }
}

TEST(Render, RefusesWhatItCannotDraw) {
  const Scene scene = scenes::build(scenes::room(1));
  need_context();
  const render::Model model(scene);
  EXPECT_THROW(render::make_technique("raytracing", scene, model), Error);
  EXPECT_THROW(render::Target(0, 100), Error);
  EXPECT_THROW(render::Target(100, -1), Error);
  EXPECT_THROW(render::Target(1 << 24, 1), Error);
  EXPECT_THROW(model.frame(looking({1, 1, 1}, {1, 1, 1}), 10, 10), Error);
  EXPECT_THROW(render::write_png("/no/such/folder/a.png", {1, 1, {0, 0, 0, 0}}), Error);
}

}  // namespace
}  // namespace shadowcut::testing
