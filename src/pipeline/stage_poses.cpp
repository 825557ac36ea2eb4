// Steps E and F: the stress-free shape behind the prone one, and the supine pose on the table.
#include "pipeline/artefacts.hpp"
#include "pipeline/body.hpp"
#include "pipeline/stages.hpp"

namespace sanatrix::pipeline {
namespace {

StageNotes notes_of(const mechanics::SolveReport& report, double moved_mm) {
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
  return notes;
}

}  // namespace

StageNotes run_unload(const StageInput& in) {
  const meshing::BreastModel model = load_model(in.from(Stage::Mesh) / "model.bin");
  const mechanics::Body body = make_body(model, in.parameters());
  mechanics::Solver solver(body, solve_options(in.parameters()));
  const mechanics::Shape unloaded = solver.inverse(
      solver.straight_nodes(model.mesh.points), gravity_captured(in.patient.scan_only()), in.ctx);
  if (in.writes) {
    save_shape({unloaded, solver.last_report().min_jacobian}, in.out / "shape.bin");
    write_pose(model, vertices(model.mesh, unloaded), model.mesh.points, in.out / "unloaded.vtu");
    write_skin(model.mesh, vertices(model.mesh, unloaded), {}, in.out / "unloaded_skin.vtp");
  }
  return notes_of(solver.last_report(),
                  mean_move_mm(model.mesh, model.mesh.points, vertices(model.mesh, unloaded)));
}

StageNotes run_supine(const StageInput& in) {
  const meshing::BreastModel model = load_model(in.from(Stage::Mesh) / "model.bin");
  const mechanics::Shape unloaded = load_shape(in.from(Stage::Unload) / "shape.bin").shape;
  const mechanics::Body body = make_body(model, in.parameters());
  mechanics::Solver solver(body, solve_options(in.parameters()));
  const mechanics::Shape supine = solver.forward(unloaded.nodes, gravity_supine, nullptr, in.ctx);
  if (in.writes) {
    save_shape({supine, solver.last_report().min_jacobian}, in.out / "shape.bin");
    write_pose(model, vertices(model.mesh, supine), vertices(model.mesh, unloaded),
               in.out / "supine.vtu");
    write_skin(model.mesh, vertices(model.mesh, supine), {}, in.out / "supine_skin.vtp");
  }
  return notes_of(solver.last_report(), mean_move_mm(model.mesh, vertices(model.mesh, unloaded),
                                                     vertices(model.mesh, supine)));
}

}  // namespace sanatrix::pipeline
