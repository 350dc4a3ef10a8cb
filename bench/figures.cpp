// Writes the figures of docs/design.md: a cone in light space, and a small SVBSP tree. Both are
// drawn from the engine's own data, so the figures change with the code.
//
//   shadowcut_figures FOLDER
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "engine/light_state.hpp"

namespace {

using namespace shadowcut;
using Point = Eigen::Vector2d;

const char* const ink = "#1f2430";
const char* const soft = "#6b7280";
const char* const positive = "#b45309";
const char* const negative = "#1d4ed8";

// SVG text, appended element by element. Coordinates are in px, y downward.
class Page {
 public:
  Page(double width, double height, const std::string& title) {
    text_ = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(width) + " " +
            number(height) + "\" width=\"" + number(width) + "\" height=\"" + number(height) +
            "\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"14\">\n<title>" + title +
            "</title>\n<defs><marker id=\"tip\" viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" "
            "markerWidth=\"7\" markerHeight=\"7\" orient=\"auto\"><path d=\"M0 0L8 4L0 8z\" "
            "fill=\"context-stroke\"/></marker></defs>\n"
            "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  }
  void line(const Point& a, const Point& b, const std::string& style) {
    text_ += "<line x1=\"" + number(a.x()) + "\" y1=\"" + number(a.y()) + "\" x2=\"" +
             number(b.x()) + "\" y2=\"" + number(b.y()) + "\" " + style + "/>\n";
  }
  void polygon(const std::vector<Point>& corners, const std::string& style) {
    text_ += "<polygon points=\"";
    for (const Point& p : corners) text_ += number(p.x()) + "," + number(p.y()) + " ";
    text_ += "\" " + style + "/>\n";
  }
  void curve(const Point& a, const Point& b, const Point& c, const Point& d,
             const std::string& style) {
    text_ += "<path d=\"M" + pair(a) + " C" + pair(b) + " " + pair(c) + " " + pair(d) +
             "\" fill=\"none\" " + style + "/>\n";
  }
  void dot(const Point& at, double radius, const std::string& style) {
    text_ += "<circle cx=\"" + number(at.x()) + "\" cy=\"" + number(at.y()) + "\" r=\"" +
             number(radius) + "\" " + style + "/>\n";
  }
  void box(const Point& centre, double width, double height, const std::string& style) {
    text_ += "<rect x=\"" + number(centre.x() - width / 2) + "\" y=\"" +
             number(centre.y() - height / 2) + "\" width=\"" + number(width) + "\" height=\"" +
             number(height) + "\" rx=\"4\" " + style + "/>\n";
  }
  // The text's middle is at y. anchor: start, middle, end.
  void write(const Point& at, const std::string& words, const std::string& anchor = "middle",
             const std::string& style = "") {
    text_ += "<text x=\"" + number(at.x()) + "\" y=\"" + number(at.y() + 5) + "\" text-anchor=\"" +
             anchor + "\" fill=\"" + ink + "\" " + style + ">" + words + "</text>\n";
  }
  void save(const std::string& path) {
    std::ofstream out(path);
    out << text_ << "</svg>\n";
    if (!out.flush()) throw Error(path + ": cannot be written");
  }

 private:
  static std::string number(double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.4g", value);
    return digits;
  }
  static std::string pair(const Point& p) { return number(p.x()) + " " + number(p.y()); }
  std::string text_;
};

std::string fill(const std::string& colour, double opacity = 1) {
  return "fill=\"" + colour + "\" fill-opacity=\"" + std::to_string(opacity) + "\" ";
}
std::string stroke(const std::string& colour, double width = 1.5, const std::string& dash = "") {
  return "stroke=\"" + colour + "\" stroke-width=\"" + std::to_string(width) +
         "\" stroke-linejoin=\"round\"" +
         (dash.empty() ? "" : " stroke-dasharray=\"" + dash + "\"") + " ";
}

// A letter in italics with a subscript.
std::string symbol(const std::string& letter, const std::string& index) {
  return "<tspan font-style=\"italic\">" + letter + "</tspan><tspan dy=\"4\" font-size=\"11\">" +
         index + "</tspan><tspan dy=\"-4\">&#8203;</tspan>";
}

// ---- the cone -----------------------------------------------------------------------------------

// A view of the world from the side, in perspective.
struct SideView {
  Vec3 eye{1.9, -6.4, 6.6}, target{0.3, 0.15, 1.55};
  Point centre{230, 250};
  double focal = 640;

