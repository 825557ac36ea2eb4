// From a surface with holes to a body: the distance to the skin on a grid.
#pragma once

#include "geometry/image.hpp"
#include "geometry/tri_mesh.hpp"

namespace sanatrix::standing {

/// Fills the voxels with the distance [mm] to the skin, negative inside. Where the scan has a hole
/// or ends, the skin goes on from the rim as the tangents of the skin around, the nearest most; the
/// farther from the rim, the more skin has a say, so that noise and teeth of a rim do not. The same
/// mean tells inside from outside where the nearest skin cannot: in folds that pass through
/// themselves. docs/theory/scan-only.md, section 2
void measure_body(const TriMesh& skin, Image3<float>& distance_mm);

}  // namespace sanatrix::standing
