// Calculation verification on a patient: the clinical outputs of the built-in patient on three
// meshes with Richardson error bars, and with three intervals of mechanics.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "core/files.hpp"
#include "fem/session.hpp"
#include "pipeline/clone.hpp"
#include "pipeline/phantom_files.hpp"
#include "pipeline/runner.hpp"
#include "verification/cases.hpp"

namespace sanatrix::verification {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::Stage;

/// Hands on what the runner says, so that a long case can be stopped.
class Monitor final : public pipeline::Monitor {
 public:
  explicit Monitor(const Context& ctx) : ctx_(ctx) {}
  void on(const Event& event) override { ctx_.detail(done, std::string(event.stage)); }
  void started(const pipeline::StageInfo&) override {}
  void finished(const pipeline::StageInfo&, const pipeline::StageRecord&) override {}
  void fresh(const pipeline::StageInfo&) override {}
  double done = 0.0;

 private:
  const Context& ctx_;
};

/// A folder of our own that goes when we go.
struct Scratch {
  fs::path folder = fs::temp_directory_path() / fmt::format("sanatrix-verify-{}", ::getpid());
  Scratch() { fs::create_directories(folder); }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
};

struct Output {
  const char* key;
  const char* name;
  const char* unit;
};
constexpr std::array<Output, 4> outputs{
    {{"max_displacement_upright_mm", "largest displacement of the skin, upright", "mm"},
     {"mean_displacement_upright_mm", "mean displacement of the skin, upright", "mm"},
     {"wound_volume_ratio_final", "final V/V0", ""},
     {"excised_cm3", "excised volume", "cm3"}}};

json run_to_outcome(pipeline::Case& patient, Monitor& monitor) {
  pipeline::Alone team;
  pipeline::follow_plan(patient);
  pipeline::save_case(patient);
  pipeline::run_case(patient, {}, monitor, team, {});
  return json::parse(read_text(patient.stage_folder(Stage::Outcome) / "outcome.json"));
}

pipeline::Case make_patient(const Scratch& scratch, const Context& ctx) {
  const phantom::Options options;
  const phantom::Phantom made = phantom::make_phantom(options, ctx.part(0.0, 0.1));
  pipeline::write_phantom(made, options, scratch.folder / "phantom");
  pipeline::NewCase given;
  given.labels = scratch.folder / "phantom/labels.nii.gz";
  given.plan = scratch.folder / "phantom/plan.json";
  pipeline::Case patient = pipeline::create_case(scratch.folder / "case", given);
  patient.parameters.set("outcome.pictures", "no");
  return patient;
}

/// Grid convergence index with three meshes (Roache 1994, doi:10.1115/1.2910291): the observed
/// order where the differences allow one, kept between 1 and 2; safety factor 1.25.
struct Richardson {
  double order, bar;  ///< bar: half length, in the unit of the output
};
Richardson richardson(const std::array<double, 3>& h, const std::array<double, 3>& f) {
  const double ratio = h[1] / h[2];
  const double change = (f[0] - f[1]) / (f[1] - f[2]);
  const double observed =
      std::isfinite(change) && change > 0.0 ? std::log(change) / std::log(ratio) : 1.0;
  const double order = std::clamp(observed, 1.0, 2.0);
  return {order, 1.25 * std::abs(f[1] - f[2]) / (std::pow(ratio, order) - 1.0)};
}

void add_mesh_study(const std::vector<json>& runs, Findings& found) {
  std::array<double, 3> h{};
  for (std::size_t i = 0; i < 3; ++i) {
    h[i] = 1.0 / std::cbrt(runs[i].at("mesh").at("vertices").get<double>());
  }
  Table table{"Meshes", {"output", "unit"}, {}};
  for (const json& run : runs) {
    table.header.push_back(fmt::format("{} vertices", run.at("mesh").at("vertices").get<int>()));
  }
  table.header.insert(table.header.end(), {"order", "error bar"});
  for (const Output& output : outputs) {
    std::array<double, 3> f{};
    std::vector<std::string> row{output.name, output.unit};
    for (std::size_t i = 0; i < 3; ++i) {
      f[i] = runs[i].at(output.key);
      row.push_back(fmt::format("{:.4g}", f[i]));
    }
    const Richardson r = richardson(h, f);
    row.insert(row.end(), {fmt::format("{:.2f}", r.order), fmt::format("{:.2g}", r.bar)});
    table.rows.push_back(row);
    found.checks.push_back(within(fmt::format("{}: error bar / value", output.name), 0.0, 0.25,
                                  r.bar / std::abs(f[2]), "",
                                  "meshes are made anew, so single outputs scatter"));
    found.plots.push_back(
        {output.name,
         "vertices^(-1/3)",
         fmt::format("{} [{}]", output.name, *output.unit != 0 ? output.unit : "-"),
         {{"three meshes, error bar at the finest",
           {h[2], h[1], h[0]},
           {f[2], f[1], f[0]},
           false,
           {r.bar, 0.0, 0.0}}}});
  }
  found.tables.push_back(std::move(table));
}

void add_time_study(pipeline::Case& patient, const json& six_days, Monitor& monitor,
                    Findings& found) {
  Table table{"Days between two mechanical equilibria", {"output", "unit", "12", "6", "3"}, {}};
  std::vector<json> runs;
  for (const char* days : {"12", "3"}) {
    patient.parameters.set("heal.mechanics_interval_days", days);
    runs.push_back(run_to_outcome(patient, monitor));
  }
  for (const Output& output : outputs) {
    const double twelve = runs[0].at(output.key);
    const double six = six_days.at(output.key);
    const double three = runs[1].at(output.key);
    table.rows.push_back({output.name, output.unit, fmt::format("{:.5g}", twelve),
                          fmt::format("{:.5g}", six), fmt::format("{:.5g}", three)});
    found.checks.push_back(within(fmt::format("{}: change from 6 to 3 days / value", output.name),
                                  0.0, 0.01, std::abs(six - three) / std::abs(three), "",
                                  "time must matter less than the mesh"));
  }
  found.tables.push_back(std::move(table));
}

Findings convergence(const Context& ctx) {
  Findings found;
  if (fem::ranks() > 1) {
    found.skipped = "it runs on one rank only";
    return found;
  }
  const Scratch scratch;
  Monitor monitor(ctx);
  pipeline::Case patient = make_patient(scratch, ctx);
  std::vector<json> runs;
  for (const int vertices : {2000, 4000, 8000}) {
    patient.parameters.set("mesh.target_vertices", std::to_string(vertices));
    patient.parameters.set("mesh.near_edge_mm",
                           fmt::format("{:.3f}", 3.0 * std::cbrt(10000.0 / vertices)));
    runs.push_back(run_to_outcome(patient, monitor));
    monitor.done += 0.2;
    if (runs.size() == 1) {  // time on the coarsest mesh, on a case of its own
      pipeline::Case other = pipeline::clone_case(patient, scratch.folder / "time", Stage::Outcome);
      add_time_study(other, runs.front(), monitor, found);
    }
  }
  add_mesh_study(runs, found);
  return found;
}

}  // namespace

void add_patient(std::vector<Case>& cases) {
  cases.push_back({"patient", "Clinical outputs of a patient: mesh and time",
                   Chapter::CalculationVerification, Cost::Full,
                   "The built-in patient from labels to outcome on meshes of about 2,000, 4,000 "
                   "and 8,000 vertices, and with mechanics every 12, 6 and 3 days. Error bars: "
                   "Richardson extrapolation as grid convergence index, safety factor 1.25.",
                   convergence});
}

}  // namespace sanatrix::verification
