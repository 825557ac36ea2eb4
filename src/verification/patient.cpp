// Calculation verification on a patient: the clinical outputs of the built-in patient on three
// meshes with Richardson error bars, and with three intervals of mechanics; and her supine pose
// with linear and with quadratic cells.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "fem/session.hpp"
#include "pipeline/artefacts.hpp"
#include "pipeline/body.hpp"
#include "pipeline/case_inputs.hpp"
#include "pipeline/convergence.hpp"
#include "pipeline/phantom_files.hpp"
#include "pipeline/runner.hpp"
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

void convergence(const Scratch& scratch, const Context& ctx, Findings& found) {
  Monitor monitor(ctx);
  const pipeline::Case patient = make_patient(scratch, ctx);
  pipeline::Alone team;
  const pipeline::Convergence study =
      pipeline::converge(patient, {{2000, 4500, 10000}, {12.0, 6.0, 3.0}, scratch.folder / "study"},
                         monitor, team, {});
  add_time_study(study, found);
  add_mesh_study(study, found);
  add_estimate(study, found);
}

/// Length of the body's mean displacement [mm] when the unloaded patient lies down.
double supine_move_mm(const meshing::BreastModel& model, std::span<const Vec3> unloaded,
                      const pipeline::Parameters& parameters, const Context& ctx) {
  const mechanics::Body body = pipeline::make_body(model.mesh, model.fibroglandular, parameters);
  mechanics::Solver solver(body, pipeline::solve_options(parameters));
  const mechanics::Shape supine =
      solver.forward(solver.straight_nodes(unloaded), pipeline::gravity_supine, nullptr, ctx);
  return pipeline::mean_move_mm(model.mesh, unloaded, pipeline::vertices(model.mesh, supine));
}

/// The development patient from her T1 image; nothing where the shared data are absent.
std::optional<pipeline::Case> make_development_patient(const Scratch& scratch) {
  const std::string image = shared_file("data/dev01/t1.nii.gz");
  const std::string plan = shared_file("data/dev01/plan.json");
  if (image.empty() || plan.empty()) {
    return std::nullopt;
  }
  pipeline::NewCase given;
  given.image = image;
  given.plan = plan;
  given.parameters = {"mesh.preset=paper"};
  return pipeline::create_case(scratch.folder / "dev01", given);
}

void compare_cells(pipeline::Case patient, const std::string& name, const Context& ctx,
                   Findings& found) {
  Monitor monitor(ctx);
  pipeline::Alone team;
  pipeline::run_case(patient, {.from = {}, .to = pipeline::Stage::Unload}, monitor, team, {});
  const meshing::BreastModel model =
      pipeline::load_model(patient.stage_folder(pipeline::Stage::Mesh) / "model.bin");
  const mechanics::Shape shape =
      pipeline::load_shape(patient.stage_folder(pipeline::Stage::Unload) / "shape.bin").shape;
  const std::span<const Vec3> unloaded = pipeline::vertices(model.mesh, shape);
  Table table{
      fmt::format("{}: from unloaded to supine, {} vertices", name, model.mesh.points.size()),
      {"cells", "mean movement [mm]"},
      {}};
  std::vector<double> moves;
  for (const std::string& element : mechanics::element_names()) {
    patient.parameters.set("solver.element", element);
    const double part = 0.6 + 0.1 * static_cast<double>(moves.size());
    moves.push_back(
        supine_move_mm(model, unloaded, patient.parameters, ctx.part(part, part + 0.1)));
    table.rows.push_back({mechanics::title_of(mechanics::element_named(element)),
                          fmt::format("{:.2f}", moves.back())});
  }
  found.tables.push_back(std::move(table));
  const auto lacks = [&](mechanics::Element element) {
    return 1.0 - moves[static_cast<std::size_t>(element)] / moves.back();
  };
  found.checks.push_back(within(fmt::format("{}: share of the movement that P1/P1 lacks", name),
                                0.0, 0.25, lacks(mechanics::Element::P1P1), "",
                                "a pose may not be off by more than tissue a third stiffer"));
  found.checks.push_back(
      within(fmt::format("{}: share of the movement that smoothed P1/P1 lacks / P1/P1", name), 0.0,
             0.6, std::abs(lacks(mechanics::Element::Smoothed)) / lacks(mechanics::Element::P1P1),
             "", "averaged strains must be worth their time"));
}

void linear_cells(const Scratch& scratch, const Context& ctx, Findings& found) {
  compare_cells(make_patient(scratch, ctx), "built-in patient", ctx.part(0.0, 0.5), found);
  if (auto patient = make_development_patient(scratch)) {
    compare_cells(std::move(*patient), "dev01", ctx.part(0.5, 1.0), found);
  }
}

using Computation = void (*)(const Scratch&, const Context&, Findings&);
/// In a folder of its own, on one rank.
std::function<Findings(const Context&)> alone(Computation compute) {
  return [compute](const Context& ctx) {
    Findings found;
    if (fem::ranks() > 1) {
      found.skipped = "it runs on one rank only";
    } else {
      compute(Scratch{}, ctx, found);
    }
    return found;
  };
}

}  // namespace

void add_patient(std::vector<Case>& cases) {
  cases.push_back({"patient", "Clinical outputs of a patient: mesh and time",
                   Chapter::CalculationVerification, Cost::Full,
                   "The built-in patient from labels to outcome on meshes of about 2,000, 4,500 "
                   "and 10,000 vertices, and with mechanics every 12, 6 and 3 days. Error bars: "
                   "Richardson extrapolation as grid convergence index, safety factor 1.25.",
                   alone(convergence)});
  cases.push_back({"patient-cells", "A pose of a patient: linear, smoothed and quadratic cells",
                   Chapter::CalculationVerification, Cost::Full,
                   "The unloaded bodies of the built-in patient and of the development patient "
                   "dev01 (where the shared data are), `paper` mesh, lie down with P1/P1, "
                   "smoothed P1/P1 and P2/P1 on the same cells. P2/P1 is the reference: on "
                   "dev01 with uniform tissue it changes by 0.1 % from this mesh to one of twice "
                   "as many vertices "
                   "(`docs/theory/discretisation-error.md`). P1/P1 moves too little.",
                   alone(linear_cells)});
}

}  // namespace sanatrix::verification
