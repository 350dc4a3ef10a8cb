// The SZ-buffer and the shadow textures of Oh & Shin: what is kept from frame to frame is what is
// made from nothing, to the bit; the method that they compare with makes the same textures; and the
// picture is that of exact shadow volumes, but for the textures' resolution.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "offscreen.hpp"
#include "scenes.hpp"
#include "shadow_texture.hpp"
#include "text.hpp"

namespace shadowcut::testing {
namespace {

using render::Model;
using render::Picture;
using render::ShadowTexture;
using scenes::Random;

using Method = ShadowTexture::Method;
constexpr int kSmallSide = 96;

Pose random_pose(Random& random) {
  Pose pose = Pose::Identity();
  pose.translate(Vec3(random.in(-4, 4), random.in(-4, 4), random.in(0.5, 2.5)));
  pose.rotate(Eigen::AngleAxisd(random.in(0, 6), random.in_cube(0.1, 1).normalized()));
  return pose;
}

Mesh random_mesh(Random& random) {
  const auto size = [&] { return random.in(0.1, 0.8); };
  switch (random.below(4)) {
    case 0:
      return scenes::uv_sphere(Vec3::Zero(), size(), 8, 5);
    case 1:
      return scenes::rectangle(Vec3::Zero(), Vec3(size(), 0, 0), Vec3(0, size(), 0.1));
    case 2: {  // one that can shadow itself
      Mesh mesh = scenes::box(Vec3(-size(), -0.1, 0), Vec3(size(), 0.1, 0.1));
      scenes::append(mesh, scenes::box(Vec3(-0.1, -0.1, 0.3), Vec3(0.1, size(), 0.9)));
      return mesh;
    }
    default:
      return scenes::box(Vec3(-size(), -size(), -size()), Vec3(size(), size(), size()));
  }
}

// Things above a floor that start to move and stop, change whether they cast, leave and come.
class Company {
 public:
  Company(std::uint64_t seed, const Light& light, int count) : random_(seed) {
    scene.add(scenes::rectangle(Vec3(-6, -6, 0), Vec3(12, 0, 0), Vec3(0, 12, 0)),
              {.name = "floor"});
    scene.add(light);
    for (int k = 0; k < count; ++k)
      members_.push_back({random_mesh(random_), random_pose(random_), {}, false, true});
    for (Member& m : members_) m.id = scene.add(m.mesh, {.name = "thing", .pose = m.pose});
  }

  void next_frame() {
    for (Member& m : members_) {
      m.moves = random_.unit() < (m.moves ? 0.7 : 0.08);
      if (m.moves && m.present) move(m);
      if (random_.below(400) == 0) come_or_go(m);
      if (m.present && random_.below(400) == 0) {
        EXPECT_EQ(scene.set_casts_shadows(m.id, !scene.find(m.id)->casts_shadows), Status::ok);
      }
    }
  }

  Scene scene;

 private:
  struct Member {
    Mesh mesh;
    Pose pose;
    ObjectId id;
    bool moves, present;
  };

  void move(Member& m) {
    m.pose.pretranslate(random_.in_cube(-0.2, 0.2));
    m.pose.rotate(Eigen::AngleAxisd(random_.in(-0.3, 0.3), Vec3::UnitZ()));
    m.pose.translation() =
        m.pose.translation().cwiseMax(Vec3(-4.5, -4.5, -0.5)).cwiseMin(Vec3(4.5, 4.5, 3));
    EXPECT_EQ(scene.set_pose(m.id, m.pose), Status::ok);
  }

  void come_or_go(Member& m) {
    if (m.present) {
      EXPECT_EQ(scene.remove(m.id), Status::ok);
    } else {
      m.id = scene.add(m.mesh, {.name = "thing", .pose = m.pose});
    }
    m.present = !m.present;
  }

