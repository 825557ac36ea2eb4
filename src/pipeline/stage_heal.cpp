// Step H: three months of healing on the operating table's pose, with checkpoints.
#include <algorithm>
#include <deque>
#include <future>
#include <iterator>
#include <optional>

#include "core/files.hpp"
#include "fem/session.hpp"
#include "pipeline/artefacts.hpp"
#include "pipeline/body.hpp"
#include "pipeline/healing_store.hpp"
#include "pipeline/model_share.hpp"
#include "pipeline/stages.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;

/// The checkpoint of the whole, on rank 0, from what every rank has of it.
recovery::Checkpoint collected(const ModelShare& model, recovery::Checkpoint mine, int species) {
  mine.species = model.collect_vertices(std::move(mine.species), species);
  mine.shape = model.collect(mine.shape);
  if (!mine.earlier.nodes.empty()) {
    mine.earlier = model.collect(mine.earlier);
  }
  return mine;
}

/// What rank 0 finds on disk, on every rank for its share.
std::optional<recovery::Checkpoint> found_checkpoint(const StageInput& in, const ModelShare& model,
                                                     int species) {
  const fs::path file = in.out / "checkpoint.bin";
  const bool here = in.writes && fs::exists(file);
  if (fem::largest(here ? 1.0 : 0.0) == 0.0) {
    return std::nullopt;
  }
  recovery::Checkpoint c = here ? load_checkpoint(file) : recovery::Checkpoint{};
  std::vector<double> numbers{c.t_s, c.wound_volume_m3, c.earlier_density,
                              c.earlier.nodes.empty() ? 0.0 : 1.0};
  std::ranges::copy(flatten(c.history), std::back_inserter(numbers));
  fem::broadcast(numbers);
  c.t_s = numbers[0];
  c.wound_volume_m3 = numbers[1];
  c.earlier_density = numbers[2];
  c.history = history_from(std::span(numbers).subspan(4), static_cast<std::size_t>(species));
  c.species = model.distribute_vertices(std::move(c.species), species);
  c.shape = model.distribute(c.shape);
  if (numbers[3] != 0.0) {
    c.earlier = model.distribute(c.earlier);
  }
  return c;
}

/// The shape of that day in the last good result, of another plan most likely, with the pressures
/// of the body before surgery, since frames have none. Where the mesh has changed it is not near,
/// and is not taken. Collective.
std::optional<mechanics::Shape> last_shape(const StageInput& in, const ModelShare& model,
                                           const mechanics::Shape& before, double t_day) {
  const fs::path file = in.from(Stage::Heal) / "frames" / (frame_name(t_day) + ".bin");
  mechanics::Shape last;
  if (in.writes && !in.anew && fs::exists(file)) {
    last = {load_frame(file).points, before.pressure};
  }
  const bool fits = in.writes && last.nodes.size() == before.nodes.size();
  if (fem::largest(fits ? 1.0 : 0.0) == 0.0) {
    return std::nullopt;
  }
  return model.distribute(last);
}

/// Writes frames and checkpoints; a frame comes before its checkpoint, so that a resumed run has
/// every frame. Frames are written on the side: compressing them takes a tenth of healing.
/// Collective.
class Keeper {
 public:
  /// wound_fraction, start: of the whole mesh, on rank 0.
  Keeper(const StageInput& in, const ModelShare& model, const healing::Model& biology,
         const std::vector<double>& wound_fraction, std::span<const Vec3> start)
      : in_(in), model_(model), biology_(biology), wound_(wound_fraction), start_(start) {}

  void observe(double t_day, std::span<const double> species, const mechanics::Shape& shape) {
    const std::vector<double> all =
        model_.collect_vertices({species.begin(), species.end()}, species_count());
    const mechanics::Shape whole = model_.collect(shape);
    if (in_.writes) {
      finish_frames(most_at_once - 1);
      frames_.push_back(std::async(std::launch::async, [this, t_day, all, whole] {
        write_frame(t_day, all, vertices(model_.whole().mesh, whole));
      }));
    }
  }
  void save(const recovery::Checkpoint& checkpoint) {
    const recovery::Checkpoint whole = collected(model_, checkpoint, species_count());
    finish_frames(0);
    if (in_.writes) {
      save_checkpoint(whole, in_.out / "checkpoint.bin");
    }
  }

