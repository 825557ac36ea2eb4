#include "standing/breast_pair.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace sanatrix::standing {
namespace {

using meshing::ColumnMap;

constexpr double least_rise_mm = 8.0;  ///< in front of the rolling ball
constexpr double peak_radius_mm = 40.0, breast_radius_mm = 70.0;
/// Distance of the nipples of adults: 16 to 30 cm, with room for large and for ptotic breasts.
constexpr double nearest_mm = 110.0, farthest_mm = 330.0;
constexpr double usual_mm = 200.0, usual_spread_mm = 45.0;  ///< arms and armpits lie farther apart
constexpr double mirror_reach_mm = 160.0;  ///< how far from the middle symmetry is looked at
constexpr double mirror_scale_mm = 12.0;   ///< asymmetry of real trunks

struct Peak {
  int i, k;
  double volume;  ///< [cm3] of the rise around it, less where little is seen
};

Vec3 place(const ColumnMap& map, int i, int k) {
  return {map.origin_mm[0] + i * map.spacing_mm, map.at(i, k),
          map.origin_mm[1] + k * map.spacing_mm};
}

/// Calls visit(i, k, dx, dz) for the columns within a radius [mm].
template <class F>
void around(const ColumnMap& map, int i, int k, double radius_mm, F&& visit) {
  const int reach = static_cast<int>(radius_mm / map.spacing_mm);
  for (int b = std::max(0, k - reach); b <= std::min(map.size[1] - 1, k + reach); ++b) {
    for (int a = std::max(0, i - reach); a <= std::min(map.size[0] - 1, i + reach); ++a) {
      const double dx = (a - i) * map.spacing_mm, dz = (b - k) * map.spacing_mm;
      if (dx * dx + dz * dz <= radius_mm * radius_mm) {
        visit(a, b, dx, dz);
      }
    }
  }
}

/// Whether the skin looks forward rather than sideways, as flanks and arms do at the rim of what is
/// seen. The lower edge of a breast, a cliff on one side, does.
bool looks_forward(const ColumnMap& skin_y, int i, int k) {
  constexpr int step = 3;
  constexpr double steepest = 1.0;
  const double here = skin_y.at(i, k), run = step * skin_y.spacing_mm;
  const auto slope = [&](int di, int dk) {
    const int a = std::clamp(i + di, 0, skin_y.size[0] - 1);
    const int b = std::clamp(k + dk, 0, skin_y.size[1] - 1);
    return std::abs(skin_y.at(a, b) - here) / run;
  };
  return std::hypot(std::min(slope(step, 0), slope(-step, 0)),
                    std::min(slope(0, step), slope(0, -step))) < steepest;
}

std::vector<Peak> find_peaks(const FrontMap& front, ColumnMap prominence) {
  std::vector<Peak> peaks;
  for (int k = 0; k < prominence.size[1]; ++k) {
    for (int i = 0; i < prominence.size[0]; ++i) {
      if (!front.seen[prominence.index(i, k)] || !looks_forward(front.skin_y, i, k)) {
        prominence.at(i, k) = 0.0;
      }
    }
  }
  for (int k = 0; k < prominence.size[1]; ++k) {
    for (int i = 0; i < prominence.size[0]; ++i) {
      const double here = prominence.at(i, k);
      if (here < least_rise_mm) {
        continue;
      }
      Peak peak{i, k, 0.0};
      bool highest = true;
      double seen = 0, all = 0;
      around(prominence, i, k, breast_radius_mm, [&](int a, int b, double dx, double dz) {
        const double there = prominence.at(a, b);
        const bool before = b < k || (b == k && a < i);  // one of equals
        const bool near = dx * dx + dz * dz < peak_radius_mm * peak_radius_mm;
        highest = highest && !(near && (there > here || (there == here && before)));
        const double is_seen = front.seen[prominence.index(a, b)] ? 1.0 : 0.0;
        peak.volume += there;
        seen += is_seen;
        all += 1;
      });
      if (highest) {
        // An arm has nothing beside it, a breast has the trunk.
        const double share = seen / all;
        peak.volume *= share * share * prominence.spacing_mm * prominence.spacing_mm * 1e-3;
        peaks.push_back(peak);
      }
    }
  }
  std::ranges::sort(peaks, [](const Peak& a, const Peak& b) { return a.volume > b.volume; });
  peaks.resize(std::min<std::size_t>(peaks.size(), 12));
  return peaks;
}

/// Mean difference [mm] of the front and its mirror image about the middle of two points, with the
/// turn about the vertical that the points themselves show taken out.
double asymmetry(const FrontMap& front, const Vec3& a, const Vec3& b) {
  const ColumnMap& map = front.skin_y;
  const Vec3 middle = 0.5 * (a + b);
  const double length = std::hypot(b[0] - a[0], b[2] - a[2]);
  const double nx = (b[0] - a[0]) / length, nz = (b[2] - a[2]) / length;
  const double slope = (b[1] - a[1]) / length;
  double sum = 0, count = 0;
  const int i = static_cast<int>(std::lround((middle[0] - map.origin_mm[0]) / map.spacing_mm));
  const int k = static_cast<int>(std::lround((middle[2] - map.origin_mm[1]) / map.spacing_mm));
  around(map, i, k, mirror_reach_mm, [&](int p, int q, double dx, double dz) {
    const double across = dx * nx + dz * nz;
    const std::size_t there =
        map.nearest(middle[0] + dx - 2 * across * nx, middle[2] + dz - 2 * across * nz);
    if (across > 0 && front.seen[map.index(p, q)] && front.seen[there]) {
      sum += std::abs(map.at(p, q) - map.value[there] - 2 * across * slope);
      count += 1;
    }
  });
  return count > 50 ? sum / count : 1e3;
}

/// Whether two rises are one ridge, as of an arm seen from its side: between breasts the skin falls
/// back.
bool one_ridge(const ColumnMap& prominence, const Peak& a, const Peak& b) {
  constexpr double most = 0.7;  // of the lower of the two
  const double low = std::min(prominence.at(a.i, a.k), prominence.at(b.i, b.k));
  return prominence.at((a.i + b.i) / 2, (a.k + b.k) / 2) > most * low;
}

/// How fast the skin falls back at the steepest place on one side of a tip, mean over the breast's
/// width; n points to that side.
double steepness(const ColumnMap& skin_y, const Peak& peak, double nx, double nz) {
  constexpr double half_width_mm = 30.0, from_mm = 5.0, to_mm = 95.0, window_mm = 10.0;
  constexpr double cliff = 3.0;  // an overhang is no steeper than this
  const Vec3 tip = place(skin_y, peak.i, peak.k);
  const auto y_at = [&](double along, double across) {
    return skin_y.value[skin_y.nearest(tip[0] + along * nx + across * nz,
                                       tip[2] + along * nz - across * nx)];
  };
  double sum = 0, count = 0;
  for (double across = -half_width_mm; across <= half_width_mm; across += skin_y.spacing_mm) {
    double steepest = 0;
    for (double along = from_mm; along <= to_mm; along += skin_y.spacing_mm) {
      const double fall = (y_at(along + window_mm, across) - y_at(along, across)) / window_mm;
      steepest = std::max(steepest, std::min(fall, cliff));
    }
    sum += steepest;
    count += 1;
  }
  return sum / count;
}

/// The middle of the top of a rise: finer than the columns, which would tilt the pair.
Vec3 tip_of(const FrontMap& front, const ColumnMap& prominence, const Peak& peak) {
  constexpr double radius_mm = 20.0, top_mm = 6.0;
  const Vec3 centre = place(front.skin_y, peak.i, peak.k);
  const double foot = prominence.at(peak.i, peak.k) - top_mm;
  double x = 0, z = 0, total = 0;
  around(prominence, peak.i, peak.k, radius_mm, [&](int a, int b, double dx, double dz) {
    const bool seen = front.seen[prominence.index(a, b)];
    const double weight = seen ? std::max(0.0, prominence.at(a, b) - foot) : 0.0;
    x += weight * dx;
    z += weight * dz;
    total += weight;
  });
  return {centre[0] + x / total, centre[1], centre[2] + z / total};
}

}  // namespace

