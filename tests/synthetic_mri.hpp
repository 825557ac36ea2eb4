// Greyscale MRI made from labels: signals of tissues, partial volume in thick slices, coil shading
// and Rician noise. For anatomies of which only labels exist, and to make given images worse.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "geometry/image.hpp"

namespace sanatrix::testing {

/// Signals relative to fat in T1 and T2 without fat suppression; turbo spin echo at 1.5 to 3 T.
struct Contrast {
  double water, skin, muscle, organ;
};
constexpr Contrast t1_contrast{0.30, 0.38, 0.23, 0.22}, t2_contrast{0.58, 0.33, 0.18, 0.26};

struct Scanner {
  double fat_signal = 200.0;
  double noise = 6.0;          ///< standard deviation in each of the two channels
  double depth_decay_mm = 90;  ///< coil: signal falls by e over this depth
  double side_tilt = 0.2;      ///< relative difference from left to right
  int slice_thickness = 3;     ///< in voxels of the labels
};

inline double relative_signal(unsigned char label, float water, const Contrast& c) {
  switch (static_cast<Label>(label)) {
    case Label::Air:
      return 0.0;
    case Label::Skin:
      return c.skin;
    case Label::Muscle:
    case Label::Bone:
      return c.muscle;
    case Label::Lung:
      return 0.04;
    case Label::Organ:
      return c.organ;
    case Label::Tumour:
      return c.water;
    default:
      return 1.0 + (c.water - 1.0) * static_cast<double>(water);
  }
}

inline void add_rician_noise(Image3<float>& image, double deviation) {
  std::mt19937 random(7);
  std::normal_distribution<double> channel(0.0, deviation);
  for (float& v : image.voxels) {
    v = static_cast<float>(
        std::round(std::hypot(static_cast<double>(v) + channel(random), channel(random))));
  }
}

/// `water`: share of fibroglandular tissue per voxel of `labels` (LPS order). Slices are means over
/// slice_thickness voxels.
inline Image3<float> synthetic_mri(const LabelImage& labels, const Image3<float>& water,
                                   const Contrast& contrast, const Scanner& scanner = {}) {
  const int n = scanner.slice_thickness;
  Image3<float> image{.size = {labels.size[0], labels.size[1], labels.size[2] / n},
                      .spacing_mm = labels.spacing_mm,
                      .origin_mm = labels.position_mm(0, 0, 0.5 * (n - 1)),
                      .direction = labels.direction,
                      .voxels = {}};
  image.spacing_mm[2] *= n;
  for (int k = 0; k < image.size[2]; ++k) {
    for (int j = 0; j < image.size[1]; ++j) {
      for (int i = 0; i < image.size[0]; ++i) {
        double sum = 0.0;
        for (int c = n * k; c < n * (k + 1); ++c) {
          sum += relative_signal(labels.at(i, j, c), water.at(i, j, c), contrast) / n;
        }
        const double depth = j * image.spacing_mm[1];
        const double across = 2.0 * i / image.size[0] - 1.0;
        image.voxels.push_back(static_cast<float>(scanner.fat_signal * sum * 1.6 *
                                                  std::exp(-depth / scanner.depth_decay_mm) *
                                                  (1.0 + scanner.side_tilt * across)));
      }
    }
  }
  add_rician_noise(image, scanner.noise);
  return image;
}

}  // namespace sanatrix::testing
