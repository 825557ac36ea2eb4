// A tetrahedral mesh with named regions, named boundary faces and named points. Plain arrays, SI.
#pragma once

#include <array>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "geometry/vec3.hpp"

namespace sanatrix {

struct BoundaryFace {
  std::array<int, 3> vertex;  ///< outward orientation (right-hand rule)
  int name = 0;               ///< index into TetMesh::boundary_names
};

struct TetMesh {
  std::vector<Vec3> points;  ///< [m], patient frame LPS (+x left, +y posterior, +z superior)
  std::vector<std::array<int, 4>> cells;  ///< vertices, positive volume
  std::vector<int> region;                ///< per cell, index into region_names
  std::vector<std::string> region_names;
  std::vector<BoundaryFace> faces;  ///< named boundary faces; need not cover the whole boundary
  std::vector<std::string> boundary_names;
  std::map<std::string, int> named_points;  ///< name -> vertex
};

/// Volume of one tetrahedron [m3]; negative when it is inverted.
double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
/// Volume of every cell at the given vertex positions [m3].
std::vector<double> cell_volumes(const TetMesh& mesh, std::span<const Vec3> points);
/// Smallest dihedral angle of every cell [degree].
std::vector<double> min_dihedral_angles(const TetMesh& mesh, std::span<const Vec3> points);
/// Faces that belong to one cell only, oriented outwards.
std::vector<std::array<int, 3>> boundary_of(const TetMesh& mesh);
/// Vertices on the named boundary, ascending. Empty when there is no such name.
std::vector<int> vertices_on(const TetMesh& mesh, const std::string& boundary_name);
/// Index of a boundary name, or -1.
int boundary_index(const TetMesh& mesh, const std::string& boundary_name);
/// Turns cells of negative volume round and throws Error{Input} for degenerate cells, unused or
/// non-finite vertices and indices out of range; `where` names the mesh in the message.
void check_and_orient(TetMesh& mesh, const std::string& where);

}  // namespace sanatrix
