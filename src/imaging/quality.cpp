// Limits are wide: they catch leaks, wrong images and suppressed fat, not unusual patients.
#include "imaging/quality.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "imaging/automatic.hpp"

namespace sanatrix::imaging {
namespace {

constexpr double clear_step = 0.5;  ///< of fat's signal
constexpr double least_seen = 0.35, doubtful_seen = 0.6;
constexpr double most_roughness_mm = 2.5;
constexpr double least_separation = 2.5, doubtful_separation = 4.0;
constexpr double least_soft_cm3 = 100.0, most_soft_cm3 = 6000.0, most_side_ratio = 2.5;

double root_mean_square_bend(const ChestWall& wall) {
  double sum = 0.0, count = 0.0;
  for (int k = 0; k < wall.slices; ++k) {
    for (int a = 1; a + 1 < wall.angles; ++a) {
      const double bend = wall.radius_mm[wall.index(a - 1, k)] -
                          2.0 * wall.radius_mm[wall.index(a, k)] +
                          wall.radius_mm[wall.index(a + 1, k)];
      sum += bend * bend;
      count += 1.0;
    }
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

}  // namespace

Quality assess(const AutomaticLabels& found) {
  Quality q;
  const ChestWall& wall = found.wall;
  // The front half of the rays; at the sides the image ends.
  std::vector<float> steps;
  for (int k = 0; k < wall.slices; ++k) {
    for (int a = wall.angles / 4; a < 3 * wall.angles / 4; ++a) {
      steps.push_back(wall.contrast[wall.index(a, k)]);
    }
  }
  const auto middle = steps.begin() + static_cast<long>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  q.wall_contrast = static_cast<double>(*middle);
  q.wall_seen = static_cast<double>(std::ranges::count_if(
                    steps, [](float s) { return static_cast<double>(s) > clear_step; })) /
                static_cast<double>(steps.size());
  q.wall_roughness_mm = root_mean_square_bend(wall);
  q.separation = found.gland.separation;
  if (q.wall_seen < least_seen) {
    q.defects.push_back(
        fmt::format("the chest wall is seen on only {:.0f} % of its front", 100.0 * q.wall_seen));
  } else if (q.wall_seen < doubtful_seen) {
    q.doubts.push_back(
        fmt::format("the chest wall is seen on {:.0f} % of its front; the rest is interpolated",
                    100.0 * q.wall_seen));
  }
  if (q.wall_roughness_mm > most_roughness_mm) {
    q.defects.push_back(fmt::format("the chest wall that was found is not smooth ({:.1f} mm)",
                                    q.wall_roughness_mm));
  }
  if (q.separation < least_separation) {
    q.defects.push_back(
        fmt::format("fat and gland cannot be told apart (separation {:.1f})", q.separation));
  } else if (q.separation < doubtful_separation) {
    q.doubts.push_back(fmt::format(
        "fat and gland differ by only {:.1f} standard deviations: their volumes are uncertain",
        q.separation));
  }
  return q;
}

void assess(const LabelImage& labels, double midline_x_mm, Quality& q) {
  std::size_t v = 0;
  const double cm3 = labels.voxel_volume_mm3() * 1e-3;
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int j = 0; j < labels.size[1]; ++j) {
      for (int i = 0; i < labels.size[0]; ++i, ++v) {
        const unsigned char label = labels.voxels[v];
        if (is_soft(label)) {
          const std::size_t side = labels.position_mm(i, j, k)[0] > midline_x_mm ? 1 : 0;
          q.soft_cm3[side] += cm3;
          q.glandular_cm3[side] +=
              label == static_cast<unsigned char>(Label::Fibroglandular) ? cm3 : 0.0;
        }
      }
    }
  }
  constexpr std::array names{"RIGHT", "LEFT"};
  for (const std::size_t side : {0U, 1U}) {
    if (q.soft_cm3[side] < least_soft_cm3 || q.soft_cm3[side] > most_soft_cm3) {
      q.defects.push_back(fmt::format("the patient's {} half has {:.0f} cm3 of soft tissue",
                                      names[side], q.soft_cm3[side]));
    }
  }
  const auto [low, high] = std::minmax(q.soft_cm3[0], q.soft_cm3[1]);
  if (low > 0.0 && high > most_side_ratio * low) {
    q.doubts.push_back(fmt::format("the two sides differ much: L {:.0f} cm3, R {:.0f} cm3",
                                   q.soft_cm3[1], q.soft_cm3[0]));
  }
}

}  // namespace sanatrix::imaging
