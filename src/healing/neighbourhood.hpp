// Which vertices a wound can change: far from it species stay as they were.
#pragma once

#include <span>
#include <vector>

#include "fem/mesh_share.hpp"
#include "geometry/vec3.hpp"
#include "healing/model.hpp"
#include "healing/wound_map.hpp"

namespace sanatrix::healing {

/// How far [m] a wound reaches into healthy tissue: there every species that diffuses in the whole
/// mesh falls back to its healthy value within sqrt(D/k), k the slowest rate at which healthy
/// tissue restores it. Infinite where the model says of no such rate, or healthy tissue changes
/// without a wound.
double reach(const Model& model);

/// Vertices within that reach of the wound, its scattered cells of small fraction included.
/// Collective where the mesh is shared.
std::vector<bool> neighbourhood(const Model& model, std::span<const Vec3> points,
                                const WoundMap& wound, const fem::MeshShare* share);

}  // namespace sanatrix::healing
