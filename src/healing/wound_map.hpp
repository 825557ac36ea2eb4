// Which vertices belong to the wound, how much of them, and how they touch healthy tissue.
#pragma once

#include <span>
#include <vector>

#include "fem/mesh_share.hpp"
#include "geometry/tet_mesh.hpp"

namespace sanatrix::healing {

/// Wound cells are those with a wound fraction of one half or more. One entry per cell or vertex.
struct WoundMap {
  std::vector<bool> cell;
  std::vector<bool> vertex;      ///< touches a wound cell (interface included)
  std::vector<double> fraction;  ///< share of wound in the vertex's lumped volume
  std::vector<double> area;      ///< the vertex's share in the surface of the wound cells [m2]
};

/// Complete for vertices that this process owns; of the others of its share, `vertex` only.
WoundMap make_wound_map(const TetMesh& mesh, std::span<const Vec3> points,
                        std::span<const double> wound_fraction, const fem::MeshShare* share);

}  // namespace sanatrix::healing
