// Energy of the skin per unit of parameter area, as a function of the metrics of the deformed and
// of the reference surface: all of the membrane's mechanics in one scalar function.
#pragma once

#include "mechanics/jet.hpp"
#include "mechanics/material.hpp"

namespace sanatrix::mechanics {

/// First fundamental forms (11, 12, 22) [m2]: a of the deformed, A of the reference surface.
struct Metrics {
  std::array<double, 3> a, A;
};

enum class MembraneState { Slack, Wrinkled, Taut };
MembraneState membrane_state(const Metrics& m, bool tension_field);

/// thickness sqrt(det A) W(C) of the incompressible Veronda-Westmann law in plane stress (Eq. 10,
/// doi:10.1371/journal.pone.0159766), relaxed to the tension field when skin.tension_field: where
/// the smaller stretch falls below the natural width of uniaxial tension the membrane wrinkles and
/// keeps the uniaxial energy; where both are below one it is slack (Pipkin 1986,
/// doi:10.1093/imamat/36.1.85). Inputs of the jet: a11, a12, a22, A11, A12, A22. [J]
Jet<6> membrane_energy(const Skin& skin, const Metrics& m);

/// As membrane_energy, for the tangent of a first step: a slack or wrinkled membrane answers with
/// its stiffness at rest, so that Newton does not start on a body without skin.
Jet<6> membrane_energy_at_rest(const Skin& skin, const Metrics& m);

/// sqrt(det A) and its derivatives with respect to A11, A12, A22.
std::array<double, 4> reference_area(const Metrics& m);

}  // namespace sanatrix::mechanics
