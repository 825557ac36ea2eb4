// The model of a case or of a problem file, for other programs.
#pragma once

#include <filesystem>
#include <string>

#include "io/peer_model.hpp"
#include "pipeline/case.hpp"
#include "pipeline/problem_file.hpp"

namespace sanatrix::pipeline {

/// The patient's stress-free shape with her tissue, skin and supports under the gravity of a pose:
/// "prone", "supine" or "upright". Error{Input} when the case has not been unloaded yet.
io::PeerModel export_case(const Case& patient, const std::string& pose);
/// A problem of mode forward; for inverse, the given mesh with a note that it is the loaded shape.
io::PeerModel export_problem(const SolveProblem& problem, const std::string& title);
/// The PROBLEM.json with which `sanatrix solve` runs an exported mesh.
std::string problem_json(const io::PeerModel& model, const std::string& mesh_file);

}  // namespace sanatrix::pipeline
