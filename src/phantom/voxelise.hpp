// The deformed body as a label volume: every voxel asks its unloaded place what is there.
#pragma once

#include <span>

#include "core/context.hpp"
#include "phantom/quadratic_cells.hpp"

namespace sanatrix::phantom {

/// `unloaded` and `nodes` are the P2 nodes of the unloaded and of the deformed body. The volume
/// ends at the body's clip planes as a scan does. Skin is 2 mm thick.
LabelImage voxelise(const BodyMesh& body, const Anatomy& anatomy, const TissueMap& tissue,
                    const QuadraticCells& cells, std::span<const Vec3> unloaded,
                    std::span<const Vec3> nodes, double voxel_mm, const Context& ctx);

}  // namespace sanatrix::phantom
