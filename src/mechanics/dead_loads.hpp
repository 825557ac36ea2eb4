// Nodal forces of loads that do not follow the deformation.
#pragma once

#include <span>
#include <vector>

#include "fem/layout.hpp"
#include "mechanics/problem.hpp"

namespace sanatrix::mechanics {

/// int N b dV + int N t dA per node of the element, vertices first, then mid-edges [N]. Quadrature
/// of degree 5 in cells and 4 on faces, so that the loads never limit the order of an element.
std::vector<Vec3> dead_forces(const Body& body, const fem::EdgeTable& edges,
                              std::span<const Vec3> reference_nodes);

}  // namespace sanatrix::mechanics
