// Takes noise out of an image without blurring its edges.
#pragma once

#include "geometry/image.hpp"
#include "geometry/image_filters.hpp"

namespace sanatrix::imaging {

/// Standard deviation of noise that is the same everywhere in `where`: from the quarter quantile of
/// the differences between next but one voxels of a row. Edges are among the larger ones.
double noise_deviation(const Image3<float>& image, const Mask& where);

/// The most probable image u for a noisy one whose neighbours in a slice differ rarely but then
/// much: least sum of (u - image)^2 / (2 deviation^2) + |gradient of u| / step (total variation,
/// Rudin, Osher and Fatemi, doi:10.1016/0167-2789(92)90242-F), slice by slice, by the primal-dual
/// method of Chambolle and Pock, doi:10.1007/s10851-010-0251-1.
/// `deviation`: of the noise, per voxel; what lies outside `where` keeps its value.
/// `step`: the mean difference between neighbours if there were no noise.
Image3<float> without_noise(const Image3<float>& image, const Image3<float>& deviation,
                            const Mask& where, double step);

}  // namespace sanatrix::imaging
