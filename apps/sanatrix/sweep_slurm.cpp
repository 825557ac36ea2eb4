// The Slurm engine: one job array for the tasks without a result, and another one for what is left
// when the array has gone. Slurm's word is not trusted: a restarted controller may run a task twice
// or forget it; result files decide.
#include <chrono>
#include <sstream>
#include <thread>

#include "child_process.hpp"
#include "core/context.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "sweep_engines.hpp"

namespace sanatrix::app {
namespace {

namespace fs = std::filesystem;

/// Arrays in a row that end without a single new result before we give up.
constexpr int most_idle_rounds = 3;
constexpr auto poll_interval = std::chrono::milliseconds(1000);

struct Alive {
  std::size_t jobs = 0;
  std::vector<std::string> waiting_for_time, held;  ///< job ids
};

std::vector<std::string> words_of(const std::string& line, char separator) {
  std::vector<std::string> words;
  std::istringstream in(line);
  for (std::string word; std::getline(in, word, separator);) {
    words.push_back(word);
  }
  return words;
}

/// What Slurm still knows of an array. A controller that does not answer counts as alive.
Alive look(const std::string& array) {
  const Captured answer = run_captured({"squeue", "-h", "-r", "-j", array, "-o", "%i|%T|%r"});
  Alive alive;
  if (answer.exit_code != 0) {
    // "Invalid job id" (long gone), or no controller: then asking for its health fails too.
    alive.jobs = run_captured({"scontrol", "ping"}).output.find(" UP") == std::string::npos ? 1 : 0;
    return alive;
  }
  for (const std::string& line : words_of(answer.output, '\n')) {
    const auto words = words_of(line, '|');
    if (words.size() < 3) {
      continue;
    }
    ++alive.jobs;
    if (words[2] == "BeginTime") {
      alive.waiting_for_time.push_back(words[0]);
    } else if (words[2].find("eld") != std::string::npos) {  // JobHeldUser, launch failed ... held
      alive.held.push_back(words[0]);
    }
  }
  return alive;
}

class SlurmEngine {
 public:
  SlurmEngine(const pipeline::Sweep& sweep, const SweepOptions& options)
      : sweep_(sweep), options_(options), folder_(sweep.out / "slurm") {
    fs::create_directories(folder_);
  }

  void run(const SweepProgress& progress, const std::stop_token& stop) {
    int idle_rounds = 0;
    std::string array = fs::exists(folder_ / "array") ? read_text(folder_ / "array") : "";
    while (!missing().empty()) {
      const std::size_t before = missing().size();
      if (array.empty()) {
        array = submit();
      }
      wait(array, progress, stop);
      array.clear();
      fs::remove(folder_ / "array");
      idle_rounds = missing().size() < before ? 0 : idle_rounds + 1;
      if (idle_rounds >= most_idle_rounds) {
        throw Error(Fault::Resource,
                    fmt::format("{} arrays in a row ended without a result", most_idle_rounds),
                    fmt::format("read the logs in {}", folder_.string()));
      }
    }
    if (!array.empty()) {
      run_captured({"scancel", array});  // copies of tasks that are done
    }
    fs::remove(folder_ / "array");
  }

 private:
  [[nodiscard]] std::vector<std::string> missing() const {
    std::vector<std::string> keys;
    for (const pipeline::SweepTask& task : sweep_.tasks) {
      if (!sweep_.done(task)) {
        keys.push_back(task.key);
      }
    }
    return keys;
  }

  std::string submit() {
    const std::vector<std::string> keys = missing();
    const fs::path list = folder_ / "tasks.txt";
    const fs::path script = folder_ / "job.sh";
    write_text(list, fmt::format("{}\n", fmt::join(keys, "\n")));
    // The number of the array's task is the line of its key. exec: the warning signal before a time
    // limit reaches the program itself, which then checkpoints.
    write_text(script, fmt::format("#!/bin/sh\n"
                                   "export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1\n"
                                   "key=$(sed -n \"$((SLURM_ARRAY_TASK_ID + 1))p\" '{}')\n"
                                   "exec '{}' sweep '{}' --out '{}' --task \"$key\" -q\n",
                                   list.string(), own_program(), sweep_.file.string(),
                                   sweep_.out.string()));
    const std::string range = options_.jobs > 0
                                  ? fmt::format("0-{}%{}", keys.size() - 1, options_.jobs)
                                  : fmt::format("0-{}", keys.size() - 1);
    std::vector<std::string> command{"sbatch",
                                     "--parsable",
                                     "--requeue",
                                     "--array=" + range,
                                     "--job-name=sanatrix-sweep",
                                     "--signal=B:INT@60",
                                     "--output=" + (folder_ / "%A_%a.log").string(),
                                     "--open-mode=append"};
    command.insert(command.end(), options_.sbatch_options.begin(), options_.sbatch_options.end());
    command.push_back(script.string());
    const Captured answer = run_captured(command);
    if (answer.exit_code != 0) {
      throw Error(Fault::Resource, "sbatch refused the job array",
                  "run it by hand to see why: sbatch --array=" + range + " " + script.string());
    }
    std::string id = words_of(words_of(answer.output, '\n').at(0), ';').at(0);
    write_text(folder_ / "array", id);
    return id;
  }

  /// Until the array has gone or everything is done.
  void wait(const std::string& array, const SweepProgress& progress, const std::stop_token& stop) {
    for (;;) {
      if (stop.stop_requested()) {
        run_captured({"scancel", "--signal=INT", "--batch", array});
        run_captured({"scancel", array});
        fs::remove(folder_ / "array");
        throw Cancelled{};
      }
      const std::size_t left = missing().size();
      const Alive alive = look(array);
      progress(sweep_.tasks.size() - left, alive.jobs);
      if (alive.jobs == 0 || left == 0) {
        if (left == 0 && alive.jobs > 0) {
          run_captured({"scancel", array});
        }
        return;
      }
      for (const std::string& job : alive.waiting_for_time) {  // a dead node's jobs wait 2 minutes
        run_captured({"scontrol", "update", "JobId=" + job, "StartTime=now"});
      }
      for (const std::string& job : alive.held) {  // tasks are idempotent: let it run
        run_captured({"scontrol", "release", job});
      }
      std::this_thread::sleep_for(poll_interval);
    }
  }

  const pipeline::Sweep& sweep_;
  SweepOptions options_;
  fs::path folder_;
};

}  // namespace

void sweep_on_slurm(const pipeline::Sweep& sweep, const SweepOptions& options,
                    const SweepProgress& progress, const std::stop_token& stop) {
  if (run_captured({"sbatch", "--version"}).exit_code != 0) {
    throw Error(Fault::Input, "there is no Slurm here: sbatch is not found",
                "use --engine local, or run this on a login node of the cluster");
  }
  SlurmEngine(sweep, options).run(progress, stop);
}

}  // namespace sanatrix::app