  Point operator()(const Vec3& x) const {
    const Vec3 ahead = (target - eye).normalized(), right = ahead.cross(Vec3::UnitZ()).normalized();
    const Vec3 up = right.cross(ahead), d = x - eye;
    const double depth = d.dot(ahead);
    return centre + focal / depth * Point(d.dot(right), -d.dot(up));
  }
};

// The section of light space at the distance 1 below the light, seen from the light.
Point section(const double r[3]) { return {r[0] / -r[2], r[1] / -r[2]}; }

void draw_cone(const std::string& path) {
  const Vec3 light_at(0, 0, 4);
  const std::array<Vec3, 4> quad{Vec3(-0.75, -0.5, 2.2), Vec3(0.7, -0.65, 2.2),
                                 Vec3(0.85, 0.45, 2.2), Vec3(-0.55, 0.6, 2.2)};
  const std::array<Vec3, 3> other{Vec3(0.3, -0.15, 1.2), Vec3(2.35, -0.5, 1.2),
                                  Vec3(2.0, 0.75, 1.2)};
  Eigen::AlignedBox3d box(light_at);
  for (const Vec3& x : quad) box.extend(x);
  box.extend(Vec3(-2, -2, 0)), box.extend(Vec3(2, 2, 0));
  const LightSpace space(Light::point(light_at), box);

  Page page(980, 480, "A cone in light space");
  const SideView view;
  const auto on_ground = [&](const Vec3& x) {
    return Vec3(light_at + (x - light_at) * (light_at.z() / (light_at.z() - x.z())));
  };

  // Left: the world.
  std::vector<Point> ground, face;
  for (const Vec3& x : quad) ground.push_back(view(on_ground(x))), face.push_back(view(x));
  page.polygon(ground, fill("#e5e7eb") + stroke("#9ca3af", 1));
  for (const Vec3& x : quad) page.line(view(light_at), view(on_ground(x)), stroke(soft, 1, "4 4"));
  page.polygon({view(light_at), view(on_ground(quad[1])), view(on_ground(quad[2]))},
               fill("#fbbf24", 0.3) + stroke(positive, 1));
  page.polygon(face, fill("#93c5fd", 0.9) + stroke(ink));
  page.line(face[1], face[2], stroke(positive, 3));
  page.dot(view(light_at), 6, fill("#facc15") + stroke(positive));
  page.write(view(light_at) + Point(14, -4), "light", "start");
  page.write((face[0] + face[2]) / 2 + Point(-14, 0), "face");
  page.write(view(on_ground(quad[1])) * 0.4 + view(on_ground(quad[2])) * 0.6 + Point(24, -18),
             "shadow plane of an edge:", "start");
  page.write(view(on_ground(quad[1])) * 0.4 + view(on_ground(quad[2])) * 0.6 + Point(24, 2),
             symbol("n", "1") + "&#183;<tspan font-style=\"italic\">r</tspan> = 0", "start");
  page.write((ground[0] + ground[2]) / 2 + Point(-10, 4), "shadow", "middle",
             "fill-opacity=\"0.7\"");
  page.write({225, 458}, "The world: a face and its shadow volume", "middle",
             "font-weight=\"bold\"");

  // Right: light space. The face is a cone, here cut by a plane; every line is a covector.
  const Point centre(690, 205);
  const auto place = [&](const Point& p) { return Point(centre + 235 * Point(p.x(), -p.y())); };
  std::vector<Point> cone, other_cone;
  std::vector<VertexRay> rays, other_rays;
  for (const Vec3& x : quad) rays.push_back(space.ray(x)), cone.push_back(section(rays.back().r));
  for (const Vec3& x : other)
    other_rays.push_back(space.ray(x)), other_cone.push_back(section(other_rays.back().r));
  const auto placed = [&](const std::vector<Point>& points) {
    std::vector<Point> out;
    for (const Point& p : points) out.push_back(place(p));
    return out;
  };
  page.polygon(placed(cone), fill("#93c5fd", 0.9));
  page.polygon(placed(other_cone), fill("#d1d5db", 0.6) + stroke(soft, 1.2));

  // Lines of edges, extended. An arrow shows the side on which n.r is positive.
  std::vector<Line> lines;
  Point middle(0, 0);
  for (const Point& p : cone) middle += p / 4;
  const double inside[3] = {middle.x(), middle.y(), -1};
  for (std::size_t i = 0; i < 4; ++i) {
    Line line = space.line(quad[i], quad[(i + 1) % 4]);
    // The engine's cones have every line positive inside.
    if (dot(line.n, inside) < 0)
      for (double& c : line.n) c = -c;
    lines.push_back(line);
    const Point a = cone[i], b = cone[(i + 1) % 4], along = (b - a).normalized();
    const bool first = i == 1;
    page.line(place(a - 0.18 * along), place(b + (first ? 0.42 : 0.18) * along),
              stroke(first ? positive : ink, first ? 2.5 : 1.5));
    const Point from = a + (b - a) * (first ? 0.72 : 0.5);
    const Point normal = Point(line.n[0], line.n[1]).normalized();
    page.line(place(from), place(from + 0.13 * normal),
              stroke(first ? positive : ink, 1.5) + "marker-end=\"url(#tip)\" ");
    page.write(place(from + 0.2 * normal), symbol("n", std::to_string(i)));
    const Point beside[] = {{-0.09, -0.09}, {0.1, -0.07}, {-0.07, 0.09}, {-0.1, 0.08}};
    page.write(place(a + beside[i]), symbol("r", std::to_string(i)));
  }
  for (const Point& p : cone) page.dot(place(p), 4, fill(ink));

  // The corners of another face, by the sign of the line n1; and the two corners of the cut.
  const Line& cut = lines[1];
  for (std::size_t i = 0; i < 3; ++i) {
    const bool plus = dot(cut.n, other_rays[i].r) > 0;
    page.dot(place(other_cone[i]), 10, fill(plus ? positive : negative));
    page.write(place(other_cone[i]), plus ? "+" : "&#8722;", "middle",
               "style=\"fill:#fff\" font-weight=\"bold\"");
    if ((dot(cut.n, other_rays[i].r) > 0) == (dot(cut.n, other_rays[(i + 1) % 3].r) > 0)) continue;
    const Line edge = space.line(other[i], other[(i + 1) % 3]);
    const Vec3 r = Vec3(cut.n[0], cut.n[1], cut.n[2]).cross(Vec3(edge.n[0], edge.n[1], edge.n[2]));
    page.dot(place(section(r.data())), 5, fill("#ffffff") + stroke(positive, 2.5));
  }
  const Point key(775, 352);
  page.dot(key, 10, fill(positive));
  page.write(key, "+", "middle", "style=\"fill:#fff\" font-weight=\"bold\"");
  page.write(key + Point(17, 0),
             symbol("n", "1") + "&#183;" + "<tspan font-style=\"italic\">r</tspan> &gt; 0, inside",
             "start");
  page.dot(key + Point(0, 26), 10, fill(negative));
  page.write(key + Point(0, 26), "&#8722;", "middle", "style=\"fill:#fff\" font-weight=\"bold\"");
  page.write(key + Point(17, 26),
             symbol("n", "1") + "&#183;" + "<tspan font-style=\"italic\">r</tspan> &lt; 0, outside",
             "start");
  page.dot(key + Point(0, 52), 5, fill("#ffffff") + stroke(positive, 2.5));
  page.write(key + Point(17, 52),
             "corner of the cut: " + symbol("n", "1") + " &#215; " +
                 "<tspan font-style=\"italic\">m</tspan>",
             "start");
  page.write({720, 458}, "Light space: lines n, corners r, another face cut by a line", "middle",
             "font-weight=\"bold\"");
  page.save(path);
}

// ---- the tree -----------------------------------------------------------------------------------

struct Shape {
  const char* name;
  const char* colour;
  double height;
  std::vector<Point> corners;  // as the light sees them, at the distance 1
};

const std::vector<Shape>& shapes() {
  static const std::vector<Shape> all{
      {"A", "#93c5fd", 2, {{-0.5, -0.45}, {0.65, -0.35}, {-0.05, 0.6}}},
      {"B", "#fcd34d", 0, {{0.1, -0.8}, {0.95, 0.2}, {0.15, 0.15}}},
      {"C", "#86efac", 3, {{-0.3, -0.28}, {0.06, -0.24}, {-0.12, 0.12}}}};
  return all;
}

class TreeFigure {
 public:
  explicit TreeFigure(const SvbspTree& tree)
      : tree_(tree), page_(1000, 660, "A small SVBSP tree") {}

