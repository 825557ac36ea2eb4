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
constexpr double steepest = 1.7320508;  // Lipschitz bound of the rounded maximum of three distances
/// Of a grid cell's edge when measuring the volume.
int parts_of(Detail detail) {
  return detail == Detail::Full ? 4 : 2;
}
constexpr float outside = -1.0F;  // a sample that was looked at and is not removed

}  // namespace

bool Resection::Grid::holds(const std::array<int, 3>& at) const {
  return std::abs(at[0]) <= half_width && std::abs(at[1]) <= half_width &&
         std::abs(at[2]) <= half_length;
}

std::size_t Resection::Grid::index(const std::array<int, 3>& at) const {
  const auto width = static_cast<std::size_t>(2 * half_width + 1);
  return (static_cast<std::size_t>(at[2] + half_length) * width +
          static_cast<std::size_t>(at[1] + half_width)) *
             width +
         static_cast<std::size_t>(at[0] + half_width);
}

Vec3 Resection::sample_point(double i, double j, double k) const {
  return centre_ + grid_.step * (i * grid_.e1 + j * grid_.e2 + k * axis_);
}

std::array<double, 3> Resection::grid_position(const Vec3& p) const {
  const Vec3 r = (1.0 / grid_.step) * (p - centre_);
  return {dot(r, grid_.e1), dot(r, grid_.e2), dot(r, axis_)};
}

/// The neighbour's distances less one step are lower bounds here; only where they are too small to
/// exclude a cap are they measured. That saves most closest-point searches.
Resection::Sample Resection::sample(const std::array<int, 3>& at, const Sample& neighbour) {
  const Vec3 p = sample_point(at[0], at[1], at[2]);
  Sample result{outside, neighbour.skin - static_cast<float>(grid_.step),
                neighbour.chest - static_cast<float>(grid_.step)};
  if (lateral(p) >= 0.0) {
    return result;
  }
  const double far = clearance_ + blend_ + 3.0 * grid_.step;  // 3: reach of a grid cell and slack
  if (result.skin < far) {
    result.skin = static_cast<float>(skin_tree_.distance(p, any_reach));
  }
  if (result.chest < far) {
    result.chest = static_cast<float>(chest_tree_.distance(p, any_reach));
  }
  const double f = shape(p, {result.skin < far, result.chest < far});
  if (f >= 0.0) {
    return result;
  }
  if (!anatomy_->body().locate(p)) {
    meets_clip_planes_ = true;
    return result;
  }
  result.depth = std::min({static_cast<float>(-f), result.skin - static_cast<float>(clearance_),
                           result.chest - static_cast<float>(clearance_)});
  return result;
}

/// Flood fill from the sample on the axis that is inside and nearest to the tumour's centre.
void Resection::fill_piece() {
  // A step below the width of the forbidden band (clearance on both sides of the skin) cannot
  // jump out of the body through the skin.
  grid_.step = std::min({usual_step, 1.5 * clearance_, 0.25 * radius_});
  grid_.half_width = static_cast<int>(std::ceil(radius_ / grid_.step)) + 1;
  grid_.half_length = static_cast<int>(longest / grid_.step);
  grid_.samples.resize(grid_.index({grid_.half_width, grid_.half_width, grid_.half_length}) + 1);

  std::deque<std::array<int, 3>> queue;
  const auto visit = [&queue, this](const std::array<int, 3>& at, const Sample& neighbour) {
    Sample& here = grid_.samples[grid_.index(at)];
    if (here.depth == 0.0F) {
      here = sample(at, neighbour);
      if (here.depth > 0.0F) {
        queue.push_back(at);
      }
    }
  };
  const int reach = static_cast<int>(radius_ / grid_.step);
  for (int k = 0; k <= reach && queue.empty(); ++k) {
    visit({0, 0, k}, {});
    if (queue.empty()) {
      visit({0, 0, -k}, {});
    }
  }
  require(!queue.empty(),
          "surgery: nothing can be excised at the tumour: it is {:.1f} mm from the skin and "
          "{:.1f} mm from the chest wall, the clearance is {:.1f} mm; reduce clearance_mm",
          skin_tree_.distance(centre_, any_reach) / mm,
          chest_tree_.distance(centre_, any_reach) / mm, clearance_ / mm);
  while (!queue.empty()) {
    const auto at = queue.front();
    queue.pop_front();
    const Sample here = grid_.samples[grid_.index(at)];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const int sign : {1, -1}) {
        auto next = at;
        next[axis] += sign;
        if (grid_.holds(next)) {
          visit(next, here);
        }
      }
    }
  }
}

/// A point of the shape belongs to the piece when a corner of its grid cell does.
bool Resection::in_piece(const Vec3& p) const {
  std::array<int, 3> low{};
  const auto position = grid_position(p);
  std::ranges::transform(position, low.begin(),
                         [](double x) { return static_cast<int>(std::floor(x)); });
  for (int corner = 0; corner < 8; ++corner) {
    const std::array<int, 3> at{low[0] + (corner & 1), low[1] + (corner >> 1 & 1),
                                low[2] + (corner >> 2)};
    if (grid_.holds(at) && grid_.samples[grid_.index(at)].depth > 0.0F) {
      return true;
    }
  }
  return false;
}

Resection::Measure Resection::measure() const {
  // The tumour's centre is a removed point; samples near the caps can only lower its distances.
  Measure result{0.0, skin_tree_.distance(centre_, any_reach),
                 chest_tree_.distance(centre_, any_reach)};
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
  const int parts = parts_of(detail_);
  const double h = grid_.step, diagonal = std::sqrt(3.0) * h, small = h / parts;
  float shallowest = std::numeric_limits<float>::infinity(), deepest = outside;
  for (int corner = 0; corner < 8; ++corner) {
    const float depth = grid_
                            .samples[grid_.index({low[0] + (corner & 1), low[1] + (corner >> 1 & 1),
                                                  low[2] + (corner >> 2)})]
                            .depth;
    shallowest = std::min(shallowest, depth);
    deepest = std::max(deepest, depth);
  }
  if (deepest <= 0.0F) {
    return;
  }
  // No point of the cell is farther than half a diagonal from a corner.
  if (shallowest > 0.5 * diagonal * steepest) {
    sum.volume_m3 += h * h * h;
    return;
  }
  const auto at = [&low, this](double x, double y, double z) {
    return sample_point(low[0] + x, low[1] + y, low[2] + z);
  };
  const Caps caps = caps_near(at(0.5, 0.5, 0.5), diagonal);
  for (int part = 0; part < parts * parts * parts; ++part) {
    const int i = part % parts, j = part / parts % parts, k = part / (parts * parts);
    const Vec3 p = at((i + 0.5) / parts, (j + 0.5) / parts, (k + 0.5) / parts);
    const double f = shape(p, caps);
    // The share of a small cube below a plane at distance f, taken as linear across its width.
    const double share = std::clamp(0.5 - f / small, 0.0, 1.0);
    if (share == 0.0 || (meets_clip_planes_ && !anatomy_->body().locate(p))) {
      continue;
    }
    sum.volume_m3 += share * small * small * small;
    if (f > 0.0 || f < -small) {
      continue;  // not at the surface, where the smallest distances are
    }
    if (caps.skin) {
      sum.min_skin_distance_m =
          std::min(sum.min_skin_distance_m, skin_tree_.distance(p, any_reach));
    }
    if (caps.chest) {
      sum.min_chest_distance_m =
          std::min(sum.min_chest_distance_m, chest_tree_.distance(p, any_reach));
    }
  }
}

}  // namespace sanatrix::surgery
