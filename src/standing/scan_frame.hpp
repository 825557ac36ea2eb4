// How the patient stands in her scan: left, back and up, found from the shape of her trunk.
// docs/theory/scan-only.md, section 1
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "geometry/rigid.hpp"
#include "geometry/textured_surface.hpp"

namespace sanatrix::standing {

/// What somebody marked on the scan, in its own frame [m]. Arrays of two are right, left.
struct ScanLandmarks {
  std::array<std::optional<Vec3>, 2> nipple;
  std::optional<Vec3> sternal_notch;
  std::optional<Vec3> up;  ///< a direction, against gravity
};

/// What a nipple's place was taken from, the surest first.
enum class NippleSign { Mark, Colour, Bump, Shape };
struct NippleFind {
  NippleSign sign = NippleSign::Shape;
  double doubt_mm = 0.0;  ///< 1 sd of the place
};

struct ScanFrame {
  Rigid to_patient;  ///< scan -> LPS [m]; x = 0 is the trunk's middle, else the origin is
                     ///< midway between the nipples
  std::array<Vec3, 2> nipple{};  ///< LPS [m]
  std::array<NippleFind, 2> nipple_find{};
  std::optional<Vec3> sternal_notch;
  std::vector<std::string> notes;  ///< how sure this is, one sentence each
};

/// Works for any rigid pose and for scans that go round the trunk. Error{Input} when no two breasts
/// side by side are found and no landmarks are given.
ScanFrame find_frame(const TexturedSurface& scan, const ScanLandmarks& marks);

}  // namespace sanatrix::standing
