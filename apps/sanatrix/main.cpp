// The command `sanatrix`: reads the command line, runs one subcommand, returns its exit code.
#include <fmt/format.h>

#include "commands.hpp"
#include "core/error.hpp"
#include "failure.hpp"
#include "interrupt.hpp"
#include "version.hpp"

namespace sanatrix::app {

void add_json(CLI::App& command, Common& common) {
  command.add_flag("--json", common.json, "machine-readable output on stdout");
}

void add_progress(CLI::App& command, Common& common) {
  command.add_flag("-v,--verbose", common.verbose,
                   "Newton residuals and stages that are up to date");
  command.add_flag("-q,--quiet", common.quiet, "no progress on stderr");
}

void add_ranks(CLI::App& command, Common& common) {
  command.add_option("--ranks", common.ranks, "number of MPI processes")
      ->check(CLI::Range(1, 1024));
}

void ScanOptions::add_to(CLI::App& command) {
  command.add_option("--scan", scan,
                     "surface scan of the standing patient before surgery: .obj (with .mtl and "
                     "photographs), .ply, .stl");
  command.add_option("--followup", followup, "surface scan after healing, to compare with");
  command.add_option("--scan-landmarks,--landmarks", scan_landmarks,
                     "JSON with landmarks_scan_mm of --scan, when it cannot be laid on by itself");
  command.add_option("--followup-landmarks", followup_landmarks, "the same for --followup");
}

std::map<std::string, std::filesystem::path> ScanOptions::given() const {
  std::map<std::string, std::filesystem::path> files;
  for (const auto& [name, file] : {std::pair{"scan", scan},
                                   {"followup", followup},
                                   {"scan_landmarks", scan_landmarks},
                                   {"followup_landmarks", followup_landmarks}}) {
    if (!file.empty()) {
      files[name] = file;
    }
  }
  return files;
}

namespace {

constexpr auto exit_codes =
    "Exit codes: 0 ok, 1 usage, 2 bad input, 3 not converged, 4 resource limit,\n"
    "            5 interrupted (run again to go on), 6 internal error.\n"
    "Research use only. Not a medical device.";

int run(int argc, char** argv) {
  CLI::App app(
      "Examples: sanatrix phantom out/phantom\n"
      "          sanatrix new out/case --labels out/phantom/labels.nii.gz --plan "
      "out/phantom/plan.json\n"
      "          sanatrix run out/case\n\n"
      "Predicts the shape of the breast three months after breast-conserving surgery.",
      "sanatrix");
  app.footer(exit_codes);
  app.set_version_flag("--version", [] { return version_text(); });
  app.require_subcommand(1);
  Common common;
  common.arguments.assign(argv + 1, argv + argc);
  Command chosen;
  for (const auto add : {add_phantom, add_inspect, add_new, add_run, add_status, add_report,
                         add_compare, add_serve, add_solve, add_export, add_sweep, add_converge,
                         add_verify, add_params, add_score, add_version}) {
    add(app, common, chosen);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) {
      return app.exit(e);  // --help and --version
    }
    fmt::print(stderr, "sanatrix: error: {} - see sanatrix --help\n", e.what());
    return exit_code(Fault::Usage);
  }
  catch_interrupts();
  return chosen();
}

}  // namespace
}  // namespace sanatrix::app

int main(int argc, char** argv) {
  try {
    return sanatrix::app::run(argc, argv);
  } catch (...) {  // the one place where everything ends
    const sanatrix::app::Failure failure = sanatrix::app::describe(std::current_exception());
    fmt::print(stderr, "sanatrix: {}\n", failure.line);
    return failure.exit_code;
  }
}