  Random random_;
  std::vector<Member> members_;
};

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

std::string difference(const std::vector<ShadowTexture::Texels>& a,
                       const std::vector<ShadowTexture::Texels>& b) {
  if (a.size() != b.size()) return text(a.size(), " textures, and ", b.size());
  for (std::size_t k = 0; k < a.size(); ++k)
    if (a[k] != b[k])
      return text("textures of object ", a[k].object, ", receiver ", a[k].receiver, ", view ",
                  a[k].view);
  return "";
}

std::string difference(const ShadowTexture& a, const ShadowTexture& b) {
  for (std::size_t view = 0; view < a.views(0).size(); ++view)
    if (!same_bits(a.sz_buffer(0).read(view), b.sz_buffer(0).read(view)))
      return text("depths of view ", view);
  return difference(a.texels(0), b.texels(0));
}

double figure(const ShadowTexture& technique, const std::string& name) {
  for (const auto& [known, value] : technique.figures())
    if (known == name) return value;
  ADD_FAILURE() << name;
  return 0;
}

// 1 000 frames; in every 25th also against a technique that knows nothing of any frame before.
void keep_up(const Light& light, std::uint64_t seed) {
  const render::OffscreenContext context;
  Company company(seed, light, 30);
  Model model(company.scene);
  ShadowTexture kept(company.scene, model, {Method::sz_buffer, true, kSmallSide});
  ShadowTexture remade(company.scene, model, {Method::sz_buffer, false, kSmallSide});
  double seen[4] = {}, made = 0, textures = 0;
  for (int frame = 0; frame < 1000; ++frame) {
    if (frame > 0) company.next_frame();
    model.scene_changed(company.scene);
    kept.update();
    remade.update();
    ASSERT_EQ(difference(kept, remade), "") << "seed " << seed << ", frame " << frame;
    if (frame % 25 == 24) {
      ShadowTexture fresh(company.scene, model, {Method::sz_buffer, true, kSmallSide});
      fresh.update();
      ASSERT_EQ(difference(kept, fresh), "")
          << "seed " << seed << ", frame " << frame << ", from nothing";
    }
    int k = 0;
    for (const char* mobility : {"ss", "sd", "ds", "dd"}) seen[k++] += figure(kept, mobility);
    made += figure(kept, "textures_made"), textures += figure(kept, "textures");
  }
  for (const double count : seen) EXPECT_GT(count, 1000);
  EXPECT_LT(made, textures);
}

TEST(SzBuffer, OfAPointLightIsKeptToTheBit) { keep_up(Light::point(Vec3(0.4, 0.3, 3.1)), 1); }
TEST(SzBuffer, OfADirectionalLightIsKeptToTheBit) {
  keep_up(Light::directional(Vec3(0.3, 0.2, -1)), 2);
}

TEST(SzBuffer, IsMadeAgainWhenItsLightMovesOrTheSceneOutgrowsIt) {
  const render::OffscreenContext context;
  Company company(3, Light::directional(Vec3(0.3, 0.2, -1)), 10);
  Model model(company.scene);
  ShadowTexture kept(company.scene, model, {Method::sz_buffer, true, kSmallSide});
  ShadowTexture remade(company.scene, model, {Method::sz_buffer, false, kSmallSide});
  const auto compare = [&](const char* when) {
    model.scene_changed(company.scene);
    kept.update();
    remade.update();
    EXPECT_EQ(difference(kept, remade), "") << when;
  };
  compare("at first");
  EXPECT_FALSE(kept.views(0).extent(0, 5).empty());
  Pose away = Pose::Identity();
  away.translate(Vec3(60, 0, 5));
  ASSERT_EQ(company.scene.set_pose(company.scene.object_id(5), away), Status::ok);
  compare("outgrown");
  EXPECT_TRUE(kept.views(0).afresh());
  EXPECT_FALSE(kept.views(0).extent(0, 5).empty());
  ASSERT_EQ(
      company.scene.set_light(company.scene.light_id(0), Light::directional(Vec3(0.2, -0.3, -1))),
      Status::ok);
  compare("light moved");
  EXPECT_TRUE(kept.views(0).afresh());
  ASSERT_EQ(company.scene.set_light(company.scene.light_id(0), Light::point(Vec3(0.2, -0.3, 4))),
            Status::ok);
  compare("another kind of light");
  EXPECT_EQ(kept.views(0).size(), 6u);
  compare("nothing happens");
  EXPECT_EQ(figure(kept, "textures_made"), 0);
}

TEST(ShadowTexture, IsTheQuadraticMethodsToTheBit) {
  const render::OffscreenContext context;
  for (const std::uint64_t seed : {4, 5}) {
    const Light light =
        seed == 4 ? Light::point(Vec3(0.4, 0.3, 3.1)) : Light::directional(Vec3(0.3, 0.2, -1));
    Company company(seed, light, 30);
    Model model(company.scene);
    ShadowTexture theirs(company.scene, model, {Method::sz_buffer, true, kSmallSide});
    ShadowTexture before(company.scene, model, {Method::quadratic, false, kSmallSide});
    for (int frame = 0; frame < 40; ++frame) {
      company.next_frame();
      model.scene_changed(company.scene);
      theirs.update();
      before.update();
      ASSERT_EQ(difference(theirs.texels(0), before.texels(0)), "")
          << "seed " << seed << ", frame " << frame;
    }
  }
}

int contrast(const std::uint8_t* a, const std::uint8_t* b) {
  return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
}

// Rays against every facet.
class Rays {
 public:
  Rays(const Scene& scene, double texel)
      : scene_(scene), light_(scene.lights()[0]), texel_(texel) {}

