// Structured meshes of tetrahedra in simple shapes: for verification and tests.
#pragma once

#include <array>
#include <functional>

#include "geometry/tet_mesh.hpp"

namespace sanatrix {

/// A lattice of n[0] x n[1] x n[2] boxes, six tetrahedra each around the diagonal that leads away
/// from the origin (Kuhn), with its vertices moved by `place`. One region, "tissue"; no boundaries.
TetMesh lattice(std::array<int, 3> n, const std::function<Vec3(int, int, int)>& place);

/// [0, size_i] with n_i boxes along axis i. Boundaries "x0", "x1", "y0", "y1", "z0", "z1".
TetMesh block(const Vec3& size, const std::array<int, 3>& n);
/// One row of boxes along x.
TetMesh bar(int boxes, double length, double width);

/// The octant x, y, z >= 0 of a ball; vertices lie on spheres of the given ascending radii, of
/// which the first is 0. Layers below `hollow` are left out. Boundaries "x0", "y0", "z0" (symmetry
/// planes), "outer" and, when hollow, "inner".
TetMesh ball_octant(const std::vector<double>& radii, int hollow = 0);
/// A quarter of a tube around z, 0 <= z <= height, one layer of boxes along z. Boundaries "x0",
/// "y0", "z0", "z1", "inner", "outer".
TetMesh tube_quarter(double inner, double outer, double height, int layers, int around);
/// Radii with `layers` equal layers up to the first radius and growing ones up to the outer one.
std::vector<double> graded_radii(double first, int layers, double outer, double growth);

/// Supports of symmetry planes for mechanics: bit i at vertices on the boundary "x0", "y0", "z0".
std::vector<std::uint8_t> symmetry_supports(const TetMesh& mesh);
Vec3 centroid(const TetMesh& mesh, std::size_t cell);
/// Per cell: 1 where inside(centroid), else 0.
std::vector<double> cells_where(const TetMesh& mesh,
                                const std::function<bool(const Vec3&)>& inside);

}  // namespace sanatrix
