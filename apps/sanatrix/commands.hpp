// The subcommands of `sanatrix`: each adds itself to the command line and is one file.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace sanatrix::app {

/// What every subcommand shares; filled by the parser before the command runs.
struct Common {
  bool json = false;
  bool verbose = false;
  bool quiet = false;
  int ranks = 1;
  std::vector<std::string> arguments;  ///< as given, for the ranks of --ranks
};

/// Set by the parser when a subcommand was chosen; returns the exit code.
using Command = std::function<int()>;

void add_phantom(CLI::App& app, Common& common, Command& chosen);
void add_new(CLI::App& app, Common& common, Command& chosen);
void add_inspect(CLI::App& app, Common& common, Command& chosen);
void add_run(CLI::App& app, Common& common, Command& chosen);
void add_status(CLI::App& app, Common& common, Command& chosen);
void add_solve(CLI::App& app, Common& common, Command& chosen);
void add_params(CLI::App& app, Common& common, Command& chosen);
void add_score(CLI::App& app, Common& common, Command& chosen);
void add_version(CLI::App& app, Common& common, Command& chosen);

/// Options that several commands have.
void add_json(CLI::App& command, Common& common);
void add_progress(CLI::App& command, Common& common);
void add_ranks(CLI::App& command, Common& common);

}  // namespace sanatrix::app
