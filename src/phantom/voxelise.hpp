// The deformed body as a label volume: every voxel asks its unloaded place what is there.
#pragma once

#include <span>

#include "core/context.hpp"
#include "phantom/body_mesh.hpp"

namespace sanatrix::phantom {

/// `nodes` are the P2 nodes of the deformed body, vertices first, then one per edge of `edges`.
/// The volume ends at the body's clip planes as a scan does. Skin is 2 mm thick.
LabelImage voxelise(const BodyMesh& body, const Anatomy& anatomy, const TissueMap& tissue,
                    std::span<const Vec3> nodes, std::span<const std::array<int, 2>> edges,
                    double voxel_mm, const Context& ctx);

}  // namespace sanatrix::phantom
