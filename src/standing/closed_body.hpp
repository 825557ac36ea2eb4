// From a surface with holes to a body: the distance to the skin on a grid.
#pragma once

#include "geometry/image.hpp"
#include "geometry/tri_mesh.hpp"

namespace sanatrix::standing {

/// Fills the voxels with the distance [mm] to the skin, negative inside. The sign is that of the
/// nearest skin's normal (Baerentzen and Aanaes, doi:10.1109/TVCG.2005.49): where the scan has a
/// hole or ends, the skin goes on from the rim, bent inwards as a breast is, and two rims meet in
/// an edge, as in the fold below a breast that no camera saw.
void measure_body(const TriMesh& skin, Image3<float>& distance_mm);

}  // namespace sanatrix::standing
