// What each tetrahedron is made of and which breast it belongs to.
#pragma once

#include "meshing/anatomy.hpp"
#include "meshing/breast_mesh.hpp"

namespace sanatrix::meshing {

/// Fills fibroglandular, side, in_breast and nipple_vertex of a model whose mesh is complete.
void assign_tissue(BreastModel& model, const Image3<float>& fibroglandular,
                   const BreastMap& breasts, const std::array<Vec3, 2>& nipple_mm);

}  // namespace sanatrix::meshing
