// Volume and wall of the wound in a deformed body.
#pragma once

#include <span>
#include <vector>

#include "fem/mesh_share.hpp"
#include "geometry/tet_mesh.hpp"
#include "mechanics/material.hpp"

namespace sanatrix::recovery {

/// Measures the wound of one mesh in many shapes.
class WoundShape {
 public:
  /// wound_fraction per cell, 0..1; the wall separates cells at or above one half from the others.
  /// `healthy` is the tissue of every cell before surgery. share: the mesh is this process's share
  /// of a larger; all that is measured is then of the whole, the same on every process, collective.
  WoundShape(const TetMesh& mesh, std::span<const double> wound_fraction,
             std::span<const Vec3> reference_points, std::span<const mechanics::Tissue> healthy,
             const fem::MeshShare* share = nullptr);
  /// Volume of the wounded share [m3] from det F per cell and pressure per vertex [Pa] (empty:
  /// zero). Elements with a pressure field conserve volume in the mean, not cell by cell: healthy
  /// cells at the wall lose what the wound should. The body's change of volume, less what healthy
  /// tissue is compressed by the pressure, is the wound's, on any mesh.
  [[nodiscard]] double volume(std::span<const double> jacobians,
                              std::span<const double> pressure) const;
  /// Area-weighted mean displacement of the wall towards the inside [m].
  [[nodiscard]] double mean_inward_displacement(std::span<const Vec3> before,
                                                std::span<const Vec3> after) const;

 private:
  const TetMesh* mesh_;
  const fem::MeshShare* share_;
  double at_rest_ = 0.0;                  ///< wounded share of the reference volume [m3]
  std::vector<double> volumes_;           ///< of every cell, reference [m3]; others' cells: zero
  std::vector<double> compliance_;        ///< of its healthy share [m3/Pa]
  std::vector<std::array<int, 3>> wall_;  ///< oriented out of the wound; others' faces left out
};

}  // namespace sanatrix::recovery
