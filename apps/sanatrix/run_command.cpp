// sanatrix run CASE: brings a case up to date.
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "failure.hpp"
#include "mpi_team.hpp"
#include "pipeline/case_inputs.hpp"
#include "progress.hpp"
#include "tables.hpp"

namespace sanatrix::app {
namespace {

using nlohmann::json;

struct Arguments {
  std::string folder, from, to, plan;
  std::vector<std::string> assignments;
  ScanOptions scans;
};

/// Applies --plan, --set, --scan and --followup, all or nothing, and keeps them in case.json.
void change(pipeline::Case& patient, const Arguments& given) {
  if (!given.plan.empty()) {
    pipeline::drop_plan(patient);
  }
  for (const std::string& assignment : given.assignments) {
    patient.parameters.set(assignment);
  }
  pipeline::replace_scans(patient, given.scans.given());
  if (!given.plan.empty()) {
    pipeline::replace_plan(patient, given.plan);
  }
  patient.parameters.check();
  pipeline::follow_plan(patient);
  pipeline::save_case(patient);
}

void print_result(const pipeline::Case& patient, const Common& common) {
  const auto file = patient.stage_folder(pipeline::Stage::Outcome) / "outcome.json";
  const bool done =
      pipeline::status(patient, pipeline::Stage::Outcome).state == pipeline::State::Fresh;
  const json outcome = done ? json::parse(read_text(file)) : json();
  if (common.json) {
    fmt::print(
        "{}\n",
        json{{"case", patient.pseudonym}, {"stages", stages_json(patient)}, {"outcome", outcome}}
            .dump(2));
  } else if (done) {
    fmt::print("{}", outcome_text(outcome));
    fmt::print("results: {}\n", file.parent_path().string());
  }
}

pipeline::RunOptions run_options(const Arguments& given) {
  pipeline::RunOptions options;
  if (!given.from.empty()) {
    options.from = pipeline::parse_stage(given.from);
  }
  if (!given.to.empty()) {
    options.to = pipeline::parse_stage(given.to);
  }
  if (options.from && options.to && *options.from > *options.to) {
    throw Error(Fault::Usage, fmt::format("--from {} comes after --to {}", given.from, given.to),
                "the order is: " + stage_names());
  }
  return options;
}

void work(const Arguments& given, const Common& common, pipeline::Team& team) {
  const pipeline::RunOptions options = run_options(given);
  pipeline::Case patient = pipeline::open_case(given.folder);
  std::optional<pipeline::CaseLock> lock;
  std::optional<Journal> journal;
  if (team.leads()) {
    lock.emplace(given.folder);
    patient = pipeline::open_case(given.folder);  // nobody changes it from here on
    change(patient, given);
    journal.emplace(patient);
  }
  team.share(0);
  if (!team.leads()) {
    patient = pipeline::open_case(given.folder);
  }
  Progress progress(common, team.leads(), journal ? &*journal : nullptr);
  try {
    pipeline::run_case(patient, options, progress, team, progress.stop_token());
  } catch (...) {  // noted in the diary, told by main
    if (journal) {
      journal->ended(pipeline::without_place(patient, describe(std::current_exception()).line));
    }
    throw;
  }
  if (team.leads()) {
    journal->ended("done");
    print_result(patient, common);
  }
}

}  // namespace

void add_run(CLI::App& app, Common& common, Command& chosen) {
  auto given = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "run",
      "Examples: sanatrix run out/case\n"
      "          sanatrix run out/case --plan other.json --set surgery.margin_mm=15\n"
      "          sanatrix run out/case --set mesh.preset=paper --to supine\n\n"
      "Runs the stages that are out of date, in order. Ctrl-C stops it; the same command goes on.");
  command->add_option("CASE", given->folder, "case folder")->required();
  command->add_option("--from", given->from, "run again from this stage on");
  command->add_option("--to", given->to, "stop after this stage");
  command->add_option("--set", given->assignments, "key=value, kept in the case; may be repeated")
      ->allow_extra_args(true);
  command->add_option("--plan", given->plan, "replaces the surgical plan");
  given->scans.add_to(*command);
  command->footer([] {
    return "Stages: " + stage_names() + "\n\nParameters for --set (sanatrix params shows all):\n" +
           parameters_text();
  });
  add_team_work(*command, common, chosen,
                [given, &common](pipeline::Team& team) { work(*given, common, team); });
}

}  // namespace sanatrix::app
