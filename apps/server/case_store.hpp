// The folder of cases as the planner sees it. Names come from addresses, so they are checked here,
// once; symbolic links are never followed.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "pipeline/case_view.hpp"

namespace sanatrix::server {

class CaseStore {
 public:
  /// Makes the folder when it is not there.
  explicit CaseStore(const std::filesystem::path& root);

  [[nodiscard]] const std::filesystem::path& root() const { return root_; }
  /// The server's own files: queue, secrets, uploads.
  [[nodiscard]] std::filesystem::path own_folder() const { return root_ / ".planner"; }
  /// Error{Input} when this is no proper name of a case.
  [[nodiscard]] std::filesystem::path folder(const std::string& id) const;
  /// Error{Input} when there is no such case.
  [[nodiscard]] pipeline::Case open(const std::string& id) const;
  [[nodiscard]] std::vector<std::string> ids() const;  ///< newest first
  /// A name that is free: "patient-1", "patient-1-b" ...
  [[nodiscard]] std::string free_id(const std::string& wanted) const;
  /// A copy with the results that do not depend on the plan; for another plan of one patient.
  void copy_for_plan(const std::string& from, const std::string& to) const;
  /// What the user calls this plan; empty: nothing. Kept beside the cases, not in them, since it
  /// may name somebody.
  [[nodiscard]] std::string plan_name(const std::string& id) const;
  void name_plan(const std::string& id, const std::string& name) const;
  /// Case -> a number that changes with its inputs, parameters or name.
  [[nodiscard]] nlohmann::json stamps() const;
  /// Deletes the case and everything in it.
  void remove(const std::string& id) const;

  /// Model and poses, kept in memory while nothing changes on disk.
  [[nodiscard]] std::shared_ptr<const pipeline::CaseView> view(const pipeline::Case& patient);
  /// A result listed in its stage's stage.json. Error{Input} for everything else.
  [[nodiscard]] std::filesystem::path result_file(const pipeline::Case& patient,
                                                  const std::string& stage_folder,
                                                  const std::string& file) const;

 private:
  struct Kept {
    std::string stamp;
    std::shared_ptr<const pipeline::CaseView> view;
    unsigned long used = 0;  ///< when, in questions
  };
  std::filesystem::path root_;
  mutable std::mutex names_mutex_;
  std::mutex mutex_;
  std::map<std::string, Kept> views_;
  unsigned long questions_ = 0;
};

/// Every file that finished stages list: [{stage, file, bytes}].
nlohmann::json result_files(const pipeline::Case& patient);

}  // namespace sanatrix::server
