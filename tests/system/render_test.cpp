// Pictures of every technique against one made by a ray for every pixel: they differ only within a
// pixel of the edge of a face or a shadow. And, named for what is wrong, the cases in which a
// published method is wrong by design.
#include <gtest/gtest.h>

#include <cmath>

#include "offscreen.hpp"
#include "ray_picture.hpp"
#include "technique.hpp"

namespace shadowcut::testing {
namespace {

using scenes::SceneData;

struct Shot {
  std::string name;
  SceneData data;
  Camera camera;
  bool in_shadow = false;  // the camera is within a shadow volume
};

SceneData with_sun(SceneData data, const Vec3& direction) {
  data.light = Light::directional(direction);
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
  const render::Target target(kWidth, kHeight);
  render::Model model(still);
  model.set_wind(wind);
  for (const std::string technique : {"stencil-kolic", "shadow-map"}) {
    const auto t = render::make_technique(technique, still, model);
    target.bind();
    render::draw(model.frame(camera, kWidth, kHeight), still, model, *t);
    const Difference d = difference(target.read(), rays, has_texels(technique));
    EXPECT_EQ(d.pixels, 0) << technique << ": " << d.pixels << " of " << d.covered
                           << " pixels differ; " << d.first;
    EXPECT_GT(difference(picture_of(still, technique, camera), rays, has_texels(technique)).pixels,
              200);
  }
  const auto fragments = render::make_technique("fragments", still, model);
  EXPECT_THROW(render::draw(model.frame(camera, kWidth, kHeight), still, model, *fragments), Error);
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
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
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
      EXPECT_GT(d.covered, kWidth * kHeight / 5) << shot.name;
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
  for (std::size_t i = 0; i < data.objects.size(); ++i)
    data.objects[i].second.casts_shadows = i % 3 != 1;
  const Scene scene = scenes::build(data);
  const Camera camera = looking({-3, -4, 4}, {1.5, 1.5, 0});
  const RayPicture rays(scene, camera);
  for (const std::string technique : {"fragments", "stencil-zfail", "stencil-hybrid",
                                      "stencil-standard", "stencil-kolic", "shadow-map"})
    EXPECT_EQ(difference(picture_of(scene, technique, camera), rays).pixels, 0) << technique;
}

// The fragments' buffers are brought up to date by what an update emits.
TEST(Render, FragmentsFollowEdits) {
  Scene scene = scenes::build(scenes::room(1));
  const Camera camera = looking({0.4, 0.4, 2.3}, {5, 4, 0.3});
  need_context();
  const render::Target target(kWidth, kHeight);
  render::Model model(scene);
  const auto technique = render::make_technique("fragments", scene, model);
  scenes::Random random(5);
  for (int k = 0; k < 25; ++k) {
    const ObjectId id = scene.object_id(2 + random.below(scene.objects().size() - 2));
    const Pose pose =
        Eigen::Translation3d(random.in(-0.3, 0.3), random.in(-0.3, 0.3), random.in(0, 0.2)) *
        scene.find(id)->pose;
    ASSERT_EQ(scene.set_pose(id, pose), Status::ok);
    model.scene_changed(scene);
    target.bind();
    render::draw(model.frame(camera, kWidth, kHeight), scene, model, *technique);
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