  // What the texels around a pixel's point can say: 'l' or 's' if all of its rays from the light
  // are lit or shadowed, '?' if an edge of the face or of a shadow is within a texel; ' ' where the
  // pixel shows nothing.
  char state_at(const render::Frame& frame, int x, int y) const {
    const Eigen::Vector4d ndc((x + 0.5) / frame.width * 2 - 1, 1 - (y + 0.5) / frame.height * 2, 0,
                              1);
    const Vec3 seen = (frame.clip.inverse() * ndc).hnormalized(), eye = frame.camera.eye;
    const auto [at, facet] = nearest(eye, seen - eye);
    if (facet == invalid_index) return ' ';
    const Plane& plane = scene_.planes()[scene_.facets()[facet].plane];
    const Vec3 to_light = light_.kind == Light::Kind::point ? Vec3(light_.position - plane.point)
                                                            : Vec3(-light_.direction);
    if (plane.normal.dot(to_light) * plane.normal.dot(eye - plane.point) < 0) return 's';
    char all = 0;
    for (int i = -2; i <= 2; ++i)
      for (int j = -2; j <= 2; ++j) {
        const char one = state_of(facet, eye + at * (seen - eye), 0.5 * i, 0.5 * j);
        if (all != 0 && all != one) return '?';
        all = one;
      }
    return all;
  }

 private:
  // How far along the ray it meets a facet; infinite if it does not.
  double meet(std::uint32_t f, const Vec3& from, const Vec3& along) const {
    const Facet& facet = scene_.facets()[f];
    const Plane& plane = scene_.planes()[facet.plane];
    const double at = plane.normal.dot(plane.point - from) / plane.normal.dot(along);
    if (!std::isfinite(at)) return std::numeric_limits<double>::infinity();
    const Vec3 x = from + at * along;
    const auto corners = scene_.corners_of(facet);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec3 &a = scene_.vertices()[corners[i].vertex],
                 &b = scene_.vertices()[corners[i + 1 == corners.size() ? 0 : i + 1].vertex];
      if ((b - a).cross(x - a).dot(plane.normal) < 0)
        return std::numeric_limits<double>::infinity();
    }
    return at;
  }

  std::pair<double, std::uint32_t> nearest(const Vec3& from, const Vec3& along) const {
    std::pair<double, std::uint32_t> best{std::numeric_limits<double>::infinity(), invalid_index};
    for (std::uint32_t f = 0; f < scene_.facets().size(); ++f)
      if (const double at = scene_.facets()[f].corner_count == 0 ? -1 : meet(f, from, along);
          at > 0 && at < best.first)
        best = {at, f};
    return best;
  }

