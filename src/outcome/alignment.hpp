// Where a surface scan lies in the patient's frame. docs/theory/outcome.md, section 1
#pragma once

#include <optional>
#include <span>

#include "geometry/rigid.hpp"

namespace sanatrix::outcome {

/// The patient's skin as it is thought to stand, and what is not certain about it.
struct StandingSkin {
  TriMesh surface;
  std::vector<double> trust;  ///< per vertex, 0..1: skin that hardly moves between poses is trusted
  /// Displacement fields per vertex by multiples of which the shape may be wrong: how far the
  /// tissue sags is what a model with assumed stiffness knows least.
  std::vector<std::vector<Vec3>> modes;
};

struct Alignment {
  Rigid to_patient;                   ///< scan -> patient frame (LPS, m)
  double median_m = 0.0;              ///< distance of trusted, overlapping skin after alignment
  double rms_m = 0.0;                 ///< of the same points, without the farthest tenth
  std::vector<double> mode_shares{};  ///< multiples of the modes that fit best
  double overlap = 0.0;  ///< share of the patient's trusted skin that the scan covers, 0..1
};

/// Rigid alignment by robust iterative closest points (point to plane, Chen and Medioni 1992,
/// doi:10.1016/0262-8856(92)90066-C; Tukey weights), from the whole space of rotations unless a
/// start (scan -> patient) is given. The shares of the modes are found along with the pose, so that
/// breasts that sag more or less than thought do not pull the scan up or down. Error{Input} when
/// what is found is not good enough to be believed, with the numbers.
Alignment align(const StandingSkin& patient, const TriMesh& scan,
                const std::optional<Rigid>& start = std::nullopt);

/// The same from a start, without judging the result: for surfaces that are known to belong
/// together.
Alignment align_freely(const StandingSkin& patient, const TriMesh& scan, const Rigid& start);

/// Starts from matching landmarks: the rigid motion with the least squared distances
/// (Umeyama 1991, doi:10.1109/34.88573). At least three pairs that are not on one line.
Rigid match_landmarks(std::span<const Vec3> scan, std::span<const Vec3> patient);

}  // namespace sanatrix::outcome
