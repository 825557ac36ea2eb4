#include "outcome/torso.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "geometry/distance.hpp"
#include "outcome/scan_target.hpp"

namespace sanatrix::outcome {
namespace {

constexpr int columns = 400;  // of an outline: 0.3 mm on an average breast

BodyFrame frame_from(const Vec3& origin, const Vec3& left, const Vec3& up) {
  const Vec3 x = normalised(left - dot(left, up) * up);
  // In LPS left is x and up is z; x cross z is -y, which is anterior.
  return {origin, x, cross(x, up), up};
}

/// Upper and lower end of a breast's frontal projection over equally wide columns.
struct Silhouette {
  double from = 0, to = 0;  ///< x of the outermost columns
  std::vector<double> low, high;
  [[nodiscard]] double width() const { return (to - from) / columns; }
};

using Flat = std::array<std::array<double, 2>, 3>;

/// Triangles of a breast in (distance from the middle, height).
std::vector<Flat> flattened(const Torso& torso, const BodyFrame& frame, std::size_t side) {
  const int wanted = side == 0 ? -1 : 1;
  std::vector<Flat> flat;
  for (const auto& t : torso.skin.triangles) {
    const bool inside = std::ranges::all_of(
        t, [&](int v) { return torso.breast[static_cast<std::size_t>(v)] == wanted; });
    if (inside) {
      Flat corners;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 p = frame(torso.skin.points[static_cast<std::size_t>(t[k])]);
        corners[k] = {wanted * p[0], p[2]};
      }
      flat.push_back(corners);
    }
  }
  require(!flat.empty(), "the patient's {} breast has no skin in the model",
          side == 0 ? "RIGHT" : "LEFT");
  return flat;
}

std::array<double, 2> extent(const std::vector<Flat>& flat) {
  std::array<double, 2> range{1e300, -1e300};
  for (const Flat& triangle : flat) {
    for (const auto& corner : triangle) {
      range = {std::min(range[0], corner[0]), std::max(range[1], corner[0])};
    }
  }
  return range;
}

Silhouette silhouette(const std::vector<Flat>& flat, const std::array<double, 2>& range) {
  Silhouette s{range[0], range[1], std::vector<double>(columns, 1e300),
               std::vector<double>(columns, -1e300)};
  for (const Flat& triangle : flat) {
    for (std::size_t k = 0; k < 3; ++k) {
      auto a = triangle[k], b = triangle[(k + 1) % 3];
      if (a[0] > b[0]) {
        std::swap(a, b);
      }
      const auto position = [&](double x) {
        return (x - s.from) / s.width() - 0.5;
      };
      const int first = std::max(0, static_cast<int>(std::ceil(position(a[0]))));
      const int last = std::min(columns - 1, static_cast<int>(std::floor(position(b[0]))));
      for (int c = first; c <= last; ++c) {
        const double x = s.from + (c + 0.5) * s.width();
        const double share = b[0] > a[0] ? (x - a[0]) / (b[0] - a[0]) : 0.0;
        const double z = a[1] + share * (b[1] - a[1]);
        s.low[static_cast<std::size_t>(c)] = std::min(s.low[static_cast<std::size_t>(c)], z);
        s.high[static_cast<std::size_t>(c)] = std::max(s.high[static_cast<std::size_t>(c)], z);
      }
    }
  }
  return s;
}

/// Over the columns that the breast covers; a mean of `half` columns on both sides takes the teeth
/// off, which are the mesh's and not the patient's.
double length_of_lower_end(const Silhouette& s) {
  constexpr int half = 10;
  std::vector<double> z;
  for (int c = 0; c < columns; ++c) {
    double sum = 0, count = 0;
    for (int n = std::max(0, c - half); n <= std::min(columns - 1, c + half); ++n) {
      if (s.low[static_cast<std::size_t>(n)] < 1e299) {
        sum += s.low[static_cast<std::size_t>(n)];
        count += 1;
      }
    }
    if (count > 0) {
      z.push_back(sum / count);
    }
  }
  double length = 0;
  for (std::size_t i = 1; i < z.size(); ++i) {
    length += std::hypot(s.width(), z[i] - z[i - 1]);
  }
  return length;
}

/// The point farthest along a direction. Points less than 3 mm behind it have a share in where it
/// is across that direction, so that it does not jump between equals.
Vec3 extreme(const std::vector<Vec3>& points, const Vec3& direction) {
  constexpr double reach_m = 0.003;
  double farthest = -1e300;
  for (const Vec3& p : points) {
    farthest = std::max(farthest, dot(direction, p));
  }
  Vec3 sum{};
  double total = 0;
  for (const Vec3& p : points) {
    const double weight = std::max(0.0, 1 - (farthest - dot(direction, p)) / reach_m);
    sum += weight * p;
    total += weight;
  }
  const Vec3 mean = (1 / total) * sum;
  return mean + (farthest - dot(direction, mean)) * direction;
}

/// Mean squared distance along the normals of the mirrored still skin from itself, per unit area.
class MirrorFit {
 public:
  explicit MirrorFit(const Torso& torso) : target_(torso.skin) {
    const std::vector<double> areas = vertex_areas(torso.skin);
    const std::vector<bool> border = border_vertices(torso.skin);
    for (std::size_t v = 0; v < torso.skin.points.size(); ++v) {
      if (torso.breast[v] == 0 && !border[v]) {
        points_.push_back(torso.skin.points[v]);
        weights_.push_back(areas[v]);
      }
    }
  }
  [[nodiscard]] bool possible() const { return points_.size() >= 30; }

