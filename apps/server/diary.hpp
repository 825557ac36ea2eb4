// Follows the diary (run.jsonl) that a run writes in its case, and the messages of other commands.
#pragma once

#include <filesystem>
#include <string>

#include "job_queue.hpp"

namespace sanatrix::server {

/// Reads what was added to run.jsonl since the last look; a run begins with a "begin" event.
class Diary {
 public:
  explicit Diary(std::filesystem::path file) : file_(std::move(file)) {}
  /// Only what comes from now on counts.
  void skip_old();
  /// True when something changed.
  bool update(JobProgress& progress);

 private:
  std::filesystem::path file_;
  std::uintmax_t read_ = 0;
  std::string rest_;  // of a line that is not complete yet
};

/// "phantom  42 %, ETA 0:31, load 80 %" into stage, fraction and text; true when it is such a line.
bool parse_progress_line(const std::string& line, JobProgress& progress);

}  // namespace sanatrix::server
