// The closed surface of the part to mesh, with the name of the boundary on every triangle.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "geometry/vec3.hpp"
#include "meshing/anatomy.hpp"
#include "meshing/deadline.hpp"

namespace sanatrix::meshing {

/// Boundaries of the model; the numbers index boundary_names().
enum class Patch { Skin, Chest, Superior, Inferior, Lateral, Posterior };
const std::vector<std::string>& boundary_names();

/// A flat side of the clip box: coordinate `axis` equals `at_mm`.
struct ClipPlane {
  Patch patch;
  std::size_t axis;
  double at_mm;
  int outwards;  ///< +1 or -1 along the axis
};
std::vector<ClipPlane> clip_planes(const ClipBox& box);

struct DomainSurface {
  std::vector<Vec3> points_mm;
  std::vector<std::array<int, 3>> triangles;  ///< outwards
  std::vector<Patch> patch;                   ///< per triangle
  ClipBox box;                                ///< the planes it was clipped by
};

/// Surface of soft tissue in front of the chest inside the box: closed, one piece. The planes are
/// moved a little where they would leave strips too narrow to mesh.
/// Throws Error{Input} when the breasts are not connected, Error{Resource} at the deadline.
DomainSurface extract_domain(const Anatomy& anatomy, const std::array<Vec3, 2>& nipple_mm,
                             const Deadline& deadline);

}  // namespace sanatrix::meshing
