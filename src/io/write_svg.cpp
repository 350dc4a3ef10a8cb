// Drawings of fragments: a plan from above, one face laid flat, or a view in perspective.
//
// The view in perspective has no painter's order and no depth buffer. The eye is added to the
// lights as one more of them: what it "lights" is what can be seen, cut by the engine as exactly as
// a shadow is, and the fragments that it reaches are drawn as they are.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "convex_clip.hpp"
#include "svg_page.hpp"
#include "text.hpp"
#include "writers.hpp"

namespace shadowcut::io {

namespace {

// px around a drawing to scale, and below it for the scale bar
constexpr double margin = 30, foot = 60;
const Colour paper(0.985, 0.98, 0.97), sky(0.90, 0.93, 0.96), ink(0.16, 0.17, 0.2);

// A frame for looking along -towards: right and above span the page.
struct Frame {
  Vec3 right, above, towards;  // unit; towards the onlooker

  Point flat(const Vec3& p) const { return {right.dot(p), above.dot(p)}; }
};

Vec3 any_normal_to(const Vec3& v) {
  const Vec3 axis = std::abs(v.normalized().x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
  return (axis - axis.dot(v) / v.squaredNorm() * v).normalized();
}

Frame frame_towards(const Vec3& towards, const Vec3& up) {
  Frame frame;
  frame.towards = towards.normalized();
  const Vec3 right = up.cross(frame.towards);
  frame.right = right.norm() > 1e-9 * up.norm() ? right.normalized() : any_normal_to(frame.towards);
  frame.above = frame.towards.cross(frame.right);
  return frame;
}

// Maps a rectangle of the frame to the page, evenly in both directions.
class Fit {
 public:
  Fit(const Eigen::AlignedBox2d& box, const SvgPage& page) {
    const Point room(page.width() - 2 * margin, page.height() - margin - foot), size = box.sizes();
    scale_ = std::min(room.x() / size.x(), room.y() / size.y());
    if (!std::isfinite(scale_)) scale_ = 1;
    const Point spare = 0.5 * (room - scale_ * size);
    origin_ = Point(margin + spare.x() - scale_ * box.min().x(),
                    margin + spare.y() + scale_ * box.max().y());
  }
  Point operator()(const Point& p) const {
    return {origin_.x() + scale_ * p.x(), origin_.y() - scale_ * p.y()};
  }
  double scale() const { return scale_; }

 private:
  Point origin_;
  double scale_;
};

// Positive on the front side of the plane, for a point or, when directional, for where the light
// comes from.
double side_of(const Plane& plane, const Light& light) {
  return light.kind == Light::Kind::point ? plane.normal.dot(light.position - plane.point)
                                          : -plane.normal.dot(light.direction);
}

// How bright a piece looks from a place: of the lights that reach it, those on the onlooker's side
// of it count. A sheet lit from behind is dark.
double seen_light(const LightSet& set, const std::vector<Light>& lights, const Plane& plane,
                  double onlooker_side) {
  double sum = 0;
  for (const std::uint32_t k : set.lights)
    if (k < lights.size() && side_of(plane, lights[k]) * onlooker_side > 0) ++sum;
  return sum;
}

// Which edges of the scene a drawing should show: the rim of a surface, or a fold sharper than 30
// degrees.
class Creases {
 public:
  explicit Creases(const Scene& scene) : scene_(scene), shows_(scene.edges().size(), false) {
    const double smooth = std::cos(std::numbers::pi / 6);
    std::vector<std::uint32_t> first(shows_.size(), invalid_index), count(shows_.size(), 0);
    for (const Facet& facet : scene.facets()) {
      for (const Corner& c : scene.corners_of(facet)) {
        const std::uint32_t edge = c.edge >> 1;
        if (first[edge] == invalid_index) first[edge] = facet.plane;
        else if (std::abs(scene.planes()[first[edge]].normal.dot(
                     scene.planes()[facet.plane].normal)) < smooth)
          shows_[edge] = true;
        ++count[edge];
      }
    }
    for (std::size_t e = 0; e < shows_.size(); ++e) shows_[e] = shows_[e] || count[e] == 1;
  }

  // Whether the edge a-b of a fragment lies on an edge of its facet that shows.
  bool holds(const Facet& facet, const Vec3& a, const Vec3& b) const {
    const std::span<const Corner> corners = scene_.corners_of(facet);
    for (std::size_t k = 0; k < corners.size(); ++k) {
      if (!shows_[corners[k].edge >> 1]) continue;
      const Vec3 &p = scene_.vertices()[corners[k].vertex],
                 &q = scene_.vertices()[corners[(k + 1) % corners.size()].vertex];
      const double tolerance = 1e-7 * (q - p).squaredNorm();
      if ((a - p).cross(q - p).norm() <= tolerance && (b - p).cross(q - p).norm() <= tolerance)
        return true;
    }
    return false;
  }

 private:
  const Scene& scene_;
  std::vector<bool> shows_;
};

// A muted colour that stays an object's own as long as its name does.
Colour colour_of_object(std::string_view name) {
  std::uint32_t hash = 2166136261u;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  const double hue = 6.0 * static_cast<double>(hash % 997) / 997,
               saturation = 0.06 + 0.16 * static_cast<double>(hash / 997 % 5) / 4;
  const auto channel = [&](double shift) {
    const double t = std::fmod(hue + shift, 6.0);
    return 1 - saturation * std::clamp(std::min(t, 4 - t), 0.0, 1.0);
  };
  return Colour(channel(5), channel(3), channel(1));
}

void legend(SvgPage& page, const Colour& lit, const Colour& shadowed) {
  page.title("");
  page.swatch({page.width() - 210, page.height() - 30}, lit, "lit");
  page.swatch({page.width() - 140, page.height() - 30}, shadowed, "shadowed");
}

// ---- plan

class Plan {
 public:
  // `lights` are all of the engine's, `shining` the indices of those that have not been removed.
  Plan(const Scene& scene, const Pieces& pieces, const View& view, const std::vector<Light>& lights,
       const std::vector<std::uint32_t>& shining)
      : scene_(scene),
        pieces_(pieces),
        view_(view),
        lights_(lights),
        shining_(shining),
        page_(view.width, view.height, paper),
        creases_(scene) {
    frame_.towards = view.up.normalized();
    frame_.right = any_normal_to(view.up);
    frame_.above = frame_.towards.cross(frame_.right);
  }

  std::string draw() {
    for (const Piece& piece : pieces_.pieces) take(piece);
    if (sheets_.empty()) throw Error("nothing to draw: no surface faces up");
    std::stable_sort(sheets_.begin(), sheets_.end(),
                     [](const Sheet& a, const Sheet& b) { return a.height < b.height; });
    Eigen::AlignedBox2d box;
    for (const Knot& c : points_) box.extend(c.at);
    const Fit fit(box, page_);
    for (const Sheet& sheet : sheets_) paint(sheet, fit);
    for (const std::uint32_t k : shining_) mark(lights_[k], fit);
    page_.scale_bar(fit.scale());
    legend(page_, colour_of(1), colour_of(0));
    return page_.finish();
  }

 private:
  struct Sheet {
    double height;
    std::uint32_t object;
    Colour colour;
    std::size_t first, count;  // into points_
  };
  struct Knot {
    Point at;
    bool crease;  // from here to the next corner
  };

  void take(const Piece& piece) {
    const Plane& plane = scene_.planes()[scene_.facets()[piece.facet].plane];
    const std::uint32_t object = scene_.faces()[piece.face].object;
    const double slope = plane.normal.dot(frame_.towards);
    const bool either_side = scene_.objects()[object].sides == Sides::open;
    if (std::abs(slope) < 1e-9 || (slope < 0 && !either_side)) return;
    const std::span<const Vec3> corners = pieces_.corners_of(piece);
    polygon_.assign(corners.begin(), corners.end());
    if (std::isfinite(view_.cut))
      clip(polygon_, scratch_, [&](const Vec3& p) { return view_.cut - frame_.towards.dot(p); });
    if (polygon_.size() < 3) return;

    const double light = seen_light(pieces_.sets[piece.set], lights_, plane, slope) /
                         static_cast<double>(pieces_.light_count);
    double height = 0;
    for (const Vec3& p : polygon_)
      height += frame_.towards.dot(p) / static_cast<double>(polygon_.size());
    const Colour tint =
        0.5 * Colour::Ones() + 0.5 * colour_of_object(scene_.objects()[object].name);
    sheets_.push_back({height, object,
                       (0.8 + 0.2 * std::abs(slope)) * colour_of(light).cwiseProduct(tint),
                       points_.size(), polygon_.size()});
    for (std::size_t i = 0; i < polygon_.size(); ++i) {
      const Vec3 &a = polygon_[i], &b = polygon_[(i + 1) % polygon_.size()];
      points_.push_back({frame_.flat(a), creases_.holds(scene_.facets()[piece.facet], a, b)});
    }
  }

  void paint(const Sheet& sheet, const Fit& fit) {
    page_.title(scene_.objects()[sheet.object].name);
    corners_.clear();
    for (std::size_t i = 0; i < sheet.count; ++i)
      corners_.push_back(fit(points_[sheet.first + i].at));
    page_.polygon(corners_, sheet.colour, sheet.colour * 0.86, 0.4);
    for (std::size_t i = 0; i < sheet.count; ++i)
      if (points_[sheet.first + i].crease)
        page_.line(corners_[i], corners_[(i + 1) % corners_.size()], ink, 0.7);
  }

  void mark(const Light& light, const Fit& fit) {
    if (light.kind != Light::Kind::point) return;
    const Point at = fit(frame_.flat(light.position));
    if (at.x() < 0 || at.y() < 0 || at.x() > page_.width() || at.y() > page_.height()) return;
    page_.title(light.name.empty() ? "light" : light.name);
    page_.disc(at, 5, Colour(1, 0.8, 0.2), ink);
  }

  const Scene& scene_;
  const Pieces& pieces_;
  const View& view_;
  const std::vector<Light>& lights_;
  const std::vector<std::uint32_t>& shining_;
  SvgPage page_;
  Creases creases_;
  Frame frame_;
  std::vector<Sheet> sheets_;
  std::vector<Knot> points_;
  std::vector<Point> corners_;
  std::vector<Vec3> polygon_, scratch_;
};

// ---- face

std::string draw_face(const Scene& scene, const Pieces& pieces, const View& view) {
  if (view.face >= scene.faces().size() || scene.faces()[view.face].object == invalid_index)
    throw Error("cannot be drawn: the scene has no such face");
  const Face& face = scene.faces()[view.face];
  const Object& object = scene.objects()[face.object];
  const std::string title = object.name + ", face " + std::to_string(face.number);
  if (face.facet_count == 0) throw Error("nothing to draw: " + title + " was refused");
  const Frame frame =
      frame_towards(scene.planes()[scene.facets()[face.first_facet].plane].normal, view.up);

  Eigen::AlignedBox2d box;
  for (std::uint32_t k = 0; k < face.facet_count; ++k)
    for (const Corner& c : scene.corners_of(scene.facets()[face.first_facet + k]))
      box.extend(frame.flat(scene.vertices()[c.vertex]));
  SvgPage page(view.width, view.height, paper);
  const Fit fit(box, page);
  page.title(title);
  std::vector<Point> corners;
  for (const Piece& piece : pieces.pieces) {
    if (piece.face != view.face) continue;
    corners.clear();
    for (const Vec3& p : pieces.corners_of(piece)) corners.push_back(fit(frame.flat(p)));
    const Colour colour = colour_of(pieces.brightness(pieces.sets[piece.set]));
    page.polygon(corners, colour, colour * 0.75, 0.75);
  }
  page.scale_bar(fit.scale());
  page.text({margin, 20}, title);
  legend(page, colour_of(1), colour_of(0));
  return page.finish();
}

// ---- camera

class CameraView {
 public:
  CameraView(const Scene& scene, const View& view, const std::vector<Light>& lights)
      : scene_(scene),
        view_(view),
        lights_(lights),
        page_(view.width, view.height, sky),
        creases_(scene) {
    const Vec3 back = view.eye - view.target;
    if (!back.allFinite() || back.norm() == 0)
      throw Error("nothing to draw: the eye is at its target");
    if (!(view.fov > 0 && view.fov < std::numbers::pi))
      throw Error("nothing to draw: a field of view is between 0 and 180 degrees");
    frame_ = frame_towards(back, view.up);
    near_ = 1e-3 * back.norm();
    slope_y_ = std::tan(view.fov / 2);
    slope_x_ = slope_y_ * view.width / view.height;
  }

  std::string draw() {
    Options options;
    options.threads = view_.threads;
    options.tuning.incremental = false;
    std::vector<Light> lights = lights_;
    lights.push_back(Light::point(view_.eye));
    const std::size_t eye = lights.size() - 1;
    Scene scene = scene_;
    scene.replace_lights(lights);
    Engine engine(scene, options);
    engine.update();
    const LightPartition all = engine.overlay();
    for (std::size_t i = 0; i < all.fragments.size(); ++i)
      if (all.reaches(i, eye)) paint(all, i);
    for (const auto& [a, b] : lines_) page_.line(a, b, ink, 0.7);
    return page_.finish();
  }

 private:
  void paint(const LightPartition& all, std::size_t i) {
    const LightPartition::Fragment& fragment = all.fragments[i];
    const std::uint32_t object = scene_.faces()[fragment.face].object;
    const std::span<const Vec3> corners = all.corners_of(fragment);
    if (!project(corners)) return;
    const Colour colour = shade(all, i, object);
    page_.title(scene_.objects()[object].name);
    // the stroke closes the hair between neighbours
    page_.polygon(page_corners_, colour, colour, 1);
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Vec3 ends[] = {corners[k], corners[(k + 1) % corners.size()]};
      if (creases_.holds(scene_.facets()[fragment.facet], ends[0], ends[1]) && project(ends))
        lines_.emplace_back(page_corners_[0], page_corners_[1]);
    }
  }

  // What is in front of the eye and inside the picture, as corners on the page.
  bool project(std::span<const Vec3> corners) {
    polygon_.clear();
    for (const Vec3& p : corners) {
      const Vec3 from_eye = p - view_.eye;
      polygon_.push_back(
          {frame_.right.dot(from_eye), frame_.above.dot(from_eye), -frame_.towards.dot(from_eye)});
    }
    clip(polygon_, scratch_, [&](const Vec3& p) { return p.z() - near_; });
    for (const double side : {-1.0, 1.0}) {
      clip(polygon_, scratch_, [&](const Vec3& p) { return slope_x_ * p.z() - side * p.x(); });
      clip(polygon_, scratch_, [&](const Vec3& p) { return slope_y_ * p.z() - side * p.y(); });
    }
    page_corners_.clear();
    for (const Vec3& p : polygon_) {
      page_corners_.push_back({0.5 * view_.width * (1 + p.x() / (p.z() * slope_x_)),
                               0.5 * view_.height * (1 - p.y() / (p.z() * slope_y_))});
    }
    return page_corners_.size() >= std::min<std::size_t>(3, corners.size());
  }

  // One brightness for a whole face and light, so that only shadows divide it.
  Colour shade(const LightPartition& all, std::size_t i, std::uint32_t object) const {
    const Plane& plane = scene_.planes()[scene_.facets()[all.fragments[i].facet].plane];
    const double eye_side = plane.normal.dot(view_.eye - plane.point);
    double light = 0;
    for (std::size_t k = 0; k < lights_.size(); ++k) {
      if (!all.reaches(i, k) || side_of(plane, lights_[k]) * eye_side <= 0) continue;
      const Vec3 to_light = lights_[k].kind == Light::Kind::point
                                ? Vec3(lights_[k].position - plane.point)
                                : Vec3(-lights_[k].direction);
      light += (0.6 + 0.4 * std::abs(plane.normal.dot(to_light.normalized()))) /
               static_cast<double>(lights_.size());
    }
    const double ambient = 0.30 + 0.10 * std::abs(plane.normal.dot(frame_.towards)) +
                           0.06 * plane.normal.dot(view_.up.normalized());
    const Colour warm(1.0, 0.97, 0.90), cool(0.86, 0.93, 1.06);
    return colour_of_object(scene_.objects()[object].name)
        .cwiseProduct(ambient * cool + 0.62 * light * warm);
  }

  const Scene& scene_;
  const View& view_;
  const std::vector<Light>& lights_;
  SvgPage page_;
  Creases creases_;
  Frame frame_;
  double near_, slope_x_, slope_y_;
  std::vector<Vec3> polygon_, scratch_;
  std::vector<Point> page_corners_;
  std::vector<std::pair<Point, Point>> lines_;
};

std::string draw(const Scene& scene, const Engine& engine, const View& view,
                 const std::vector<Light>& lights) {
  const std::vector<std::uint32_t> shining = lights_of(engine);
  if (view.kind == View::Kind::camera) {
    std::vector<Light> some;
    for (const std::uint32_t k : shining) some.push_back(lights[k]);
    return CameraView(scene, view, some).draw();
  }
  const Pieces pieces = pieces_of(scene, engine);
  return view.kind == View::Kind::face ? draw_face(scene, pieces, view)
                                       : Plan(scene, pieces, view, lights, shining).draw();
}

}  // namespace

void write_svg(const std::string& path, const Scene& scene, const Engine& engine,
               const View& view) {
  std::vector<Light> lights = view.lights;
  if (lights.empty()) lights.assign(scene.lights().begin(), scene.lights().end());
  if (view.kind != View::Kind::face && lights.size() != engine.light_count())
    throw Error(path +
                ": cannot be drawn: the lights of the view differ from the lights of the engine");
  try {
    write_text(path, draw(scene, engine, view, lights));
  } catch (const Error& error) {
    const std::string what = error.what();
    throw Error(what.starts_with(path) ? what : path + ": " + what);
  }
}

}  // namespace shadowcut::io
