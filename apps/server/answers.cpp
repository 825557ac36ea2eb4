#include "answers.hpp"

#include <filesystem>
#include <new>

#include "core/error.hpp"
#include "core/files.hpp"
#include "pipeline/stage_store.hpp"

namespace sanatrix::server {

using nlohmann::json;

Response json_answer(const json& j, int status) {
  return {.status = status, .body = j.dump(-1, ' ', false, json::error_handler_t::replace)};
}

Response bundle_answer(std::string bytes) {
  return {.type = "application/octet-stream", .body = std::move(bytes)};
}

namespace {

int status_of(Fault fault) {
  switch (fault) {
    case Fault::Usage:
    case Fault::Input:
      return 400;
    case Fault::Numerics:
      return 422;
    case Fault::Resource:
      return 503;
    case Fault::Internal:
      break;
  }
  return 500;
}

Response failure(int status, const std::string& what, const std::string& hint,
                 const std::vector<std::string>& trail = {}) {
  return json_answer({{"fault", status < 500 ? "input" : "server"},
                      {"what", what},
                      {"hint", hint},
                      {"trail", trail}},
                     status);
}

}  // namespace

Response error_answer() {
  try {
    throw;
  } catch (const Error& e) {
    return failure(status_of(e.fault()), e.what(), e.hint(), e.trail());
  } catch (const std::bad_alloc&) {
    return failure(503, "not enough memory", "close other programs or choose a coarser mesh");
  } catch (const std::filesystem::filesystem_error& e) {
    return failure(503, e.code().message(), "check free space and permissions");
  } catch (const std::exception&) {
    return failure(500, "something unexpected happened in the planner",
                   "reload the page; if it happens again, please report it");
  }
}

json body_of(const Request& request) {
  json body = json::parse(request.body.empty() ? "{}" : request.body, nullptr, false);
  require(body.is_object(), "the request is not a JSON object");
  return body;
}

json to_json(const Job& job) {
  return {{"id", job.id},
          {"case", job.case_id},
          {"kind", job.kind},
          {"state", name_of(job.state)},
          {"step", job.step},
          {"steps", job.steps.size()},
          {"created_s", job.created_s},
          {"started_s", job.started_s},
          {"ended_s", job.ended_s},
          {"exit_code", job.exit_code},
          {"message", job.message},
          {"progress",
           {{"stage", job.progress.stage},
            {"fraction", job.progress.fraction},
            {"text", job.progress.text},
            {"finished", job.progress.finished}}}};
}

json summary(const std::string& id, const pipeline::Case& patient) {
  json stages = json::array();
  bool outcome_fresh = false;
  for (const pipeline::StageInfo& stage : pipeline::all_stages()) {
    const pipeline::StageStatus s = pipeline::status(patient, stage.id);
    outcome_fresh = stage.name == "outcome" && s.state == pipeline::State::Fresh;
    stages.push_back({{"name", stage.name},
                      {"letter", stage.letter},
                      {"title", stage.title},
                      {"state", pipeline::name_of(s.state)},
                      {"reason", s.reason},
                      {"seconds", s.seconds},
                      {"warnings", s.warnings}});
  }
  json j{{"id", id},
         {"patient", patient.pseudonym},
         {"stages", stages},
         {"parameters", patient.parameters.given()},
         {"inputs", json::array()},
         {"plan", patient.has_plan() ? patient.inputs.at("plan").sha256 : ""},
         {"plan_name", ""},
         {"side", nullptr},
         {"outcome", nullptr}};
  j["photograph"] = false;
  for (const auto& [name, input] : patient.inputs) {
    j["inputs"].push_back(name);
    if (name.starts_with("scan.") && content_type(input.file).starts_with("image/")) {
      j["photograph"] = true;
    }
  }
  if (patient.has_plan()) {
    const json plan = json::parse(read_text(patient.input("plan")), nullptr, false);
    if (plan.is_object()) {
      j["side"] = plan.value("operated_side", "");
      j["plan_name"] = plan.contains("name") && plan["name"].is_string() ? plan["name"] : json("");
    }
  }
  const auto file = patient.stage_folder(pipeline::Stage::Outcome) / "outcome.json";
  if (std::filesystem::exists(file)) {
    j["outcome"] = json::parse(read_text(file), nullptr, false);
    j["outcome_fresh"] = outcome_fresh;
  }
  return j;
}

std::vector<std::string> assignments(const json& wish) {
  std::vector<std::string> list;
  pipeline::Parameters checked;
  for (const auto& [key, value] : wish.items()) {
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    checked.set(key, text);
    list.push_back(fmt::format("{}={}", key, text));
  }
  return list;
}

std::string content_type(const std::string& file) {
  const std::vector<std::pair<std::string, std::string>> table{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".json", "application/json"},
      {".png", "image/png"},
      {".svg", "image/svg+xml"},
      {".csv", "text/csv; charset=utf-8"},
      {".txt", "text/plain; charset=utf-8"},
      {".pdf", "application/pdf"},
      {".glb", "model/gltf-binary"},
      {".jpg", "image/jpeg"},
      {".jpeg", "image/jpeg"},
      {".woff2", "font/woff2"}};
  for (const auto& [extension, type] : table) {
    if (file.ends_with(extension)) {
      return type;
    }
  }
  return "application/octet-stream";
}

}  // namespace sanatrix::server
