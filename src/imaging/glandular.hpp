// Fibroglandular tissue against fat: a share per voxel from the signal relative to fat.
#pragma once

#include <array>

#include "geometry/image.hpp"
#include "geometry/image_filters.hpp"

namespace sanatrix::imaging {

struct GlandularModel {
  double gland_signal = 0.3;  ///< of fibroglandular tissue without fat, relative to fat's 1
  double fat_signal = 1.0;    ///< peak of fat after bias correction
  double fat_spread = 0.05;   ///< standard deviation of fat: noise, texture, rest of the shading
  double separation = 0.0;    ///< |fat - gland| / spread: below 3 the two cannot be told apart
  std::array<double, 3> parts{0.6, 0.1, 0.3};  ///< shares of pure fat, pure gland, mixed voxels
  /// Of the voxels with a share of gland above 0.4, those above 0.75: low where gland is strands.
  double solid = 0.5;
};

/// Finds the two classes in the histogram of `relative` within `where`.
GlandularModel fit_glandular_model(const Image3<float>& relative, const Mask& where);

/// Probability that a voxel of this relative signal holds fat alone.
double pure_fat(const GlandularModel& model, double relative);

/// Share of fibroglandular tissue, 0..1, that a relative signal means.
float glandular_share(const GlandularModel& model, float relative);

}  // namespace sanatrix::imaging
