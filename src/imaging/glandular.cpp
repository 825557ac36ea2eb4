#include "imaging/glandular.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

/// Of the histogram, from a signal of 0.2 on: darker is muscle, vessel or artefact.
constexpr std::size_t first_bin = 40;

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

double normal(double x, double mean, double deviation) {
  const double t = (x - mean) / deviation;
  return std::exp(-0.5 * t * t) / (deviation * std::sqrt(2.0 * std::numbers::pi));
}

/// Densities at a signal of pure fat, pure gland, and voxels that hold both in every proportion.
std::array<double, 3> densities(const GlandularModel& m, double x) {
  const double root = m.fat_spread * std::numbers::sqrt2;
  return {normal(x, m.fat_signal, m.fat_spread), normal(x, m.gland_signal, m.fat_spread),
          0.5 * (std::erf((x - m.gland_signal) / root) - std::erf((x - m.fat_signal) / root)) /
              (m.fat_signal - m.gland_signal)};
}

constexpr double anything = 1e-6;  ///< density of what is none of these

/// Finds the parts with which the model explains the histogram best (EM).
void fit_parts(const std::array<double, bins>& count, GlandularModel& model) {
  std::array<std::array<double, 3>, bins> density{};
  for (std::size_t b = first_bin; b < bins; ++b) {
    density[b] = densities(model, centre(b));
  }
  model.parts = {0.6, 0.1, 0.3};
  for (int round = 0; round < 60; ++round) {
    std::array<double, 3> next{};
    for (std::size_t b = first_bin; b < bins; ++b) {
      std::array<double, 3> part{};
      double sum = anything;
      for (std::size_t c = 0; c < 3; ++c) {
        part[c] = model.parts[c] * density[b][c];
        sum += part[c];
      }
      for (std::size_t c = 0; c < 3; ++c) {
        next[c] += count[b] * part[c] / sum;
      }
    }
    const double total = next[0] + next[1] + next[2];
    for (std::size_t c = 0; c < 3; ++c) {
      model.parts[c] = next[c] / total;
    }
  }
}

/// Voxels darker than a signal, but not as dark as muscle, vessels and artefacts.
double darker(const std::array<double, bins>& count, double signal) {
  double sum = 0.0;
  for (std::size_t b = first_bin; b < bins && centre(b) < signal; ++b) {
    sum += count[b];
  }
  return sum;
}

/// The signal that the darkest fifth of the gland stays below; gland is what lies below the middle
/// between that signal and fat. The very darkest are tumour, vessels and noise.
double darkest_fifth(const std::array<double, bins>& count, double fat_signal) {
  constexpr double fifth = 0.2;
  double signal = 0.5 * fat_signal;
  for (int round = 0; round < 40; ++round) {
    const double enough = fifth * darker(count, 0.5 * (signal + fat_signal));
    double sum = 0.0;
    std::size_t b = first_bin;
    while (b + 1 < bins && sum < enough) {
      sum += count[b++];
    }
    signal = centre(b);
  }
  return signal;
}

}  // namespace

/// Fat is the peak near 1; only its bright side is free of gland and tells the spread. Gland has
/// seldom a peak, and no voxel need be free of fat: its signal is that of the darkest fifth. Given
/// both, fat, gland and uniformly distributed mixtures of both explain the histogram (Santago and
/// Gage, doi:10.1109/42.241885).
GlandularModel fit_glandular_model(const Image3<float>& relative, const Mask& where) {
  const std::array<double, bins> count = smoothed(histogram(relative, where));
  GlandularModel model;
  const std::size_t peak = highest(count, 0.75, 1.25);
  model.fat_signal = centre(peak);
  std::size_t half = peak;
  while (half + 1 < bins && count[half] > 0.5 * count[peak]) {
    ++half;
  }
  model.fat_spread = std::max((centre(half) - model.fat_signal) / 1.1774, 0.02);
  model.gland_signal =
      std::min(darkest_fifth(count, model.fat_signal), model.fat_signal - 2.0 * model.fat_spread);
  model.separation = (model.fat_signal - model.gland_signal) / model.fat_spread;
  fit_parts(count, model);
  const auto above = [&](double share) {
    return darker(count, model.fat_signal - share * (model.fat_signal - model.gland_signal));
  };
  model.solid = above(0.75) / std::max(above(0.4), 1.0);
  return model;
}

double pure_fat(const GlandularModel& model, double relative) {
  const std::array<double, 3> density = densities(model, relative);
  double sum = anything;
  for (std::size_t c = 0; c < 3; ++c) {
    sum += model.parts[c] * density[c];
  }
  return model.parts[0] * density[0] / sum;
}

float glandular_share(const GlandularModel& model, float relative) {
  const double share =
      (model.fat_signal - static_cast<double>(relative)) / (model.fat_signal - model.gland_signal);
  return static_cast<float>(std::clamp(share, 0.0, 1.0));
}

}  // namespace sanatrix::imaging
