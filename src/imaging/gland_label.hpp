// The hard label of fibroglandular tissue, from shares that noise blurs.
#pragma once

#include "geometry/image.hpp"
#include "geometry/image_filters.hpp"
#include "imaging/glandular.hpp"

namespace sanatrix::imaging {

/// Labels as fibroglandular what holds about as much gland as fat, among the voxels of `clean`,
/// which hold nothing else. `image` is not smoothed; `fat_signal` is what pure fat has at every
/// voxel.
void label_gland(LabelImage& labels, const Image3<float>& image, const Image3<float>& fat_signal,
                 const GlandularModel& gland, const Mask& clean);

}  // namespace sanatrix::imaging
