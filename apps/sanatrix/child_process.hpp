// Starting programs without a shell.
#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

namespace sanatrix::app {

/// The file of the running program.
std::string own_program();
/// Starts a program found on PATH. Its stdout goes to stderr, so that ours stays clean for data.
/// Error{Resource} when it cannot be started.
pid_t start_process(const std::vector<std::string>& arguments);

struct Captured {
  int exit_code = -1;  ///< -1: ended by a signal or not started
  std::string output;  ///< stdout; stderr is thrown away
};
Captured run_captured(const std::vector<std::string>& arguments);

}  // namespace sanatrix::app
