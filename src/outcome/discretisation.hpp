// How far a computed displacement may be from that of an infinitely fine mesh, estimated from the
// displacement alone: no further solve. docs/theory/discretisation-error.md
#pragma once

#include <span>

#include "geometry/tet_mesh.hpp"

namespace sanatrix::outcome {

/// Relative error of a displacement of linear elements, eta^2, where eta is the relative L2
/// difference between the cells' constant gradients and their volume-weighted means at the vertices
/// (Zienkiewicz and Zhu 1987, doi:10.1002/nme.1620240206). Gradients converge with h, displacements
/// with h^2 (Aubin and Nitsche), and eta follows the relative error of gradients, so its square
/// follows that of displacements. Counts cells in `used`. 0 when nothing moves.
double relative_displacement_error(const TetMesh& mesh, std::span<const Vec3> points,
                                   std::span<const Vec3> displacement,
                                   const std::vector<bool>& used);

}  // namespace sanatrix::outcome
