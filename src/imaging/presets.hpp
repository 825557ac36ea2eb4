// What the numbers of a label file mean: one table per known source of label maps.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/image.hpp"
#include "imaging/segmentation.hpp"

namespace sanatrix::imaging {

struct Tissue {
  Label label;
  double fibroglandular;  ///< volume fraction, 0..1
};

struct LabelTable {
  std::string name;
  std::vector<Tissue> tissue;  ///< per number in the file
  /// The map knows only the front sheet of the chest wall: what is behind the sheet is not air.
  bool sheet_only = false;
  double skin_limit_mm = 0.0;  ///< skin labels deeper than this are adipose; 0: as given
  /// Half height of the part around the breasts that can be trusted; 0: all of it.
  double half_height_mm = 0.0;
};

const LabelTable& label_table(LabelPreset preset);

}  // namespace sanatrix::imaging
