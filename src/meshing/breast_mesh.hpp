// Steps C and D: labels -> a tetrahedral two-breast model with tissue per cell and named
// boundaries.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/context.hpp"
#include "geometry/image.hpp"
#include "geometry/tet_mesh.hpp"

namespace sanatrix::meshing {

/// Where the mesh must be fine: everything within `radius` of the segment a-b. [m], LPS
struct Focus {
  Vec3 a, b;
  double radius;
};

struct MeshOptions {
  int target_vertices = 10000;  ///< the achieved number is within 15 % of it where the shape allows
  double near_edge_m = 0.003;   ///< edge length in the focus, upper bound
  double far_edge_m = 0.008;    ///< edge length far from the focus; scaled to meet target_vertices
  std::optional<Focus> focus;
  double time_limit_s = 120.0;      ///< Error{Resource} beyond it
  double slab_half_height_m = 0.0;  ///< 0: chosen from the extent of the breasts
  bool standing = false;            ///< labels of a standing patient, whose breasts lie flatter
};

/// The geometrical and tissue model of the prone patient.
struct BreastModel {
  TetMesh mesh;  ///< one region "breast"; boundaries skin, chest, superior, inferior, lateral,
                 ///< posterior
  std::vector<double> fibroglandular;  ///< volume fraction per cell, 0..1
  std::vector<signed char> side;       ///< per cell: -1 patient's right, +1 patient's left
  std::vector<bool> in_breast;  ///< per cell: inside the breast proper (not flank, not sternum)
  double midline_x_m = 0.0;
  std::array<int, 2> nipple_vertex{};  ///< [0] right, [1] left: skin vertex nearest to the landmark
  std::vector<std::string> warnings;
};

BreastModel mesh_breasts(const LabelImage& labels, const Image3<float>& fibroglandular,
                         double midline_x_mm, const std::array<Vec3, 2>& nipple_mm,
                         const MeshOptions& options, const Context& ctx);

/// What a reviewer asks about a mesh.
struct MeshQuality {
  double min_dihedral_deg, p01_dihedral_deg;
  double min_edge_m, mean_edge_m, max_edge_m;
  double mean_edge_in_focus_m;  ///< 0 without focus
  double
      skin_roughness_deg;  ///< 95th percentile of the angle between normals of adjacent skin faces
};
MeshQuality measure_quality(const BreastModel& model, const std::optional<Focus>& focus);

}  // namespace sanatrix::meshing
