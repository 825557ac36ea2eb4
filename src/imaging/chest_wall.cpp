// Rays from an axis inside the thorax; on each the step from dark muscle to bright fat that no
// thick fat lies behind. Dynamic programming gives the best surface slice by slice, tied to its
// neighbours; a second pass works on the difference from the smoothed first one, so that a steep
// flank costs nothing.
#include "imaging/chest_wall.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace sanatrix::imaging {
namespace {

constexpr double radial_step_mm = 1.0;
constexpr int radii = 240;
constexpr double widest_angle = 125.0 * std::numbers::pi / 180.0;
constexpr double angle_step = 0.9 * std::numbers::pi / 180.0;
// Muscle is below a quarter of the signal of fat, marrow above a half, fat is 1.
constexpr float dark = 0.50F, bright = 0.92F;
constexpr double side_mm = 5.0;         ///< depth over which the sides of the step are averaged
constexpr double thick_fat_mm = 9.0;    ///< no such layer lies closely behind the wall
constexpr double fat_search_mm = 40.0;  ///< so far behind; gland is not that much deeper
constexpr double gland_weight = 0.5;    ///< of a step from muscle to gland, against one to fat
constexpr int most_step = 4;            ///< of the surface from ray to ray [radial steps]

/// Values on rays: slice, angle, radius (fastest).
struct Rays {
  int angles = 0, slices = 0;
  std::vector<float> value;
  [[nodiscard]] std::size_t line(int a, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(angles) +
            static_cast<std::size_t>(a)) *
           radii;
  }
};

/// Relative signal along every ray; -1 outside the body or the image.
Rays sample_signal(const Image3<float>& relative, const Mask& body, const ChestWall& frame) {
  Rays rays{frame.angles, frame.slices, {}};
  rays.value.assign(
      static_cast<std::size_t>(frame.angles) * static_cast<std::size_t>(frame.slices) * radii,
      -1.0F);
  for (int k = 0; k < frame.slices; ++k) {
    for (int a = 0; a < frame.angles; ++a) {
      const double angle = frame.first_angle + a * frame.angle_step;
      for (int r = 0; r < radii; ++r) {
        const double i =
            (frame.centre_i_mm + r * radial_step_mm * std::sin(angle)) / relative.spacing_mm[0];
        const double j =
            (frame.centre_j_mm - r * radial_step_mm * std::cos(angle)) / relative.spacing_mm[1];
        if (i < 0 || j < 0 || i > relative.size[0] - 1 || j > relative.size[1] - 1 ||
            body.at(static_cast<int>(std::lround(i)), static_cast<int>(std::lround(j)), k) == 0) {
          continue;
        }
        const Neighbourhood n = neighbourhood(relative, {i, j, static_cast<double>(k)});
        float g = 0.0F;
        for (std::size_t c = 0; c < 8; ++c) {
          g += static_cast<float>(n.weight[c]) * relative.voxels[n.voxel[c]];
        }
        rays.value[rays.line(a, k) + static_cast<std::size_t>(r)] = std::max(g, 0.0F);
      }
    }
  }
  return rays;
}

/// The signal as a share between two values; unknown stays -1.
Rays share_between(const Rays& signal, float zero, float one) {
  Rays share = signal;
  for (float& v : share.value) {
    v = v < 0.0F ? v : std::clamp((v - zero) / (one - zero), 0.0F, 1.0F);
  }
  return share;
}

/// Mean over the known values of an interval; `otherwise` when fewer than half are known.
double mean_known(const float* line, int from, int to, double otherwise) {
  double sum = 0.0;
  int known = 0;
  for (int r = std::max(0, from); r < std::min(radii, to); ++r) {
    if (line[r] >= 0.0F) {
      sum += static_cast<double>(line[r]);
      ++known;
    }
  }
  return 2 * known >= to - from ? sum / known : otherwise;
}

