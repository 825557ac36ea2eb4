// The lumped P1 Laplacian of the vertices that one rank owns, for a group of species.
#pragma once

#include <span>
#include <vector>

#include "geometry/tet_mesh.hpp"
#include "healing/wound_map.hpp"

namespace sanatrix::healing {

/// Rows of (-M^-1 K) with the diagonal left out, and what passes to healthy tissue. [1/m2]
struct Laplacian {
  struct Entry {
    int column;
    double weight;
  };
  std::vector<int> row;          ///< CSR
  std::vector<Entry> entries;    ///< of a row in the order of the mesh's vertices
  std::vector<double> exchange;  ///< per row, with tissue that stays healthy
  std::vector<double> diagonal;  ///< per row, sum of weights and exchange
};

enum class Domain {
  Mesh,   ///< every cell; vertices that are not near are held at their healthy values
  Wound,  ///< wound cells only, healthy values on their surface (docs/theory/healing.md)
};

/// Rows for the given vertices, ascending, all of them near; columns are near vertices of the mesh.
Laplacian make_laplacian(const TetMesh& mesh, std::span<const Vec3> points, const WoundMap& wound,
                         Domain domain, const std::vector<bool>& near,
                         std::span<const int> vertices);

/// A Laplacian applied to some species at once: the unknowns of a vertex lie side by side.
struct Diffusion {
  std::vector<double> diffusivity;  ///< per species of the group [m2/s]
  std::vector<double> healthy;      ///< per species, what is exchanged with
  int first = 0;                    ///< where the group's unknowns begin in the own vector
  Laplacian laplacian;              ///< columns: where a vertex's unknowns begin in the vector

  /// out = D M^-1 K q, own unknowns of the group; q: own unknowns and ghosts.
  void apply(std::span<const double> q, std::span<double> out) const;
  /// The same for a difference of two states, which healthy values do not enter.
  void apply_homogeneous(std::span<const double> q, std::span<double> out) const;
};

}  // namespace sanatrix::healing
