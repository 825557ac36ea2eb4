// The subcommands of `sanatrix`: each adds itself to the command line and is one file.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
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

/// Scans of the patient's surface, as options of several commands.
struct ScanOptions {
  std::string scan, followup, scan_landmarks, followup_landmarks;

  void add_to(CLI::App& command);
  /// Those that were given, by the names of pipeline::replace_scans.
  [[nodiscard]] std::map<std::string, std::filesystem::path> given() const;
};

/// Set by the parser when a subcommand was chosen; returns the exit code.
using Command = std::function<int()>;

void add_report(CLI::App& app, Common& common, Command& chosen);
void add_compare(CLI::App& app, Common& common, Command& chosen);
void add_phantom(CLI::App& app, Common& common, Command& chosen);
void add_new(CLI::App& app, Common& common, Command& chosen);
void add_inspect(CLI::App& app, Common& common, Command& chosen);
void add_run(CLI::App& app, Common& common, Command& chosen);
void add_status(CLI::App& app, Common& common, Command& chosen);
void add_solve(CLI::App& app, Common& common, Command& chosen);
void add_params(CLI::App& app, Common& common, Command& chosen);
void add_serve(CLI::App& app, Common& common, Command& chosen);
void add_score(CLI::App& app, Common& common, Command& chosen);
void add_export(CLI::App& app, Common& common, Command& chosen);
void add_converge(CLI::App& app, Common& common, Command& chosen);
void add_sweep(CLI::App& app, Common& common, Command& chosen);
void add_verify(CLI::App& app, Common& common, Command& chosen);
void add_version(CLI::App& app, Common& common, Command& chosen);

/// Options that several commands have.
void add_json(CLI::App& command, Common& common);
void add_progress(CLI::App& command, Common& common);
void add_ranks(CLI::App& command, Common& common);

}  // namespace sanatrix::app