/// Cost of every position of the wall: minus the step, plus fat that would lie behind it and muscle
/// that would lie closely in front of it.
Rays position_cost(const Rays& signal) {
  const Rays fatness = share_between(signal, dark, bright);
  const Rays darkness = share_between(signal, 0.36F, 0.22F);
  Rays cost{fatness.angles, fatness.slices, std::vector<float>(fatness.value.size(), 0.0F)};
  constexpr int side = static_cast<int>(side_mm / radial_step_mm);
  constexpr int thick = static_cast<int>(thick_fat_mm / radial_step_mm);
  constexpr int search = static_cast<int>(fat_search_mm / radial_step_mm);
  for (int k = 0; k < fatness.slices; ++k) {
    for (int a = 0; a < fatness.angles; ++a) {
      const float* line = &fatness.value[fatness.line(a, k)];
      float* out = &cost.value[cost.line(a, k)];
      const float* dark_line = &darkness.value[darkness.line(a, k)];
      std::array<double, radii> muscle{};  // of a layer that begins at r
      for (int r = 0; r < radii; ++r) {
        muscle[static_cast<std::size_t>(r)] = mean_known(dark_line, r, r + 4, 0.0);
      }
      std::array<double, radii> layer{};  // of fat that ends at r
      for (int r = 0; r < radii; ++r) {
        layer[static_cast<std::size_t>(r)] = mean_known(line, r - thick, r, 0.0);
      }
      for (int r = 0; r < radii; ++r) {
        const double thickest =
            *std::max_element(&layer[static_cast<std::size_t>(std::max(r - search, 0))],
                              &layer[static_cast<std::size_t>(std::max(r - 1, 0))] + 1);
        const bool known = line[r] >= 0.0F || (r > 0 && line[r - 1] >= 0.0F);
        // At the border of the image nothing is known: no step, no gain.
        const double front = mean_known(line, r, r + side, 0.0);
        // Directly behind it is dark; muscle may be as thin as two steps.
        const double near_back = mean_known(line, r - 2, r, 1.0);
        double darkest = near_back;
        for (int q = r - side; q <= r - 3; ++q) {
          darkest = std::min(darkest, mean_known(line, q, q + 2, 1.0));
        }
        const double back = 0.5 * (near_back + darkest);
        // Where gland lies on muscle there is no fat in front; muscle is darker still.
        const double from_gland =
            mean_known(dark_line, r - 3, r, 0.0) - mean_known(dark_line, r, r + side, 1.0);
        const double step = known ? std::max(front - back, gland_weight * from_gland) : 0.0;
        const double fat_behind = std::max(0.0, thickest - 0.75) / 0.25;
        // Skin is the limit: a wall outside the body is impossible.
        const bool outside = r > 2 && line[r - 1] < 0.0F && line[r - 2] < 0.0F &&
                             mean_known(line, 0, r, -1.0) >= 0.0;
        const double muscle_in_front =
            *std::max_element(&muscle[static_cast<std::size_t>(std::min(r + 2, radii - 1))],
                              &muscle[static_cast<std::size_t>(std::min(r + 15, radii - 1))] + 1);
        out[r] = static_cast<float>(-std::max(step, 0.0) + 1.2 * fat_behind +
                                    0.25 * muscle_in_front + (outside ? 0.5 : 0.0));
      }
    }
  }
  return cost;
}

struct Stiffness {
  double along;    ///< per squared radial step between rays
  double between;  ///< per squared radial step from the neighbouring slices
};

/// Best closed-form path through one slice. `base`: what the path's shape is compared with.
void best_path(const Rays& cost, int k, const std::vector<double>& base, const Stiffness& stiff,
               const std::vector<double>& neighbours, std::vector<double>& radius) {
  const int n = cost.angles;
  constexpr float never = std::numeric_limits<float>::infinity();
  std::vector<float> best(static_cast<std::size_t>(n) * radii, never);
  std::vector<short> from(best.size(), 0);
  const auto own_cost = [&](int a, int r) {
    double c = static_cast<double>(cost.value[cost.line(a, k) + static_cast<std::size_t>(r)]);
    if (!neighbours.empty()) {
      const double off = r - neighbours[static_cast<std::size_t>(a)];
      c += stiff.between * std::min(off * off, 100.0);
    }
    return static_cast<float>(c);
  };
  for (int r = 0; r < radii; ++r) {
    best[static_cast<std::size_t>(r)] = own_cost(0, r);
  }
  for (int a = 1; a < n; ++a) {
    const float* before = &best[static_cast<std::size_t>(a - 1) * radii];
    float* here = &best[static_cast<std::size_t>(a) * radii];
    const double slope = base[static_cast<std::size_t>(a)] - base[static_cast<std::size_t>(a - 1)];
    const int shift = static_cast<int>(std::lround(slope));
    for (int r = 0; r < radii; ++r) {
      float least = never;
      int source = r;
      for (int d = -most_step; d <= most_step; ++d) {
        const int q = r - shift - d;
        if (q < 0 || q >= radii) {
          continue;
        }
        const double bend = (r - q) - slope;
        const float c = before[q] + static_cast<float>(stiff.along * bend * bend);
        if (c < least) {
          least = c;
          source = q;
        }
      }
      here[r] = least + own_cost(a, r);
      from[static_cast<std::size_t>(a) * radii + static_cast<std::size_t>(r)] =
          static_cast<short>(source);
    }
  }
  const auto last = best.end() - radii;
  int r = static_cast<int>(std::min_element(last, best.end()) - last);
  for (int a = n - 1; a >= 0; --a) {
    radius[static_cast<std::size_t>(k) * static_cast<std::size_t>(n) +
           static_cast<std::size_t>(a)] = r;
    r = from[static_cast<std::size_t>(a) * radii + static_cast<std::size_t>(r)];
  }
}

