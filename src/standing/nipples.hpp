// Nipples and sternal notch on a scan whose axes are known.
#pragma once

#include "standing/scan_frame.hpp"

namespace sanatrix::standing {

/// Fills to_patient, nipple, nipple_find and sternal_notch; marked ones are taken as they are. The
/// scan's colours say most, then a bump, then the shape of the breast. `rotation` turns
/// the scan into LPS, where the trunk's middle is at `middle_x_m` (nothing: midway between the
/// nipples). Error{Input} when there is no breast on one side.
void locate_nipples(const TexturedSurface& scan, const Mat3& rotation,
                    std::optional<double> middle_x_m, const ScanLandmarks& marks, ScanFrame& frame);

}  // namespace sanatrix::standing
