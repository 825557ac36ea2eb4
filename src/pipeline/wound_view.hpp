// Where the wound is, for pictures that are to show it.
#pragma once

#include "pipeline/result.hpp"

namespace sanatrix::pipeline {

/// Centre of gravity of the removed tissue in a pose.
Vec3 wound_centre(const CaseResult& result, std::span<const Vec3> pose);
/// The same vertices with the cells that reach into the cube of this half edge around the wound [m]
/// in the supine pose, or a little beyond it.
TetMesh cells_near_wound(const CaseResult& result, double half_edge_m);

/// What the plan says, carried by the tissue from the pose in which it was drawn to the supine one.
struct PlanShapes {
  TriMesh tumour;    ///< sphere of the tumour's radius
  TriMesh planned;   ///< side of the planned cylinder, or behind the drawn outline
  TriMesh resected;  ///< boundary of the cells that count as wound (half of them or more)
};
PlanShapes plan_shapes(const CaseResult& result);

}  // namespace sanatrix::pipeline