  void draw(const std::string& path) {
    name_pieces();
    draw_view();
    lay_out(Place::root(), 0);
    step_ = 690 / next_leaf_;
    left_ = 300 + step_ / 2;
    // The tree is drawn over the arrows from the location lists, which need the places of the
    // pieces.
    const Page blank = page_;
    draw_branch(Place::root());
    page_ = blank;
    draw_locations();
    draw_branch(Place::root());
    page_.save(path);
  }

 private:
  static constexpr double top = 60, row = 64;

  const Shape& shape_of(FacetId facet) const { return shapes()[tree_.tables().object_of(facet)]; }
  // a0, a1, ...: the lines of the edges of A.
  std::string name_of(LineId line) const {
    for (std::size_t o = 0; o < tree_.tables().objects.size(); ++o) {
      const Object& object = tree_.tables().objects[o];
      if (!tree_.tables().lines.is_own(object, static_cast<std::uint32_t>(o), line)) continue;
      const char letter = static_cast<char>(shapes()[o].name[0] - 'A' + 'a');
      return symbol(std::string(1, letter), std::to_string(line.value() - object.first_edge));
    }
    return "?";
  }

  // A0, B0, B1, ...: in the order of the location lists.
  void name_pieces() {
    std::map<std::uint32_t, int> count;
    for (std::size_t i = 0; i < tree_.pieces.pieces().size(); ++i) {
      const Piece& piece = tree_.pieces.pieces()[i];
      if (piece.kind == Piece::Kind::free) continue;
      const std::uint32_t object = tree_.tables().object_of(piece.facet);
      names_[i] = shapes()[object].name + std::to_string(count[object]++);
    }
  }

