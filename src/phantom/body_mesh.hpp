// Tetrahedra that fill the phantom's unloaded body: a grid over the chest wall, layers up to the
// skin.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "geometry/tet_mesh.hpp"
#include "phantom/tissue.hpp"

namespace sanatrix::phantom {

struct BodyMesh {
  TetMesh
      mesh;  ///< boundaries skin, chest, superior, inferior, posterior; points nipple_R, nipple_L
  std::vector<ChestPlace> places;  ///< per vertex
};

/// Edges of about `edge` in the breasts of an average patient, a little more in larger ones. [m]
BodyMesh mesh_body(const Anatomy& anatomy, double edge);

/// P2 nodes of the unloaded body: vertices, then one node per edge on the curved design, so that
/// skin and chest wall have no facets.
std::vector<Vec3> curved_nodes(const BodyMesh& body, const Anatomy& anatomy,
                               std::span<const std::array<int, 2>> edges);

/// Share of gland and tumour of every cell.
std::vector<double> gland_fractions(const BodyMesh& body, const Anatomy& anatomy,
                                    const TissueMap& tissue);

/// Divides the tetrahedron 0 <= c <= b <= a <= n into n^3 equal ones (Kuhn 1960); corners are
/// lattice points, whose weights at the four vertices are 1 - a/n, (a - b)/n, (b - c)/n, c/n.
struct Lattice {
  explicit Lattice(int n);
  std::vector<std::array<double, 4>> weights;  ///< per lattice point
  std::vector<std::array<int, 4>> tetrahedra;  ///< lattice points
};

}  // namespace sanatrix::phantom
