// Step B without a human: labels and glandular shares from a greyscale prone MRI.
#pragma once

#include <string>
#include <vector>

#include "core/context.hpp"
#include "geometry/image.hpp"
#include "imaging/chest_wall.hpp"
#include "imaging/glandular.hpp"
#include "imaging/resample.hpp"

namespace sanatrix::imaging {

/// What the segmentation found on the grid of the image (in LPS order, without what lies far behind
/// the breasts), and how sure it is.
struct AutomaticLabels {
  TissueGrid grid;
  Image3<float> relative;  ///< signal relative to fat
  ChestWall wall;
  GlandularModel gland;
  double noise = 0.0;  ///< of air, relative to fat in the middle of the breasts
};

/// Prone, both breasts, T1 or T2 without fat suppression. Error{Input} saying what is not there.
AutomaticLabels label_image(const Image3<float>& image, const Context& ctx);

}  // namespace sanatrix::imaging
