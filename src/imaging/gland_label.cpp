// Which voxels count as gland: by their shares, after noise has been taken off.
#include "imaging/gland_label.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "imaging/denoise.hpp"

namespace sanatrix::imaging {
namespace {

/// What looks like noise is partly texture and strands of gland, which should stay.
constexpr double noise_alone = 0.7;
/// Deviation of a share beyond which gland cannot be told from fat: three of them are all of it.
constexpr float most_noise = 0.5F;

/// The share of gland that the image itself says, without smoothing and beyond 0 and 1, so that
/// noise has no preferred sign; 0 where it is not mixed of fat and gland.
Image3<float> plain_share(const Image3<float>& image, const Image3<float>& fat_signal,
                          const GlandularModel& gland, const Mask& clean) {
  Image3<float> share = image_like<float>(image);
  for (std::size_t v = 0; v < share.voxels.size(); ++v) {
    if (clean.voxels[v] != 0) {
      const double relative = static_cast<double>(image.voxels[v]) /
                              std::max(static_cast<double>(fat_signal.voxels[v]), 1e-6);
      share.voxels[v] = static_cast<float>(std::clamp(
          (gland.fat_signal - relative) / (gland.fat_signal - gland.gland_signal), -1.5, 2.5));
    }
  }
  return share;
}

/// Noise of that share: the scanner's is the same everywhere, the signal is not.
Image3<float> deviation_of_share(const Image3<float>& image, const Image3<float>& fat_signal,
                                 const GlandularModel& gland, const Mask& clean) {
  const double noise = noise_alone * noise_deviation(image, clean);
  Image3<float> deviation = image_like<float>(image);
  for (std::size_t v = 0; v < deviation.voxels.size(); ++v) {
    deviation.voxels[v] =
        static_cast<float>(noise / (std::max(static_cast<double>(fat_signal.voxels[v]), 1e-6) *
                                    (gland.fat_signal - gland.gland_signal)));
  }
  return deviation;
}

/// A smoothed voxel with this share counts as gland. Less than a half: slices that are thicker than
/// strands of gland mix them with the fat around, and smoothing draws them farther towards it, the
/// more noise there is (`deviation`, of the middle voxel). More where gland is solid.
double least_share(const GlandularModel& gland, double deviation) {
  return 0.26 + 0.22 * std::exp(-deviation / 0.15) + 0.3 * std::max(gland.solid - 0.55, 0.0);
}

double median(const Image3<float>& image, const Mask& where) {
  std::vector<float> values;
  for (std::size_t v = 0; v < image.voxels.size(); ++v) {
    if (where.voxels[v] != 0) {
      values.push_back(image.voxels[v]);
    }
  }
  if (values.empty()) {
    return 0.0;
  }
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Gaussian means of shares over the surroundings, of clean voxels alone.
template <class Value>
Image3<float> mean_around(const Mask& clean, const Value& value) {
  constexpr double surroundings_mm = 11.0;
  Image3<float> sum = image_like<float>(clean), weight = sum;
  for (std::size_t v = 0; v < sum.voxels.size(); ++v) {
    if (clean.voxels[v] != 0) {
      sum.voxels[v] = value(v);
      weight.voxels[v] = 1.0F;
    }
  }
  smooth(sum, surroundings_mm);
  smooth(weight, surroundings_mm);
  for (std::size_t v = 0; v < sum.voxels.size(); ++v) {
    sum.voxels[v] /= std::max(weight.voxels[v], 1e-3F);
  }
  return sum;
}

/// Strands are lost in noise one by one, but where some are there are more: a noisy share is drawn
/// towards the mean of its surroundings the more, the more its noise exceeds what shares differ by
/// there (Lee, doi:10.1109/TPAMI.1980.4766994).
void draw_to_surroundings(Image3<float>& share, Image3<float>& deviation, const Mask& clean) {
  constexpr float least_variance = 1e-4F;
  const Image3<float> mean = mean_around(clean, [&](std::size_t v) { return share.voxels[v]; });
  const Image3<float> variance = mean_around(clean, [&](std::size_t v) {
    const float off = share.voxels[v] - mean.voxels[v], noise = deviation.voxels[v];
    return off * off - noise * noise;
  });
  for (std::size_t v = 0; v < share.voxels.size(); ++v) {
    if (clean.voxels[v] != 0) {
      const float differs = std::max(variance.voxels[v], least_variance);
      const float noise = deviation.voxels[v] * deviation.voxels[v];
      const float own = differs / (differs + noise);
      share.voxels[v] = mean.voxels[v] + own * (share.voxels[v] - mean.voxels[v]);
      deviation.voxels[v] *= std::sqrt(own);
    }
  }
}

}  // namespace

void label_gland(LabelImage& labels, const Image3<float>& image, const Image3<float>& fat_signal,
                 const GlandularModel& gland, const Mask& pure) {
  Image3<float> deviation = deviation_of_share(image, fat_signal, gland, pure);
  Mask clean = pure;
  for (std::size_t v = 0; v < clean.voxels.size(); ++v) {
    if (deviation.voxels[v] > most_noise) {
      clean.voxels[v] = 0;
    }
  }
  Image3<float> share = plain_share(image, fat_signal, gland, clean);
  const auto least = static_cast<float>(least_share(gland, median(deviation, clean)));
  draw_to_surroundings(share, deviation, clean);
  share = without_noise(share, deviation, clean);
  for (std::size_t v = 0; v < share.voxels.size(); ++v) {
    if (clean.voxels[v] != 0 && share.voxels[v] >= least) {
      labels.voxels[v] = static_cast<unsigned char>(Label::Fibroglandular);
    }
  }
}

}  // namespace sanatrix::imaging
