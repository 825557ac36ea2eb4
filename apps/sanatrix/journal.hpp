// The case's own diary: run.log for people, run.jsonl for machines. No names, no user's paths.
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>

#include "pipeline/runner.hpp"

namespace spdlog {
class logger;
}

namespace sanatrix::app {

class Journal {
 public:
  /// Appends to the diary; the first lines say what runs on what.
  explicit Journal(const pipeline::Case& patient);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  void progress(const Event& event);
  void started(const pipeline::StageInfo& stage);
  void finished(const pipeline::StageInfo& stage, const pipeline::StageRecord& record);
  void ended(const std::string& line);

 private:
  std::shared_ptr<spdlog::logger> log_;  // spdlog hands out shared loggers only
  std::ofstream lines_;
};

}  // namespace sanatrix::app