 private:
  /// Waits until at most so many are being written.
  void finish_frames(std::size_t left) {
    while (frames_.size() > left) {
      frames_.front().get();
      frames_.pop_front();
    }
  }
  [[nodiscard]] int species_count() const { return static_cast<int>(biology_.species().size()); }

  void write_frame(double t_day, std::span<const double> species,
                   std::span<const Vec3> pose) const {
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
    io::write_vtu(model_.whole().mesh, pose, fields, frames / (frame_name(t_day) + ".vtu"),
                  io::LengthUnit::Millimetre);
    save_frame({t_day, {species.begin(), species.end()}, {pose.begin(), pose.end()}},
               frames / (frame_name(t_day) + ".bin"));
  }

  const StageInput& in_;
  const ModelShare& model_;
  const healing::Model& biology_;
  const std::vector<double>& wound_;
  std::span<const Vec3> start_;
  static constexpr std::size_t most_at_once = 2;
  std::deque<std::future<void>> frames_;  ///< that are being written
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

void write_results(const StageInput& in, const ModelShare& model, const recovery::Result& result,
                   const healing::Model& biology, double min_jacobian) {
  const mechanics::Shape healed = model.collect(result.healed);
  std::vector<double> tissue = model.collect_cells(flatten(result.tissue), numbers_per_tissue);
  if (!in.writes) {
    return;
  }
  save_shape({healed, min_jacobian}, in.out / "shape.bin");
  save_tissue(std::move(tissue), in.out / "tissue.bin");
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
                      .mechanics_density_change = p.number("heal.mechanics_density_change"),
                      .record_interval_days = p.number("heal.record_interval_days")};
  return problem;
}

}  // namespace

StageNotes run_heal(const StageInput& in) {
  const Parameters& p = in.parameters();
  const ModelShare model(in, wall_guard(in));
  const mechanics::Body& body = model.body();
  const auto biology = healing::make_model(p.text("heal.preset"), p.list("heal.overrides"));
  const mechanics::Shape before = whole_shape(in, Stage::Supine);
  const std::vector<double> wound_fraction =
      in.writes ? load_wound(in.from(Stage::Surgery) / "wound.bin").fraction
                : std::vector<double>{};
  const mechanics::Shape unloaded = model.distribute(whole_shape(in, Stage::Unload));
  const mechanics::Shape supine = model.distribute(before);

  recovery::Problem problem = make_problem(p, body, *biology);
  problem.reference_nodes = unloaded.nodes;
  problem.start = supine;
  problem.species_points = vertices(*body.mesh, supine);
  problem.wound_fraction = model.distribute_cells(wound_fraction, 1);
  problem.hint = [&](double t_day) {
    return last_shape(in, model, before, t_day);
  };
  const auto resume = found_checkpoint(in, model, static_cast<int>(biology->species().size()));
  if (resume) {
    in.ctx.at(0.0, "resuming from a checkpoint");
  }
  Keeper keeper(in, model, *biology, wound_fraction, vertices(model.whole().mesh, before));
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
  write_results(in, model, result, *biology, min_jacobian);
  StageNotes notes;
  notes.numbers = {{"wound_volume_ratio", result.history.back().volume_ratio},
                   {"min_jacobian", min_jacobian},
                   {"newton_iterations", result.totals.newton_iterations},
                   {"krylov_iterations", result.totals.krylov_iterations},
                   {"factorisations", result.totals.factorisations},
                   {"seconds_species", result.seconds_species},
                   {"seconds_mechanics", result.seconds_mechanics}};
  std::ranges::copy(model.numbers(), std::back_inserter(notes.numbers));
  return notes;
}

}  // namespace sanatrix::pipeline
