// How well two label maps of one patient agree: what a validation study reports.
#pragma once

#include "geometry/image.hpp"

namespace sanatrix::imaging {

struct SurfaceError {
  double mean_mm = 0.0, p95_mm = 0.0;
};
struct Agreement {
  double soft_dice = 0.0;                 ///< breast soft tissue
  double glandular_dice = 0.0;            ///< fibroglandular and tumour
  double glandular_volume_percent = 0.0;  ///< found against true, signed difference
  SurfaceError chest_wall, skin;          ///< true surface to found one, and back
};

/// Both in the sanatrix table, of one frame of reference; compared on the grid of the reference.
Agreement compare_labels(const LabelImage& found, const LabelImage& reference);

}  // namespace sanatrix::imaging
