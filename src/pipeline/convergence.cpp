#include "pipeline/convergence.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "pipeline/stages.hpp"
#include "pipeline/sweep.hpp"

namespace sanatrix::pipeline {
namespace {

using nlohmann::json;
using Settings = std::map<std::string, std::string>;

constexpr double safety = 1.25;  // of the grid convergence index on three meshes
/// Edges of neighbouring meshes differ by this factor: ASME V&V 20 asks for at least 1.3.
constexpr double refinement = 1.3;

double spread(std::span<const double> values) {
  const auto [low, high] = std::ranges::minmax(values);
  return high - low;
}

/// (h2^p - h1^p) / (h1^p - h0^p), finest first: what the differences of values of order p have as
/// their ratio. Grows with p.
double difference_ratio(double p, const std::array<double, 3>& finest_first) {
  const auto& [h0, h1, h2] = finest_first;
  return (std::pow(h2, p) - std::pow(h1, p)) / (std::pow(h1, p) - std::pow(h0, p));
}

/// The same sizes of cells in another number, near the resection and far from it.
Settings mesh_settings(const Case& patient, int vertices) {
  const meshing::MeshOptions own = mesh_options(patient.parameters);
  if (vertices == own.target_vertices) {
    return {};  // the case's own mesh, which may be there already
  }
  const double factor = std::cbrt(static_cast<double>(own.target_vertices) / vertices);
  return {{"mesh.target_vertices", std::to_string(vertices)},
          {"mesh.near_edge_mm", fmt::format("{:.3f}", 1e3 * own.near_edge_m * factor)},
          {"mesh.far_edge_mm", fmt::format("{:.3f}", 1e3 * own.far_edge_m * factor)}};
}

std::vector<int> chosen_vertices(const Case& patient, std::vector<int> given) {
  if (given.empty()) {
    const double own = mesh_options(patient.parameters).target_vertices;
    for (const int coarser : {2, 1, 0}) {
      given.push_back(static_cast<int>(std::lround(own / std::pow(refinement, 3.0 * coarser))));
    }
  }
  std::ranges::sort(given);
  given.erase(std::ranges::unique(given).begin(), given.end());
  if (given.size() < 3) {
    throw Error(Fault::Usage, "an order of convergence needs three meshes of different sizes",
                "for example --sizes 2000,4500,10000");
  }
  return given;
}

std::vector<double> chosen_intervals(const Case& patient, std::vector<double> given) {
  const double own = patient.parameters.number("heal.mechanics_interval_days");
  if (given.empty()) {
    given = {2.0 * own, own, 0.5 * own};
  }
  std::ranges::sort(given, std::greater<>());
  given.erase(std::ranges::unique(given).begin(), given.end());
  return given;
}

ConvergenceRun read_run(const json& result, const std::string& what) {
  if (result.at("status") != "ok") {
    throw Error(Fault::Numerics, fmt::format("{}: {}", what, result.at("error").get<std::string>()),
                "leave this one out with --sizes or --intervals");
  }
  const json& outcome = result.at("outcome");
  ConvergenceRun run;
  run.vertices = outcome.at("mesh").at("vertices");
  run.estimated_error = outcome.at("discretisation_error").at("relative");
  for (const ClinicalOutput& output : clinical_outputs()) {
    run.values.push_back(outcome.at(output.key));
  }
  return run;
}

void check_meshes(const std::vector<ConvergenceRun>& runs) {
  for (std::size_t i = 0; i + 1 < runs.size(); ++i) {
    if (runs[i].vertices * 1.1 > runs[i + 1].vertices) {
      throw Error(Fault::Numerics,
                  fmt::format("meshes of {} and {} vertices are too much alike for an order of "
                              "convergence",
                              runs[i].vertices, runs[i + 1].vertices),
                  "choose --sizes that are further apart, or larger: the shape of the skin needs "
                  "its share");
    }
  }
}

/// The runs of a study, one sweep task each: results that are there already are not made again.
class Study {
 public:
  Study(const Case& patient, const std::filesystem::path& out, Monitor& monitor, Team& team,
        const std::stop_token& stop)
      : patient_(patient), monitor_(monitor), team_(team), stop_(stop) {
    sweep_.case_folder = patient.folder;
    sweep_.out = out / "runs";
  }

  ConvergenceRun run(const Settings& settings, const std::string& what, double done) {
    Context("converge", monitor_, stop_).at(done, what);
    const SweepTask task = make_task(patient_, {}, settings);
    run_task(sweep_, task, monitor_, team_, stop_);
    return read_run(json::parse(read_text(sweep_.result_file(task))), what);
  }

