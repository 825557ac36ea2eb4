// A scan of the trunk as seen from the front: one height per column of a regular grid.
#pragma once

#include <vector>

#include "geometry/tri_mesh.hpp"
#include "meshing/anatomy.hpp"

namespace sanatrix::standing {

struct FrontMap {
  meshing::ColumnMap skin_y;  ///< y [mm] of the most anterior skin; smooth where it was not seen
  std::vector<bool> seen;     ///< per column: the scan has skin there

  /// Columns that were not seen and are not open to the border of the map: holes in the front.
  [[nodiscard]] std::vector<bool> holes() const;
};

/// Columns x and z [mm], within low and high.
struct FrontWindow {
  std::array<double, 2> low_mm{}, high_mm{};
};
FrontWindow window_of(const TriMesh& surface, double margin_mm);

/// `surface` in LPS metres.
FrontMap front_map(const TriMesh& surface, const FrontWindow& window, double spacing_mm);

/// Distance [mm], seen from the front, of every column to the nearest one with `from`; in steps of
/// the spacing.
std::vector<double> frontal_distance(const meshing::ColumnMap& grid, const std::vector<bool>& from);

}  // namespace sanatrix::standing
