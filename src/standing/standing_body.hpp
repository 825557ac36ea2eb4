// The surface-scan-only path: labels of a standing torso from her skin alone, for the same mesh as
// labels of an MRI. docs/theory/scan-only.md
#pragma once

#include "core/context.hpp"
#include "imaging/segmentation.hpp"
#include "standing/chest_wall.hpp"

namespace sanatrix::standing {

struct BodyOptions {
  double spacing_mm = 1.0;    ///< of the labels
  double gland_share = 0.20;  ///< fibroglandular volume fraction of the breasts, 0..1
  double wall_depth_mm = usual_wall_depth_mm;  ///< soft tissue over the chest wall beside a breast
};

struct StandingBody {
  imaging::Segmentation segmentation;  ///< of the standing patient
  std::array<double, 2> breast_cm3{};  ///< right, left: in front of the wall, in the footprint
  std::array<double, 2> breast_doubt_cm3{};  ///< 1 sd, from the doubt about the wall
  double unseen_share = 0.0;                 ///< of the breasts' front that the scan does not show
  meshing::ColumnMap wall_y;                 ///< [mm] front of the estimated wall, seen from front
  std::vector<signed char> side;             ///< breast of each of its columns
};

/// `skin` and `nipple` in LPS [m]. Error{Input}: the scan shows too little of a breast, has a hole
/// that is too large, or what stands forward is no breast.
StandingBody build_body(const TriMesh& skin, const std::array<Vec3, 2>& nipple,
                        const BodyOptions& options, const Context& ctx);

}  // namespace sanatrix::standing
