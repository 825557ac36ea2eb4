// A segmentation whose chest wall lies nearer to the skin, or deeper, than it was found: what an
// error of the wall does to all that follows can then be computed.
#pragma once

#include "imaging/segmentation.hpp"

namespace sanatrix::imaging {

/// Moves the chest wall (labels 4 to 7) everywhere perpendicularly to itself; positive: deeper.
/// What the wall sets free becomes adipose tissue; tumours are left where they are.
void move_wall(Segmentation& segmentation, double deeper_mm);

}  // namespace sanatrix::imaging
