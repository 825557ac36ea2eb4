// Landmarks given by hand must not contradict the scan: who mixes up left and right here operates
// on the wrong breast.
#pragma once

#include "standing/scan_frame.hpp"

namespace sanatrix::standing {

/// Error{Input} when a mark lies far from the skin, or the skin at both marked nipples looks to the
/// back when nipples and sternal notch say what is left and up.
void check_marks(const TriMesh& scan, const ScanLandmarks& marks);

/// Error{Input} when the marks contradict how she was found to stand: a nipple on the other side, a
/// notch below the nipples.
void check_marks(const ScanFrame& frame, const ScanLandmarks& marks);

}  // namespace sanatrix::standing