  // The light's view, with the pieces.
  void draw_view() {
    const auto place = [](const Point& p) { return Point(120 + 150 * p.x(), 210 - 150 * p.y()); };
    const auto outline = [&](std::span<const ConeCorner> corners) {
      std::vector<Point> points;
      for (const ConeCorner& c : corners) points.push_back(place(section(c.r)));
      return points;
    };
    page_.write({120, 28}, "Seen from the light", "middle", "font-weight=\"bold\"");
    std::vector<std::pair<Point, std::string>> labels;
    // Far pieces first; a piece behind another face is drawn last, dashed.
    for (const std::size_t object : {1, 0, 2}) {
      for (const auto& [i, name] : names_) {
        const Piece& piece = tree_.pieces.pieces()[i];
        if (tree_.tables().object_of(piece.facet) != object || piece.kind == Piece::Kind::behind)
          continue;
        const std::vector<Point> points = outline(tree_.pieces.corners(piece));
        page_.polygon(points, fill(shape_of(piece.facet).colour) + stroke(ink, 1.2));
        Point middle(0, 0);
        for (const Point& p : points) middle += p / static_cast<double>(points.size());
        if (name == "A0") middle = place({-0.07, 0.3});
        labels.push_back({middle, name});
      }
    }
    for (const auto& [i, name] : names_) {
      const Piece& piece = tree_.pieces.pieces()[i];
      if (piece.kind != Piece::Kind::behind) continue;
      const std::vector<Point> points = outline(tree_.pieces.corners(piece));
      page_.polygon(points, fill("#1f2937", 0.18) + stroke(ink, 1.2, "5 4"));
      Point middle(0, 0);
      for (const Point& p : points) middle += p / static_cast<double>(points.size());
      labels.push_back({middle, name});
    }
    for (const auto& [at, name] : labels) page_.write(at, name);
    // Names of the lines of A, at its edges.
    const std::vector<Point>& a = shapes()[0].corners;
    const Object& object = tree_.tables().objects[0];
    for (std::uint32_t e = 0; e < object.edge_count; ++e) {
      const Line& line = tree_.tables().lines[LineId(object.first_edge + e)];
      Point ends[2], middle(0, 0);
      std::size_t found = 0;
      for (const Point& p : a) {
        middle += p / 3;
        const double r[3] = {p.x(), p.y(), -1};
        if (std::abs(dot(line.n, r)) < 1e-9 && found < 2) ends[found++] = p;
      }
      const Point along = ends[1] - ends[0],
                  at = ends[0] + along * (ends[0].x() < ends[1].x() ? 0.25 : 0.75);
      Point out(along.y(), -along.x());
      if (out.dot(at - middle) < 0) out = -out;
      page_.write(place(at + 0.1 * out.normalized()), name_of(LineId(object.first_edge + e)));
    }
    page_.write({120, 372}, "B2 is behind A: shadowed", "middle", "font-size=\"12\"");
  }

