// Moves vertices of flat tetrahedra where reconnecting them did not help.
#pragma once

#include "meshing/tetrahedra.hpp"

namespace sanatrix::meshing {

/// Raises the smallest dihedral angles above the bound where moving vertices can do it. Vertices on
/// a patch stay on it, vertices where patches meet stay where they are.
void move_vertices_of_flat_cells(Tetrahedra& mesh, const DomainSurface& surface, double bound_deg);

}  // namespace sanatrix::meshing
