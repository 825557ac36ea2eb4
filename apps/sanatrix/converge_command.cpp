// sanatrix converge CASE: how much the clinical outputs depend on the mesh and on time steps.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "mpi_team.hpp"
#include "pipeline/convergence.hpp"
#include "progress.hpp"
#include "verification/svg_plot.hpp"

namespace sanatrix::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::Convergence;
using pipeline::ConvergenceRun;

struct Arguments {
  std::string folder, out;
  std::vector<int> sizes;
  std::vector<double> intervals;
};

json runs_json(const std::vector<ConvergenceRun>& runs) {
  json list = json::array();
  for (const ConvergenceRun& run : runs) {
    json values = json::object();
    for (std::size_t i = 0; i < run.values.size(); ++i) {
      values[pipeline::clinical_outputs()[i].key] = run.values[i];
    }
    list.push_back({{"vertices", run.vertices},
                    {"mechanics_interval_days", run.interval_days},
                    {"estimated_relative_error", run.estimated_error},
                    {"values", values}});
  }
  return list;
}

json convergence_json(const std::string& pseudonym, const Convergence& found) {
  json outputs = json::array();
  for (std::size_t i = 0; i < found.error_bars.size(); ++i) {
    const pipeline::ClinicalOutput& output = pipeline::clinical_outputs()[i];
    const pipeline::ErrorBar& bar = found.error_bars[i];
    outputs.push_back({{"key", output.key},
                       {"name", output.name},
                       {"unit", output.unit},
                       {"finest", found.by_mesh.back().values[i]},
                       {"error_bar", bar.half_size},
                       {"order", bar.order},
                       {"order_observed", bar.observed}});
  }
  return {{"format", "sanatrix-convergence"},
          {"case", pseudonym},
          {"notice", "research use only, not a medical device"},
          {"method", "grid convergence index of the three finest meshes, safety factor 1.25"},
          {"outputs", outputs},
          {"by_mesh", runs_json(found.by_mesh)},
          {"by_interval", runs_json(found.by_interval)}};
}

std::string row_text(const std::string& name, const std::vector<double>& values) {
  std::string line = fmt::format("{:<47}", name);
  for (const double v : values) {
    line += fmt::format(" {:>10.4g}", v);
  }
  return line;
}

std::string label(const pipeline::ClinicalOutput& output) {
  return output.unit.empty() ? output.name : fmt::format("{} [{}]", output.name, output.unit);
}

std::string table_text(const Convergence& found) {
  std::string text = fmt::format("{:<47}", "vertices");
  for (const ConvergenceRun& run : found.by_mesh) {
    text += fmt::format(" {:>10}", run.vertices);
  }
  text += "   error bar   order\n";
  std::vector<double> estimates;
  for (const ConvergenceRun& run : found.by_mesh) {
    estimates.push_back(100.0 * run.estimated_error);
  }
  const auto& outputs = pipeline::clinical_outputs();
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const pipeline::ErrorBar& bar = found.error_bars[i];
    text += fmt::format("{} {:>11} {:>7}\n", row_text(label(outputs[i]), found.mesh_values(i)),
                        fmt::format("±{:.2g}", bar.half_size),
                        bar.observed ? fmt::format("{:.1f}", bar.order) : "none");
  }
  text += row_text("mesh error of displacements by outcome.json [%]", estimates) + "\n\n";
  std::vector<double> days;
  for (const ConvergenceRun& run : found.by_interval) {
    days.push_back(run.interval_days);
  }
  text += row_text("days between mechanical equilibria", days) + "\n";
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    text += row_text(label(outputs[i]), found.interval_values(i)) + "\n";
  }
  return text + "Research use only. Not a medical device.\n";
}

/// All outputs in one picture: their distance from the value on the finest mesh.
verification::Plot mesh_plot(const Convergence& found) {
  verification::Plot plot{"Outputs by mesh, error bars at the finest",
                          "edge length, the finest mesh's as 1",
                          "distance from the finest mesh [%]"};
  for (std::size_t i = 0; i < found.error_bars.size(); ++i) {
    verification::Curve curve{pipeline::clinical_outputs()[i].name, found.edges(), {}};
    const std::vector<double> values = found.mesh_values(i);
    const double scale = 100.0 / std::abs(values.back());
    for (const double v : values) {
      curve.y.push_back(scale * (v - values.back()));
      curve.error_bar.push_back(0.0);
    }
    curve.error_bar.back() = scale * found.error_bars[i].half_size;
    plot.curves.push_back(std::move(curve));
  }
  return plot;
}

void write_results(const Convergence& found, const json& as_json, const fs::path& out) {
  write_text(out / "convergence.json", as_json.dump(2) + "\n");
  write_text(out / "convergence.txt", table_text(found));
  write_text(out / "convergence.svg", verification::svg_plot(mesh_plot(found)));
}

void work(const Arguments& given, const Common& common, pipeline::Team& team) {
  const fs::path folder = fs::weakly_canonical(given.folder);
  const fs::path out =
      given.out.empty() ? fs::path(folder.string() + ".convergence") : fs::absolute(given.out);
  pipeline::open_case(folder);  // what is no case is refused before anything is locked or made
  std::optional<pipeline::CaseLock> lock;
  if (team.leads()) {
    lock.emplace(folder);
    std::error_code problem;
    fs::create_directories(out, problem);
    if (problem) {
      throw Error(Fault::Resource, fmt::format("{}: the folder cannot be made: {}",
                                               out.filename().string(), problem.message()));
    }
  }
  team.share(0);
  const pipeline::Case patient = pipeline::open_case(folder);
  Progress progress(common, team.leads());
  const Convergence found = pipeline::converge(patient, {given.sizes, given.intervals, out},
                                               progress, team, progress.stop_token());
  if (!team.leads()) {
    return;
  }
  const json as_json = convergence_json(patient.pseudonym, found);
  write_results(found, as_json, out);
  fmt::print("{}", common.json ? as_json.dump(2) + "\n" : table_text(found));
  if (!common.json) {
    fmt::print("results: {}\n", out.string());
  }
}

}  // namespace

void add_converge(CLI::App& app, Common& common, Command& chosen) {
  auto given = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "converge",
      "Examples: sanatrix converge out/case\n"
      "          sanatrix converge out/case --sizes 5000,11000,24000 --intervals 6,3\n\n"
      "Runs the case on several meshes and with several intervals between mechanical equilibria, "
      "and says\nhow far the clinical outputs may be from those of an infinitely fine mesh "
      "(docs/user/converge.md).\nThe same command goes on after a stop or a crash.");
  command->add_option("CASE", given->folder, "case folder with a plan")->required();
  command
      ->add_option("--sizes", given->sizes,
                   "numbers of vertices, three or more (default: the case's own and two coarser)")
      ->delimiter(',')
      ->check(CLI::Range(500, 2000000));
  command
      ->add_option("--intervals", given->intervals,
                   "days between equilibria (default: twice, once and half the case's own)")
      ->delimiter(',')
      ->check(CLI::Range(0.1, 365.0));
  command->add_option("--out", given->out, "folder of the results (default: CASE.convergence)");
  add_team_work(*command, common, chosen,
                [given, &common](pipeline::Team& team) { work(*given, common, team); });
}

}  // namespace sanatrix::app
