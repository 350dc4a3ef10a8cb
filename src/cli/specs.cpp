// Parsing of arguments; see specs.hpp.
#include "specs.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>

namespace shadowcut::cli {

namespace {

// A list of finite numbers separated by commas, or nullopt.
std::optional<std::vector<double>> parse_numbers(std::string_view text) {
  std::vector<double> numbers;
  const char *at = text.data(), *const end = at + text.size();
  while (true) {
    double value = 0;
    const auto [rest, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
    numbers.push_back(value);
    if (rest == end) return numbers;
    if (*rest != ',') return std::nullopt;
    at = rest + 1;
  }
}

io::View camera_view(const std::vector<double>& n) {
  io::View view;
  view.kind = io::View::Kind::camera;
  view.eye = Vec3(n[0], n[1], n[2]);
  view.target = Vec3(n[3], n[4], n[5]);
  if (n.size() == 7) view.fov = n[6] * std::numbers::pi / 180;
  return view;
}

std::optional<io::View> face_view(std::string_view object, std::string_view number,
                                  const Scene& scene) {
  std::uint32_t face = 0;
  const auto [rest, error] = std::from_chars(number.data(), number.data() + number.size(), face);
  if (number.empty() || error != std::errc() || rest != number.data() + number.size())
    return std::nullopt;
  for (const Object& o : scene.objects()) {
    if (!o.alive || o.name != object) continue;
    if (face >= o.face_count)
      throw Error("--svg: object '" + o.name + "' has no face " + std::to_string(face));
    io::View view;
    view.kind = io::View::Kind::face;
    view.face = o.first_face + face;
    return view;
  }
  return std::nullopt;
}

template <typename Number>
std::string shortest_text(Number value) {
  char digits[32];
  return std::string(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

}  // namespace

std::string number_text(double value) { return shortest_text(value); }
std::string number_text(float value) { return shortest_text(value); }

Light parse_light(const std::string& spec) {
  const std::size_t colon = spec.find(':');
  const std::string kind = spec.substr(0, colon);
  const auto numbers = colon == std::string::npos
                           ? std::nullopt
                           : parse_numbers(std::string_view(spec).substr(colon + 1));
  const bool directional = kind == "directional" || kind == "sun";
  if ((kind != "point" && !directional) || !numbers || numbers->size() != 3)
    throw Error("--light: '" + spec + "' is neither point:x,y,z nor directional:dx,dy,dz");
  const Vec3 v((*numbers)[0], (*numbers)[1], (*numbers)[2]);
  const Light light = directional ? Light::directional(v) : Light::point(v);
  try {
    Scene().add(light);  // the scene's own checks
  } catch (const Error& error) {
    throw Error("--light: '" + spec + "': " + error.what());
  }
  return light;
}

std::string light_spec(const Light& light) {
  const bool point = light.kind == Light::Kind::point;
  const Vec3& v = point ? light.position : light.direction;
  return (point ? "point:" : "sun:") + number_text(v.x()) + "," + number_text(v.y()) + "," +
         number_text(v.z());
}

io::View parse_view(const std::string& spec, const Scene& scene) {
  const std::size_t colon = spec.rfind(':');
  const std::string_view before = std::string_view(spec).substr(0, colon);
  const std::string_view after =
      colon == std::string::npos ? std::string_view() : std::string_view(spec).substr(colon + 1);
  if (const auto view = face_view(before, after, scene)) return *view;
  const auto numbers = parse_numbers(colon == std::string::npos ? std::string_view(spec) : after);
  if (colon == std::string::npos && numbers && (numbers->size() == 6 || numbers->size() == 7))
    return camera_view(*numbers);
  io::View plan;
  if (spec == "plan") return plan;
  if (before == "plan" && numbers && numbers->size() == 1) {
    plan.cut = numbers->front();
    return plan;
  }
  throw Error("--svg: '" + spec +
              "' is not plan, plan:HEIGHT, OBJECT:FACE of this scene, or ex,ey,ez,tx,ty,tz[,fov]");
}

io::View parse_camera(const std::string& spec) {
  const auto numbers = parse_numbers(spec);
  if (!numbers || (numbers->size() != 6 && numbers->size() != 7))
    throw Error("--camera: '" + spec + "' is not ex,ey,ez,tx,ty,tz[,fov]");
  return camera_view(*numbers);
}

std::pair<int, int> parse_size(const std::string& spec) {
  int width = 0, height = 0;
  const char* const end = spec.data() + spec.size();
  const auto [cross, bad_width] = std::from_chars(spec.data(), end, width);
  const bool parted = bad_width == std::errc() && cross != end && *cross == 'x';
  const auto [rest, bad_height] = std::from_chars(parted ? cross + 1 : end, end, height);
  if (!parted || bad_height != std::errc() || rest != end || width <= 0 || height <= 0)
    throw Error("--size: '" + spec + "' is not WIDTHxHEIGHT in pixels");
  return {width, height};
}

std::vector<double> parse_numbers_of(const std::string& option, const std::string& text,
                                     const std::string& form) {
  const auto numbers = parse_numbers(text);
  const auto count = static_cast<std::size_t>(std::count(form.begin(), form.end(), ',')) + 1;
  if (!numbers || numbers->size() != count) throw Error(option + ": '" + text + "' is not " + form);
  return *numbers;
}

double parse_share(const std::string& option, const std::string& text) {
  const auto numbers = parse_numbers(text);
  if (!numbers || numbers->size() != 1 || numbers->front() < 0 || numbers->front() > 1)
    throw Error(option + ": '" + text + "' is not a number from 0 to 1");
  return numbers->front();
}

MinFeature parse_min_feature(const std::string& text) {
  MinFeature out;
  const bool is_angle = text.size() > 2 && text.ends_with("sr");
  const auto numbers =
      parse_numbers(std::string_view(text).substr(0, text.size() - (is_angle ? 2 : 0)));
  if (!numbers || numbers->size() != 1 || numbers->front() < 0)
    throw Error("--min-feature: '" + text +
                "' is neither an area nor a solid angle such as 1e-6sr");
  (is_angle ? out.solid_angle : out.area) = numbers->front();
  return out;
}

Vec3 parse_axis(const std::string& name) {
  return name == "x" ? Vec3::UnitX() : name == "y" ? Vec3::UnitY() : Vec3::UnitZ();
}

const std::map<std::string, Kernel>& kernels() {
  static const std::map<std::string, Kernel> all{{"fast", Kernel::fast}, {"exact", Kernel::exact}};
  return all;
}

const char* kernel_name(Kernel kernel) {
  for (const auto& [name, value] : kernels()) {
    if (value == kernel) return name.c_str();
  }
  return "";
}

}  // namespace shadowcut::cli