 private:
  const Case& patient_;
  Monitor& monitor_;
  Team& team_;
  std::stop_token stop_;
  Sweep sweep_;
};

}  // namespace

ErrorBar richardson(std::span<const double> edges, std::span<const double> values) {
  ensure(edges.size() >= 3 && edges.size() == values.size(), "Richardson needs three meshes");
  const std::size_t last = values.size() - 1;
  const std::array h{edges[last], edges[last - 1], edges[last - 2]};
  const double fine = values[last - 1] - values[last];
  const double coarse = values[last - 2] - values[last - 1];
  const double observed = fine == 0.0 ? 0.0 : coarse / fine;
  double low = 1.0;
  double high = 2.0;
  const double round_off = 1e-9;
  const bool settles =
      observed >= (1.0 - round_off) * difference_ratio(low, h) || (fine == 0.0 && coarse == 0.0);
  if (settles) {
    for (int halving = 0; halving < 50; ++halving) {
      const double middle = 0.5 * (low + high);
      (difference_ratio(middle, h) < observed ? low : high) = middle;
    }
  }
  const double bar = safety * std::abs(fine) / (std::pow(h[1] / h[0], low) - 1.0);
  return {low, settles, settles ? bar : std::max(bar, spread(values.last(3)))};
}

const std::vector<ClinicalOutput>& clinical_outputs() {
  static const std::vector<ClinicalOutput> outputs{
      {"max_displacement_upright_mm", "largest displacement of the skin, upright", "mm"},
      {"mean_displacement_upright_mm", "mean displacement of the skin, upright", "mm"},
      {"wound_volume_ratio_final", "final V/V0", ""},
      {"wound_half_contraction_day", "half of the contraction", "d"},
      {"excised_cm3", "excised volume", "cm3"}};
  return outputs;
}

std::vector<double> Convergence::edges() const {
  std::vector<double> h;
  for (const ConvergenceRun& run : by_mesh) {
    h.push_back(std::cbrt(static_cast<double>(by_mesh.back().vertices) / run.vertices));
  }
  return h;
}

namespace {

std::vector<double> values_of(const std::vector<ConvergenceRun>& runs, std::size_t output) {
  std::vector<double> values;
  for (const ConvergenceRun& run : runs) {
    values.push_back(run.values[output]);
  }
  return values;
}

}  // namespace

std::vector<double> Convergence::mesh_values(std::size_t output) const {
  return values_of(by_mesh, output);
}
std::vector<double> Convergence::interval_values(std::size_t output) const {
  return values_of(by_interval, output);
}

Convergence converge(const Case& patient, const ConvergenceOptions& options, Monitor& monitor,
                     Team& team, const std::stop_token& stop) {
  require(patient.has_plan(), "the case has no surgical plan: nothing heals, nothing converges");
  const std::vector<int> vertices = chosen_vertices(patient, options.vertices);
  const std::vector<double> intervals = chosen_intervals(patient, options.intervals);
  run_case(patient, {.from = {}, .to = Stage::Supine}, monitor, team, stop);
  Study study(patient, options.out, monitor, team, stop);
  const double all = static_cast<double>(vertices.size() + intervals.size());
  Convergence found;
  const double own_interval = patient.parameters.number("heal.mechanics_interval_days");
  for (const int count : vertices) {
    const double done = static_cast<double>(found.by_mesh.size()) / all;
    found.by_mesh.push_back(study.run(mesh_settings(patient, count),
                                      fmt::format("mesh of about {} vertices", count), done));
    found.by_mesh.back().interval_days = own_interval;
  }
  check_meshes(found.by_mesh);
  for (const double days : intervals) {
    const double done = static_cast<double>(vertices.size() + found.by_interval.size()) / all;
    const Settings settings =
        days == own_interval ? Settings{}
                             : Settings{{"heal.mechanics_interval_days", fmt::format("{}", days)}};
    found.by_interval.push_back(
        study.run(settings, fmt::format("equilibria every {:g} days", days), done));
    found.by_interval.back().interval_days = days;
  }
  const std::vector<double> h = found.edges();
  for (std::size_t i = 0; i < clinical_outputs().size(); ++i) {
    found.error_bars.push_back(richardson(h, found.mesh_values(i)));
  }
  return found;
}

}  // namespace sanatrix::pipeline
