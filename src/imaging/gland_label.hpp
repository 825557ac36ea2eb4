// The hard label of fibroglandular tissue, from shares that noise blurs.
#pragma once

#include "geometry/image.hpp"
#include "geometry/image_filters.hpp"
#include "imaging/glandular.hpp"

namespace sanatrix::imaging {

/// Labels as fibroglandular what holds about as much gland as fat, among the voxels of `pure`,
/// which hold nothing else, unless noise hides the difference of the two. `image` is not smoothed;
/// `fat_signal` is what pure fat has at every voxel.
void label_gland(LabelImage& labels, const Image3<float>& image, const Image3<float>& fat_signal,
                 const GlandularModel& gland, const Mask& pure);

}  // namespace sanatrix::imaging
