// Step J: the standing patient before surgery and with the healed tissue.
#include <algorithm>
#include <iterator>
#include <optional>

#include "core/archive.hpp"
#include "fem/session.hpp"
#include "pipeline/artefacts.hpp"
#include "pipeline/body.hpp"
#include "pipeline/healing_store.hpp"
#include "pipeline/model_share.hpp"
#include "pipeline/stages.hpp"

namespace sanatrix::pipeline {
namespace {

/// Was the last good result's pose before surgery made from what it would be made from now?
bool is_kept(const std::filesystem::path& folder, const std::string& key) {
  if (!std::filesystem::exists(folder / "before_key.bin") ||
      !std::filesystem::exists(folder / "before.bin")) {
    return false;
  }
  const Archive archive = Archive::load(folder / "before_key.bin");
  const auto entry = archive.texts.find("key");
  return entry != archive.texts.end() && entry->second == key;
}

/// The pose before surgery from the last good result, if nothing changed that it depends on; rank 0
/// decides and alone reads it. Collective.
std::optional<SolvedShape> kept_before(const StageInput& in, const std::string& key) {
  const std::filesystem::path folder = in.from(Stage::Upright);
  const bool kept = in.writes && !in.anew && is_kept(folder, key);
  if (fem::largest(kept ? 1.0 : 0.0) == 0.0) {
    return std::nullopt;
  }
  return in.writes ? load_shape(folder / "before.bin") : SolvedShape{};
}

/// The pose after healing of the last good result, of another plan most likely. Where the mesh has
/// changed it is not near. Collective.
std::optional<mechanics::Shape> last_after(const StageInput& in, const ModelShare& model,
                                           const mechanics::Shape& unloaded) {
  const std::filesystem::path file = in.from(Stage::Upright) / "after.bin";
  mechanics::Shape last;
  if (in.writes && !in.anew && std::filesystem::exists(file)) {
    last = load_shape(file).shape;
  }
  const bool fits = in.writes && last.nodes.size() == unloaded.nodes.size();
  if (fem::largest(fits ? 1.0 : 0.0) == 0.0) {
    return std::nullopt;
  }
  return model.distribute(last);
}

void write_before(const StageInput& in, const meshing::BreastModel& model,
                  const SolvedShape& before, std::span<const Vec3> unloaded) {
  Archive key;
  key.texts["key"] = upright_before_key(in.patient);
  key.save(in.out / "before_key.bin");
  save_shape(before, in.out / "before.bin");
  const std::span<const Vec3> pose = vertices(model.mesh, before.shape);
  write_pose(model, pose, unloaded, in.out / "upright_before.vtu");
  write_skin(model.mesh, pose, {}, in.out / "upright_before_skin.vtp");
}

void write_after(const StageInput& in, const meshing::BreastModel& model, const SolvedShape& after,
                 const SolvedShape& before) {
  save_shape(after, in.out / "after.bin");
  const std::span<const Vec3> pose = vertices(model.mesh, after.shape);
  const std::span<const Vec3> was = vertices(model.mesh, before.shape);
  write_pose(model, pose, was, in.out / "upright_after.vtu");
  io::Fields moved;
  moved.point.push_back(displacement_mm(was, pose));
  write_skin(model.mesh, pose, moved, in.out / "upright_after_skin.vtp");
}

void add_counts(StageNotes& notes, const std::string& pose, const mechanics::SolveReport& report) {
  notes.numbers.emplace_back("newton_iterations_" + pose, report.newton_iterations);
  notes.numbers.emplace_back("krylov_iterations_" + pose, report.krylov_iterations);
}

}  // namespace

std::string upright_before_key(const Case& patient) {
  Recipe made = recipe(patient, Stage::Upright);
  made.entries.erase("stage heal");
  return made.fingerprint();
}

StageNotes run_upright(const StageInput& in) {
  const ModelShare model(in, wall_guard(in));
  const mechanics::Shape unloaded = whole_shape(in, Stage::Unload);
  const std::vector<Vec3> at_rest = model.distribute(unloaded).nodes;
  mechanics::Solver solver(model.body(), solve_options(in.parameters()));
  StageNotes notes;
  SolvedShape before;
  mechanics::Shape mine;
  if (const auto kept = kept_before(in, upright_before_key(in.patient))) {
    before = *kept;
    mine = model.distribute(before.shape);
  } else {
    mine = solver.forward(at_rest, gravity_upright, nullptr, in.ctx.part(0.0, 0.6));
    before = {model.collect(mine), solver.last_report().min_jacobian};
    add_counts(notes, "before", solver.last_report());
  }
  notes.numbers.emplace_back("min_jacobian_before", before.min_jacobian);
  if (in.writes) {
    const std::span<const Vec3> from = vertices(model.whole().mesh, unloaded);
    notes.numbers.emplace_back(
        "mean_move_mm",
        mean_move_mm(model.whole().mesh, from, vertices(model.whole().mesh, before.shape)));
    write_before(in, model.whole(), before, from);
  }
  std::ranges::copy(model.numbers(), std::back_inserter(notes.numbers));
  if (!in.patient.has_plan()) {
    return notes;
  }
  solver.set_tissue(tissue_from(model.distribute_cells(
      in.writes ? load_tissue(in.from(Stage::Heal) / "tissue.bin") : std::vector<double>{},
      numbers_per_tissue)));
  if (const auto last = last_after(in, model, unloaded);
      last && solver.misfit(at_rest, gravity_upright, *last) <
                  solver.misfit(at_rest, gravity_upright, mine)) {
    mine = *last;
  }
  mine = solver.forward(at_rest, gravity_upright, &mine, in.ctx.part(0.6, 1.0));
  const SolvedShape after{model.collect(mine), solver.last_report().min_jacobian};
  if (in.writes) {
    write_after(in, model.whole(), after, before);
  }
  add_counts(notes, "after", solver.last_report());
  notes.numbers.emplace_back("min_jacobian_after", after.min_jacobian);
  return notes;
}

}  // namespace sanatrix::pipeline
