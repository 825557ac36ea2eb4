// A triangulated surface. Plain arrays, SI.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "geometry/tet_mesh.hpp"

namespace sanatrix {

struct TriMesh {
  std::vector<Vec3> points;  ///< [m], LPS
  std::vector<std::array<int, 3>> triangles;
};

double area(const Vec3& a, const Vec3& b, const Vec3& c);  ///< [m2]
double surface_area(const TriMesh& surface);               ///< [m2]
/// Area-weighted unit normals per vertex.
std::vector<Vec3> vertex_normals(const TriMesh& surface);

/// The named boundary of a mesh at given vertex positions; `vertex` maps surface to mesh vertices.
struct Surface {
  TriMesh mesh;
  std::vector<int> vertex;
};
Surface extract_surface(const TetMesh& mesh, std::span<const Vec3> points,
                        const std::vector<std::string>& boundary_names);

}  // namespace sanatrix
