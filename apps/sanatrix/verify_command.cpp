// sanatrix verify: every verification and validation case, its table, and the credibility page.
#include <algorithm>

#include <fmt/format.h>

#include "commands.hpp"
#include "core/error.hpp"
#include "mpi_team.hpp"
#include "progress.hpp"
#include "verification/credibility.hpp"

namespace sanatrix::app {
namespace {

struct Arguments {
  std::string only, write;
  bool fast = false;
};

void work(const Arguments& given, const Common& common, pipeline::Team& team) {
  Progress progress(common, team.leads());
  std::vector<verification::CaseResult> results;
  const auto chosen = verification::select(given.only);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (given.fast && chosen[i]->cost == verification::Cost::Full) {
      continue;
    }
    const double share = 1.0 / static_cast<double>(chosen.size());
    const Context ctx("verify", progress, progress.stop_token());
    const double done = share * static_cast<double>(i);
    ctx.at(done, chosen[i]->title);
    results.push_back(verification::run(*chosen[i], ctx.part(done, done + share)));
  }
  if (!team.leads()) {
    return;
  }
  if (!given.write.empty()) {
    verification::write_page(results, given.write);
  }
  fmt::print("{}",
             common.json ? verification::results_json(results) : verification::table_text(results));
  const auto failed = std::ranges::count_if(results, [](const auto& r) { return !r.pass(); });
  const auto skipped =
      std::ranges::count_if(results, [](const auto& r) { return !r.found.skipped.empty(); });
  if (!common.json) {
    fmt::print("{} cases, {} failed, {} not run\n", results.size(), failed, skipped);
  }
  if (failed > 0) {
    throw Error(Fault::Numerics, fmt::format("{} of {} cases failed", failed, results.size()),
                "the lines with FAIL say which numbers are outside");
  }
}

}  // namespace

void add_verify(CLI::App& app, Common& common, Command& chosen) {
  auto given = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "verify",
      "Examples: sanatrix verify\n"
      "          sanatrix verify --only mms\n"
      "          sanatrix verify --write docs/credibility\n\n"
      "Runs the verification and validation cases: manufactured solutions, closed forms, peers, "
      "the paper.\nCases that need the shared development data ask SANATRIX_SHARED for it.");
  command->add_option("--only", given->only, "one case, or all whose name begins with this");
  command->add_flag("--fast", given->fast, "only the cases that are also tests");
  command->add_option("--write", given->write, "folder for the credibility page and its plots");
  add_team_work(*command, common, chosen,
                [given, &common](pipeline::Team& team) { work(*given, common, team); });
}

}  // namespace sanatrix::app
