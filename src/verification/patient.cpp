// Calculation verification on a patient: the clinical outputs of the built-in patient on three
// meshes with Richardson error bars, and with three intervals of mechanics.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <unistd.h>

#include "fem/session.hpp"
#include "pipeline/case_inputs.hpp"
#include "pipeline/convergence.hpp"
#include "pipeline/phantom_files.hpp"
#include "verification/cases.hpp"

namespace sanatrix::verification {
namespace {

namespace fs = std::filesystem;

/// Hands on what the runner says, so that a long case can be stopped.
class Monitor final : public pipeline::Monitor {
 public:
  explicit Monitor(const Context& ctx) : ctx_(ctx) {}
  void on(const Event& event) override {
    done_ = event.stage == "converge" ? event.fraction : done_;
    ctx_.detail(done_, std::string(event.stage));
  }
  void started(const pipeline::StageInfo&) override {}
  void finished(const pipeline::StageInfo&, const pipeline::StageRecord&) override {}
  void fresh(const pipeline::StageInfo&) override {}

 private:
  const Context& ctx_;
  double done_ = 0.0;
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

pipeline::Case make_patient(const Scratch& scratch, const Context& ctx) {
  const phantom::Options options;
  const phantom::Phantom made = phantom::make_phantom(options, ctx.part(0.0, 0.1));
  pipeline::write_phantom(made, options, scratch.folder / "phantom");
  pipeline::NewCase given;
  given.labels = scratch.folder / "phantom/labels.nii.gz";
  given.plan = scratch.folder / "phantom/plan.json";
  pipeline::Case patient = pipeline::create_case(scratch.folder / "case", given);
  pipeline::follow_plan(patient);
  patient.parameters.set("mesh.preset", "paper");  // of the study in time
  pipeline::save_case(patient);
  return patient;
}

void add_mesh_study(const pipeline::Convergence& study, Findings& found) {
  Table table{"Meshes", {"output", "unit"}, {}};
  for (const pipeline::ConvergenceRun& run : study.by_mesh) {
    table.header.push_back(fmt::format("{} vertices", run.vertices));
  }
  table.header.insert(table.header.end(), {"order", "error bar"});
  for (std::size_t i = 0; i < study.error_bars.size(); ++i) {
    const pipeline::ClinicalOutput& output = pipeline::clinical_outputs()[i];
    const pipeline::ErrorBar& bar = study.error_bars[i];
    std::vector<double> values = study.mesh_values(i);
    std::vector<std::string> row{output.name, output.unit};
    for (const double v : values) {
      row.push_back(fmt::format("{:.4g}", v));
    }
    row.insert(row.end(), {bar.observed ? fmt::format("{:.2f}", bar.order) : "none",
                           fmt::format("{:.2g}", bar.half_size)});
    table.rows.push_back(row);
    found.checks.push_back(within(fmt::format("{}: error bar / value", output.name), 0.0, 0.25,
                                  bar.half_size / std::abs(values.back()), "",
                                  "meshes are made anew, so single outputs scatter"));
    std::vector<double> h = study.edges();
    std::ranges::reverse(h);
    std::ranges::reverse(values);
    std::vector<double> bars(values.size(), 0.0);
    bars.front() = bar.half_size;
    found.plots.push_back(
        {output.name,
         "edge length, the finest mesh's as 1",
         fmt::format("{} [{}]", output.name, output.unit.empty() ? "-" : output.unit),
         {{"three meshes, error bar at the finest", h, values, false, bars}}});
  }
  found.tables.push_back(std::move(table));
}

/// The error that outcome.json estimates from one mesh, beside the one seen between meshes.
void add_estimate(const pipeline::Convergence& study, Findings& found) {
  const double estimated = study.by_mesh.back().estimated_error;
  for (const std::size_t i : {0U, 1U}) {
    const double seen = study.error_bars[i].half_size / study.by_mesh.back().values[i];
    found.checks.push_back(
        within(fmt::format("{}: error bar / estimate of outcome.json",
                           pipeline::clinical_outputs()[i].name),
               0.0, 3.0, seen / estimated, "",
               "the estimate is one of size; the error bar has a safety factor of 1.25"));
  }
}

void add_time_study(const pipeline::Convergence& study, Findings& found) {
  Table table{"Days between two mechanical equilibria", {"output", "unit"}, {}};
  for (const pipeline::ConvergenceRun& run : study.by_interval) {
    table.header.push_back(fmt::format("{:g}", run.interval_days));
  }
  for (std::size_t i = 0; i < study.error_bars.size(); ++i) {
    const pipeline::ClinicalOutput& output = pipeline::clinical_outputs()[i];
    const std::vector<double> values = study.interval_values(i);
    std::vector<std::string> row{output.name, output.unit};
    for (const double v : values) {
      row.push_back(fmt::format("{:.5g}", v));
    }
    table.rows.push_back(row);
    const double six = values[values.size() - 2];
    const double three = values.back();
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
  const pipeline::Case patient = make_patient(scratch, ctx);
  pipeline::Alone team;
  const pipeline::Convergence study =
      pipeline::converge(patient, {{2000, 4500, 10000}, {12.0, 6.0, 3.0}, scratch.folder / "study"},
                         monitor, team, {});
  add_time_study(study, found);
  add_mesh_study(study, found);
  add_estimate(study, found);
  return found;
}

}  // namespace

void add_patient(std::vector<Case>& cases) {
  cases.push_back({"patient", "Clinical outputs of a patient: mesh and time",
                   Chapter::CalculationVerification, Cost::Full,
                   "The built-in patient from labels to outcome on meshes of about 2,000, 4,500 "
                   "and 10,000 vertices, and with mechanics every 12, 6 and 3 days. Error bars: "
                   "Richardson extrapolation as grid convergence index, safety factor 1.25.",
                   convergence});
}

}  // namespace sanatrix::verification
