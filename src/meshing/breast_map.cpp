// Where the breasts are: what stands in front of a large ball rolling over the prone torso.
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/error.hpp"
#include "meshing/anatomy.hpp"

namespace sanatrix::meshing {
namespace {

constexpr double footprint_prominence_mm = 10.0;
constexpr double clearly_mm = 20.0;  ///< of a nipple in front of a ball that is long enough
constexpr double lengthened = 1.25;
}  // namespace

const RollingBall standing_ball{80.0, 80.0, 130.0, 2};
const double standing_reach_mm = 115.0;
const double standing_above_mm = 60.0;

namespace {

/// The torso's shape needs no finer columns than this [mm].
constexpr double coarse_mm = 4.0;

ColumnMap coarsen(const ColumnMap& map) {
  const int step = std::max(1, static_cast<int>(std::lround(coarse_mm / map.spacing_mm)));
  ColumnMap coarse{.size = {(map.size[0] + step - 1) / step, (map.size[1] + step - 1) / step},
                   .spacing_mm = map.spacing_mm * step,
                   .origin_mm = map.origin_mm,
                   .value = {}};
  for (int k = 0; k < coarse.size[1]; ++k) {
    for (int i = 0; i < coarse.size[0]; ++i) {
      coarse.value.push_back(map.at(i * step, k * step));
    }
  }
  return coarse;
}

/// Extreme of y +- the ball's cap over all columns under the ball. sign +1 moves the ball's centre
/// back until it is inside the body everywhere, -1 gives the front of that ball.
ColumnMap roll(const ColumnMap& map, const RollingBall& ball, int sign) {
  const int reach_x = static_cast<int>(ball.x_mm / map.spacing_mm);
  const int reach_z = static_cast<int>(ball.z_mm / map.spacing_mm);
  std::vector<std::pair<std::array<int, 2>, double>> cap;
  for (int b = -reach_z; b <= reach_z; ++b) {
    for (int a = -reach_x; a <= reach_x; ++a) {
      const double x = a * map.spacing_mm / ball.x_mm, z = b * map.spacing_mm / ball.z_mm;
      if (x * x + z * z <= 1.0) {
        cap.push_back({{a, b}, ball.y_mm * std::sqrt(1.0 - x * x - z * z)});
      }
    }
  }
  ColumnMap result = map;
  for (int k = 0; k < map.size[1]; ++k) {
    for (int i = 0; i < map.size[0]; ++i) {
      double extreme = -1e9;
      for (const auto& [offset, height] : cap) {
        const int a = std::clamp(i + offset[0], 0, map.size[0] - 1);
        const int b = std::clamp(k + offset[1], 0, map.size[1] - 1);
        extreme = std::max(extreme, sign * map.at(a, b) + height);
      }
      result.at(i, k) = sign * extreme;
    }
  }
  return result;
}

/// Where breasts are looked for.
struct Rise {
  ColumnMap map;           ///< [mm] in front of a ball
  double breast_reach_mm;  ///< from the nipple, seen from the front
};

/// In front of the shortest of the balls that both nipples stand clearly forward of, or of the
/// longest. What is less high is less wide, too: the long ball leaves the flanks as well.
Rise clear_rise(const ColumnMap& skin, const AnatomyOptions& options) {
  RollingBall ball = options.ball;
  for (double reach_mm = options.breast_reach_mm;; reach_mm /= lengthened) {
    ColumnMap map = prominence_of(skin, ball);
    const bool clear = std::ranges::all_of(options.nipple_mm, [&](const Vec3& nipple) {
      return map.value[map.nearest(nipple[0], nipple[2])] >= clearly_mm;
    });
    if (clear || ball.lengthenings == 0) {
      return {std::move(map), reach_mm};
    }
    ball.z_mm *= lengthened;
    --ball.lengthenings;
  }
}

/// Columns of one rise of the map each, numbered; -1 outside `raised`. From the highest column down
/// every column joins the rise of its higher neighbours. Two rises that meet become one unless the
/// lower of them stands clearly above the saddle where they meet: an arm beside a breast is its
/// own.
std::vector<int> rises_of(const ColumnMap& map, const std::vector<bool>& raised,
                          double least_saddle) {
  std::vector<std::size_t> order;
  for (std::size_t c = 0; c < raised.size(); ++c) {
    if (raised[c]) {
      order.push_back(c);
    }
  }
  std::ranges::stable_sort(order, std::greater{}, [&](std::size_t c) { return map.value[c]; });
  std::vector<int> rise(raised.size(), -1), joined;
  std::vector<double> top;
  const auto root = [&](int r) {
    while (joined[static_cast<std::size_t>(r)] != r) {
      r = joined[static_cast<std::size_t>(r)];
    }
    return r;
  };
  const int nx = map.size[0];
  for (const std::size_t c : order) {
    const int i = static_cast<int>(c) % nx, k = static_cast<int>(c) / nx;
    for (const auto& [di, dk] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const int a = i + di, b = k + dk;
      if (a < 0 || b < 0 || a >= nx || b >= map.size[1] || rise[map.index(a, b)] < 0) {
        continue;
      }
      const int there = root(rise[map.index(a, b)]);
      const int here = rise[c] < 0 ? there : root(rise[c]);
      // Numbers grow as tops get lower.
      const auto [high, low] = std::minmax(here, there);
      if (map.value[c] > least_saddle * top[static_cast<std::size_t>(low)]) {
        joined[static_cast<std::size_t>(low)] = high;
      }
      rise[c] = rise[c] < 0 ? there : root(high);
    }
    if (rise[c] < 0) {
      rise[c] = static_cast<int>(top.size());
      joined.push_back(rise[c]);
      top.push_back(map.value[c]);
    }
  }
  for (int& r : rise) {
    r = r < 0 ? r : root(r);
  }
  return rise;
}

/// The rise that a nipple is on, on its side of the midline.
void mark_breast(BreastMap& breasts, const Rise& rise, const AnatomyOptions& options,
                 signed char side) {
  const ColumnMap& map = rise.map;
  const Vec3& nipple_mm = options.nipple_mm[side < 0 ? 0 : 1];
  std::vector<bool> raised;
  for (std::size_t c = 0; c < map.value.size(); ++c) {
    const std::size_t column = c % static_cast<std::size_t>(map.size[0]);
    const std::size_t row = c / static_cast<std::size_t>(map.size[0]);
    const double x = map.origin_mm[0] + static_cast<double>(column) * map.spacing_mm;
    const double z = map.origin_mm[1] + static_cast<double>(row) * map.spacing_mm;
    const bool mine = (x > options.midline_x_mm) == (side > 0) &&
                      std::hypot(x - nipple_mm[0], z - nipple_mm[2]) <= rise.breast_reach_mm;
    raised.push_back(mine && map.value[c] > footprint_prominence_mm);
  }
  const std::size_t tip = map.nearest(nipple_mm[0], nipple_mm[2]);
  if (!raised[tip]) {
    throw Error(Fault::Input,
                fmt::format("no breast on the patient's {}: the nipple at {:.0f} {:.0f} {:.0f} mm "
                            "stands only {:.0f} mm forward of the torso",
                            side > 0 ? "left" : "right", nipple_mm[0], nipple_mm[1], nipple_mm[2],
                            map.value[tip]),
                "the model needs both breasts, on a prone image or a standing scan");
  }
  const std::vector<int> rises = rises_of(map, raised, options.least_saddle);
  for (std::size_t c = 0; c < map.value.size(); ++c) {
    if (rises[c] == rises[tip]) {
      breasts.side[c] = side;
    }
  }
}

/// Median thickness of tissue over the chest beside the breasts.
double tissue_beside(const BreastMap& breasts, const ColumnMap& skin_y, const ColumnMap& chest_y) {
  std::vector<double> thickness;
  for (std::size_t c = 0; c < skin_y.value.size(); ++c) {
    const double t = chest_y.value[c] - skin_y.value[c];
    // Beside the chest a column runs along the flank and says nothing.
    if (breasts.side[c] == 0 && t > 0.0 && t < 60.0) {
      thickness.push_back(t);
    }
  }
  if (thickness.empty()) {
    return 20.0;
  }
  const auto middle = thickness.begin() + static_cast<long>(thickness.size() / 2);
  std::nth_element(thickness.begin(), middle, thickness.end());
  return *middle;
}

}  // namespace

void fill_smoothly(ColumnMap& map, const std::vector<std::size_t>& columns) {
  const auto nx = static_cast<std::size_t>(map.size[0]);
  const auto nz = static_cast<std::size_t>(map.size[1]);
  std::vector<bool> free(map.value.size(), false);
  for (const std::size_t c : columns) {
    free[c] = true;
  }
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t c = 0; c < free.size(); ++c) {
    sum += free[c] ? 0.0 : map.value[c];
    count += free[c] ? 0.0 : 1.0;
  }
  for (const std::size_t c : columns) {
    map.value[c] = sum / std::max(count, 1.0);
  }
  // Over-relaxed Gauss-Seidel for the Laplace equation; 0.05 mm is far below a voxel.
  for (int sweep = 0; sweep < 2000; ++sweep) {
    double change = 0.0;
    for (const std::size_t c : columns) {
      const std::size_t i = c % nx;
      const std::size_t k = c / nx;
      const double mean =
          0.25 * (map.value[i > 0 ? c - 1 : c] + map.value[i + 1 < nx ? c + 1 : c] +
                  map.value[k > 0 ? c - nx : c] + map.value[k + 1 < nz ? c + nx : c]);
      const double step = 1.8 * (mean - map.value[c]);
      map.value[c] += step;
      change = std::max(change, std::abs(step));
    }
    if (change < 0.05 * 0.01) {
      break;
    }
  }
}

