// The trunk ends at the arms, wherever the patient holds them.
#pragma once

#include "standing/front_map.hpp"

namespace sanatrix::standing {

/// x [mm] of the sagittal planes between arm and trunk, right and left: in the gap or the groove
/// beside the breasts. Far away where the scan shows no arm.
std::array<double, 2> armpits(const FrontMap& front, const std::array<Vec3, 2>& nipple_mm);

}  // namespace sanatrix::standing