  /// One Gauss-Newton step for the turn about `up` and the shift along `left`.
  double improve(BodyFrame& frame) const {
    double a00 = 0, a01 = 0, a11 = 0, b0 = 0, b1 = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Vec3 mirrored = frame.mirror(points_[i]);
      const auto hit = target_.closest(mirrored);
      if (hit.on_border || hit.distance > 0.015) {
        continue;
      }
      const double r = dot(hit.normal, hit.point - mirrored);
      // M(p) = p - 2 (n.(p-c)) n: turning n by w about up changes n by w (up x n).
      const Vec3 arm = points_[i] - frame.origin;
      const double across = dot(frame.left, arm);
      const Vec3 turned = cross(frame.up, frame.left);
      const Vec3 d_turn = -2 * (dot(turned, arm) * frame.left + across * turned);
      const Vec3 d_shift = 2.0 * frame.left;
      const double j0 = dot(hit.normal, d_turn), j1 = dot(hit.normal, d_shift);
      const double far = r / 0.01;
      const double w = weights_[i] * std::max(0.0, 1 - far * far);
      a00 += w * j0 * j0;
      a01 += w * j0 * j1;
      a11 += w * j1 * j1;
      b0 += w * j0 * r;
      b1 += w * j1 * r;
    }
    const double determinant = a00 * a11 - a01 * a01;
    if (!(determinant > 1e-9 * a00 * a11)) {
      return 0.0;
    }
    const double turn = (a11 * b0 - a01 * b1) / determinant;
    const double shift = (a00 * b1 - a01 * b0) / determinant;
    const Vec3 left = frame.left + turn * cross(frame.up, frame.left);
    frame = frame_from(frame.origin + shift * frame.left, left, frame.up);
    return std::abs(shift) + 0.1 * std::abs(turn);
  }

 private:
  ScanTarget target_;
  std::vector<Vec3> points_;
  std::vector<double> weights_;
};

}  // namespace

BodyFrame body_frame(const Torso& torso, const Vec3& roughly_left) {
  BodyFrame frame = frame_from(torso.notch, roughly_left, normalised(torso.up));
  const MirrorFit fit(torso);
  if (fit.possible()) {
    for (int i = 0; i < 30 && fit.improve(frame) > 1e-8; ++i) {
    }
  }
  return frame;
}

Outline outline(const Torso& torso, const BodyFrame& frame, std::size_t side) {
  const std::vector<Flat> flat = flattened(torso, frame, side);
  const Silhouette s = silhouette(flat, extent(flat));
  Outline result;
  result.length_m = length_of_lower_end(s);
  for (std::size_t c = 0; c < columns; ++c) {
    result.area_m2 += std::max(0.0, s.high[c] - s.low[c]) * s.width();
  }
  const int wanted = side == 0 ? -1 : 1;
  std::vector<Vec3> points;
  for (std::size_t v = 0; v < torso.skin.points.size(); ++v) {
    if (torso.breast[v] == wanted) {
      points.push_back(frame(torso.skin.points[v]));
      points.back()[0] *= wanted;
    }
  }
  result.lowest = extreme(points, {0, 0, -1});
  result.lateral = extreme(points, {1, 0, 0});
  return result;
}

double overlap_difference(const Torso& torso, const BodyFrame& frame) {
  const std::vector<Flat> right = flattened(torso, frame, 0), left = flattened(torso, frame, 1);
  const std::array<double, 2> a = extent(right), b = extent(left);
  const std::array<double, 2> both{std::min(a[0], b[0]), std::max(a[1], b[1])};
  const Silhouette r = silhouette(right, both), l = silhouette(left, both);
  double area = 0;
  for (std::size_t c = 0; c < columns; ++c) {
    const double height_r = std::max(0.0, r.high[c] - r.low[c]);
    const double height_l = std::max(0.0, l.high[c] - l.low[c]);
    const double common =
        std::max(0.0, std::min(r.high[c], l.high[c]) - std::max(r.low[c], l.low[c]));
    area += (height_r + height_l - 2 * common) * r.width();
  }
  return area;
}

double rms_asymmetry(const Torso& torso, const BodyFrame& frame) {
  const ScanTarget target(torso.skin);
  const std::vector<double> areas = vertex_areas(torso.skin);
  std::array<double, 2> squares{}, weight{};
  for (std::size_t v = 0; v < torso.skin.points.size(); ++v) {
    if (torso.breast[v] != 0) {
      const auto hit = target.closest(frame.mirror(torso.skin.points[v]));
      if (!hit.on_border) {
        const std::size_t side = torso.breast[v] < 0 ? 0 : 1;
        squares[side] += areas[v] * hit.distance * hit.distance;
        weight[side] += areas[v];
      }
    }
  }
  double rms = 0;
  for (std::size_t side = 0; side < 2; ++side) {
    rms += weight[side] > 0 ? 0.5 * std::sqrt(squares[side] / weight[side]) : 0.0;
  }
  return rms;
}

}  // namespace sanatrix::outcome
