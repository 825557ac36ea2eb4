// Whether a model that was made of a scan lies where the scan lies.
#pragma once

#include <span>

#include "geometry/tri_mesh.hpp"

namespace sanatrix::standing {

struct SkinDistance {
  double p95 = 0.0, largest = 0.0;  ///< [m]
  Vec3 worst{};                     ///< [m], where it is largest
};

/// Of points of a model's skin from the scan; both in LPS [m]. Points nearest to a rim are left
/// out: there the scan has a hole that was closed, or ends.
SkinDistance distance_from_scan(std::span<const Vec3> skin, const TriMesh& scan);

}  // namespace sanatrix::standing
