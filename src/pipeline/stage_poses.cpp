// Steps E and F: the stress-free shape behind the prone one, and the supine pose on the table.
#include <algorithm>
#include <iterator>

#include "pipeline/artefacts.hpp"
#include "pipeline/body.hpp"
#include "pipeline/model_share.hpp"
#include "pipeline/stages.hpp"

namespace sanatrix::pipeline {
namespace {

StageNotes notes_of(const mechanics::SolveReport& report, double moved_mm,
                    const ModelShare& model) {
  StageNotes notes;
  notes.numbers = {{"newton_iterations", report.newton_iterations},
                   {"krylov_iterations", report.krylov_iterations},
                   {"factorisations", report.factorisations},
                   {"load_steps", report.load_steps},
                   {"last_residual", report.last_residual},
                   {"min_jacobian", report.min_jacobian},
                   {"seconds_assembly", report.seconds_assembly},
                   {"seconds_linear", report.seconds_linear},
                   {"mean_move_mm", moved_mm}};
  std::ranges::copy(model.numbers(), std::back_inserter(notes.numbers));
  return notes;
}

}  // namespace

StageNotes run_unload(const StageInput& in) {
  const ModelShare model(in);
  mechanics::Solver solver(model.body(), solve_options(in.parameters()));
  const mechanics::Shape unloaded =
      model.collect(solver.inverse(solver.straight_nodes(model.body().mesh->points),
                                   gravity_captured(in.patient.scan_only()), in.ctx));
  double moved_mm = 0.0;
  if (in.writes) {
    const TetMesh& mesh = model.whole().mesh;
    const std::span<const Vec3> pose = vertices(mesh, unloaded);
    save_shape({unloaded, solver.last_report().min_jacobian}, in.out / "shape.bin");
    write_pose(model.whole(), pose, mesh.points, in.out / "unloaded.vtu");
    write_skin(mesh, pose, {}, in.out / "unloaded_skin.vtp");
    moved_mm = mean_move_mm(mesh, mesh.points, pose);
  }
  return notes_of(solver.last_report(), moved_mm, model);
}

StageNotes run_supine(const StageInput& in) {
  const ModelShare model(in);
  const mechanics::Shape unloaded = whole_shape(in, Stage::Unload);
  mechanics::Solver solver(model.body(), solve_options(in.parameters()));
  const mechanics::Shape supine = model.collect(
      solver.forward(model.distribute(unloaded).nodes, gravity_supine, nullptr, in.ctx));
  double moved_mm = 0.0;
  if (in.writes) {
    const TetMesh& mesh = model.whole().mesh;
    const std::span<const Vec3> from = vertices(mesh, unloaded);
    const std::span<const Vec3> pose = vertices(mesh, supine);
    save_shape({supine, solver.last_report().min_jacobian}, in.out / "shape.bin");
    write_pose(model.whole(), pose, from, in.out / "supine.vtu");
    write_skin(mesh, pose, {}, in.out / "supine_skin.vtp");
    moved_mm = mean_move_mm(mesh, from, pose);
  }
  return notes_of(solver.last_report(), moved_mm, model);
}

}  // namespace sanatrix::pipeline
