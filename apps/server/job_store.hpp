// The queue's table: every change is on disk before anybody hears of it.
#pragma once

#include <filesystem>
#include <vector>

#include "child.hpp"
#include "job_queue.hpp"

struct sqlite3;

namespace sanatrix::server {

/// A job with the process that works on it, if one does.
struct StoredJob {
  Job job;
  ProcessId process = {};
};

class JobStore {
 public:
  explicit JobStore(const std::filesystem::path& file);
  ~JobStore();
  JobStore(const JobStore&) = delete;
  JobStore& operator=(const JobStore&) = delete;

  void save(const StoredJob& stored);
  [[nodiscard]] std::vector<StoredJob> load() const;  ///< oldest first
  void forget(const std::string& id);

 private:
  sqlite3* db_ = nullptr;
};

}  // namespace sanatrix::server
