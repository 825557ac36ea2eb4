// Last repairs of flat tetrahedra that reconnecting inside the mesh cannot reach.
#pragma once

#include "meshing/deadline.hpp"
#include "meshing/tetrahedra.hpp"

namespace sanatrix::meshing {

/// Takes cells away that lie flat on a smooth patch with two faces.
void peel_flat_cells(Tetrahedra& mesh, double bound_deg);

/// Raises the smallest dihedral angles above the bound where moving vertices can do it. Vertices on
/// a patch stay on it, vertices where patches meet stay where they are.
void move_vertices_of_flat_cells(Tetrahedra& mesh, const DomainSurface& surface, double bound_deg,
                                 const Deadline& deadline);

}  // namespace sanatrix::meshing
