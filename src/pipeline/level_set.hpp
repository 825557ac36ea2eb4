// The surface on which a vertex field has a given value, by marching tetrahedra.
#pragma once

#include <span>

#include "geometry/tri_mesh.hpp"

namespace sanatrix::pipeline {

/// Triangles face towards lower values. Points on shared edges are shared.
TriMesh level_set(const TetMesh& mesh, std::span<const Vec3> points, std::span<const double> field,
                  double level);

/// Cell values to vertices, weighted by cell volume.
std::vector<double> to_vertices(const TetMesh& mesh, std::span<const Vec3> points,
                                std::span<const double> cell_values);

}  // namespace sanatrix::pipeline
