#include "pipeline/runner.hpp"

#include <algorithm>
#include <array>
#include <chrono>

#include "core/error.hpp"
#include "pipeline/stages.hpp"
#include "pipeline/wall_range.hpp"

namespace sanatrix::pipeline {
namespace {

using StageFunction = StageNotes (*)(const StageInput&);
constexpr std::array<StageFunction, 9> functions{run_image,  run_segment, run_mesh,
                                                 run_unload, run_supine,  run_surgery,
                                                 run_heal,   run_upright, run_outcome};

/// Stages to look at, in order. Without a plan the upright pose before surgery comes first, so
/// that everything that can be computed is there when surgery asks for the plan.
std::vector<Stage> route(const Case& patient, const RunOptions& options) {
  std::vector<Stage> stages;
  for (const StageInfo& stage : all_stages()) {
    if (stage.id == Stage::Surgery && !patient.has_plan()) {
      stages.push_back(Stage::Upright);
    }
    if (stage.id != Stage::Upright || patient.has_plan()) {
      stages.push_back(stage.id);
    }
  }
  if (options.to) {
    if (const auto last = std::ranges::find(stages, *options.to); last != stages.end()) {
      stages.erase(last + 1, stages.end());
    }
  }
  return stages;
}

StageNotes work(const Case& patient, const StageInfo& stage, bool anew, Monitor& monitor,
                Team& team, const std::stop_token& stop) {
  if (!stage.collective && !team.leads()) {
    return {};
  }
  const StageInput input{patient, aside_folder(patient, stage.id), team.leads(), anew,
                         Context(stage.name, monitor, stop)};
  input.ctx.at(0.0);
  return functions[static_cast<std::size_t>(stage.id)](input);
}

void run_stage(const Case& patient, const StageInfo& stage, bool anew, Monitor& monitor, Team& team,
               const std::stop_token& stop) {
  const auto start = std::chrono::steady_clock::now();
  if (team.leads()) {
    monitor.started(stage);
    begin(patient, stage.id);
  }
  team.share(0);
  StageNotes notes = work(patient, stage, anew, monitor, team, stop);
  if (team.leads()) {
    StageRecord record{
        .recipe = recipe(patient, stage.id),
        .seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
        .warnings = std::move(notes.warnings),
        .numbers = std::move(notes.numbers),
        .files = {}};
    commit(patient, stage.id, record);
    monitor.finished(stage, record);
  }
  team.share(0);
}

}  // namespace

void run_case(const Case& patient, const RunOptions& options, Monitor& monitor, Team& team,
              std::stop_token stop) {
  if (team.leads()) {
    check_inputs(patient);
    clean_up(patient);
  }
  for (const Stage stage : route(patient, options)) {
    const bool forced = options.from && stage >= *options.from;
    const bool wanted = forced || status(patient, stage).state != State::Fresh;
    if (team.share(wanted ? 1 : 0) == 0) {
      if (team.leads()) {
        monitor.fresh(info(stage));
      }
      continue;
    }
    try {
      if (stage == Stage::Outcome) {
        run_wall_variants(patient, monitor, team, stop);
      }
      during(info(stage).name,
             [&] { run_stage(patient, info(stage), forced, monitor, team, stop); });
    } catch (const Error& e) {
      if (team.leads()) {
        record_failure(patient, stage, e.one_line());
        clean_up(patient);
      }
      throw;
    }
  }
}

}  // namespace sanatrix::pipeline
