// How the patient stands in her scan: left, back and up, found from the shape of her trunk.
// docs/theory/scan-only.md, section 1
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "geometry/rigid.hpp"

namespace sanatrix::standing {

/// What somebody marked on the scan, in its own frame [m]. Arrays of two are right, left.
struct ScanLandmarks {
  std::array<std::optional<Vec3>, 2> nipple;
  std::optional<Vec3> sternal_notch;
  std::optional<Vec3> up;  ///< a direction, against gravity
};

struct ScanFrame {
  Rigid to_patient;              ///< scan -> LPS [m], origin midway between the nipples
  std::array<Vec3, 2> nipple{};  ///< LPS [m]
  std::optional<Vec3> sternal_notch;
  std::vector<std::string> notes;  ///< how sure this is, one sentence each
};

/// Works for any rigid pose and for scans that go round the trunk. Error{Input} when no two breasts
/// side by side are found and no landmarks are given.
ScanFrame find_frame(const TriMesh& scan, const ScanLandmarks& marks);

}  // namespace sanatrix::standing
