// Cases that know nothing but a surface scan of the standing patient: her frame, and plans that
// are given from the nipple. docs/user/scans.md
#pragma once

#include "pipeline/case.hpp"
#include "standing/scan_frame.hpp"

namespace sanatrix::pipeline {

/// The landmarks of a file: our JSON ("landmarks_scan_mm", perhaps "up_scan") or Slicer markups
/// with points named nipple_R, nipple_L, sternal_notch. In the scan's frame [m]. Error{Input}.
standing::ScanLandmarks read_marks(const std::string& json_text, const std::string& name);

/// Finds how the patient stands in her scan and keeps it as the input "scan_frame". Error{Input}
/// when the scan shows no breasts.
void find_standing_frame(Case& patient);

/// Whether that frame was found with the unit that the case's parameters ask for.
bool stands_in_unit(const Case& patient);

/// What find_standing_frame kept, and the scan itself in LPS [m].
struct StandingScan {
  TriMesh skin;
  std::array<Vec3, 2> nipple{};  ///< right, left
  std::optional<Vec3> sternal_notch;
  Rigid to_patient;
  std::string unit;
  std::string nipples;  ///< JSON: what they were taken from, and their doubt
  std::vector<std::string> notes;
};
StandingScan load_standing_scan(const Case& patient);

/// A plan that says clock or quadrant, distance from the nipple and depth becomes one in LPS, in
/// the pose of the scan; other plans stay as they are. Error{Input} names the key.
std::string placed_plan(const std::string& json_text, const StandingScan& scan,
                        const std::string& name);

}  // namespace sanatrix::pipeline