  // Leaves from left to right: positive sides first.
  void lay_out(Place place, int depth) {
    const Branch branch = tree_.branch(place);
    double x;
    if (branch.is_out()) {
      x = next_leaf_;
      next_leaf_ += 1;
    } else if (branch.is_pp()) {
      const Place front(branch.node(), 0);
      lay_out(front, depth + 1);
      x = where_[front.value()].x();
      // Room for the pieces on the right.
      next_leaf_ =
          std::max(next_leaf_, x + 1 + 1.0 * static_cast<double>(pieces_of(branch.node())));
    } else {
      const Place sides[2] = {Place(branch.node(), 0), Place(branch.node(), 1)};
      for (const Place side : sides) lay_out(side, depth + 1);
      x = (where_[sides[0].value()].x() + where_[sides[1].value()].x()) / 2;
    }
    where_[place.value()] = Point(x, depth);
  }
  std::size_t pieces_of(NodeId node) const {
    std::size_t count = 0;
    for (const auto& [i, name] : names_) {
      const Piece& piece = tree_.pieces.pieces()[i];
      count += piece.kind != Piece::Kind::at_leaf && piece.node() == node;
    }
    return count;
  }
  Point at(Place place) const {
    const Point& p = where_.at(place.value());
    return {left_ + step_ * p.x(), top + row * p.y()};
  }

  void draw_branch(Place place) {
    const Branch branch = tree_.branch(place);
    const Point here = at(place);
    if (branch.is_out()) {
      page_.box(here, 40, 20, fill("#ffffff") + stroke(soft, 1));
      page_.write(here, "OUT", "middle", "font-size=\"11\"");
      return;
    }
    const NodeId node = branch.node();
    for (std::uint32_t side = 0; side < (branch.is_pp() ? 1u : 2u); ++side) {
      const Place below(node, side);
      const Point to = at(below);
      page_.line(here, to, stroke(ink, 1.2));
      if (branch.is_sp()) {
        const Point middle = here + (to - here) * 0.5;
        const double shift = std::abs(to.x() - here.x()) < 30 ? 12 : 0;
        page_.dot(middle + Point(side == 0 ? -shift : shift, 0), 8, fill("#ffffff"));
        page_.write(middle + Point(side == 0 ? -shift : shift, 0), side == 0 ? "+" : "&#8722;",
                    "middle", side == 0 ? "style=\"fill:#b45309\"" : "style=\"fill:#1d4ed8\"");
      } else {
        page_.write(here + (to - here) * 0.58 + Point(8, 0), "in front", "start",
                    "font-size=\"11\" fill-opacity=\"0.75\"");
      }
      draw_branch(below);
    }
    if (branch.is_sp()) {
      page_.dot(here, 17, fill("#ffffff") + stroke(ink, 1.6));
      page_.write(here, name_of(tree_.node(node).line()));
      return;
    }
    draw_pp_node(node, here);
  }

  // The PP-node and the list of its pieces.
  void draw_pp_node(NodeId node, const Point& here) {
    const Shape& shape = shape_of(tree_.owner_facet(node));
    page_.box(here, 44, 30, fill(shape.colour) + stroke(ink, 1.6));
    page_.write(here, shape.name, "middle", "font-weight=\"bold\"");
    double x = here.x() + 54;
    for (const auto& [i, name] : names_) {
      const Piece& piece = tree_.pieces.pieces()[i];
      if (piece.kind == Piece::Kind::at_leaf || piece.node() != node) continue;
      const bool behind = piece.kind == Piece::Kind::behind;
      page_.line({x - 32, here.y()}, {x - 17, here.y()}, stroke(soft, 1));
      page_.box({x, here.y()}, 34, 22,
                fill(behind ? "#d1d5db" : shape_of(piece.facet).colour) +
                    stroke(ink, 1, behind ? "4 3" : ""));
      page_.write({x, here.y()}, name, "middle", "font-size=\"12\"");
      piece_at_[i] = {x, here.y() + 11};
      x += 52;
    }
  }

