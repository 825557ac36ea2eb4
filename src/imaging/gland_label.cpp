// Which voxels count as gland: how many by their own shares, which by what lies around them.
#include "imaging/gland_label.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "imaging/denoise.hpp"

namespace sanatrix::imaging {
namespace {

/// What looks like noise is partly texture and strands of gland, which should stay.
constexpr double noise_alone = 0.7;
/// A voxel with this share counts as gland. Less than a half, since slices that are thicker than
/// strands of gland mix them with the fat around, which is more than the gland; the less the fewer
/// of the voxels with gland hold little else.
constexpr double solid_gland_share = 0.48, strand_gland_share = 0.42;
constexpr double solid_part = 0.65, strand_part = 0.45;

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

/// 0 where gland is all strands, 1 where it is solid.
double solidity(const GlandularModel& gland) {
  return std::clamp((gland.solid - strand_part) / (solid_part - strand_part), 0.0, 1.0);
}

double least_share(const GlandularModel& gland) {
  return std::lerp(strand_gland_share, solid_gland_share, solidity(gland));
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

/// Fibroglandular is what holds more gland than fat. Which voxels is decided by the share of the
/// surroundings, since noise sits in single voxels; how many by the shares themselves, since a mean
/// over the surroundings thins strands. Where noise lets fat look like gland, it lets as much fat
/// look as far brighter than fat: these are taken off.
void harden(LabelImage& labels, const Image3<float>& share, Image3<float> deviation,
            const GlandularModel& model, const Mask& clean) {
  const double gland_share = least_share(model);
  Image3<float> drawn = share;
  draw_to_surroundings(drawn, deviation, clean);
  const Image3<float> around = without_noise(drawn, deviation, clean);
  std::vector<float> candidates;
  long gland = 0;
  for (std::size_t v = 0; v < around.voxels.size(); ++v) {
    if (clean.voxels[v] != 0) {
      candidates.push_back(around.voxels[v]);
      const double here = share.voxels[v];
      gland += here > gland_share ? 1 : here < -gland_share ? -1 : 0;
    }
  }
  if (gland <= 0) {
    return;
  }
  const auto least = candidates.end() - gland;
  std::nth_element(candidates.begin(), least, candidates.end());
  const float threshold = *least;
  for (std::size_t v = 0; v < around.voxels.size(); ++v) {
    if (clean.voxels[v] != 0 && around.voxels[v] >= threshold) {
      labels.voxels[v] = static_cast<unsigned char>(Label::Fibroglandular);
    }
  }
}

}  // namespace

void label_gland(LabelImage& labels, const Image3<float>& image, const Image3<float>& fat_signal,
                 const GlandularModel& gland, const Mask& clean) {
  harden(labels, plain_share(image, fat_signal, gland, clean),
         deviation_of_share(image, fat_signal, gland, clean), gland, clean);
}

}  // namespace sanatrix::imaging
