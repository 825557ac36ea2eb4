// Greyscale MRI made from labels: signals of tissues, thick slices, coil shading, Rician noise.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "prone_anatomy.hpp"

namespace sanatrix::testing {

/// Signals relative to fat in T1 and T2 without fat suppression; turbo spin echo at 1.5 to 3 T.
struct Contrast {
  double water, skin, muscle, organ, marrow;
  double fat_signal;  ///< of the scanner's scale
};
constexpr Contrast t1_contrast{0.30, 0.38, 0.23, 0.22, 0.62, 260.0};
constexpr Contrast t2_contrast{0.577, 0.33, 0.18, 0.26, 0.62, 203.0};

/// Smooth sensitivity of the receiving coil.
struct Coil {
  double decay_mm = 75.0;  ///< from 1.6 at the front it falls with depth by e over this length
  double floor = 0.25;     ///< to this
  double side_tilt = 0.15, end_tilt = 0.0;  ///< relative difference from the middle to left, top
  double end_fall = 0.25;                   ///< towards both ends of the stack
  double hot_spots = 0.25;                  ///< 25 mm wide, beside the sternum
  double waves = 0.05;                      ///< 90 mm long, random
  double power = 1.0;                       ///< of all of it: 2 doubles the shading
};
struct Scanner {
  Coil coil;
  double noise = 6.7;  ///< standard deviation in each of the two channels
  double texture = 0.035;
  double pixel_mm = 0.6;
  int slice = 3;  ///< thickness in voxels of the anatomy
};

inline double relative_signal(unsigned char label, float water, const Contrast& c) {
  switch (static_cast<Label>(label)) {
    case Label::Air:
      return 0.0;
    case Label::Skin:
      return c.skin;
    case Label::Muscle:
      return c.muscle;
    case Label::Bone:
      return c.marrow;
    case Label::Lung:
      return 0.035;
    case Label::Organ:
      return c.organ;
    case Label::Tumour:
      return 0.8 * c.water;
    default:
      return 1.0 + (c.water - 1.0) * static_cast<double>(water);
  }
}

inline void add_rician_noise(Image3<float>& image, double deviation, unsigned seed = 7) {
  std::mt19937 random(seed);
  std::normal_distribution<double> channel(0.0, deviation);
  for (float& v : image.voxels) {
    v = static_cast<float>(
        std::round(std::hypot(static_cast<double>(v) + channel(random), channel(random))));
  }
}

/// `c`: place as a share of the field, 0 to 1 along each axis; `mm`: from the first voxel.
inline double sensitivity(const Coil& coil, const Vec3& c, const Vec3& mm, double front_mm) {
  const double depth = std::max(mm[1] - front_mm, 0.0);
  const double across = 2.0 * c[0] - 1.0, along = 2.0 * c[2] - 1.0;
  double s = coil.floor + (1.6 - coil.floor) * std::exp(-depth / coil.decay_mm);
  s *= (1.0 + coil.side_tilt * across) * (1.0 + coil.end_tilt * along) *
       (1.0 - coil.end_fall * along * along);
  const double from_middle = std::abs(across) - 0.15;
  s *= 1.0 + coil.hot_spots *
                 std::exp(-std::pow(from_middle / 0.15, 2) - std::pow((depth - 90.0) / 35.0, 2));
  return s;
}

struct SyntheticMri {
  Image3<float> image;
  LabelImage truth;  ///< the middle of every slice
};

/// Slices are means over the thickness, pixels linear between the anatomy's voxels.
inline SyntheticMri synthetic_mri(const Anatomy& body, const Contrast& contrast,
                                  const Scanner& scanner = {}) {
  const LabelImage& labels = body.labels;
  const Image3<float> wave = smooth_random(labels, 90.0, 5);
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  int front = labels.size[1];
  for (std::size_t v = 0; v < labels.voxels.size(); ++v) {
    if (labels.voxels[v] != 0) {
      const auto row =
          v / static_cast<std::size_t>(labels.size[0]) % static_cast<std::size_t>(labels.size[1]);
      front = std::min(front, static_cast<int>(row));
    }
  }
  Image3<float> signal = image_like<float>(labels);
  std::size_t v = 0;
  for (int k = 0; k < labels.size[2]; ++k) {
    for (int j = 0; j < labels.size[1]; ++j) {
      for (int i = 0; i < labels.size[0]; ++i, ++v) {
        const Vec3 share{(i + 0.5) / labels.size[0], (j + 0.5) / labels.size[1],
                         (k + 0.5) / labels.size[2]};
        const Vec3 mm{i * labels.spacing_mm[0], j * labels.spacing_mm[1], k * labels.spacing_mm[2]};
        const double coil = sensitivity(scanner.coil, share, mm, front * labels.spacing_mm[1]) *
                            (1.0 + scanner.coil.waves * static_cast<double>(wave.voxels[v]));
        signal.voxels[v] =
            static_cast<float>(contrast.fat_signal *
                               relative_signal(labels.voxels[v], body.water.voxels[v], contrast) *
                               (1.0 + scanner.texture * normal(random)) *
                               std::pow(std::max(coil, 0.01), scanner.coil.power));
      }
    }
  }
  const int n = scanner.slice;
  SyntheticMri mri;
  Image3<float>& image = mri.image;
  image.size = {static_cast<int>((labels.size[0] - 1) * labels.spacing_mm[0] / scanner.pixel_mm),
                static_cast<int>((labels.size[1] - 1) * labels.spacing_mm[1] / scanner.pixel_mm),
                labels.size[2] / n};
  image.spacing_mm = {scanner.pixel_mm, scanner.pixel_mm, n * labels.spacing_mm[2]};
  image.origin_mm = labels.position_mm(0, 0, 0.5 * (n - 1));
  for (int k = 0; k < image.size[2]; ++k) {
    for (int j = 0; j < image.size[1]; ++j) {
      for (int i = 0; i < image.size[0]; ++i) {
        const double a = i * scanner.pixel_mm / labels.spacing_mm[0],
                     b = j * scanner.pixel_mm / labels.spacing_mm[1];
        const int a0 = static_cast<int>(a), b0 = static_cast<int>(b);
        const double s = a - a0, t = b - b0;
        double sum = 0.0;
        for (int c = n * k; c < n * (k + 1); ++c) {
          sum += (1 - t) * ((1 - s) * static_cast<double>(signal.at(a0, b0, c)) +
                            s * static_cast<double>(signal.at(a0 + 1, b0, c))) +
                 t * ((1 - s) * static_cast<double>(signal.at(a0, b0 + 1, c)) +
                      s * static_cast<double>(signal.at(a0 + 1, b0 + 1, c)));
        }
        image.voxels.push_back(static_cast<float>(sum / n));
        mri.truth.voxels.push_back(labels.at(static_cast<int>(std::lround(a)),
                                             static_cast<int>(std::lround(b)), n * k + n / 2));
      }
    }
  }
  mri.truth.size = image.size;
  mri.truth.spacing_mm = image.spacing_mm;
  mri.truth.origin_mm = image.origin_mm;
  add_rician_noise(image, scanner.noise);
  return mri;
}

}  // namespace sanatrix::testing