  void draw_locations() {
    const double y = 628;
    page_.write({330, y - 34}, "Location lists", "start", "font-weight=\"bold\"");
    double x = 330;
    for (std::size_t object = 0; object < shapes().size(); ++object) {
      page_.write({x, y}, std::string(shapes()[object].name) + ":", "start",
                  "font-weight=\"bold\"");
      x += 40;
      for (const auto& [i, name] : names_) {
        const Piece& piece = tree_.pieces.pieces()[i];
        if (tree_.tables().object_of(piece.facet) != object) continue;
        page_.box({x, y}, 34, 22, fill(shapes()[object].colour) + stroke(ink, 1));
        page_.write({x, y}, name, "middle", "font-size=\"12\"");
        if (object == 1) {
          const Point from(x, y - 11), to = piece_at_.at(i);
          page_.curve(from, from - Point(0, 70), to + Point(0, 70), to,
                      stroke("#b45309", 1, "2 3") + "marker-end=\"url(#tip)\" ");
        }
        x += 44;
      }
      x += 26;
    }
    // Legend.
    const Point key(40, 440);
    page_.dot(key, 13, fill("#ffffff") + stroke(ink, 1.6));
    page_.write(key + Point(26, 0), "SP-node: line of an edge", "start");
    page_.box(key + Point(0, 40), 30, 22, fill("#e5e7eb") + stroke(ink, 1.6));
    page_.write(key + Point(26, 40), "PP-node: plane of a face", "start");
    page_.box(key + Point(0, 78), 34, 20, fill("#ffffff") + stroke(soft, 1));
    page_.write(key + Point(0, 78), "OUT", "middle", "font-size=\"11\"");
    page_.write(key + Point(26, 78), "OUT leaf: lit", "start");
    page_.box(key + Point(0, 114), 30, 22, fill("#93c5fd") + stroke(ink, 1));
    page_.write(key + Point(26, 114), "piece on its PP-node", "start");
    page_.box(key + Point(0, 150), 30, 22, fill("#d1d5db") + stroke(ink, 1, "4 3"));
    page_.write(key + Point(26, 150), "piece behind: shadowed", "start");
    page_.write({650, 28}, "The tree, in the order of insertion A, B, C", "middle",
                "font-weight=\"bold\"");
  }

  const SvbspTree& tree_;
  Page page_;
  std::map<std::size_t, std::string> names_;  // by piece
  std::map<std::uint32_t, Point> where_;      // by place: number of the leaf, depth
  std::map<std::size_t, Point> piece_at_;
  double next_leaf_ = 0, left_ = 0, step_ = 0;
};

void draw_tree(const std::string& path) {
  const double light_height = 4;
  Scene scene;
  for (const Shape& shape : shapes()) {
    Mesh mesh;
    std::vector<std::uint32_t> face;
    const double distance = light_height - shape.height;
    for (const Point& p : shape.corners) {
      face.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
      mesh.vertices.push_back({p.x() * distance, p.y() * distance, shape.height});
    }
    mesh.add_face(face);
    ObjectSettings settings;
    settings.name = shape.name;
    settings.sides = Sides::open;
    scene.add(mesh, settings);
  }
  Options options;
  options.threads = 1;
  options.tuning.order = Order::as_given;
  options.tuning.facets_per_cell = 0;
  const LightState state(scene, Light::point({0, 0, light_height}), options);
  TreeFigure(state.view().grid[CellId(0u)]).draw(path);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: shadowcut_figures FOLDER\n";
    return 2;
  }
  try {
    const std::string folder = argv[1];
    draw_cone(folder + "/light_space_cone.svg");
    draw_tree(folder + "/svbsp_tree.svg");
  } catch (const std::exception& error) {
    std::cerr << "shadowcut_figures: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
