// Landmarks of the skin with how sure they are, for people and for what needs a reference point.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/image.hpp"
#include "imaging/segmentation.hpp"

namespace sanatrix::imaging {

struct SkinLandmark {
  std::string name;             ///< "nipple_right", "inframammary_fold_left", "midline", ...
  std::optional<Vec3> at_mm{};  ///< LPS; nothing where it was not found
  double confidence = 0.0;      ///< 0..1, docs/theory/segmentation.md; not a probability
  std::string missing{};        ///< why it was not found
};

/// What is as sure as that may serve as a point of reference.
constexpr double sure_landmark = 0.5;

/// Nipples, midline at the level of the nipples, the inframammary fold below either nipple, and the
/// sternal notch: all are listed, also those that the field does not reach or that nothing finds.
std::vector<SkinLandmark> skin_landmarks(const Segmentation& segmentation);

}  // namespace sanatrix::imaging
