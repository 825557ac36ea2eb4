// First Piola-Kirchhoff stress and its derivative for the tissue law of Eq. (9),
// doi:10.1371/journal.pone.0159766, with pressure as an independent field and active stress.
#pragma once

#include "geometry/vec3.hpp"
#include "mechanics/material.hpp"

namespace sanatrix::mechanics {

/// dP_iJ / dF_kL, index [3 i + J][3 k + L]. [Pa]
using Tangent9 = std::array<std::array<double, 9>, 9>;

struct StressPoint {
  double J;      ///< det F
  Mat3 F_inv_t;  ///< F^-T
  Mat3 P;        ///< first Piola-Kirchhoff stress, pressure included [Pa]
};

/// P = integrity dWiso/dF + T F + p J F^-T. F must have det > 0.
StressPoint stress(const Tissue& tissue, const Mat3& F, double p);
/// dP/dF, where p itself changes with J by dp_dJ.
void stress_tangent(const Tissue& tissue, const Mat3& F, double p, double dp_dJ,
                    const StressPoint& at, Tangent9& A);
/// integrity Wiso + T/2 (F:F - 3), the energy whose derivative is P without pressure [Pa].
double energy(const Tissue& tissue, const Mat3& F);

}  // namespace sanatrix::mechanics