ColumnMap prominence_of(const ColumnMap& skin_y, const RollingBall& ball) {
  ColumnMap prominence = roll(roll(skin_y, ball, 1), ball, -1);
  for (std::size_t c = 0; c < skin_y.value.size(); ++c) {
    prominence.value[c] -= skin_y.value[c];
  }
  return prominence;
}

BreastMap map_breasts(const ColumnMap& skin_y, const ColumnMap& chest_y,
                      const AnatomyOptions& options) {
  const ColumnMap skin = coarsen(skin_y);
  BreastMap breasts;
  breasts.prominence = prominence_of(skin, options.ball);
  breasts.side.assign(skin.value.size(), 0);
  // The long ball tells where a small breast is, but leaves the chest above and below it, too.
  const Rise rise = clear_rise(skin, options);
  mark_breast(breasts, rise, options, -1);
  mark_breast(breasts, rise, options, 1);
  std::vector<std::size_t> covered;
  for (std::size_t c = 0; c < breasts.side.size(); ++c) {
    if (breasts.side[c] != 0) {
      covered.push_back(c);
    }
  }
  breasts.base = skin;
  fill_smoothly(breasts.base, covered);
  breasts.behind_base_mm = tissue_beside(breasts, skin, coarsen(chest_y));
  return breasts;
}

}  // namespace sanatrix::meshing
