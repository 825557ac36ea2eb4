// Who computes the tasks of a sweep: processes on this machine, or a Slurm cluster. Both only start
// workers and look for result files; neither is believed when it says that a task is done.
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "pipeline/sweep.hpp"

namespace sanatrix::app {

struct SweepOptions {
  int jobs = 0;  ///< workers at a time; 0: cores (local), no limit (Slurm)
  std::vector<std::string> sbatch_options;  ///< passed on: "--partition=long"
};
/// Told now and then: tasks done and workers alive.
using SweepProgress = std::function<void(std::size_t done, std::size_t running)>;

/// Until every task has its result. Throws Cancelled when stopped, Error{Resource} when tasks keep
/// dying; what is done is kept in both cases.
void sweep_locally(const pipeline::Sweep& sweep, const SweepOptions& options,
                   const SweepProgress& progress, const std::stop_token& stop);
void sweep_on_slurm(const pipeline::Sweep& sweep, const SweepOptions& options,
                    const SweepProgress& progress, const std::stop_token& stop);

}  // namespace sanatrix::app
