// The stages as functions: inputs and parameters in, files out. One .cpp each; the runner knows
// nothing else about them.
#pragma once

#include "meshing/breast_mesh.hpp"
#include "pipeline/runner.hpp"

namespace sanatrix::pipeline {

/// Fingerprint of all that the upright pose before surgery depends on; the plan does not belong to
/// it.
std::string upright_before_key(const Case& patient);

/// What the parameters ask of the mesher; the focus is not among it.
meshing::MeshOptions mesh_options(const Parameters& parameters);

StageNotes run_image(const StageInput& in);
StageNotes run_segment(const StageInput& in);
StageNotes run_mesh(const StageInput& in);
StageNotes run_unload(const StageInput& in);
StageNotes run_supine(const StageInput& in);
StageNotes run_surgery(const StageInput& in);
StageNotes run_heal(const StageInput& in);
StageNotes run_upright(const StageInput& in);
StageNotes run_outcome(const StageInput& in);

}  // namespace sanatrix::pipeline
