// Brings an image of any orientation into an order in which i, j, k run along L, P and S.
#pragma once

#include "geometry/image.hpp"
#include "geometry/image_filters.hpp"

namespace sanatrix::imaging {

/// The same voxels, reordered so that i grows towards the patient's left, j towards posterior and
/// k towards superior, as far as the acquisition allows: nothing is interpolated, an oblique
/// acquisition stays oblique (its rest of a rotation is in `direction`).
Image3<float> in_lps_order(const Image3<float>& image);

/// Means over blocks of voxels along i and j such that voxels are at least about `size_mm` wide.
Image3<float> shrink_in_plane(const Image3<float>& image, double size_mm);

}  // namespace sanatrix::imaging
