// One command on several MPI ranks: starting them, agreeing, and ending together.
#pragma once

#include <functional>

#include "commands.hpp"
#include "pipeline/team.hpp"

namespace sanatrix::app {

/// Starts MPI and PETSc, works, and returns the exit code. A failure on one rank ends all.
int with_team(const std::function<void(pipeline::Team&)>& work);

/// Should this process start `mpirun` instead of working itself?
bool must_launch_ranks(const Common& common);
/// The same command under `mpirun -n N`; returns its exit code.
int launch_ranks(const Common& common);

}  // namespace sanatrix::app
