// The one connected piece of a resection around its tumour, sampled on a grid along the axis.
#include <algorithm>
#include <deque>
#include <limits>

#include "core/error.hpp"
#include "surgery/plan.hpp"

namespace sanatrix::surgery {
namespace {

constexpr double mm = 1e-3;
constexpr double usual_step = 2.0 * mm;
/// No resection is longer than this to either side of the tumour.
constexpr double longest = 300.0 * mm;
constexpr int parts = 4;          // of a grid cell's edge when measuring the volume
constexpr float outside = -1.0F;  // a sample that was looked at and is not removed

}  // namespace

std::size_t Resection::Grid::index(int i, int j, int k) const {
  const auto width = static_cast<std::size_t>(2 * half_width + 1);
  return (static_cast<std::size_t>(k + half_length) * width +
          static_cast<std::size_t>(j + half_width)) *
             width +
         static_cast<std::size_t>(i + half_width);
}

Vec3 Resection::sample_point(double i, double j, double k) const {
  return centre_ + grid_.step * (i * grid_.e1 + j * grid_.e2 + k * axis_);
}

/// Flood fill from the sample on the axis that is inside and nearest to the tumour's centre.
void Resection::fill_piece() {
  // A step below the width of the forbidden band (clearance on both sides of the skin) cannot
  // jump out of the body through the skin.
  grid_.step = std::min({usual_step, 1.5 * clearance_, 0.25 * radius_});
  const Vec3 helper = std::abs(axis_[2]) < 0.7 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
  grid_.e1 = normalised(cross(helper, axis_));
  grid_.e2 = cross(axis_, grid_.e1);
  grid_.half_width = static_cast<int>(std::ceil(radius_ / grid_.step)) + 1;
  grid_.half_length = static_cast<int>(longest / grid_.step);
  grid_.depth.assign(grid_.index(grid_.half_width, grid_.half_width, grid_.half_length) + 1, 0.0F);

  const auto inside = [this](int i, int j, int k) {
    const Vec3 p = sample_point(i, j, k);
    const double f = shape(p, {true, true});
    if (f >= 0.0) {
      return outside;
    }
    if (!body_.locate(p)) {
      meets_clip_planes_ = true;
      return outside;
    }
    return static_cast<float>(-f);
  };
  const int reach = static_cast<int>(radius_ / grid_.step);
  std::deque<std::array<int, 3>> queue;
  for (int k = 0; k <= reach && queue.empty(); ++k) {
    for (const int sign : {1, -1}) {
      const float depth = inside(0, 0, sign * k);
      if (depth > 0.0F && queue.empty()) {
        grid_.depth[grid_.index(0, 0, sign * k)] = depth;
        queue.push_back({0, 0, sign * k});
      }
    }
  }
  require(!queue.empty(),
          "surgery: nothing can be excised at the tumour: it is {:.1f} mm from the skin and "
          "{:.1f} mm from the chest wall, the clearance is {:.1f} mm; reduce clearance_mm",
          skin_tree_.closest(centre_).distance / mm, chest_tree_.closest(centre_).distance / mm,
          clearance_ / mm);
  while (!queue.empty()) {
    const auto at = queue.front();
    queue.pop_front();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const int sign : {1, -1}) {
        auto next = at;
        next[axis] += sign;
        const int limit = axis == 2 ? grid_.half_length : grid_.half_width;
        if (std::abs(next[axis]) >= limit) {
          continue;
        }
        float& depth = grid_.depth[grid_.index(next[0], next[1], next[2])];
        if (depth == 0.0F && (depth = inside(next[0], next[1], next[2])) > 0.0F) {
          queue.push_back(next);
        }
      }
    }
  }
}

/// A point of the shape belongs to the piece when a corner of its grid cell does.
bool Resection::in_piece(const Vec3& p) const {
  const Vec3 r = (1.0 / grid_.step) * (p - centre_);
  const std::array<int, 3> low{static_cast<int>(std::floor(dot(r, grid_.e1))),
                               static_cast<int>(std::floor(dot(r, grid_.e2))),
                               static_cast<int>(std::floor(dot(r, axis_)))};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int limit = axis == 2 ? grid_.half_length : grid_.half_width;
    if (low[axis] < -limit || low[axis] + 1 > limit) {
      return false;
    }
  }
  for (int corner = 0; corner < 8; ++corner) {
    if (grid_.depth[grid_.index(low[0] + (corner & 1), low[1] + (corner >> 1 & 1),
                                low[2] + (corner >> 2))] > 0.0F) {
      return true;
    }
  }
  return false;
}

Resection::Measure Resection::measure() const {
  // The tumour's centre is a removed point; samples near the caps can only lower its distances.
  Measure result{0.0, skin_tree_.closest(centre_).distance, chest_tree_.closest(centre_).distance};
  const int w = grid_.half_width, l = grid_.half_length;
  for (int k = -l; k < l; ++k) {
    for (int j = -w; j < w; ++j) {
      for (int i = -w; i < w; ++i) {
        measure_cell({i, j, k}, result);
      }
    }
  }
  return result;
}

void Resection::measure_cell(const std::array<int, 3>& low, Measure& sum) const {
  const double h = grid_.step, diagonal = std::sqrt(3.0) * h, small = h / parts;
  float shallowest = std::numeric_limits<float>::infinity(), deepest = outside;
  for (int corner = 0; corner < 8; ++corner) {
    const float depth = grid_.depth[grid_.index(low[0] + (corner & 1), low[1] + (corner >> 1 & 1),
                                                low[2] + (corner >> 2))];
    shallowest = std::min(shallowest, depth);
    deepest = std::max(deepest, depth);
  }
  if (deepest <= 0.0F) {
    return;
  }
  if (shallowest > 2.0 * diagonal) {
    sum.volume_m3 += h * h * h;
    return;
  }
  const auto at = [&low, this](double x, double y, double z) {
    return sample_point(low[0] + x, low[1] + y, low[2] + z);
  };
  const Caps caps = caps_near(at(0.5, 0.5, 0.5), diagonal);
  for (int part = 0; part < parts * parts * parts; ++part) {
    const Vec3 p = at((part % parts + 0.5) / parts, (part / parts % parts + 0.5) / parts,
                      (part / parts / parts + 0.5) / parts);
    const double f = shape(p, caps);
    // The share of a small cube below a plane at distance f, taken as linear across its width.
    const double share = std::clamp(0.5 - f / small, 0.0, 1.0);
    if (share == 0.0 || (meets_clip_planes_ && !body_.locate(p))) {
      continue;
    }
    sum.volume_m3 += share * small * small * small;
    if (f <= 0.0 && caps.skin) {
      sum.min_skin_distance_m = std::min(sum.min_skin_distance_m, skin_tree_.closest(p).distance);
    }
    if (f <= 0.0 && caps.chest) {
      sum.min_chest_distance_m =
          std::min(sum.min_chest_distance_m, chest_tree_.closest(p).distance);
    }
  }
}

}  // namespace sanatrix::surgery
