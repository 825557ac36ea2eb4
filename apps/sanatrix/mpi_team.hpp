// One command on several MPI ranks: starting them, agreeing, and ending together.
#pragma once

#include <functional>

#include "commands.hpp"
#include "pipeline/team.hpp"

namespace sanatrix::app {

/// Starts MPI and PETSc, works, and returns the exit code. A failure on one rank ends all.
int with_team(const std::function<void(pipeline::Team&)>& work);

/// Gives the command --ranks, --json, -v and -q, and this work, done by as many processes as
/// --ranks says.
void add_team_work(CLI::App& command, Common& common, Command& chosen,
                   const std::function<void(pipeline::Team&)>& work);

}  // namespace sanatrix::app
