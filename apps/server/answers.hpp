// Words and JSON that several answers share.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "http.hpp"
#include "job_queue.hpp"
#include "pipeline/case.hpp"

namespace sanatrix::server {

Response json_answer(const nlohmann::json& j, int status = 200);
Response bundle_answer(std::string bytes);
/// {fault, what, hint, trail} with the status that fits; for the exception in flight.
Response error_answer();
/// The body as a JSON object; Error{Input} when it is not.
nlohmann::json body_of(const Request& request);
nlohmann::json to_json(const Job& job);
/// Name, patient, stages with state, plan's name and side, and the outcome when it is fresh.
nlohmann::json summary(const std::string& id, const pipeline::Case& patient);
/// Values of --set from {"heal.preset": "..."}; each is checked.
std::vector<std::string> assignments(const nlohmann::json& wish);
/// Type for the browser by extension.
std::string content_type(const std::string& file);

}  // namespace sanatrix::server
