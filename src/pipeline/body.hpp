// The patient as a mechanical body: tissue, skin and supports (Fig 3 of
// doi:10.1371/journal.pone.0159766).
#pragma once

#include <span>

#include "mechanics/problem.hpp"
#include "pipeline/parameters.hpp"

namespace sanatrix::pipeline {

inline constexpr double standard_gravity = 9.81;  ///< [m/s2]
inline constexpr Vec3 gravity_prone{0, -standard_gravity, 0};
inline constexpr Vec3 gravity_supine{0, standard_gravity, 0};
inline constexpr Vec3 gravity_upright{0, 0, -standard_gravity};

/// Of the pose in which the patient's geometry was captured: prone MRI or standing scan.
inline Vec3 gravity_captured(bool scan_only) {
  return scan_only ? gravity_upright : gravity_prone;
}

/// The tissue preset with the values given for this case.
mechanics::TissuePreset tissue_values(const Parameters& parameters);
mechanics::Element element_of(const Parameters& parameters);
/// Chest fixed, superior and inferior cuts held along the axis, all else free; membrane on the
/// skin. `fibroglandular`: volume fraction per cell. `mesh` must outlive the body.
mechanics::Body make_body(const TetMesh& mesh, std::span<const double> fibroglandular,
                          const Parameters& parameters);
/// Keeps the cells that touch the chest from folding: Tissue::guard of them (ADR 18).
void guard_wall(mechanics::Body& body, double guard);
mechanics::SolveOptions solve_options(const Parameters& parameters);

}  // namespace sanatrix::pipeline