/// Median over neighbouring slices and rays, then Gaussian: the shape without single errors.
std::vector<double> smoothed(const std::vector<double>& radius, int angles, int slices,
                             int half_rays, int half_slices) {
  std::vector<double> median(radius.size());
  std::vector<double> window;
  for (int k = 0; k < slices; ++k) {
    for (int a = 0; a < angles; ++a) {
      window.clear();
      for (int c = std::max(0, k - half_slices); c <= std::min(slices - 1, k + half_slices); ++c) {
        for (int b = std::max(0, a - half_rays); b <= std::min(angles - 1, a + half_rays); ++b) {
          window.push_back(radius[static_cast<std::size_t>(c) * static_cast<std::size_t>(angles) +
                                  static_cast<std::size_t>(b)]);
        }
      }
      const auto middle = window.begin() + static_cast<long>(window.size() / 2);
      std::nth_element(window.begin(), middle, window.end());
      median[static_cast<std::size_t>(k) * static_cast<std::size_t>(angles) +
             static_cast<std::size_t>(a)] = *middle;
    }
  }
  Image3<float> image{.size = {angles, slices, 1},
                      .spacing_mm = {1.0 / half_rays, 1.0 / half_slices, 1.0},
                      .voxels = {median.begin(), median.end()}};
  smooth(image, 0.6);
  return {image.voxels.begin(), image.voxels.end()};
}

/// Anchored: the first round is tied to the base, so that slices at the end of the stack, which
/// support only each other, cannot go astray together.
enum class Start { Free, Anchored };

void best_surface(const Rays& cost, const std::vector<double>& base, const Stiffness& stiff,
                  Start start, int rounds, std::vector<double>& radius) {
  const auto n = static_cast<std::size_t>(cost.angles);
  for (int round = 0; round < rounds; ++round) {
    for (int k = 0; k < cost.slices; ++k) {
      std::vector<double> neighbours;
      if (round == 0 && start == Start::Anchored) {
        const auto first = base.begin() + static_cast<long>(static_cast<std::size_t>(k) * n);
        neighbours.assign(first, first + static_cast<long>(n));
      } else if (round > 0) {
        neighbours.assign(n, 0.0);
        for (std::size_t a = 0; a < n; ++a) {
          const auto at = [&](int c) {
            return radius[static_cast<std::size_t>(c) * n + a];
          };
          const int low = std::max(0, k - 1), high = std::min(cost.slices - 1, k + 1);
          neighbours[a] = 0.5 * (at(low == k ? high : low) + at(high == k ? low : high));
        }
      }
      const std::vector<double> own(
          base.begin() + static_cast<long>(static_cast<std::size_t>(k) * n),
          base.begin() + static_cast<long>(static_cast<std::size_t>(k + 1) * n));
      best_path(cost, k, own, stiff, neighbours, radius);
    }
  }
}

}  // namespace

double ChestWall::angle_of(double i_mm, double j_mm) const {
  return std::atan2(i_mm - centre_i_mm, centre_j_mm - j_mm);
}

double ChestWall::behind_mm(double i_mm, double j_mm, int k) const {
  const double di = i_mm - centre_i_mm, dj = centre_j_mm - j_mm;
  const double at =
      std::clamp((angle_of(i_mm, j_mm) - first_angle) / angle_step, 0.0, angles - 1.0);
  const int low = std::min(static_cast<int>(at), angles - 2);
  const double t = at - low;
  const double radius = (1.0 - t) * radius_mm[index(low, k)] + t * radius_mm[index(low + 1, k)];
  return radius - std::hypot(di, dj);
}

ChestWall find_chest_wall(const Image3<float>& relative, const Mask& body, double cleft_i_mm,
                          double cleft_j_mm) {
  ChestWall wall;
  wall.centre_i_mm = cleft_i_mm;
  wall.centre_j_mm = cleft_j_mm + thorax_radius_mm;
  wall.first_angle = -widest_angle;
  wall.angle_step = angle_step;
  wall.angles = 2 * static_cast<int>(widest_angle / angle_step) + 1;
  wall.slices = relative.size[2];
  const Rays cost = position_cost(sample_signal(relative, body, wall));
  std::vector<double> radius(static_cast<std::size_t>(wall.angles) *
                             static_cast<std::size_t>(wall.slices));
  std::vector<double> base(radius.size(), 0.0);
  best_surface(cost, base, {.along = 0.05, .between = 0.01}, Start::Free, 3, radius);
  base = smoothed(radius, wall.angles, wall.slices, 8,
                  std::max(3, static_cast<int>(std::lround(20.0 / relative.spacing_mm[2]))));
  best_surface(cost, base, {.along = 0.15, .between = 0.05}, Start::Anchored, 4, radius);
  const std::vector<double> fine = smoothed(radius, wall.angles, wall.slices, 2, 1);
  for (std::size_t p = 0; p < fine.size(); ++p) {
    const auto r = static_cast<std::size_t>(std::clamp(std::lround(radius[p]), 0L, radii - 1L));
    wall.radius_mm.push_back((fine[p] - 0.5) * radial_step_mm);
    wall.contrast.push_back(-cost.value[p * radii + r]);
  }
  return wall;
}

}  // namespace sanatrix::imaging
