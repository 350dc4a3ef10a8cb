// The SZ-buffer of K.-S. Oh, B.-S. Shin, "An efficient method for dynamic shadow texture
// generation", IEICE Trans. Inf. & Syst. E88-D(3), 2005: the depth, from a light, of the nearest
// surface along every ray, and its update from one frame to the next (section 3.1), after K.-S. Oh,
// B.-S. Shin, Y.-G. Shin, "Mobility culling", J. Vis. Comput. Anim. 12(3), 2001.
//
// Two depth buffers: the static one has the objects that stand still, the rendering one has all. A
// frame puts the rendering buffer back to the objects that stand still now, by erasing and drawing
// again what the moving ones covered; brings the static buffer up to date from it; and draws the
// moving objects. Extents are rectangles.
//
// Departures. Section 3.1 calls the objects that begin to move DS and those that have come to rest
// SD; here it is as it defines them: SD is static in the previous frame and dynamic in this one. A
// point light has six independent buffers, the faces of a cube. The static buffer is brought up to
// date in the extents that have changed, and not copied whole; what is drawn again is drawn only
// where it was erased. An object that comes into the scene or leaves it moves in that frame.
#pragma once

#include <map>

#include "model.hpp"

namespace shadowcut::render {

// Pixels x0 <= x < x1, y0 <= y < y1.
struct Rectangle {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  bool empty() const { return x0 >= x1 || y0 >= y1; }
  bool overlaps(const Rectangle& o) const {
    return !empty() && !o.empty() && x0 < o.x1 && o.x0 < x1 && y0 < o.y1 && o.y0 < y1;
  }
  friend bool operator==(const Rectangle&, const Rectangle&) = default;
};
// The smallest rectangle that holds both.
Rectangle united(const Rectangle& a, const Rectangle& b);

// In the previous frame and in this one: s, it did not change; d, it did.
enum class Mobility : std::uint8_t { ss, sd, ds, dd };

// What a light sees of a scene, and what of it moves. A view is a square picture that the light
// takes: six of a point light, in the order and with the directions of OpenGL's cube maps; one of a
// directional light, a parallel projection wide enough for the scene.
class LightViews {
 public:
  // The scene and its model must outlive it. A view has side x side pixels.
  LightViews(const Scene& scene, const Model& model, std::size_t light, int side)
      : scene_(scene), model_(model), light_(light), side_(side) {}

  // One frame on. The model is up to date with the scene.
  void advance();

  int side() const { return side_; }
  std::size_t light() const { return light_; }
  std::size_t size() const { return clips_.size(); }
  const Mat4f& clip(std::size_t view) const { return clips_[view]; }

  // Nothing of the previous frame can be used: it is the first one, the light has changed, or the
  // scene has outgrown the view. All objects are ss then.
  bool afresh() const { return afresh_; }
  std::size_t object_count() const { return mobility_.size(); }
  Mobility mobility(std::uint32_t object) const { return mobility_[object]; }
  bool moves(std::uint32_t object) const {
    return mobility_[object] == Mobility::sd || mobility_[object] == Mobility::dd;
  }
  // The objects that move in this frame, removed ones included.
  std::span<const std::uint32_t> moving() const { return moving_; }
  bool casts(std::uint32_t object) const { return now_[object].casts; }

  // The pixels in which an object can be seen, or more; empty where it does not stand; and before
  // it moved in this frame, if it did and cast.
  const Rectangle& extent(std::size_t view, std::uint32_t object) const {
    return now_[object].extents[view];
  }
  const Rectangle& extent_before(std::size_t view, std::uint32_t moving) const {
    return before_.at(moving).extents[view];
  }
  // Something that casts has moved into these pixels, or within them, or out of them.
  bool disturbed(std::size_t view, const Rectangle& pixels) const;
  // Of some facets of an object.
  Rectangle extent(std::size_t view, std::uint32_t object,
                   std::span<const std::uint32_t> facets) const;

 private:
  struct Seen {
    bool casts = false;
    std::array<Rectangle, 6> extents;
  };
  bool aim();
  bool covers(std::uint32_t object) const;
  void start();
  Seen look_at(std::uint32_t object) const;

  const Scene& scene_;
  const Model& model_;
  const std::size_t light_;
  const int side_;
  std::vector<Mat4f> clips_;
  double reach_ = 0;  // of a directional light's view: half its width
  bool afresh_ = true;
  std::uint64_t known_ = 0, light_known_ = 0;
  std::vector<Mobility> mobility_;  // by object
  std::vector<Seen> now_;           // by object
  std::vector<std::uint32_t> moving_;
  std::map<std::uint32_t, Seen> before_;
};

class SzBuffer {
 public:
  // Both must outlive it.
  SzBuffer(const Model& model, const LightViews& views);

  // Brings it to the frame to which the views have been advanced: once for each.
  void update();
  // The same from nothing; and the rendering buffer alone, for who wants no coherence.
  void make_all();
  void make_rendering();

  GLuint depths(std::size_t view) const { return layers_[view].rendering.get(); }
  std::vector<float> read(std::size_t view) const;
  // Objects drawn in the frame, in all views.
  std::size_t drawn() const { return drawn_; }

 private:
  struct Layer {
    Texture rendering, standing;
  };
  void make_layers();
  template <class Draw>
  void draw_views(const Draw& draw_view);
  void begin(std::size_t view) const;
  void erase(std::size_t view) const;
  void draw_uncovered(std::size_t view);
  void keep_static(std::size_t view) const;
  void draw_moving(std::size_t view);
  void draw(std::size_t view, std::uint32_t object);

  const Model& model_;
  const LightViews& views_;
  Program depth_;
  Framebuffer rendering_, standing_;  // of the view that is worked at
  std::vector<Layer> layers_;         // by view
  std::size_t drawn_ = 0;
};

// A square depth texture, and what is drawn to until the end of its life: before that is bound
// again.
Texture make_depths(int side);
class KeptBinding {
 public:
  KeptBinding();
  ~KeptBinding();
  KeptBinding(const KeptBinding&) = delete;
  KeptBinding& operator=(const KeptBinding&) = delete;

 private:
  GLint framebuffer_ = 0;
  std::array<GLint, 4> viewport_{};
};

// GLSL for a surface as a light's view sees it: the same numbers wherever it is used.
extern const char* const light_view_vertex_shader;

}  // namespace shadowcut::render
