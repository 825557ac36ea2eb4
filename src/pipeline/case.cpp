#include "pipeline/case.hpp"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "core/error.hpp"
#include "core/files.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
constexpr int format_version = 1;

json to_json(const Vec3& v) {
  return json::array({v[0], v[1], v[2]});
}

json to_json(const FocusRule& rule) {
  json j{{"side", rule.side == surgery::Side::Left ? "L" : "R"}, {"radius_m", rule.radius}};
  if (rule.centre) {
    j["centre_m"] = to_json(*rule.centre);
  }
  if (rule.axis) {
    j["axis"] = to_json(*rule.axis);
  }
  return j;
}

FocusRule focus_from(const json& j) {
  FocusRule rule{.centre = {}, .axis = {}, .side = {}, .radius = j.at("radius_m").get<double>()};
  rule.side = j.at("side") == "L" ? surgery::Side::Left : surgery::Side::Right;
  if (j.contains("centre_m")) {
    rule.centre = j["centre_m"].get<Vec3>();
  }
  if (j.contains("axis")) {
    rule.axis = j["axis"].get<Vec3>();
  }
  return rule;
}

Case case_from(const json& j, const fs::path& folder) {
  require(j.at("format") == "sanatrix-case", "this is not the case.json of Sanatrix");
  require(j.at("version") == format_version,
          "the case has format version {}, this program reads {}", j.at("version").dump(),
          format_version);
  Case patient;
  patient.folder = folder;
  patient.pseudonym = j.at("pseudonym");
  patient.label_preset = j.at("label_preset");
  for (const auto& [name, input] : j.at("inputs").items()) {
    patient.inputs[name] = {input.at("file"), input.at("sha256")};
  }
  for (const auto& [key, value] : j.at("parameters").items()) {
    patient.parameters.set(key, value.get<std::string>());
  }
  if (j.contains("focus")) {
    patient.focus = focus_from(j["focus"]);
  }
  return patient;
}

}  // namespace

fs::path Case::input(const std::string& name) const {
  return folder / inputs.at(name).file;
}

fs::path Case::stage_folder(Stage stage) const {
  return folder / "stages" / info(stage).folder;
}

surgery::Plan Case::plan() const {
  if (!has_plan()) {
    throw Error(Fault::Input, "this case has no surgical plan",
                "give one with `sanatrix run CASE --plan plan.json` (docs/user/plan.md)");
  }
  surgery::Plan plan = surgery::read_plan(read_text(input("plan")), "plan.json");
  // The radius last: changed tumour and margin would move it along.
  for (const std::string key : {"tumour_radius_mm", "margin_mm", "clearance_mm", "radius_mm"}) {
    if (parameters.has("surgery." + key)) {
      surgery::set_plan_value(plan, key, parameters.text("surgery." + key));
    }
  }
  return plan;
}

Case open_case(const fs::path& folder) {
  const fs::path file = folder / "case.json";
  if (!fs::exists(file)) {
    throw Error(Fault::Input,
                fmt::format("{} is not a case: it has no case.json", folder.filename().string()),
                "make one with `sanatrix new CASE --image PATH` or `--labels FILE`");
  }
  const std::string text = read_text(file);
  return during("case.json", [&] {
    try {
      return case_from(json::parse(text), folder);
    } catch (const json::exception& e) {
      throw Error(Fault::Input, fmt::format("it cannot be used: {}", e.what()));
    }
  });
}

void save_case(const Case& patient) {
  json j{{"format", "sanatrix-case"},      {"version", format_version},
         {"pseudonym", patient.pseudonym}, {"label_preset", patient.label_preset},
         {"inputs", json::object()},       {"parameters", patient.parameters.given()}};
  for (const auto& [name, input] : patient.inputs) {
    j["inputs"][name] = {{"file", input.file}, {"sha256", input.sha256}};
  }
  if (patient.focus) {
    j["focus"] = to_json(*patient.focus);
  }
  write_text(patient.folder / "case.json", j.dump(2) + "\n");
}

void follow_plan(Case& patient) {
  if (patient.has_plan()) {
    patient.focus = follow(patient.focus, patient.plan());
  }
}

void check_inputs(const Case& patient) {
  for (const auto& [name, input] : patient.inputs) {
    const fs::path file = patient.folder / input.file;
    require(fs::exists(file), "{}: this input of the case is missing", input.file);
    if (sha256_of_file(file) != input.sha256) {
      throw Error(Fault::Input, fmt::format("{}: it has changed since it was given", input.file),
                  "make a new case from the changed file");
    }
  }
}

std::string without_place(const Case& patient, std::string text) {
  const std::string place = (patient.folder / "").string();
  for (auto at = text.find(place); at != std::string::npos; at = text.find(place, at)) {
    text.erase(at, place.size());
  }
  return text;
}

CaseLock::CaseLock(const fs::path& folder) {
  const fs::path file = folder / ".lock";
  file_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) {
    throw Error(Fault::Resource,
                fmt::format("the case folder cannot be written: {}", std::strerror(errno)));
  }
  // A record lock: not inherited by child processes, gone when this process is gone.
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  if (::fcntl(file_, F_SETLK, &lock) != 0) {
    ::fcntl(file_, F_GETLK, &lock);
    ::close(file_);
    throw Error(Fault::Resource,
                fmt::format("the case is in use by process {}", static_cast<long>(lock.l_pid)),
                "wait for it to end, or stop it; what it finished is kept");
  }
}

CaseLock::~CaseLock() {
  ::close(file_);
}

}  // namespace sanatrix::pipeline
