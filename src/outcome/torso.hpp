// The standing torso with its landmarks, and the frame in which cosmetic indices are defined.
// docs/theory/outcome.md, section 3
#pragma once

#include <array>

#include "geometry/tri_mesh.hpp"

namespace sanatrix::outcome {

/// One pose. Arrays of two are [0] patient's right, [1] left.
struct Torso {
  TriMesh skin;                     ///< [m]
  std::vector<signed char> breast;  ///< per vertex: -1 right, +1 left, 0 neither
  Vec3 up{0, 0, 1};                 ///< against gravity
  Vec3 notch{};                     ///< sternal notch, or what stands for it
  std::array<Vec3, 2> nipple{};
  std::array<Vec3, 2> fold{};  ///< inframammary fold below the nipple
  std::array<double, 2> volume_m3{};
  std::array<double, 2> upper_share{};  ///< of the volume above the nipple's level
};

/// x to the patient's left, y anterior, z up, from the sternal notch.
struct BodyFrame {
  Vec3 origin{}, left{}, anterior{}, up{};

  [[nodiscard]] Vec3 operator()(const Vec3& p) const {
    const Vec3 r = p - origin;
    return {dot(left, r), dot(anterior, r), dot(up, r)};
  }
  /// Mirrored at the mid-sagittal plane.
  [[nodiscard]] Vec3 mirror(const Vec3& p) const { return p - (2 * dot(left, p - origin)) * left; }
};

/// Starts from the given direction to the patient's left and refines the mid-sagittal plane by
/// laying the mirrored skin outside both breasts onto itself; breasts would hide their asymmetry.
BodyFrame body_frame(const Torso& torso, const Vec3& roughly_left);

/// Frontal outline of a breast on both its sides, as seen by a camera in front of the patient.
struct Outline {
  double length_m = 0.0;  ///< of the lower contour, from the most lateral point to the medial end
  double area_m2 = 0.0;
  Vec3 lowest{}, lateral{};  ///< in the body frame, x positive on both sides (away from the middle)
};
/// side 0 right, 1 left.
Outline outline(const Torso& torso, const BodyFrame& frame, std::size_t side);
/// Area that belongs to one breast or the mirrored other, not to both [m2].
double overlap_difference(const Torso& torso, const BodyFrame& frame);
/// Root mean square distance of each breast's mirrored skin from the other side's skin [m].
double rms_asymmetry(const Torso& torso, const BodyFrame& frame);

}  // namespace sanatrix::outcome
