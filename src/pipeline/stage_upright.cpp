// Step J: the standing patient before surgery and with the healed tissue.
#include <algorithm>
#include <optional>

#include "core/archive.hpp"
#include "pipeline/artefacts.hpp"
#include "pipeline/body.hpp"
#include "pipeline/healing_store.hpp"
#include "pipeline/stages.hpp"

namespace sanatrix::pipeline {
namespace {

/// The pose before surgery from the last good result, if nothing changed that it depends on.
std::optional<SolvedShape> kept_before(const StageInput& in, const std::string& key) {
  const std::filesystem::path folder = in.from(Stage::Upright);
  if (!std::filesystem::exists(folder / "before_key.bin") ||
      !std::filesystem::exists(folder / "before.bin")) {
    return std::nullopt;
  }
  const Archive archive = Archive::load(folder / "before_key.bin");
  if (const auto entry = archive.texts.find("key");
      entry == archive.texts.end() || entry->second != key) {
    return std::nullopt;
  }
  return load_shape(folder / "before.bin");
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
  const meshing::BreastModel model = load_model(in.from(Stage::Mesh) / "model.bin");
  const mechanics::Shape unloaded = load_shape(in.from(Stage::Unload) / "shape.bin").shape;
  const mechanics::Body body = make_body(model, in.parameters());
  mechanics::Solver solver(body, solve_options(in.parameters()));
  StageNotes notes;
  std::optional<SolvedShape> before;
  if (!in.anew) {
    before = kept_before(in, upright_before_key(in.patient));
  }
  if (!before) {
    const Context part = in.ctx.part(0.0, 0.6);
    before = {solver.forward(unloaded.nodes, gravity_upright, nullptr, part),
              solver.last_report().min_jacobian};
    add_counts(notes, "before", solver.last_report());
  }
  notes.numbers.emplace_back("min_jacobian_before", before->min_jacobian);
  notes.numbers.emplace_back("mean_move_mm",
                             mean_move_mm(model.mesh, vertices(model.mesh, unloaded),
                                          vertices(model.mesh, before->shape)));
  if (in.writes) {
    write_before(in, model, *before, vertices(model.mesh, unloaded));
  }
  if (!in.patient.has_plan()) {
    return notes;
  }
  solver.set_tissue(load_tissue(in.from(Stage::Heal) / "tissue.bin"));
  const Context part = in.ctx.part(0.6, 1.0);
  SolvedShape after{solver.forward(unloaded.nodes, gravity_upright, &before->shape, part)};
  after.min_jacobian = solver.last_report().min_jacobian;
  if (in.writes) {
    write_after(in, model, after, *before);
  }
  add_counts(notes, "after", solver.last_report());
  notes.numbers.emplace_back("min_jacobian_after", after.min_jacobian);
  return notes;
}

}  // namespace sanatrix::pipeline
