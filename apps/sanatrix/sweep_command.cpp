// sanatrix sweep SWEEP.json: many variations of one case, here or on a cluster.
#include <algorithm>
#include <cerrno>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "child_process.hpp"
#include "commands.hpp"
#include "core/error.hpp"
#include "mpi_team.hpp"
#include "progress.hpp"
#include "sweep_engines.hpp"

namespace sanatrix::app {
namespace {

struct Arguments {
  std::string file, out, engine = "local", task;
  SweepOptions options;
};

/// The worker: one task in this process.
int work(const Arguments& given, const Common& common) {
  return with_team([&](pipeline::Team& team) {
    const pipeline::Sweep sweep = pipeline::read_sweep(given.file, given.out);
    const auto task = std::ranges::find(sweep.tasks, given.task, &pipeline::SweepTask::key);
    require(task != sweep.tasks.end(),
            "the sweep has no task {}: the case, a plan or {} has changed since it began",
            given.task, sweep.file.filename().string());
    Progress progress(common, team.leads());
    pipeline::run_task(sweep, *task, progress, team, progress.stop_token());
  });
}

/// What all tasks share is computed once, in the case itself.
void prepare(const pipeline::Sweep& sweep, const Common& common) {
  const pipeline::Case base = pipeline::open_case(sweep.case_folder);
  if (pipeline::status(base, pipeline::Stage::Supine).state == pipeline::State::Fresh) {
    return;
  }
  std::vector<std::string> command{own_program(), "run", sweep.case_folder.string(), "--to",
                                   "supine"};
  if (common.quiet) {
    command.emplace_back("-q");
  }
  const pid_t child = start_process(command);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) == exit_interrupted) {
    throw Cancelled{};
  }
  require(WEXITSTATUS(status) == 0, "the case could not be brought as far as its supine pose");
}

int drive(const Arguments& given, const Common& common) {
  const pipeline::Sweep sweep = pipeline::read_sweep(given.file, given.out);
  std::error_code problem;
  std::filesystem::create_directories(sweep.out / "results", problem);
  if (problem) {
    throw Error(Fault::Resource, fmt::format("{}: the folder cannot be made: {}",
                                             sweep.out.filename().string(), problem.message()));
  }
  const pipeline::CaseLock lock(sweep.out);
  Progress progress(common, true);
  prepare(sweep, common);
  const Context ctx("sweep", progress, progress.stop_token());
  const double all = static_cast<double>(sweep.tasks.size());
  std::size_t last_done = sweep.tasks.size() + 1;
  const auto tell = [&](std::size_t done, std::size_t running) {
    if (done != last_done) {
      ctx.at(static_cast<double>(done) / all,
             fmt::format("{} of {} tasks done, {} running", done, sweep.tasks.size(), running));
      last_done = done;
    }
    ctx.detail(static_cast<double>(done) / all, "");  // hears of Ctrl-C
  };
  try {
    (given.engine == "slurm" ? sweep_on_slurm : sweep_locally)(sweep, given.options, tell,
                                                               progress.stop_token());
  } catch (...) {  // the table of what there is
    pipeline::collect(sweep);
    throw;
  }
  const std::string text = pipeline::collect(sweep);
  if (common.json) {
    fmt::print("{}", text);
    return 0;
  }
  const auto rows = nlohmann::json::parse(text).at("results");
  const auto failed =
      std::ranges::count_if(rows, [](const auto& row) { return row.at("status") != "ok"; });
  fmt::print("{} tasks, {} failed\nresults: {}\n", rows.size(), failed,
             (sweep.out / "results.csv").string());
  return 0;
}

}  // namespace

void add_sweep(CLI::App& app, Common& common, Command& chosen) {
  auto given = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "sweep",
      "Examples: sanatrix sweep margins.json\n"
      "          sanatrix sweep margins.json --engine slurm --sbatch=--partition=long\n\n"
      "Runs many plans and parameters of one case (docs/user/sweep.md). The same command goes on\n"
      "after a stop or a crash.");
  command->add_option("SWEEP", given->file, "sweep file (JSON)")->required();
  command->add_option("--out", given->out, "folder of the results (default: beside the file)");
  command->add_option("--engine", given->engine, "local processes or a Slurm cluster")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
  command->add_option("--jobs", given->options.jobs, "workers at a time")
      ->check(CLI::Range(1, 100000));
  command->add_option("--sbatch", given->options.sbatch_options,
                      "option for sbatch; may be repeated");
  command->add_option("--task", given->task, "computes only this task, in this process");
  add_json(*command, common);
  add_progress(*command, common);
  command->callback([given, &common, &chosen] {
    chosen = [=, &common] {
      return given->task.empty() ? drive(*given, common) : work(*given, common);
    };
  });
}

}  // namespace sanatrix::app
