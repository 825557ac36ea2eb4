// The sternal notch: the hollow of the skin above the breastbone, if the field reaches it.
#pragma once

#include "imaging/skin_landmarks.hpp"

namespace sanatrix::imaging {

/// On the skin of the hollow's floor, where it turns from the breastbone's upper edge into the
/// neck. A field that ends below it, or in it, has no notch: `missing` says so.
SkinLandmark find_sternal_notch(const Segmentation& segmentation);

}  // namespace sanatrix::imaging
