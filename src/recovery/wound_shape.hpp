// Volume and wall of the wound in a deformed body.
#pragma once

#include <span>
#include <vector>

#include "geometry/tet_mesh.hpp"

namespace sanatrix::recovery {

/// Measures the wound of one mesh in many shapes.
class WoundShape {
 public:
  /// wound_fraction per cell, 0..1; the wall separates cells at or above one half from the others.
  WoundShape(const TetMesh& mesh, std::span<const double> wound_fraction,
             std::span<const Vec3> reference_points);
  /// Volume of the wounded share [m3]. Healthy tissue is incompressible and the elements conserve
  /// volume around vertices, not cell by cell: in all cells that touch the wound, the healthy share
  /// keeps its reference volume and the wound takes the whole change.
  [[nodiscard]] double volume(std::span<const Vec3> points) const;
  /// Area-weighted mean displacement of the wall towards the inside [m].
  [[nodiscard]] double mean_inward_displacement(std::span<const Vec3> before,
                                                std::span<const Vec3> after) const;

 private:
  const TetMesh* mesh_;
  std::vector<std::size_t> touching_;     ///< cells with a vertex of the wound
  std::vector<double> healthy_share_;     ///< of each of them, reference volume [m3]
  std::vector<std::array<int, 3>> wall_;  ///< oriented out of the wound
};

}  // namespace sanatrix::recovery
