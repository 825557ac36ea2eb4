// Finds the two breasts of a prone patient on an LPS-aligned label grid: peaks, midline, nipples.
#pragma once

#include <array>

#include "geometry/image.hpp"

namespace sanatrix::imaging {

struct Landmarks {
  std::array<Vec3, 2> nipple_mm;  ///< [0] right, [1] left
  bool nipples_from_label = false;
  double midline_x_mm = 0.0;
};

/// Throws Error{Input} without two breasts that hang towards -y, one on each side of a cleft.
Landmarks find_landmarks(const LabelImage& labels);

}  // namespace sanatrix::imaging