std::vector<BreastPair> find_pairs(const FrontMap& front, const ColumnMap& prominence) {
  const std::vector<Peak> peaks = find_peaks(front, prominence);
  std::vector<BreastPair> pairs;
  for (std::size_t m = 0; m < peaks.size(); ++m) {
    for (std::size_t n = m + 1; n < peaks.size(); ++n) {
      std::array<Peak, 2> two{peaks[m], peaks[n]};
      if (two[0].i > two[1].i) {
        std::swap(two[0], two[1]);
      }
      const Vec3 a = tip_of(front, prominence, two[0]);
      const Vec3 b = tip_of(front, prominence, two[1]);
      const double apart = std::hypot(b[0] - a[0], b[2] - a[2]);
      if (apart < nearest_mm || apart > farthest_mm || one_ridge(prominence, two[0], two[1])) {
        continue;
      }
      const double unusual = (apart - usual_mm) / usual_spread_mm;
      const double small = std::min(two[0].volume, two[1].volume);
      const double large = std::max(two[0].volume, two[1].volume);
      const double nx = -(b[2] - a[2]) / apart, nz = (b[0] - a[0]) / apart;
      pairs.push_back(
          {{a, b},
           small * small / large *
               std::exp(-asymmetry(front, a, b) / mirror_scale_mm - 0.5 * unusual * unusual),
           steepness(front.skin_y, two[0], -nx, -nz) + steepness(front.skin_y, two[1], -nx, -nz) -
               steepness(front.skin_y, two[0], nx, nz) - steepness(front.skin_y, two[1], nx, nz)});
    }
  }
  std::ranges::stable_sort(pairs, std::greater{}, &BreastPair::score);
  return pairs;
}

std::optional<BreastPair> find_level_pair(const FrontMap& front, const ColumnMap& prominence,
                                          std::optional<double> middle_x_mm) {
  constexpr double most_slope = 0.4;  // a breast and an arm are no pair
  constexpr double unlike_mm = 60.0;  // nipples of one patient are nearly mirror images
  std::optional<BreastPair> best;
  double most = 0.0;
  for (const BreastPair& pair : find_pairs(front, prominence)) {
    const auto& [right, left] = pair.tip_mm;
    const double across = right[0] + left[0] - 2 * middle_x_mm.value_or(0.5 * (right[0] + left[0]));
    const double unlike = middle_x_mm ? std::hypot(across, left[2] - right[2]) / unlike_mm : 0.0;
    const double merit = pair.score * std::exp(-0.5 * unlike * unlike);
    if (std::abs(left[2] - right[2]) < most_slope * (left[0] - right[0]) && merit > most) {
      best = pair;
      most = merit;
    }
  }
  return best;
}

}  // namespace sanatrix::standing
