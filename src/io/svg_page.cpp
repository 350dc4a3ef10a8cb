// A page of SVG; see svg_page.hpp.
#include "svg_page.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "text.hpp"

namespace shadowcut::io {

namespace {

std::string hex(const Colour& colour) {
  static constexpr std::string_view digits = "0123456789abcdef";
  std::string text = "#";
  for (const double c : colour) {
    const auto level = static_cast<std::size_t>(std::lround(std::clamp(c, 0.0, 1.0) * 255));
    text += digits[level >> 4];
    text += digits[level & 15];
  }
  return text;
}

std::string escaped(std::string_view words) {
  std::string text;
  for (const char c : printable(words)) {
    if (c == '<') text += "&lt;";
    else if (c == '>') text += "&gt;";
    else if (c == '&') text += "&amp;";
    else if (c == '"') text += "&quot;";
    else text += c;
  }
  return text;
}

// The greatest of 1, 2 and 5 times a power of ten that is not above `limit`.
double round_length(double limit) {
  const double power = std::pow(10.0, std::floor(std::log10(limit)));
  for (const double step : {5.0, 2.0}) {
    if (step * power <= limit) return step * power;
  }
  return power;
}

}  // namespace

SvgPage::SvgPage(double width, double height, const Colour& background)
    : width_(width), height_(height) {
  text_ =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" "
      "width=\"";
  number(width);
  text_ += "\" height=\"";
  number(height);
  text_ += "\" viewBox=\"0 0 ";
  number(width);
  text_ += ' ';
  number(height);
  text_ +=
      "\" stroke-linejoin=\"round\" font-family=\"sans-serif\" font-size=\"13\">\n<rect "
      "width=\"100%\" height=\"100%\" fill=\"" +
      hex(background) + "\"/>\n";
}

void SvgPage::number(double value) {
  char digits[64];
  const auto end = std::to_chars(digits, digits + sizeof digits, std::clamp(value, -1e9, 1e9),
                                 std::chars_format::fixed, 2)
                       .ptr;
  std::string_view word(digits, static_cast<std::size_t>(end - digits));
  while (word.ends_with('0')) word.remove_suffix(1);
  if (word.ends_with('.')) word.remove_suffix(1);
  text_ += word == "-0" ? "0" : word;
}

void SvgPage::attributes(const Colour& fill, const Colour& stroke, double stroke_width) {
  text_ += "\" fill=\"" + hex(fill) + "\" stroke=\"" + hex(stroke) + "\" stroke-width=\"";
  number(stroke_width);
  text_ += "\"/>\n";
}

void SvgPage::title(std::string_view title) {
  if (in_group_ && title_ == title) return;
  if (in_group_) text_ += "</g>\n";
  text_ += "<g>";
  if (!title.empty()) text_ += "<title>" + escaped(title) + "</title>";
  text_ += '\n';
  title_ = title;
  in_group_ = true;
}

void SvgPage::polygon(std::span<const Point> corners, const Colour& fill, const Colour& stroke,
                      double stroke_width) {
  text_ += "<polygon points=\"";
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i > 0) text_ += ' ';
    number(corners[i].x());
    text_ += ',';
    number(corners[i].y());
  }
  attributes(fill, stroke, stroke_width);
}

void SvgPage::line(const Point& a, const Point& b, const Colour& stroke, double stroke_width) {
  text_ += "<path d=\"M";
  number(a.x());
  text_ += ' ';
  number(a.y());
  text_ += 'L';
  number(b.x());
  text_ += ' ';
  number(b.y());
  text_ += "\" stroke=\"" + hex(stroke) + "\" stroke-width=\"";
  number(stroke_width);
  text_ += "\"/>\n";
}

void SvgPage::disc(const Point& centre, double radius, const Colour& fill, const Colour& stroke) {
  text_ += "<circle cx=\"";
  number(centre.x());
  text_ += "\" cy=\"";
  number(centre.y());
  text_ += "\" r=\"";
  number(radius);
  attributes(fill, stroke, 1);
}

void SvgPage::text(const Point& at, std::string_view words) {
  text_ += "<text x=\"";
  number(at.x());
  text_ += "\" y=\"";
  number(at.y());
  text_ += "\" fill=\"#222\">" + escaped(words) + "</text>\n";
}

void SvgPage::swatch(const Point& at, const Colour& fill, std::string_view words) {
  const Point corners[] = {at, at + Point(14, 0), at + Point(14, 14), at + Point(0, 14)};
  polygon(corners, fill, Colour(0.3, 0.3, 0.3), 0.75);
  text(at + Point(20, 12), words);
}

void SvgPage::scale_bar(double px_per_unit) {
  title("");
  const double length = round_length(0.25 * width_ / px_per_unit), bar = length * px_per_unit;
  const Point a(30, height_ - 22), b = a + Point(bar, 0), tick(0, 5);
  const Colour ink(0.13, 0.13, 0.13);
  line(a, b, ink, 1.5);
  line(a - tick, a + tick, ink, 1.5);
  line(b - tick, b + tick, ink, 1.5);
  std::string words;
  append(words, length);
  text(b + Point(10, 4.5), words + (length == 1 ? " scene unit" : " scene units"));
}

std::string SvgPage::finish() {
  if (in_group_) text_ += "</g>\n";
  in_group_ = false;
  return text_ += "</svg>\n";
}

}  // namespace shadowcut::io
