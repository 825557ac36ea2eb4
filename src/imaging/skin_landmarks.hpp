// Landmarks of the skin with how sure they are, for people and for what needs a reference point.
#pragma once

#include <string>
#include <vector>

#include "geometry/image.hpp"
#include "imaging/segmentation.hpp"

namespace sanatrix::imaging {

struct SkinLandmark {
  std::string name;         ///< "nipple_right", "inframammary_fold_left", "midline", ...
  Vec3 at_mm{};             ///< LPS
  double confidence = 0.0;  ///< 0..1, docs/theory/segmentation.md; not a probability
};

/// Nipples, midline at the level of the nipples, and the inframammary fold below either nipple
/// where the field reaches that far.
std::vector<SkinLandmark> skin_landmarks(const Segmentation& segmentation);

}  // namespace sanatrix::imaging
