// Steps E and F: the stress-free shape behind the prone one, and the supine pose on the table.
#include <algorithm>
#include <array>
#include <iterator>

#include "core/error.hpp"
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

/// Tried in this order until unloading converges; the chest wall's cells of hard anatomies fold in
/// the inverse problem long before the body does (ADR 18).
constexpr std::array wall_guards{1.0, 5.0, 10.0, 20.0};
/// All tries but the last give up here: what needs smaller steps ends at a fold.
constexpr double first_try_load_step = 0.2;

/// A shape without gravity and the report of how it was found.
struct Unloaded {
  mechanics::Shape shape;  ///< whole, on rank 0
  mechanics::SolveReport report;
};

StageNotes write_unloaded(const StageInput& in, const ModelShare& model, const Unloaded& found,
                          double guard) {
  double moved_mm = 0.0;
  if (in.writes) {
    const TetMesh& mesh = model.whole().mesh;
    const std::span<const Vec3> pose = vertices(mesh, found.shape);
    save_shape({found.shape, found.report.min_jacobian, guard}, in.out / "shape.bin");
    write_pose(model.whole(), pose, mesh.points, in.out / "unloaded.vtu");
    write_skin(mesh, pose, {}, in.out / "unloaded_skin.vtp");
    moved_mm = mean_move_mm(mesh, mesh.points, pose);
  }
  StageNotes notes = notes_of(found.report, moved_mm, model);
  notes.numbers.emplace_back("wall_guard", guard);
  if (guard > 1.0) {
    notes.warnings.push_back(fmt::format(
        "single cells on the chest wall folded and were stiffened against it (guard {:g}): the "
        "breast may move up to {} % too little between poses",
        guard, guard > 5.0 ? 10 : 4));
  }
  return notes;
}

Unloaded unload(const StageInput& in, const ModelShare& model, bool last_try) {
  mechanics::SolveOptions options = solve_options(in.parameters());
  options.smallest_load_step = last_try ? options.smallest_load_step : first_try_load_step;
  mechanics::Solver solver(model.body(), options);
  const std::vector<Vec3> imaged = solver.straight_nodes(model.body().mesh->points);
  const Vec3 gravity = gravity_captured(in.patient.scan_only());
  mechanics::Shape shape = model.collect(solver.inverse(imaged, gravity, in.ctx));
  return {std::move(shape), solver.last_report()};
}

}  // namespace

StageNotes run_unload(const StageInput& in) {
  // Taylor-Hood cells have no share of their own that could be raised.
  const bool one_try = element_of(in.parameters()) == mechanics::Element::P2P1;
  for (const double guard : wall_guards) {
    const bool last = one_try || guard == wall_guards.back();
    const ModelShare model(in, guard);
    try {
      return write_unloaded(in, model, unload(in, model, last), guard);
    } catch (const Error& e) {
      if (last || e.fault() != Fault::Numerics) {
        throw;
      }
      in.ctx.at(0.0, "cells on the chest wall fold; again with a guard against it");
    }
  }
  ensure(false, "no try of unloading was the last");
  return {};
}

StageNotes run_supine(const StageInput& in) {
  const ModelShare model(in, wall_guard(in));
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
