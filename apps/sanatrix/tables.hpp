// What commands print: stages, parameters and the outcome, as text or JSON.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "pipeline/case.hpp"

namespace sanatrix::app {

std::string stage_names();
/// Name, state, reason, seconds and warnings of every stage.
nlohmann::json stages_json(const pipeline::Case& patient);
std::string parameters_text();
nlohmann::json parameters_json();
/// The key numbers of an outcome.json.
std::string outcome_text(const nlohmann::json& outcome);

}  // namespace sanatrix::app
