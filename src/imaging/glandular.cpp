#include "imaging/glandular.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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

constexpr double least_gland_signal = 0.2;  ///< darker is muscle, vessel or artefact

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

/// Finds the parts with which the model explains the histogram best (EM) and returns the
/// log-likelihood.
double fit_parts(const std::array<double, bins>& count, GlandularModel& model) {
  const auto first = static_cast<std::size_t>(least_gland_signal / bin_width);
  std::array<std::array<double, 3>, bins> density{};
  for (std::size_t b = first; b < bins; ++b) {
    density[b] = densities(model, centre(b));
  }
  model.parts = {0.6, 0.1, 0.3};
  double value = 0.0;
  for (int round = 0; round < 60; ++round) {
    std::array<double, 3> next{};
    value = 0.0;
    for (std::size_t b = first; b < bins; ++b) {
      std::array<double, 3> part{};
      double sum = anything;
      for (std::size_t c = 0; c < 3; ++c) {
        part[c] = model.parts[c] * density[b][c];
        sum += part[c];
      }
      value += count[b] * std::log(sum);
      for (std::size_t c = 0; c < 3; ++c) {
        next[c] += count[b] * part[c] / sum;
      }
    }
    const double total = next[0] + next[1] + next[2];
    for (std::size_t c = 0; c < 3; ++c) {
      model.parts[c] = next[c] / total;
    }
  }
  return value;
}

}  // namespace

/// Fat is the peak near 1; only its bright side is free of gland and tells the spread. The signal
/// of pure gland is the one with which fat, gland and uniformly distributed mixtures of both
/// explain the histogram best (Santago and Gage, doi:10.1109/42.241885): a peak where gland is
/// solid, the end of the tail where every voxel holds some fat.
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
  GlandularModel best = model;
  double most = -std::numeric_limits<double>::infinity();
  for (model.gland_signal = least_gland_signal + 0.02;
       model.gland_signal < model.fat_signal - 2.0 * model.fat_spread;
       model.gland_signal += 2.0 * bin_width) {
    if (const double fit = fit_parts(count, model); fit > most) {
      most = fit;
      best = model;
    }
  }
  best.separation = (best.fat_signal - best.gland_signal) / best.fat_spread;
  return best;
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
