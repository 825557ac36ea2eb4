#include "imaging/body_mask.hpp"

#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace sanatrix::imaging {
namespace {

/// Otsu, doi:10.1109/TSMC.1979.4310076, on a histogram of square roots (bright tails are long).
double otsu_threshold(const Image3<float>& image, double brightest) {
  constexpr int bins = 512;
  std::vector<double> count(bins, 0.0);
  const double scale = (bins - 1) / std::sqrt(brightest);
  for (const float v : image.voxels) {
    const double x = std::sqrt(std::clamp(static_cast<double>(v), 0.0, brightest)) * scale;
    count[static_cast<std::size_t>(x)] += 1.0;
  }
  double total = 0.0, moment = 0.0;
  for (int b = 0; b < bins; ++b) {
    total += count[static_cast<std::size_t>(b)];
    moment += b * count[static_cast<std::size_t>(b)];
  }
  double below = 0.0, below_moment = 0.0, best = -1.0;
  int threshold = 0;
  for (int b = 0; b < bins; ++b) {
    below += count[static_cast<std::size_t>(b)];
    below_moment += b * count[static_cast<std::size_t>(b)];
    if (below == 0.0 || below == total) {
      continue;
    }
    const double apart = below_moment / below - (moment - below_moment) / (total - below);
    if (const double between = below * (total - below) * apart * apart; between > best) {
      best = between;
      threshold = b;
    }
  }
  return std::pow((threshold + 0.5) / scale, 2);
}

Mask largest_part(const Mask& mask) {
  const Parts parts = connected_parts(mask);
  Mask largest = image_like<unsigned char>(mask);
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
    largest.voxels[v] = parts.part[v] == 0 ? 1 : 0;
  }
  return largest;
}

/// Dark voxels that are connected to the front or to a side of the field of view, slice by slice:
/// a lung that opens to the back or to the next slice is not outside.
Mask outside_air(const Mask& body) {
  Mask air = image_like<unsigned char>(body);
  const auto [nx, ny, nz] = body.size;
  std::vector<std::array<int, 2>> front;
  for (int k = 0; k < nz; ++k) {
    front.clear();
    const auto visit = [&](int i, int j) {
      if (i >= 0 && j >= 0 && i < nx && j < ny && body.at(i, j, k) == 0 && air.at(i, j, k) == 0) {
        air.at(i, j, k) = 1;
        front.push_back({i, j});
      }
    };
    for (int i = 0; i < nx; ++i) {
      visit(i, 0);
    }
    for (int j = 0; j < ny / 2; ++j) {  // the back half of a side may be cut tissue
      visit(0, j);
      visit(nx - 1, j);
    }
    while (!front.empty()) {
      const auto [i, j] = front.back();
      front.pop_back();
      visit(i - 1, j);
      visit(i + 1, j);
      visit(i, j - 1);
      visit(i, j + 1);
    }
  }
  return air;
}

/// The values of what lies in front of all in its column that is above the threshold.
std::vector<float> in_front_of_body(const Image3<float>& image, const Image3<float>& threshold,
                                    const Image3<float>& values) {
  constexpr double apart_mm = 9.0;  // no skin, and three times the widest smoothing
  const auto apart = static_cast<int>(std::ceil(apart_mm / image.spacing_mm[1]));
  std::vector<float> found;
  for (int k = 0; k < image.size[2]; ++k) {
    for (int i = 0; i < image.size[0]; ++i) {
      int front = 0;
      while (front < image.size[1] && image.at(i, front, k) <= threshold.at(i, front, k)) {
        ++front;
      }
      for (int j = 0; j < front - apart; ++j) {
        found.push_back(values.at(i, j, k));
      }
    }
  }
  return found;
}

