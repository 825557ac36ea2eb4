// Lines on the skin as paths of skin vertices, for display.
#pragma once

#include <span>
#include <vector>

#include "geometry/tri_mesh.hpp"

namespace sanatrix::surgery {

/// Polyline on the skin through `entry` along the relaxed skin tension lines, which run close to
/// horizontal over the breast; `half_length` to either side. [m]
std::vector<Vec3> default_incision(const Vec3& entry, const Vec3& axis_towards_skin,
                                   double half_length);

/// Shortest edge path that joins the skin vertices nearest to the points of a polyline, which is
/// sampled finely first. Vertices of the mesh, without repetitions.
std::vector<int> path_on_skin(const Surface& skin, std::span<const Vec3> polyline);

}  // namespace sanatrix::surgery
