// Many variations of one case: which they are, how one is computed, and the table of all. The work
// is cut into tasks named by what their result depends on, so that any number of workers may die,
// repeat or meet: a task has one result file, complete or absent.
#pragma once

#include <filesystem>
#include <map>
#include <stop_token>
#include <string>
#include <vector>

#include "pipeline/case.hpp"
#include "pipeline/runner.hpp"
#include "pipeline/team.hpp"

namespace sanatrix::pipeline {

struct SweepTask {
  std::string key;                              ///< hash of all that the outcome depends on
  std::filesystem::path plan;                   ///< empty: the case's own
  std::map<std::string, std::string> settings;  ///< parameter -> value
};

struct Sweep {
  std::filesystem::path file;         ///< SWEEP.json
  std::filesystem::path case_folder;  ///< what is varied
  std::filesystem::path out;          ///< tasks/, results/, results.csv, results.json
  std::vector<std::string> varied;    ///< parameters in the order of the file
  std::vector<SweepTask> tasks;       ///< equal ones once
  [[nodiscard]] std::filesystem::path result_file(const SweepTask& task) const;
  [[nodiscard]] bool done(const SweepTask& task) const;
};

/// A task made in the program. The plan may be empty: the case's own. Error{Input, Usage} for
/// settings that the case cannot have.
SweepTask make_task(const Case& base, std::filesystem::path plan,
                    std::map<std::string, std::string> settings);

/// docs/user/sweep.md. Strict; relative paths are relative to the file. `out` empty: beside the
/// file, named after it.
Sweep read_sweep(const std::filesystem::path& file, const std::filesystem::path& out);

/// Computes one task unless its result is there; waits while another process works on it. What
/// cannot be computed (bad input, no convergence) is a result too; Error{Resource} and Cancelled
/// pass on and leave a task that can be resumed.
void run_task(const Sweep& sweep, const SweepTask& task, Monitor& monitor, Team& team,
              std::stop_token stop);

/// results.csv and results.json from the results there are. Returns the JSON text.
std::string collect(const Sweep& sweep);

}  // namespace sanatrix::pipeline
