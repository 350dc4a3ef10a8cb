#include "light_space/light_space.hpp"

#include <cmath>
#include <utility>

namespace shadowcut {
namespace {

// Beyond this many scene radii a point light is treated in the far frame. Nearer, plain differences
// from the light lose under five bits.
constexpr double far_radii = 16;

// A bound rounded to float, and never below the bound.
float up(double bound) { return static_cast<float>(bound) * (1 + 0x1p-22f); }

}  // namespace

LightSpace::LightSpace(const Light& light, const Eigen::AlignedBox3d& box) {
  const Vec3 middle = box.isEmpty() ? Vec3::Zero().eval() : Vec3(box.min() / 2 + box.max() / 2);
  const double radius = box.isEmpty() ? 1.0 : std::max((box.max() - middle).stableNorm(), 1e-300);
  const bool directional = light.kind == Light::Kind::directional;
  const Vec3 d =
      directional ? light.direction.stableNormalized().eval() : Vec3(middle - light.position);
  far_ = directional || d.stableNorm() > far_radii * radius;
  center_ = far_ ? middle : light.position;
  int exponent;
  std::frexp(far_ ? radius : std::max(radius, d.stableNorm()), &exponent);
  scale_ = std::ldexp(1.0, exponent), inverse_scale_ = std::ldexp(1.0, -exponent);
  if (!far_) {
    // Seen from the origin, a loop with a x b > 0 inside runs clockwise.
    handedness_ = -1;
    return;
  }
  Eigen::Index z;
  d.cwiseAbs().maxCoeff(&z);
  axis_[0] = static_cast<int>((z + 1) % 3), axis_[1] = static_cast<int>((z + 2) % 3),
  axis_[2] = static_cast<int>(z);
  shear_x_ = d[axis_[0]] / d[z];
  shear_y_ = d[axis_[1]] / d[z];
  inverse_depth_ = directional ? 0 : 1 / d[z];
  sign_ = d[z] > 0 ? 1 : -1;
  // The light looks along its axis. When d_z > 0 it sees the back of the (x, y) plane.
  handedness_ = d[z] > 0 ? -1 : 1;
}

// Near: one rounding a component. Far: X has one rounding; a sheared component at most five
// roundings of |X_x| + |X_z| (|shear| <= 1).
LightSpace::Raw LightSpace::raw_ray(const Vec3& x) const {
  const Vec3 d = x - center_;
  if (!far_) {
    const Vec3 r = d * inverse_scale_;
    return {r, unit_roundoff * r.norm()};
  }
  const double a = d[axis_[0]], b = d[axis_[1]], c = d[axis_[2]];
  const Vec3 r((a - shear_x_ * c) * inverse_scale_, (b - shear_y_ * c) * inverse_scale_,
               1 + c * inverse_depth_);
  const double size = (std::abs(a) + std::abs(b) + 2 * std::abs(c)) * inverse_scale_;
  return {r, unit_roundoff * (5 * size + 3 * std::abs(c * inverse_depth_) + 1)};
}

VertexRay LightSpace::ray(const Vec3& x) const {
  const Raw raw = raw_ray(x);
  const double length = raw.r.norm();
  VertexRay out{{raw.r[0] / length, raw.r[1] / length, raw.r[2] / length},
                up(raw.error / length + 2 * unit_roundoff)};
  return out;
}

// n = r x e, where e is the image of b - a: the corners are subtracted before the light's distance
// costs digits. The end with the shorter ray gives the better-conditioned product.
Line LightSpace::line(const Vec3& a, const Vec3& b) const {
  const Raw ra = raw_ray(a), rb = raw_ray(b);
  const Raw& from = ra.r.squaredNorm() <= rb.r.squaredNorm() ? ra : rb;
  const Vec3 d = b - a;
  Vec3 e = d * inverse_scale_;
  double e_error = unit_roundoff * e.norm();
  if (far_) {
    const double x = d[axis_[0]], y = d[axis_[1]], z = d[axis_[2]];
    e = Vec3((x - shear_x_ * z) * inverse_scale_, (y - shear_y_ * z) * inverse_scale_,
             z * inverse_depth_);
    e_error = unit_roundoff * (5 * (std::abs(x) + std::abs(y) + 2 * std::abs(z)) * inverse_scale_ +
                               2 * std::abs(e[2]));
  }
  const Vec3 n = from.r.cross(e);
  const double r_length = from.r.norm(), e_length = e.norm(), length = n.norm();
  const double error =
      r_length * e_error + e_length * from.error + 4 * unit_roundoff * r_length * e_length;
  return {{n[0] / length, n[1] / length, n[2] / length},
          up(error / length + 2 * unit_roundoff),
          invalid_index,
          invalid_index};
}

// The signed distance of the light from the plane, to a positive factor: positive when the front
// faces away. `error`: of this number, for the plane as given. `tilted`: by how much the number may
// change because the plane is only as certain as its corners.
double LightSpace::awayness(const Plane& p, double& error, double& tilted) const {
  const Vec3 d = p.point - center_;
  const Vec3 m = p.normal;
  const double reach = m.dot(d) * inverse_scale_,
               size = m.cwiseAbs().dot(d.cwiseAbs()) * inverse_scale_,
               flatness = p.flatness * inverse_scale_;
  if (!far_) {
    error = 6 * unit_roundoff * size + flatness;
    tilted = p.tilt * d.stableNorm() * inverse_scale_;
    return reach;
  }
  const double inverse_depth = inverse_depth_ * scale_;
  const double mx = m[axis_[0]], my = m[axis_[1]], mz = m[axis_[2]];
  const double k = mx * shear_x_ + my * shear_y_ + mz + reach * inverse_depth;
  error = 8 * unit_roundoff *
              (std::abs(mx) + std::abs(my) + std::abs(mz) + size * std::abs(inverse_depth)) +
          flatness * std::abs(inverse_depth);
  tilted = 2 * p.tilt;
  return k * sign_;
}

Orientation LightSpace::orientation(const Plane& p) const {
  double error, tilted;
  const double g = awayness(p, error, tilted);
  if (!(std::abs(g) > 2 * (error + tilted))) return Orientation::edge_on;
  return g > 0 ? Orientation::away : Orientation::toward;
}

// Substituting the inverse of T into m.X + p W = 0, with p = -m.(point - C).
PlaneCovector LightSpace::plane(const Plane& p) const {
  const Vec3 d = p.point - center_;
  const Vec3& m = p.normal;
  const double reach = m.dot(d) * inverse_scale_,
               size = m.cwiseAbs().dot(d.cwiseAbs()) * inverse_scale_;
  double g_error, unused;
  const double g = awayness(p, g_error, unused);
  PlaneCovector out{};
  double numerator_error = 0;  // absolute, in addition to the rounding of each component
  if (!far_) {
    for (int i = 0; i < 3; ++i) out.q[i] = m[i] / reach;
  } else {
    out.q[0] = m[axis_[0]] / g;  // g is sign_ K: m was sheared in awayness
    out.q[1] = m[axis_[1]] / g;
    out.q[2] = -reach / g;
    numerator_error = unit_roundoff * (2 + 5 * size) + p.flatness * inverse_scale_;
  }
  const double length = std::sqrt(out.q[0] * out.q[0] + out.q[1] * out.q[1] + out.q[2] * out.q[2]);
  // The relative error of the denominator moves all of q.
  out.error = up((length * g_error + numerator_error) / std::abs(g) + 4 * unit_roundoff * length);
  return out;
}

Vec3 LightSpace::covector(const Plane& p) const {
  const Vec3& m = p.normal;
  if (!far_) return m;
  return Vec3(m[axis_[0]], m[axis_[1]], -m.dot(p.point - center_) * inverse_scale_).normalized();
}

// Near: a ray at distance D that turns by e moves the point by D e across itself, and by that over
// the sine of its angle with the plane, which is |m.(p - C)| / D, along the plane. Far: across, by
// the ray's length times the scale; then along the light's direction, which has no component above
// 1.2 where the third is 1, until the plane is met.
double LightSpace::spread(const Vec3& x, const Plane& p) const {
  if (!far_) return (x - center_).squaredNorm() / std::abs(p.normal.dot(p.point - center_));
  double unused_error, unused_tilt;
  const double k = std::abs(awayness(p, unused_error, unused_tilt));
  return 1.2 * scale_ * raw_ray(x).r.norm() * (1 + 2 / k);
}

double LightSpace::slide(const Vec3& x, const Plane& p) const {
  if (!far_) return (x - center_).norm() / std::abs(p.normal.dot(p.point - center_));
  double unused_error, unused_tilt;
  // 2.1 bounds the length of a vector without a component above 1.2.
  return 2.1 / std::abs(awayness(p, unused_error, unused_tilt));
}

std::pair<Vec3, Vec3> LightSpace::span(const Vec3& n) const {
  // Short numbers: sums and products of them stay exact for longer.
  const auto shortened = [this](const Vec3& x) {
    return Vec3(x.unaryExpr([this](double c) {
      return std::nearbyint(c * inverse_scale_ * 0x1p24) * (scale_ * 0x1p-24);
    }));
  };
  if (!far_) {
    const Vec3 u = n.unitOrthogonal(), v = n.cross(u);
    return {shortened(center_ + scale_ * u), shortened(center_ + scale_ * v)};
  }
  // Where the line crosses the plane through the centre that the frame's axis stands on: r = (foot
  // + t along, 1).
  const double length = n[0] * n[0] + n[1] * n[1];
  const double foot[2] = {-n[2] * n[0] / length, -n[2] * n[1] / length},
               along[2] = {n[1] / std::sqrt(length), -n[0] / std::sqrt(length)};
  const auto at = [&](double t) {
    return shortened(back_from_far({foot[0] + t * along[0], foot[1] + t * along[1], 1}, 0));
  };
  return {at(0), at(1)};
}

Vec3 LightSpace::back_from_far(const Vec3& r, double h) const {
  const double z = -sign_ * scale_ * h;
  const double w = r[2] - z * inverse_depth_;
  Vec3 x;
  x[axis_[0]] = (scale_ * r[0] + shear_x_ * z) / w;
  x[axis_[1]] = (scale_ * r[1] + shear_y_ * z) / w;
  x[axis_[2]] = z / w;
  return center_ + x;
}

}  // namespace shadowcut
