// A contracting spherical wound in spherical symmetry: an independent answer for strong
// contraction.
#pragma once

#include <vector>

#include "healing/model.hpp"
#include "mechanics/material.hpp"

namespace sanatrix::verification {

/// Relative cell density along the radius, piecewise linear.
struct RadialProfile {
  std::vector<double> radius;   ///< [m], ascending from 0 to the wall
  std::vector<double> density;  ///< eta/eta0
  [[nodiscard]] double at(double r) const;
};

/// V/V0 of the wound in equilibrium with these cells, in a free ball of radius `outer` [m]. Linear
/// elements along the radius with stresses from principal stretches; nothing is shared with the
/// three-dimensional code. Error{Numerics} when Newton's method fails.
double radial_volume_ratio(const RadialProfile& cells, double outer,
                           const healing::WoundMechanics& wound, const mechanics::Tissue& healthy);

}  // namespace sanatrix::verification
