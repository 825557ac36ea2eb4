// Solves the problem of a PROBLEM.json and writes result.json, result.vtu and history.csv.
#pragma once

#include <filesystem>
#include <string>

#include "core/context.hpp"
#include "pipeline/problem_file.hpp"
#include "pipeline/team.hpp"

namespace sanatrix::pipeline {

/// Collective over the team. Returns the text of result.json. When the model does not converge,
/// result.json says "converged": false and Error{Numerics} passes on.
std::string solve_problem(SolveProblem& problem, const std::filesystem::path& out, Team& team,
                          const Context& ctx);

}  // namespace sanatrix::pipeline
