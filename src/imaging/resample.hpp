// Brings a label volume of any orientation and spacing onto an isotropic grid aligned with LPS.
#pragma once

#include "core/context.hpp"
#include "geometry/image.hpp"
#include "imaging/presets.hpp"

namespace sanatrix::imaging {

struct TissueGrid {
  LabelImage labels;
  Image3<float> fibroglandular;
};

/// Surfaces of the body and of the chest wall come from interpolated distances, so that thick
/// slices leave no stairs; tissues inside come from votes of the neighbouring voxels.
TissueGrid resample_to_lps(const LabelImage& source, const LabelTable& table, double spacing_mm,
                           const Context& ctx);
/// The same for labels of the sanatrix table with their shares. `skin_limit_mm`: as in LabelTable.
TissueGrid resample_to_lps(const TissueGrid& source, double skin_limit_mm, double spacing_mm,
                           const Context& ctx);

}  // namespace sanatrix::imaging