  // The ray from the light that passes x by so many texels to the right and up.
  char state_of(std::uint32_t facet, const Vec3& x, double right, double up) const {
    Vec3 from = light_.position, along = x - light_.position;
    if (light_.kind == Light::Kind::point) {
      int axis = 0;
      const double distance = along.cwiseAbs().maxCoeff(&axis);
      along[(axis + 1) % 3] += right * texel_ * distance;
      along[(axis + 2) % 3] += up * texel_ * distance;
    } else {
      const Vec3 u = light_.direction.normalized().unitOrthogonal(),
                 v = u.cross(light_.direction.normalized());
      along = 100 * light_.direction.normalized();
      from = x + texel_ * (right * u + up * v) - along;
    }
    const double at = meet(facet, from, along);
    if (!(at > 0 && std::isfinite(at))) return '?';
    return nearest(from, along).first < at * (1 - 1e-6) ? 's' : 'l';
  }

  const Scene& scene_;
  const Light& light_;
  const double texel_;  // its size, at distance one of a point light
};

// With 2048 texels to a view they are about as large as these pictures' pixels. Where the pictures
// differ, and at some pixels besides, rays say what is right.
void compare_pictures(const Scene& scene, const render::Camera& camera, const std::string& what) {
  constexpr int width = 480, height = 360;
  const Model model(scene);
  const render::Frame frame = model.frame(camera, width, height);
  const render::Target target(width, height);
  const auto picture_by = [&](const char* name) {
    const auto technique = render::make_technique(name, scene, model);
    target.bind();
    render::draw(frame, scene, model, *technique);
    return target.read();
  };
  const Picture textures = picture_by("shadow-texture"), volumes = picture_by("stencil-zfail");
  model.draw_ambient(frame);
  const Picture ambient = target.read();
  const Rays rays(scene,
                  (scene.lights()[0].kind == Light::Kind::point ? 1 : model.radius()) * 2 / 2048);
  int differ = 0, near_edges = 0, asked = 0, wrong = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool differs = contrast(textures.at(x, y), volumes.at(x, y)) > 12;
      if (!differs && (x * 7 + y * 13) % 128 != 0) continue;
      const char right = rays.state_at(frame, x, y),
                 drawn = contrast(textures.at(x, y), ambient.at(x, y)) > 12 ? 'l' : 's';
      ++asked;
      differ += differs;
      near_edges += differs && right == '?';
      wrong += right != '?' && right != ' ' && right != drawn;
    }
  std::printf(
      "%s: %d pixels differ (%.3f %%), %d of them within a texel of an edge; of %d pixels asked, "
      "%d wrong elsewhere\n",
      what.c_str(), differ, 100.0 * differ / (width * height), near_edges, asked, wrong);
  EXPECT_LT(differ, width * height / 200) << what;
  EXPECT_EQ(wrong, 0) << what;
}

TEST(ShadowTexture, DrawsTheRoomAsShadowVolumesDo) {
  const render::OffscreenContext context;
  const Scene scene = scenes::build(scenes::room(4));
  compare_pictures(scene, {Vec3(0.3, 0.3, 2.5), Vec3(6, 5, 0.2), 1.3}, "room 4");
  compare_pictures(scene, {Vec3(6, 5, 2), Vec3(0.3, 0.3, 0.2), 1.3},
                   "room 4, from the other corner");
}

TEST(ShadowTexture, DrawsRandomThingsAsShadowVolumesDo) {
  const render::OffscreenContext context;
  for (std::uint64_t seed = 10; seed < 14; ++seed) {
    const bool sun = seed % 2 == 1;
    Company company(
        seed, sun ? Light::directional(Vec3(0.3, 0.2, -1)) : Light::point(Vec3(0.4, 0.3, 5.1)), 25);
    compare_pictures(company.scene, {Vec3(-7, -5, 5), Vec3(0, 0, 0.5), 1.0}, text("seed ", seed));
  }
}

}  // namespace
}  // namespace shadowcut::testing
