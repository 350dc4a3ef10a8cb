// Writers and a scene with holes: objects and lights that have been removed leave gaps in the
// arrays, and no trace in any file.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <shadowcut/io.hpp>
#include <sstream>

#include "scenes.hpp"

namespace shadowcut::testing {
namespace {

namespace fs = std::filesystem;

ObjectId object_named(const Scene& scene, const std::string& name) {
  for (std::size_t i = 0; i < scene.objects().size(); ++i)
    if (scene.objects()[i].name == name) return scene.object_id(i);
  return {};
}

// A room whose bookcase is gone, and the first of its lights.
struct Holes : ::testing::Test {
  Scene scene = scenes::build(scenes::room(1));
  LightId first = scene.light_id(0);
  fs::path folder = fs::temp_directory_path() / ("shadowcut-writers-" + std::to_string(::getpid()));

  Holes() {
    fs::create_directory(folder);
    Light second = Light::point({3.1, 1.7, 2.2});
    second.name = "second";
    scene.add(second);
    Light third = Light::directional({0.3, 0.4, -1});
    scene.add(third);
    for (const char* name : {"bookcase.1", "book.1", "poster"})
      EXPECT_EQ(scene.remove(object_named(scene, name)), Status::ok) << name;
    EXPECT_EQ(scene.remove(first), Status::ok);
  }
  ~Holes() override { fs::remove_all(folder); }

  std::string path(const std::string& name) const { return (folder / name).string(); }
  std::string written(const std::string& name, const io::View& view = {}) const {
    Engine engine(scene);
    engine.update();
    io::write_fragments(path(name), scene, engine, view);
    return text(name);
  }
  std::string text(const std::string& name) const {
    std::ostringstream all;
    all << std::ifstream(path(name), std::ios::binary).rdbuf();
    return all.str();
  }
};

TEST_F(Holes, EveryFormatLeavesOutWhatIsGone) {
  for (const char* name : {"a.obj", "a.ply", "a.gltf", "a.svg"}) {
    const std::string all = written(name);
    EXPECT_NE(all.find("desk.1"), std::string::npos) << name;
    EXPECT_EQ(all.find("bookcase"), std::string::npos) << name;
    EXPECT_EQ(all.find("lit by 0"), std::string::npos) << name;
  }
  EXPECT_NE(text("a.gltf").find("lit by 1+2"), std::string::npos);
  EXPECT_NE(text("a.svg").find("second"), std::string::npos);
  EXPECT_EQ(text("a.svg").find("lamp"), std::string::npos);  // the light that is gone is not marked
  EXPECT_FALSE(written("a.glb").empty());
}

TEST_F(Holes, OneLightLeftIsThePlainCase) {
  ASSERT_EQ(scene.remove(scene.light_id(2)), Status::ok);
  const std::string all = written("b.gltf");
  EXPECT_NE(all.find("\"lit\""), std::string::npos);
  EXPECT_EQ(all.find("lit by"), std::string::npos);
  EXPECT_FALSE(written("b.svg").empty());
}

TEST_F(Holes, NoLightLeftIsAnError) {
  for (std::size_t k = 1; k < 3; ++k) ASSERT_EQ(scene.remove(scene.light_id(k)), Status::ok);
  EXPECT_THROW(written("c.obj"), Error);
  EXPECT_FALSE(fs::exists(path("c.obj")));
}

TEST_F(Holes, TheCameraSeesByTheLightsThatAreLeft) {
  io::View view;
  view.kind = io::View::Kind::camera;
  view.eye = Vec3(0.5, 0.5, 2.4);
  view.target = Vec3(4, 4, 0.3);
  const std::string with_hole = written("d.svg", view);
  Scene tight = scenes::build(scenes::room(1));
  for (const char* name : {"bookcase.1", "book.1", "poster"})
    ASSERT_EQ(tight.remove(object_named(tight, name)), Status::ok);
  const std::vector<Light> left(scene.lights().begin() + 1, scene.lights().end());
  tight.replace_lights(left);
  scene = tight;
  EXPECT_EQ(with_hole, written("d.svg", view));
}

TEST_F(Holes, AFaceThatIsNoObjectsCannotBeDrawn) {
  io::View view;
  view.kind = io::View::Kind::face;
  const auto faces = scene.faces();
  view.face = static_cast<std::uint32_t>(
      std::find_if(faces.begin(), faces.end(),
                   [](const Face& f) { return f.object == invalid_index; }) -
      faces.begin());
  ASSERT_LT(view.face, faces.size());
  EXPECT_THROW(written("e.svg", view), Error);
}

TEST_F(Holes, AreasHaveARowForEachFaceAndLightThatIsThere) {
  Engine engine(scene);
  engine.update();
  io::write_areas(path("areas.csv"), scene, engine);
  std::istringstream rows(text("areas.csv"));
  std::string row;
  std::getline(rows, row);
  std::size_t count = 0;
  while (std::getline(rows, row)) {
    ++count;
    EXPECT_TRUE(row.starts_with("1,") || row.starts_with("2,")) << row;
    EXPECT_EQ(row.find("bookcase"), std::string::npos) << row;
  }
  const auto faces = scene.faces();
  EXPECT_EQ(count, 2 * static_cast<std::size_t>(
                           std::count_if(faces.begin(), faces.end(),
                                         [](const Face& f) { return f.object != invalid_index; })));
}

}  // namespace
}  // namespace shadowcut::testing
