// Thorax and breasts of the phantom; docs/theory/phantom.md has the sizes and their reasons.
#include "phantom/anatomy.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"

namespace sanatrix::phantom {
namespace {

constexpr double mm = 1e-3, cm3 = 1e-6;
constexpr double flatness = 0.68;    // depth over width of the chest's front half
constexpr double groove = 4.0 * mm;  // of the sternum
constexpr double groove_width = 25.0 * mm;
constexpr double backward_slope = 0.05;  // of the chest towards the neck
constexpr double usual_volume = 600.0 * cm3;
constexpr double fold = 0.30;  // width of the transition from dome to layer, in r^2
constexpr int table = 801;

double shift_back(double z) {
  return backward_slope * z;
}

/// max(x, 0), rounded over |x| < fold.
double soft_positive(double x) {
  if (std::abs(x) >= fold) {
    return std::max(x, 0.0);
  }
  return (x + fold) * (x + fold) / (4.0 * fold);
}

double base_radius_for(double volume) {
  // Base width 80, 126 and 170 mm for 150, 600 and 1500 cm3.
  return 63.0 * mm * std::pow(volume / usual_volume, 0.33);
}

double half_distance_for(double volume) {
  return std::max(84.0 * mm, (1.0 + 0.5 * fold) * base_radius_for(volume) + 8.0 * mm);
}

}  // namespace

double uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

Thorax::Thorax(double half_arc) {
  // The quarter perimeter of an ellipse of this flatness is 1.336 times its half width.
  const double a = half_arc / 1.336, b = flatness * a;
  const auto curve = [a, b](double angle) {
    const double x = a * std::sin(angle), g = x / groove_width;
    return std::array{x, -b * std::cos(angle) + groove * std::exp(-g * g)};
  };
  constexpr int fine = 20000;
  std::vector<double> arc{0.0};
  auto last = curve(0.0);
  for (int i = 1; i <= fine; ++i) {
    const auto next = curve(0.5 * std::numbers::pi * i / fine);
    arc.push_back(arc.back() + std::hypot(next[0] - last[0], next[1] - last[1]));
    last = next;
  }
  half_arc_ = arc.back();
  step_ = 2.0 * half_arc_ / (table - 1);
  for (int i = 0; i < table; ++i) {
    const double s = -half_arc_ + i * step_;
    const auto above = std::ranges::lower_bound(arc, std::min(std::abs(s), half_arc_));
    const double angle =
        std::copysign(0.5 * std::numbers::pi * static_cast<double>(above - arc.begin()) / fine, s);
    const auto p = curve(angle);
    const double g = p[0] / groove_width, e = groove * std::exp(-g * g);
    // Derivatives of the curve by the angle.
    const double x1 = a * std::cos(angle), x2 = -a * std::sin(angle);
    const double slope = -2.0 * g / groove_width * e;
    const double bend = (4.0 * g * g - 2.0) / (groove_width * groove_width) * e;
    const double y1 = b * std::sin(angle) + slope * x1;
    const double y2 = b * std::cos(angle) + bend * x1 * x1 + slope * x2;
    const double speed = std::hypot(x1, y1);
    samples_.push_back(
        {p[0], p[1], y1 / speed, -x1 / speed, (x1 * y2 - y1 * x2) / (speed * speed * speed)});
  }
}

Thorax::Sample Thorax::at(double s) const {
  const double i = std::clamp((s + half_arc_) / step_, 0.0, table - 1.000001);
  const auto k = static_cast<std::size_t>(i);
  const double w = i - static_cast<double>(k);
  const Sample &p = samples_[k], &q = samples_[k + 1];
  const auto mix = [w](double u, double v) {
    return (1.0 - w) * u + w * v;
  };
  return {mix(p.x, q.x), mix(p.y, q.y), mix(p.nx, q.nx), mix(p.ny, q.ny),
          mix(p.curvature, q.curvature)};
}

Vec3 Thorax::normal(double s) const {
  const Sample c = at(s);
  return normalised({c.nx, c.ny, 0.0});
}

double Thorax::curvature(double s) const {
  return at(s).curvature;
}

Vec3 Thorax::point(const ChestPlace& place) const {
  const Sample c = at(place.s);
  return Vec3{c.x, c.y + shift_back(place.z), place.z} + place.t * normal(place.s);
}

ChestPlace Thorax::locate(const Vec3& p) const {
  const double y = p[1] - shift_back(p[2]);
  const auto distance2 = [&](int i) {
    const Sample& c = samples_[static_cast<std::size_t>(i)];
    return (c.x - p[0]) * (c.x - p[0]) + (c.y - y) * (c.y - y);
  };
  int best = 0;
  for (int stride = 40, from = 0, to = table - 1; stride >= 1; stride /= 6) {
    for (int i = from; i <= to; i += stride) {
      best = distance2(i) < distance2(best) ? i : best;
    }
    from = std::max(best - stride, 0);
    to = std::min(best + stride, table - 1);
  }
  // Along the normal of the nearest sample; the remainder along its tangent moves s.
  const Sample& c = samples_[static_cast<std::size_t>(best)];
  const double dx = p[0] - c.x, dy = y - c.y;
  const double t = dx * c.nx + dy * c.ny;
  const double along = (-dx * c.ny + dy * c.nx) / (1.0 + c.curvature * t);
  const double s = std::clamp(-half_arc_ + best * step_ + along, -half_arc_, half_arc_);
  const Sample exact = at(s);
  return {s, p[2], (p[0] - exact.x) * exact.nx + (y - exact.y) * exact.ny};
}

Anatomy::Anatomy(double volume_m3, std::uint64_t seed)
    : layer_(7.0 * mm + 6.0 * mm * std::sqrt(volume_m3 / usual_volume)),
      thorax_(half_distance_for(volume_m3) + 1.1 * base_radius_for(volume_m3) + 28.0 * mm) {
  std::mt19937_64 random(seed);
  for (const int i : {0, 1}) {
    const double volume = volume_m3 * uniform(random, 0.97, 1.03);
    Breast& breast = breasts_[static_cast<std::size_t>(i)];
    breast = {2.0 * i - 1.0,           0.0, uniform(random, -3.0, 3.0) * mm,
              base_radius_for(volume), 0.0, volume};
    breast.s = breast.side * (half_distance_for(volume_m3) + uniform(random, -1.5, 1.5) * mm);
    double low = 0.0, high = 3.0 * breast.radius;
    for (int k = 0; k < 40; ++k) {
      breast.projection = 0.5 * (low + high);
      (volume_within(breast) < volume ? low : high) = breast.projection;
    }
  }
  const double radius = base_radius_for(volume_m3);
  low_ = -0.95 * radius - 30.0 * mm;
  high_ = 1.15 * radius + 25.0 * mm;
}

double Anatomy::base_radius(const Breast& breast, double s, double z) const {
  const double u = (s - breast.s) * breast.side / breast.radius, w = (z - breast.z) / breast.radius;
  // The upper pole is longer than the lower one, and longest towards the armpit.
  const double pole = 1.0 + 0.12 * std::tanh(2.0 * w);
  const double r = std::hypot(u, w / pole);
  const double armpit = r > 0.0 ? std::max(0.0, (u + w) / (std::numbers::sqrt2 * r)) : 0.0;
  return r / (1.0 + 0.06 * armpit * armpit * std::min(r, 1.0));
}

double Anatomy::thickness(double s, double z) const {
  double h = layer_;
  for (const Breast& breast : breasts_) {
    const double r = base_radius(breast, s, z);
    h += breast.projection * soft_positive(1.0 - r * r);
  }
  return h;
}

double Anatomy::depth(const ChestPlace& place) const {
  constexpr double d = 0.5 * mm;
  const double stretch = 1.0 + thorax_.curvature(place.s) * place.t;
  const double by_s =
      (thickness(place.s + d, place.z) - thickness(place.s - d, place.z)) / (2.0 * d * stretch);
  const double by_z = (thickness(place.s, place.z + d) - thickness(place.s, place.z - d)) / (2 * d);
  return (thickness(place.s, place.z) - place.t) / std::sqrt(1.0 + by_s * by_s + by_z * by_z);
}

double Anatomy::volume_within(const Breast& breast) const {
  constexpr int n = 60;
  const double reach = 1.3 * breast.radius, step = 2.0 * reach / n;
  double volume = 0.0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double s = breast.s - reach + (i + 0.5) * step;
      const double z = breast.z - reach + (j + 0.5) * step;
      const double r = base_radius(breast, s, z);
      if (r < 1.0) {
        const double h = layer_ + breast.projection * soft_positive(1.0 - r * r);
        volume += (h + 0.5 * thorax_.curvature(s) * h * h) * step * step;
      }
    }
  }
  return volume;
}

}  // namespace sanatrix::phantom