/// Median and deviation of the darkest mode. Tissue among air is always brighter: the deviation is
/// that of the dark side, and what is above four of them is cut off. Zeros are padding, not air,
/// unless nearly all is zero.
AirSignal dark_mode(std::vector<float> values) {
  constexpr double below_one_deviation = 0.159, least_air = 0.1;
  require(!values.empty(), "the image has no dark surroundings: the patient fills all of it");
  const auto zeros = std::ranges::count(values, 0.0F);
  if (static_cast<double>(zeros) < (1.0 - least_air) * static_cast<double>(values.size())) {
    std::erase(values, 0.0F);
  }
  std::ranges::sort(values);
  AirSignal air;
  for (int round = 0; round < 12; ++round) {
    const auto n = static_cast<double>(values.size());
    air.mean = static_cast<double>(values[values.size() / 2]);
    air.deviation =
        air.mean - static_cast<double>(values[static_cast<std::size_t>(below_one_deviation * n)]);
    const auto limit = static_cast<float>(air.mean + 4.0 * air.deviation + 1e-6);
    values.erase(std::ranges::upper_bound(values, limit), values.end());
  }
  return air;
}

constexpr double tile_mm = 12.0;
constexpr double quiet = 0.25;  ///< quantile of a tile's differences; edges are the other ones
constexpr float least_noise_share = 0.15F;

/// Low quantile of the differences between next but one voxels of a tile.
float quiet_difference(const Image3<float>& image, const std::array<int, 3>& first,
                       const std::array<int, 3>& tile) {
  std::vector<float> differences;
  for (int k = first[2]; k < std::min(first[2] + tile[2], image.size[2]); ++k) {
    for (int j = first[1]; j < std::min(first[1] + tile[1], image.size[1]); ++j) {
      for (int i = first[0]; i + 2 < std::min(first[0] + tile[0], image.size[0]); ++i) {
        differences.push_back(std::abs(image.at(i + 2, j, k) - image.at(i, j, k)));
      }
    }
  }
  if (differences.empty()) {
    return std::numeric_limits<float>::infinity();
  }
  const auto low =
      differences.begin() + static_cast<long>(quiet * static_cast<double>(differences.size()));
  std::nth_element(differences.begin(), low, differences.end());
  return *low;
}

/// Every tile takes the greatest value of itself and its neighbours.
Image3<float> widened(const Image3<float>& tiles) {
  Image3<float> result = tiles;
  const auto [nx, ny, nz] = tiles.size;
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        for (int b = std::max(j - 1, 0); b <= std::min(j + 1, ny - 1); ++b) {
          for (int a = std::max(i - 1, 0); a <= std::min(i + 1, nx - 1); ++a) {
            result.at(i, j, k) = std::max(result.at(i, j, k), tiles.at(a, b, k));
          }
        }
      }
    }
  }
  return result;
}

constexpr double dim_scale_mm = 3.0;  ///< standard deviation of the mean's Gaussian weights

/// The mean of the voxels around. What is above the threshold counts as the threshold, or it would
/// shine over the edge of the body: outside, no more than half of the way to the threshold is left.
Image3<float> capped_mean(const Image3<float>& image, const Image3<float>& threshold) {
  Image3<float> mean = image;
  for (std::size_t v = 0; v < image.voxels.size(); ++v) {
    mean.voxels[v] = std::min(image.voxels[v], threshold.voxels[v]);
  }
  smooth(mean, dim_scale_mm);
  return mean;
}

}  // namespace

Image3<float> dim_tissue(const Image3<float>& image, const Image3<float>& threshold,
                         const Image3<float>& fat_signal, const Image3<float>& noise) {
  constexpr double clear = 5.0;         ///< deviations
  constexpr double rise = 0.35;         ///< of the way from air to fat: beyond the edge is skin
  constexpr double share_error = 1.15;  ///< of a tile; what looks like less noise may be chance
  const Image3<float> mean = capped_mean(image, threshold);
  const AirSignal air = dark_mode(in_front_of_body(image, threshold, mean));
  Image3<float> dim = image_like<float>(image);
  std::size_t v = 0;
  for (int k = 0; k < image.size[2]; ++k) {
    for (int j = 0; j < image.size[1]; ++j) {
      for (int i = 0; i < image.size[0]; ++i, ++v) {
        const double share = std::min(1.0, share_error * sample(noise, image.position_mm(i, j, k)));
        const double level = std::max(
            share * (air.mean + clear * air.deviation),
            (1.0 - rise) * share * air.mean + rise * static_cast<double>(fat_signal.voxels[v]));
        dim.voxels[v] = static_cast<double>(mean.voxels[v]) > level ? 1.0F : 0.0F;
      }
    }
  }
  return dim;
}

