#include "journal.hpp"

#include <chrono>

#include <fmt/chrono.h>
#include <nlohmann/json.hpp>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/spdlog.h>

#include "version.hpp"

namespace sanatrix::app {
namespace {

using nlohmann::json;

std::string now() {
  const auto t = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(t));
}

}  // namespace

Journal::Journal(const pipeline::Case& patient)
    : log_(std::make_shared<spdlog::logger>("run",
                                            std::make_shared<spdlog::sinks::basic_file_sink_mt>(
                                                (patient.folder / "run.log").string()))),
      lines_(patient.folder / "run.jsonl", std::ios::app) {
  log_->set_pattern("%Y-%m-%d %H:%M:%S %v");
  log_->flush_on(spdlog::level::info);
  const Version& v = version();
  json inputs = json::object();
  log_->info("sanatrix {} commit {} ({}, {})", v.number, v.commit, v.compiler, v.build);
  log_->info("libraries: {}", v.libraries);
  log_->info("case {}, seed 1", patient.pseudonym);
  for (const auto& [name, input] : patient.inputs) {
    log_->info("input {} sha256 {}", name, input.sha256);
    inputs[name] = input.sha256;
  }
  for (const auto& [key, value] : patient.parameters.given()) {
    log_->info("parameter {} = {}", key, value);
  }
  lines_ << json{{"time", now()},
                 {"event", "begin"},
                 {"version", v.number},
                 {"commit", v.commit},
                 {"compiler", v.compiler},
                 {"build", v.build},
                 {"libraries", v.libraries},
                 {"case", patient.pseudonym},
                 {"seed", 1},
                 {"inputs", inputs},
                 {"parameters", patient.parameters.given()}}
                .dump()
         << std::endl;
}

Journal::~Journal() = default;

void Journal::progress(const Event& event) {
  lines_ << json{{"time", now()},
                 {"event", event.detail ? "detail" : "progress"},
                 {"stage", event.stage},
                 {"fraction", event.fraction},
                 {"text", event.text}}
                .dump()
         << '\n';
  if (event.detail) {
    log_->info("  {}", event.text);
  }
}

void Journal::started(const pipeline::StageInfo& stage) {
  log_->info("[{}] {}", stage.letter, stage.title);
  lines_ << json{{"time", now()}, {"event", "started"}, {"stage", stage.name}}.dump() << std::endl;
}

void Journal::finished(const pipeline::StageInfo& stage, const pipeline::StageRecord& record) {
  json numbers = json::object();
  std::string text;
  for (const auto& [name, value] : record.numbers) {
    numbers[name] = value;
    text += fmt::format(" {}={:.6g}", name, value);
  }
  log_->info("[{}] {}: done in {:.2f} s{}", stage.letter, stage.name, record.seconds, text);
  for (const std::string& warning : record.warnings) {
    log_->info("[{}] {}: warning: {}", stage.letter, stage.name, warning);
  }
  lines_ << json{{"time", now()},       {"event", "finished"},
                 {"stage", stage.name}, {"seconds", record.seconds},
                 {"numbers", numbers},  {"warnings", record.warnings}}
                .dump()
         << std::endl;
}

void Journal::ended(const std::string& line) {
  log_->info(line);
  lines_ << json{{"time", now()}, {"event", "end"}, {"text", line}}.dump() << std::endl;
}

}  // namespace sanatrix::app
