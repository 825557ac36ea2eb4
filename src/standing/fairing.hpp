// Smooth values where nothing was measured.
#pragma once

#include <vector>

#include "geometry/image.hpp"

namespace sanatrix::standing {

/// Replaces the unknown values of an image by the smoothest ones between the known: least sum of
/// squared Laplacians. A level set then crosses the unknown part with continuous slope, as a bent
/// plate does. The values that are there are where the search begins.
void fair(Image3<float>& image, const std::vector<bool>& unknown);

}  // namespace sanatrix::standing
