// Long work as child processes of this program, remembered in SQLite: a crash of the work is a
// message, a crash of the server loses nothing.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sanatrix::server {

/// Commands of `sanatrix` that make up one job, run one after the other; each can be run again.
struct Step {
  std::vector<std::string> words;               ///< without the program
  std::optional<std::string> clear_first = {};  ///< a folder of ours that must not exist before
};

enum class JobState { Queued, Running, Done, Failed, Cancelled };
std::string name_of(JobState state);  ///< "running"

struct JobProgress {
  std::string stage, text;
  double fraction = 0.0;
  std::vector<std::string> finished;  ///< stages finished by this job
};

struct Job {
  std::string id, case_id, kind;  ///< kind: "create", "run"
  std::vector<Step> steps;
  std::size_t step = 0;  ///< the one that runs, or is next
  JobState state = JobState::Queued;
  long created_s = 0, started_s = 0, ended_s = 0;  ///< Unix time
  int exit_code = 0;
  std::string message;  ///< why it failed: one line for people
  JobProgress progress;
};

class JobQueue {
 public:
  /// Opens or makes the queue; what was running when the last server died is taken up again.
  /// `cases` holds the case folders, in which runs leave their diary (run.jsonl).
  JobQueue(const std::filesystem::path& folder, std::filesystem::path cases);
  /// Asks the running work to stop at its next safe point; it goes on with the next server.
  ~JobQueue();
  JobQueue(const JobQueue&) = delete;
  JobQueue& operator=(const JobQueue&) = delete;

  std::string add(const std::string& case_id, const std::string& kind, std::vector<Step> steps);
  void cancel(const std::string& id);
  /// A failed or cancelled job goes on where it stopped.
  void resume(const std::string& id);
  [[nodiscard]] std::vector<Job> jobs() const;  ///< newest first
  [[nodiscard]] std::optional<Job> find(const std::string& id) const;
  /// Is something waiting or running for this case?
  [[nodiscard]] bool busy(const std::string& case_id) const;
  /// Changes with every change of any job.
  [[nodiscard]] long revision() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sanatrix::server
