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
constexpr double most_blind = 0.25, doubtful_blind = 0.01;
constexpr double most_roughness_mm = 2.5;
constexpr double most_open_share = 0.05;  ///< of the slices; fewer are one end of the field
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

/// Patches of 30 mm along the body and 18 degrees around it in which less than 40 % has a step:
/// what the whole wall's share hides when one breast's half is lost in noise.
double blind_share(const ChestWall& wall, double slice_mm) {
  constexpr double patch_mm = 30.0, visible_step = 0.35, enough = 0.4;
  constexpr int rays = 20;
  const int high = std::min(wall.slices, std::max(2, static_cast<int>(patch_mm / slice_mm)));
  double patches = 0.0, blind = 0.0;
  for (int k = 0; k + high <= wall.slices; k += std::max(1, high / 2)) {
    for (int a = wall.angles / 4; a + rays < 3 * wall.angles / 4; a += rays / 2) {
      int seen = 0;
      for (int c = k; c < k + high; ++c) {
        for (int b = a; b < a + rays; ++b) {
          seen += static_cast<double>(wall.contrast[wall.index(b, c)]) > visible_step ? 1 : 0;
        }
      }
      patches += 1.0;
      blind += seen < enough * high * rays ? 1.0 : 0.0;
    }
  }
  return patches > 0.0 ? blind / patches : 0.0;
}

void check_wall(Quality& q) {
  if (q.wall_seen < least_seen) {
    q.defects.push_back(
        fmt::format("the chest wall is seen on only {:.0f} % of its front", 100.0 * q.wall_seen));
  } else if (q.wall_blind > most_blind) {
    q.defects.push_back(
        fmt::format("noise or shading hides {:.0f} % of the chest wall's places of 30 mm",
                    100.0 * q.wall_blind));
  } else if (q.wall_seen < doubtful_seen) {
    q.doubts.push_back(
        fmt::format("the chest wall is seen on {:.0f} % of its front; the rest is interpolated",
                    100.0 * q.wall_seen));
  } else if (q.wall_blind > doubtful_blind) {
    q.doubts.emplace_back(
        "the chest wall is not seen over 30 mm and more in places; it is "
        "interpolated there, look at overlay.png");
  }
  if (q.wall_roughness_mm > most_roughness_mm) {
    q.defects.push_back(fmt::format("the chest wall that was found is not smooth ({:.1f} mm)",
                                    q.wall_roughness_mm));
  }
}

/// Air close behind the chest wall, away from the flanks [mm2]: behind a body that the field shows
/// whole there is air, too, but not so soon.
double air_behind_wall_mm2(const LabelImage& labels, int k) {
  constexpr double near_mm = 40.0, inner_part = 0.8;  // of the columns that show the wall
  std::vector<std::array<int, 2>> wall;               // column, its first voxel of wall
  for (int i = 0; i < labels.size[0]; ++i) {
    for (int j = 0; j < labels.size[1]; ++j) {
      if (is_wall(labels.at(i, j, k))) {
        wall.push_back({i, j});
        break;
      }
    }
  }
  const auto aside =
      static_cast<std::size_t>(0.5 * (1.0 - inner_part) * static_cast<double>(wall.size()));
  const int reach = static_cast<int>(near_mm / labels.spacing_mm[1]);
  int air = 0;
  for (std::size_t c = aside; c + aside < wall.size(); ++c) {
    const auto [i, first] = wall[c];
    for (int j = first; j < std::min(first + reach, labels.size[1]); ++j) {
      air += labels.at(i, j, k) == 0 ? 1 : 0;
    }
  }
  return air * labels.spacing_mm[0] * labels.spacing_mm[1];
}

/// Slices in which there is: from the side air went through skin and fat that noise hides, and the
/// skin of the slice is wrong by centimetres.
int count_open_slices(const LabelImage& labels) {
  constexpr double open_mm2 = 100.0;
  int open = 0;
  for (int k = 0; k < labels.size[2]; ++k) {
    open += air_behind_wall_mm2(labels, k) > open_mm2 ? 1 : 0;
  }
  return open;
}

void check_skin(const LabelImage& labels, Quality& q) {
  q.open_slices = count_open_slices(labels);
  if (q.open_slices == 0) {
    return;
  }
  const std::string found = fmt::format(
      "the skin at the side is lost in noise in {} of {} slices: air was found behind the chest "
      "wall",
      q.open_slices, labels.size[2]);
  (q.open_slices > most_open_share * labels.size[2] ? q.defects : q.doubts).push_back(found);
}

