// What the surgeon gets to see in numbers: volumes, displacements, surface distances.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "geometry/distance.hpp"
#include "geometry/tet_mesh.hpp"

namespace sanatrix::outcome {

/// Distances from one surface to another; the columns of the paper's Table 1. [m]
struct SurfaceDistance {
  double mean, deviation, p50, p90, p95, max;
  std::size_t samples;
};
/// Of weighted values; values without weight are left out. Error{Input} when none is left.
SurfaceDistance statistics(std::span<const double> values, std::span<const double> weights);
/// From the vertices of `from` (area-weighted) to the closest points of `to`.
SurfaceDistance surface_distance(const TriMesh& from, const TriMesh& to);

struct TissueVolumes {  ///< of one side, in cm3
  double breast_cm3, adipose_cm3, fibroglandular_cm3;
  double model_cm3;  ///< all of the side's half of the model, flank and sternum included
};
/// [0] right, [1] left.
std::array<TissueVolumes, 2> tissue_volumes(const TetMesh& mesh, std::span<const Vec3> points,
                                            std::span<const double> fibroglandular,
                                            std::span<const signed char> side,
                                            const std::vector<bool>& in_breast);
/// Displacement of skin vertices between two poses. [mm]
struct SkinDisplacement {
  double max_mm, mean_mm;  ///< area-weighted mean over the chosen skin
  int max_vertex;
};
SkinDisplacement skin_displacement(const TetMesh& mesh, std::span<const Vec3> before,
                                   std::span<const Vec3> after,
                                   const std::vector<bool>& vertex_used);

}  // namespace sanatrix::outcome
