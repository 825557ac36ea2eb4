#include "standing/arms.hpp"

#include <algorithm>
#include <cmath>

namespace sanatrix::standing {
namespace {

/// Skin that comes forward again by this much beyond the flank is an arm; ribs and folds do less.
constexpr double arm_rise_mm = 15.0;
constexpr double gap_mm = 12.0;  ///< of nothing between trunk and arm
constexpr double beyond_all_mm = 1e9;
constexpr double least_height_mm = 20.0;  ///< of what is taken for an arm

/// x [mm] where the trunk ends in a row, walking outwards from below or above the nipple; far away
/// when there is nothing beside it.
double end_of_row(const FrontMap& front, const std::vector<bool>& holes, int row, double from_mm,
                  int step) {
  const meshing::ColumnMap& map = front.skin_y;
  const auto x_of = [&](int i) {
    return map.origin_mm[0] + i * map.spacing_mm;
  };
  int last = static_cast<int>(std::lround((from_mm - map.origin_mm[0]) / map.spacing_mm));
  int groove = last;
  double deepest = -1e9;
  for (int i = last; i >= 0 && i < map.size[0]; i += step) {
    const std::size_t c = map.index(i, row);
    if (!front.seen[c] && !holes[c]) {
      continue;
    }
    if (std::abs(i - last) * map.spacing_mm > gap_mm) {
      return 0.5 * (x_of(last) + x_of(i));
    }
    last = i;
    if (map.value[c] > deepest) {
      deepest = map.value[c];
      groove = i;
    }
    if (map.value[c] < deepest - arm_rise_mm) {
      return x_of(groove);
    }
  }
  return step * beyond_all_mm;
}

}  // namespace

std::array<double, 2> armpits(const FrontMap& front, const std::array<Vec3, 2>& nipple_mm) {
  // Lower down a breast may hang in front of what is beside it.
  constexpr double above_nipple_mm = 120.0;
  const std::vector<bool> holes = front.holes();
  std::array<double, 2> result{-beyond_all_mm, beyond_all_mm};
  for (const std::size_t side : {0U, 1U}) {
    std::vector<double> ends;
    for (int k = 0; k < front.skin_y.size[1]; ++k) {
      const double up =
          front.skin_y.origin_mm[1] + k * front.skin_y.spacing_mm - nipple_mm[side][2];
      if (up < 0 || up > above_nipple_mm) {
        continue;
      }
      const double end = end_of_row(front, holes, k, nipple_mm[side][0], side == 0 ? -1 : 1);
      if (std::abs(end) < beyond_all_mm) {
        ends.push_back(end);
      }
    }
    if (ends.size() * front.skin_y.spacing_mm > least_height_mm) {
      const auto middle = ends.begin() + static_cast<std::ptrdiff_t>(ends.size() / 2);
      std::nth_element(ends.begin(), middle, ends.end());
      result[side] = *middle;
    }
  }
  return result;
}

}  // namespace sanatrix::standing
