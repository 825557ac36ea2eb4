// Lengths along a surface, as a tape measures them.
#pragma once

#include <span>
#include <vector>

#include "geometry/tri_mesh.hpp"

namespace sanatrix {

/// Lengths of the shortest ways on the surface from the place nearest to `from` to those nearest
/// to each of `to` [m]; NaN where there is no way. Exact on the triangles (Xin and Wang 2009,
/// doi:10.1145/1559755.1559761, by CGAL). Points at equal places are one.
std::vector<double> lengths_along(const TriMesh& surface, const Vec3& from,
                                  std::span<const Vec3> to);

}  // namespace sanatrix
