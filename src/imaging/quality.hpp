// Can the result of the automatic segmentation be believed? Numbers, doubts and refusals.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "geometry/image.hpp"

namespace sanatrix::imaging {

struct AutomaticLabels;

struct Quality {
  std::array<double, 2> soft_cm3{};       ///< [0] right, [1] left half of the model region
  std::array<double, 2> glandular_cm3{};  ///< the same
  double wall_contrast = 0.0;             ///< median step at the chest wall, 0..1 of fat's signal
  double wall_seen = 0.0;                 ///< share of the wall with a clear step
  double wall_roughness_mm = 0.0;         ///< root mean square of its second differences
  double wall_blind = 0.0;                ///< share of its patches of 30 mm that are hardly seen
  double separation = 0.0;                ///< fat against gland, in standard deviations of fat
  int open_slices = 0;                    ///< with air close behind the chest wall
  std::vector<std::string> doubts;        ///< usable, but look
  std::vector<std::string> defects;       ///< not usable because ...
};

Quality assess(const AutomaticLabels& found);
/// Adds volumes and their plausibility.
void assess(const LabelImage& labels, double midline_x_mm, Quality& quality);

}  // namespace sanatrix::imaging
