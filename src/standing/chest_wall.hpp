// Where the chest wall is likely to be behind a scanned skin. docs/theory/scan-only.md, section 3
#pragma once

#include "meshing/anatomy.hpp"
#include "standing/front_map.hpp"

namespace sanatrix::standing {

/// Skin of the trunk as if there were no breasts: y [mm] per column. What the breasts cover, and
/// the rim around them, is spanned by a surface between a membrane and a thin plate, bulged as a
/// chest is.
meshing::ColumnMap trunk_without_breasts(const FrontMap& front, const meshing::BreastMap& breasts);

/// Soft tissue between that skin and the fascia [mm], and the doubt (1 sd) about the wall's place
/// behind a breast.
inline constexpr double usual_wall_depth_mm = 16.0;
inline constexpr double wall_doubt_mm = 7.0;
/// The same of the wall as a whole, which the breasts' volume follows.
inline constexpr double wall_offset_doubt_mm = 4.0;

}  // namespace sanatrix::standing
