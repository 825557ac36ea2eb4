// sanatrix solve PROBLEM.json --out DIR: the engine on any tetrahedral mesh.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "mpi_team.hpp"
#include "pipeline/problem_solver.hpp"
#include "progress.hpp"

namespace sanatrix::app {
namespace {

void work(const std::string& file, const std::string& out, const Common& common,
          pipeline::Team& team) {
  pipeline::SolveProblem problem = pipeline::read_problem(file);
  Progress progress(common, team.leads());
  const Context ctx("solve", progress, progress.stop_token());
  const std::string result = pipeline::solve_problem(problem, out, team, ctx);
  if (!team.leads()) {
    return;
  }
  if (common.json) {
    fmt::print("{}", result);
    return;
  }
  const auto j = nlohmann::json::parse(result);
  fmt::print("converged: {} Newton iterations, max displacement {:.4f} mm, min det F {:.4f}\n",
             j["newton_iterations"].get<int>(), j["max_displacement_mm"].get<double>(),
             j["min_jacobian"].get<double>());
  for (const auto& [name, u] : j["probes"].items()) {
    fmt::print("  {}: {:.4f} {:.4f} {:.4f} mm\n", name, u[0].get<double>(), u[1].get<double>(),
               u[2].get<double>());
  }
  fmt::print("results: {}\n", out);
}

}  // namespace

void add_solve(CLI::App& app, Common& common, Command& chosen) {
  struct Arguments {
    std::string file, out;
  };
  auto given = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "solve",
      "Example: sanatrix solve hemisphere.json --out out/hemisphere\n\n"
      "Solves gravity, its inverse, or healing on any tetrahedral mesh (docs/user/solve.md).");
  command->add_option("PROBLEM", given->file, "problem file (JSON)")->required();
  command->add_option("--out", given->out, "folder for result.json, result.vtu, history.csv")
      ->required();
  add_team_work(*command, common, chosen, [given, &common](pipeline::Team& team) {
    work(given->file, given->out, common, team);
  });
}

}  // namespace sanatrix::app
