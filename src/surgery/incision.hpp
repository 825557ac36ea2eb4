// Lines on the skin as paths of skin vertices, for display.
#pragma once

#include <span>
#include <vector>

#include "surgery/anatomy.hpp"

namespace sanatrix::surgery {

/// Polyline on the skin through `entry` along the relaxed skin tension lines, which run close to
/// horizontal over the breast; `half_length` to either side. [m]
std::vector<Vec3> default_incision(const Vec3& entry, const Vec3& axis_towards_skin,
                                   double half_length);

/// Arc of 150 degrees around the nipple, on the side of the tumour, at `radius` (the areola's
/// edge).
std::vector<Vec3> circumareolar_incision(const Vec3& nipple, const Vec3& entry, double radius);
/// From the areola's edge straight away from the nipple, over the entry point and half as far on.
std::vector<Vec3> radial_incision(const Vec3& nipple, const Vec3& entry, double areola_radius);
/// Along the lower border of the breast: the lowest of the given skin points of the breast in steps
/// of x, over `width` centred below the entry point. Empty when there are none.
std::vector<Vec3> inframammary_incision(std::span<const Vec3> breast_skin, const Vec3& entry,
                                        double width);

/// Shortest edge path that joins the skin vertices nearest to the points of a polyline, which is
/// sampled finely first. Vertices of the mesh, without repetitions.
std::vector<int> path_on_skin(const Anatomy& anatomy, std::span<const Vec3> polyline);

}  // namespace sanatrix::surgery
