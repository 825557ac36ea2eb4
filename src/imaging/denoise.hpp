// Takes noise out of an image without blurring its edges.
#pragma once

#include "geometry/image.hpp"
#include "geometry/image_filters.hpp"

namespace sanatrix::imaging {

/// Standard deviation of noise that is the same everywhere in `where`: from the mean of the
/// smallest quarter of the differences between next but one voxels of a row. Edges are among the
/// larger ones; a quantile would be one of few whole numbers.
double noise_deviation(const Image3<float>& image, const Mask& where);

/// The image u with the least sum of (u - image)^2 / (2 deviation) + |gradient of u| (total
/// variation, Rudin, Osher and Fatemi, doi:10.1016/0167-2789(92)90242-F), slice by slice, by the
/// primal-dual method of Chambolle and Pock, doi:10.1007/s10851-010-0251-1.
/// The deviation, not its square: in one dimension an extremum of n voxels moves by 2 deviation /
/// n, so that noise goes at any strength, and weak signals keep more than a fixed prior of u would
/// leave them.
/// `deviation`: of the noise, per voxel, with image values that are shares of 0 to 1; what lies
/// outside `where` keeps its value.
Image3<float> without_noise(const Image3<float>& image, const Image3<float>& deviation,
                            const Mask& where);

}  // namespace sanatrix::imaging
