// Step H: three months of healing on the operating table's pose, with checkpoints.
#include <algorithm>
#include <optional>

#include "core/files.hpp"
#include "pipeline/artefacts.hpp"
#include "pipeline/body.hpp"
#include "pipeline/healing_store.hpp"
#include "pipeline/stages.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;

/// Writes frames and checkpoints; a frame comes before its checkpoint, so that a resumed run has
/// every frame.
class Keeper {
 public:
  Keeper(const StageInput& in, const meshing::BreastModel& model, const healing::Model& biology,
         const std::vector<double>& wound_fraction, std::vector<Vec3> start)
      : in_(in),
        model_(model),
        biology_(biology),
        wound_(wound_fraction),
        start_(std::move(start)) {}

  void observe(double t_day, std::span<const double> species, const mechanics::Shape& shape) {
    if (in_.writes) {
      write_frame(t_day, species, vertices(model_.mesh, shape));
    }
  }
  void save(const recovery::Checkpoint& checkpoint) {
    if (in_.writes) {
      save_checkpoint(checkpoint, in_.out / "checkpoint.bin");
    }
  }

 private:
  void write_frame(double t_day, std::span<const double> species, std::span<const Vec3> pose) {
    const std::size_t n = biology_.species().size();
    io::Fields fields;
    for (std::size_t s = 0; s < n; ++s) {
      std::vector<double> values;
      for (std::size_t i = s; i < species.size(); i += n) {
        values.push_back(species[i]);
      }
      fields.point.push_back(io::scalar_field(biology_.species()[s].key, std::move(values)));
    }
    fields.point.push_back(displacement_mm(start_, pose));
    fields.cell.push_back(io::scalar_field("wound_fraction", wound_));
    const fs::path frames = in_.out / "frames";
    fs::create_directories(frames);
    io::write_vtu(model_.mesh, pose, fields, frames / (frame_name(t_day) + ".vtu"),
                  io::LengthUnit::Millimetre);
    save_frame({t_day, {species.begin(), species.end()}, {pose.begin(), pose.end()}},
               frames / (frame_name(t_day) + ".bin"));
  }

  const StageInput& in_;
  const meshing::BreastModel& model_;
  const healing::Model& biology_;
  const std::vector<double>& wound_;
  std::vector<Vec3> start_;
};

void write_series(const fs::path& folder) {
  std::vector<std::pair<double, std::string>> steps;
  for (const auto& entry : fs::directory_iterator(folder / "frames")) {
    if (entry.path().extension() == ".bin") {
      const std::string name = entry.path().stem().string();
      steps.emplace_back(load_frame(entry.path()).t_day, "frames/" + name + ".vtu");
    }
  }
  std::ranges::sort(steps);
  io::write_pvd(steps, folder / "healing.pvd");
}

void write_results(const StageInput& in, const recovery::Result& result,
                   const healing::Model& biology, double min_jacobian) {
  save_shape({result.healed, min_jacobian}, in.out / "shape.bin");
  save_tissue(result.tissue, in.out / "tissue.bin");
  save_history(result.history, in.out / "history.bin");
  write_text(in.out / "history.csv", recovery::history_csv(result.history, biology));
  write_series(in.out);
}

recovery::Problem make_problem(const Parameters& p, const mechanics::Body& body,
                               const healing::Model& biology) {
  recovery::Problem problem;
  problem.body = &body;
  problem.gravity = gravity_supine;
  problem.model = &biology;
  problem.species_options = {.scheme = p.text("heal.scheme") == "explicit"
                                           ? healing::Scheme::Explicit
                                           : healing::Scheme::Cvode,
                             .relative_tolerance = p.number("heal.relative_tolerance"),
                             .dt_s = p.number("heal.dt_s")};
  problem.schedule = {.days = p.number("heal.days"),
                      .mechanics_interval_days = p.number("heal.mechanics_interval_days"),
                      .record_interval_days = p.number("heal.record_interval_days")};
  return problem;
}

}  // namespace

StageNotes run_heal(const StageInput& in) {
  const Parameters& p = in.parameters();
  const meshing::BreastModel model = load_model(in.from(Stage::Mesh) / "model.bin");
  const mechanics::Shape unloaded = load_shape(in.from(Stage::Unload) / "shape.bin").shape;
  const mechanics::Shape supine = load_shape(in.from(Stage::Supine) / "shape.bin").shape;
  const surgery::Wound wound = load_wound(in.from(Stage::Surgery) / "wound.bin");
  const mechanics::Body body = make_body(model, p);
  const auto biology = healing::make_model(p.text("heal.preset"), p.list("heal.overrides"));
  const std::span<const Vec3> supine_points = vertices(model.mesh, supine);

  recovery::Problem problem = make_problem(p, body, *biology);
  problem.reference_nodes = unloaded.nodes;
  problem.start = supine;
  problem.species_points = supine_points;
  problem.wound_fraction = wound.fraction;
  std::optional<recovery::Checkpoint> resume;
  if (fs::exists(in.out / "checkpoint.bin")) {
    resume = load_checkpoint(in.out / "checkpoint.bin");
    in.ctx.at(0.0, "resuming from a checkpoint");
  }
  Keeper keeper(in, model, *biology, wound.fraction, {supine_points.begin(), supine_points.end()});
  const recovery::Result result = recovery::heal(
      problem, resume, [&](const recovery::Checkpoint& c) { keeper.save(c); },
      [&](double t_day, std::span<const double> species, const mechanics::Shape& shape) {
        keeper.observe(t_day, species, shape);
      },
      in.ctx);

  double min_jacobian = 1.0;
  for (const recovery::HistoryRow& row : result.history) {
    min_jacobian = std::min(min_jacobian, row.min_jacobian);
  }
  if (in.writes) {
    write_results(in, result, *biology, min_jacobian);
  }
  StageNotes notes;
  notes.numbers = {{"wound_volume_ratio", result.history.back().volume_ratio},
                   {"min_jacobian", min_jacobian},
                   {"newton_iterations", result.totals.newton_iterations},
                   {"krylov_iterations", result.totals.krylov_iterations},
                   {"factorisations", result.totals.factorisations},
                   {"seconds_species", result.seconds_species},
                   {"seconds_mechanics", result.seconds_mechanics}};
  return notes;
}

}  // namespace sanatrix::pipeline
