// What the doubt about the chest wall does to the outcome: the case with its wall nearer to the
// skin, and deeper. docs/theory/outcome.md, section 5
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "pipeline/runner.hpp"

namespace sanatrix::pipeline {

/// Runs the case twice more, from its segmentation on, when outcome.wall_range asks for it. Results
/// that are there already are not made again; what fails is a result too. Collective over the team.
void run_wall_variants(const Case& patient, Monitor& monitor, Team& team,
                       const std::stop_token& stop);

/// Adds the ranges to outcome.json: "wall_range" for its own numbers and one per cosmetic index;
/// null where they were not asked for.
void add_wall_range(const Case& patient, nlohmann::json& outcome);

}  // namespace sanatrix::pipeline
