// The plane in which a trunk is its own mirror image. docs/theory/scan-only.md, section 1
#pragma once

#include <vector>

#include "geometry/tri_mesh.hpp"

namespace sanatrix::standing {

/// Points p with dot(normal, p) = offset_m.
struct MirrorPlane {
  Vec3 normal{1, 0, 0};
  double offset_m = 0.0;
  double share = 0.0;  ///< of the skin looked at that lies on its mirror image, within 5 mm
};

/// Lays the mirrored surface onto itself (closest points along the normals), starting from `plane`.
/// `counts`: per vertex, whether it is looked at; few or none leave the plane as it is.
MirrorPlane fit_mirror(const TriMesh& surface, const std::vector<bool>& counts, MirrorPlane plane);

}  // namespace sanatrix::standing