constexpr std::array sides{"RIGHT", "LEFT"};

/// How far [mm] the skin of each half stands in front of the skin of the midline, per slice; and
/// what of the body the front and the sides of the image cut off.
struct Field {
  std::array<std::vector<double>, 2> stands_mm;
  std::array<double, 2> cut_mm2{};
};

Field view_field(const LabelImage& labels, double midline_i_mm) {
  const auto [nx, ny, nz] = labels.size;
  const int middle =
      std::clamp(static_cast<int>(std::lround(midline_i_mm / labels.spacing_mm[0])), 0, nx - 1);
  const auto front = [&](int i, int k) {
    int j = 0;
    while (j < ny && labels.at(i, j, k) == 0) {
      ++j;
    }
    return j;
  };
  Field field;
  const double dx = labels.spacing_mm[0], dy = labels.spacing_mm[1], dz = labels.spacing_mm[2];
  for (int k = 0; k < nz; ++k) {
    std::array<int, 2> tip{ny, ny};
    const int cleft = front(middle, k);
    for (int i = 0; i < nx; ++i) {
      const int j = front(i, k);
      const std::size_t side = i > middle ? 1 : 0;
      tip[side] = std::min(tip[side], j);
      field.cut_mm2[side] += j == 0 ? dx * dz : 0.0;
    }
    for (const std::size_t side : {0U, 1U}) {
      field.stands_mm[side].push_back(dy * (cleft - tip[side]));
      // A flank may be cut off, what stands in front of the midline's skin is breast.
      for (int j = 0; j < cleft; ++j) {
        field.cut_mm2[side] += labels.at(side == 0 ? 0 : nx - 1, j, k) != 0 ? dy * dz : 0.0;
      }
    }
  }
  return field;
}

void check_field(const LabelImage& labels, double midline_i_mm, Quality& q) {
  const Field field = view_field(labels, midline_i_mm);
  constexpr double most_cut_mm2 = 100.0, end_mm = 12.0, still_breast = 0.6;
  for (const std::size_t side : {0U, 1U}) {
    if (field.cut_mm2[side] > most_cut_mm2) {
      q.defects.push_back(
          fmt::format("the {} breast is cut off by the edge of the image over {:.0f} "
                      "cm2",
                      sides[side], 0.01 * field.cut_mm2[side]));
    }
    const auto& stands = field.stands_mm[side];
    const auto tip = std::ranges::max_element(stands);
    const double below_mm = static_cast<double>(tip - stands.begin()) * labels.spacing_mm[2];
    const double above_mm = static_cast<double>(stands.end() - 1 - tip) * labels.spacing_mm[2];
    for (const bool upper : {false, true}) {
      const char* end = upper ? "upper" : "lower";
      if ((upper ? above_mm : below_mm) < end_mm) {
        q.defects.push_back(
            fmt::format("the {} breast is cut off by the {} end of the image", sides[side], end));
      } else if ((upper ? stands.back() : stands.front()) > still_breast * *tip) {
        q.doubts.push_back(
            fmt::format("the {} breast goes on beyond the {} end of the image", sides[side], end));
      }
    }
  }
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
  q.wall_blind = blind_share(wall, found.grid.labels.spacing_mm[2]);
  check_skin(found.grid.labels, q);
  check_wall(q);
  check_field(found.grid.labels, wall.centre_i_mm, q);
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
  for (const std::size_t side : {0U, 1U}) {
    if (q.soft_cm3[side] < least_soft_cm3 || q.soft_cm3[side] > most_soft_cm3) {
      q.defects.push_back(fmt::format("the patient's {} half has {:.0f} cm3 of soft tissue",
                                      sides[side], q.soft_cm3[side]));
    }
  }
  const auto [low, high] = std::minmax(q.soft_cm3[0], q.soft_cm3[1]);
  if (low > 0.0 && high > most_side_ratio * low) {
    q.doubts.push_back(fmt::format("the two sides differ much: L {:.0f} cm3, R {:.0f} cm3",
                                   q.soft_cm3[1], q.soft_cm3[0]));
  }
}

}  // namespace sanatrix::imaging