Image3<float> noise_share(const Image3<float>& image, const AirSignal& air) {
  std::array<int, 3> tile{};
  Image3<float> tiles = image_like<float>(image);
  for (std::size_t a = 0; a < 3; ++a) {
    tile[a] = std::max(1, static_cast<int>(std::lround(tile_mm / image.spacing_mm[a])));
    tiles.size[a] = std::max(1, image.size[a] / tile[a]);
    tiles.spacing_mm[a] = tile[a] * image.spacing_mm[a];
  }
  tiles.origin_mm =
      image.position_mm(0.5 * (tile[0] - 1), 0.5 * (tile[1] - 1), 0.5 * (tile[2] - 1));
  tiles.voxels.clear();
  for (int k = 0; k < tiles.size[2]; ++k) {
    for (int j = 0; j < tiles.size[1]; ++j) {
      for (int i = 0; i < tiles.size[0]; ++i) {
        tiles.voxels.push_back(
            quiet_difference(image, {i * tile[0], j * tile[1], k * tile[2]}, tile));
      }
    }
  }
  // The quarter quantile of differences of normal noise: 0.3186 * sqrt(2) deviations.
  const auto of_air = static_cast<float>(0.4506 * std::max(air.deviation, 1e-6));
  for (float& v : tiles.voxels) {
    v = std::clamp(v / of_air, least_noise_share, 1.0F);
  }
  return widened(tiles);
}

AirSignal measure_air(const Image3<float>& image) {
  std::vector<float> sample;
  const std::size_t step = std::max<std::size_t>(1, image.voxels.size() / 400000);
  for (std::size_t v = 0; v < image.voxels.size(); v += step) {
    sample.push_back(image.voxels[v]);
  }
  const auto high = sample.begin() + static_cast<long>(0.995 * static_cast<double>(sample.size()));
  std::nth_element(sample.begin(), high, sample.end());
  require(*high > 0.0F, "the image is empty: hardly a voxel is above zero");
  // Lungs, muscle and fat far from the coil are dark as well: only what is in front of all that is
  // bright is surely air, but for tissue at the ends of the field, which is cut off.
  const auto bright = static_cast<float>(otsu_threshold(image, *high));
  const Image3<float> threshold = image_like<float>(image, bright);
  return dark_mode(in_front_of_body(image, threshold, image));
}

Mask body_mask(const Image3<float>& image, const Image3<float>& threshold) {
  Mask bright = image_like<unsigned char>(image);
  for (std::size_t v = 0; v < image.voxels.size(); ++v) {
    bright.voxels[v] =
        image.voxels[v] > threshold.voxels[threshold.voxels.size() == 1 ? 0 : v] ? 1 : 0;
  }
  const Mask air = outside_air(largest_part(bright));
  Mask body = image_like<unsigned char>(image);
  std::size_t inside = 0;
  for (std::size_t v = 0; v < body.voxels.size(); ++v) {
    body.voxels[v] = air.voxels[v] == 0 ? 1 : 0;
    inside += body.voxels[v];
  }
  require(static_cast<double>(inside) * image.voxel_volume_mm3() > 500e3,
          "no body was found in the image: the bright part has only {:.0f} cm3",
          static_cast<double>(inside) * image.voxel_volume_mm3() * 1e-3);
  return body;
}

}  // namespace sanatrix::imaging
