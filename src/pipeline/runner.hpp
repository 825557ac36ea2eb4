// Runs the stages of a case that are out of date, in order.
#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/context.hpp"
#include "pipeline/stage_store.hpp"
#include "pipeline/team.hpp"

namespace sanatrix::pipeline {

/// What one stage is given. It reads artefacts of its upstream stages and writes into `out`.
struct StageInput {
  const Case& patient;
  std::filesystem::path out;
  bool writes;  ///< on rank 0 only, which also reads what belongs to the whole mesh
  bool anew;    ///< the user asked for it: nothing of an older result may be used
  Context ctx;

  [[nodiscard]] const Parameters& parameters() const { return patient.parameters; }
  [[nodiscard]] std::filesystem::path from(Stage stage) const {
    return patient.stage_folder(stage);
  }
};
struct StageNotes {
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, double>> numbers;
};

/// Hears of progress inside stages (Listener) and of the stages themselves.
class Monitor : public Listener {
 public:
  virtual void started(const StageInfo& stage) = 0;
  virtual void finished(const StageInfo& stage, const StageRecord& record) = 0;
  virtual void fresh(const StageInfo& stage) = 0;
};

struct RunOptions {
  std::optional<Stage> from;  ///< run again from here on, fresh or not
  std::optional<Stage> to;    ///< stop after it
};

/// The caller holds the CaseLock on rank 0. Collective over the team. An Error is recorded with
/// its stage and passes on; so does Cancelled, leaving a case that can be resumed.
void run_case(const Case& patient, const RunOptions& options, Monitor& monitor, Team& team,
              std::stop_token stop);

}  // namespace sanatrix::pipeline
