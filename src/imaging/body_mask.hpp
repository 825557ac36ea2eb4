// Where the patient is: everything that is not air in front of her or beside her.
#pragma once

#include "geometry/image.hpp"
#include "geometry/image_filters.hpp"

namespace sanatrix::imaging {

/// Signal of air in front of the body, median and standard deviation, in a (smoothed) image.
struct AirSignal {
  double mean = 0.0, deviation = 0.0;
};
AirSignal measure_air(const Image3<float>& image);

/// The body in an image in LPS order: brighter than `threshold` (per voxel; one value: the same
/// everywhere), the largest part, with everything enclosed or cut off from the front and the sides
/// (lungs). Error{Input} without a body.
Mask body_mask(const Image3<float>& image, const Image3<float>& threshold);

/// The noise of every place as a share of the air's: 1, or less where shading, or a correction of
/// it, took noise and signal down together. On coarse tiles, for `sample`.
Image3<float> noise_share(const Image3<float>& image, const AirSignal& air);

/// Tissue that single voxels cannot tell from air, far from the coil, but means over some
/// millimetres can: where these stand clear of the same means in the air in front of the body, and
/// half way from air to fat. 1 there, 0 elsewhere, for `sample`. `threshold`: of what single voxels
/// do tell; `fat_signal` and `noise` (`noise_share`): per voxel.
Image3<float> dim_tissue(const Image3<float>& image, const Image3<float>& threshold,
                         const Image3<float>& fat_signal, const Image3<float>& noise);

}  // namespace sanatrix::imaging
