#include "imaging/glandular.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace sanatrix::imaging {
namespace {

constexpr int bins = 300;
constexpr double bin_width = 0.005;  // relative signals 0..1.5

std::array<double, bins> histogram(const Image3<float>& relative, const Mask& where) {
  std::array<double, bins> count{};
  for (std::size_t v = 0; v < where.voxels.size(); ++v) {
    if (where.voxels[v] != 0) {
      const int b = static_cast<int>(static_cast<double>(relative.voxels[v]) / bin_width);
      count[static_cast<std::size_t>(std::clamp(b, 0, bins - 1))] += 1.0;
    }
  }
  return count;
}

constexpr double least_gland_signal = 0.2;  ///< darker is muscle, vessel or artefact
constexpr double strand_quantile = 0.03;
constexpr double solid_share = 0.56, strand_share = 0.32;

std::array<double, bins> smoothed(const std::array<double, bins>& count) {
  std::array<double, bins> result{};
  constexpr int reach = 4;
  for (int b = 0; b < bins; ++b) {
    double weight = 0.0;
    for (int d = -reach; d <= reach; ++d) {
      if (b + d >= 0 && b + d < bins) {
        const double w = std::exp(-0.5 * d * d / 4.0);
        result[static_cast<std::size_t>(b)] += w * count[static_cast<std::size_t>(b + d)];
        weight += w;
      }
    }
    result[static_cast<std::size_t>(b)] /= weight;
  }
  return result;
}

double centre(std::size_t bin) {
  return (static_cast<double>(bin) + 0.5) * bin_width;
}

std::size_t highest(const std::array<double, bins>& count, double from, double to) {
  auto best = static_cast<std::size_t>(from / bin_width);
  for (std::size_t b = best; b < bins && centre(b) < to; ++b) {
    best = count[b] > count[best] ? b : best;
  }
  return best;
}

std::size_t lowest(const std::array<double, bins>& count, double from, double to) {
  auto best = static_cast<std::size_t>(from / bin_width);
  for (std::size_t b = best; b < bins && centre(b) < to; ++b) {
    best = count[b] < count[best] ? b : best;
  }
  return best;
}

}  // namespace

/// Fat is the peak near 1. Gland is a second peak where there is much of it; where there are
/// strands only, every voxel holds some fat and the darkest of them come nearest to pure gland.
GlandularModel fit_glandular_model(const Image3<float>& relative, const Mask& where) {
  const std::array<double, bins> count = smoothed(histogram(relative, where));
  const double total = std::accumulate(count.begin(), count.end(), 0.0);
  GlandularModel model;
  const std::size_t peak = highest(count, 0.80, 1.25);
  model.fat_signal = centre(peak);
  // Only the bright side of the peak is free of gland: its half width at half maximum.
  std::size_t half = peak;
  while (half + 1 < bins && count[half] > 0.5 * count[peak]) {
    ++half;
  }
  model.fat_spread = std::max((centre(half) - model.fat_signal) / 1.1774, 0.02);
  const double clear = model.fat_signal - 3.0 * model.fat_spread;  // surely not pure fat
  double tail = 0.0;
  for (std::size_t b = 0; centre(b) < clear; ++b) {
    tail += count[b];
  }
  const std::size_t second = highest(count, 0.20, clear);
  const std::size_t valley = lowest(count, centre(second), model.fat_signal);
  if (count[second] > 1.3 * count[valley] && tail > 0.05 * total) {
    model.gland_signal = centre(second);
    model.hard_share = solid_share;
  } else {
    model.hard_share = strand_share;
    double below = 0.0;
    std::size_t b = static_cast<std::size_t>(least_gland_signal / bin_width);
    while (b + 1 < bins && below < strand_quantile * tail) {
      below += count[b++];
    }
    model.gland_signal = centre(b);
  }
  model.gland_signal = std::clamp(model.gland_signal, least_gland_signal, clear);
  model.separation = (model.fat_signal - model.gland_signal) / model.fat_spread;
  return model;
}

float glandular_share(const GlandularModel& model, float relative) {
  const double share =
      (model.fat_signal - static_cast<double>(relative)) / (model.fat_signal - model.gland_signal);
  return static_cast<float>(std::clamp(share, 0.0, 1.0));
}

}  // namespace sanatrix::imaging
