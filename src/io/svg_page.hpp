// A page of SVG: polygons, lines and words, with a scale bar. Page coordinates are px, y down.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>

namespace shadowcut::io {

using Point = Eigen::Vector2d;
using Colour = Eigen::Vector3d;  // sRGB, 0 to 1

class SvgPage {
 public:
  SvgPage(double width, double height, const Colour& background);

  // What follows belongs to `title`, until the next title; viewers show it where the pointer is.
  void title(std::string_view title);
  void polygon(std::span<const Point> corners, const Colour& fill, const Colour& stroke,
               double stroke_width);
  void line(const Point& a, const Point& b, const Colour& stroke, double stroke_width);
  void disc(const Point& centre, double radius, const Colour& fill, const Colour& stroke);
  void text(const Point& at, std::string_view words);
  void swatch(const Point& at, const Colour& fill, std::string_view words);
  // A bar of a round length, at the lower left.
  void scale_bar(double px_per_unit);

  double width() const { return width_; }
  double height() const { return height_; }
  std::string finish();  // the file's text

 private:
  void number(double value);
  void attributes(const Colour& fill, const Colour& stroke, double stroke_width);

  double width_, height_;
  std::string text_;
  std::string title_;
  bool in_group_ = false;
};

}  // namespace shadowcut::io
