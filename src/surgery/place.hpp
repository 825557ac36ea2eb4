// Where a tumour is, in the surgeon's words. The only definition: planner and report both use it.
#pragma once

#include <string>

#include "surgery/plan.hpp"

namespace sanatrix::surgery {

/// Seen from the nipple by somebody who faces the patient, in the pose in which she was captured
/// (prone for an MRI, standing for a scan alone): the pose of the radiologist's report, and one
/// that exists before anything is simulated.
struct Place {
  std::string quadrant;       ///< "upper outer" ...; "central" behind the areola
  double clock_hour = 0.0;    ///< in half hours, 0.5 to 12; 3 is her left
  double from_nipple_mm = 0;  ///< straight
};
Place place_of(const Vec3& tumour_centre, const Vec3& nipple, Side side);

}  // namespace sanatrix::surgery
