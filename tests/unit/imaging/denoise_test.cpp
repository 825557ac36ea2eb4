// Noise: how much there is, and taking it off.
#include "imaging/denoise.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace sanatrix::imaging {
namespace {

Image3<float> grid(int rows, int columns) {
  Image3<float> image;
  image.size = {columns, rows, 1};
  image.voxels.assign(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns), 0.0F);
  return image;
}

Mask everywhere(const Image3<float>& image) {
  Mask mask = image_like<unsigned char>(image);
  mask.voxels.assign(image.voxels.size(), 1);
  return mask;
}

// Scanners store whole numbers. 40,000 voxels: the mean of a quarter of the differences is known to
// 1 %, whole numbers and the edge add 2 %.
TEST(NoiseDeviation, IsFoundInWholeNumbersWithAnEdge) {
  Image3<float> image = grid(200, 200);
  std::mt19937 random(3);
  for (const double deviation : {2.5, 7.2, 14.4}) {
    std::normal_distribution<double> noise(0.0, deviation);
    for (std::size_t v = 0; v < image.voxels.size(); ++v) {
      image.voxels[v] =
          static_cast<float>(std::round((v % 200 < 100 ? 200.0 : 120.0) + noise(random)));
    }
    EXPECT_NEAR(noise_deviation(image, everywhere(image)), deviation, 0.03 * deviation);
  }
}

// In one dimension an extremum of n voxels moves by 2 deviation / n, a level at an end by
// deviation / n: derivative of the least sum by the height of the level. 40 steps find it to 0.01.
TEST(WithoutNoise, MovesLevelsByTheDeviationOverTheirLength) {
  Image3<float> image = grid(1, 12);
  for (std::size_t v = 4; v < 8; ++v) {
    image.voxels[v] = 1.0F;
  }
  Image3<float> deviation = image_like<float>(image);
  deviation.voxels.assign(image.voxels.size(), 0.2F);
  const Image3<float> smooth = without_noise(image, deviation, everywhere(image));
  EXPECT_NEAR(smooth.voxels[5], 1.0 - 2.0 * 0.2 / 4.0, 0.01);
  EXPECT_NEAR(smooth.voxels[1], 0.2 / 4.0, 0.01);
}

}  // namespace
}  // namespace sanatrix::imaging
