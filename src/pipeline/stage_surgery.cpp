// Step G: what the plan removes, as a fraction of every cell.
#include <algorithm>

#include "core/error.hpp"
#include "core/files.hpp"
#include "pipeline/artefacts.hpp"
#include "pipeline/case_view.hpp"
#include "pipeline/level_set.hpp"
#include "pipeline/stages.hpp"

namespace sanatrix::pipeline {
namespace {

/// The plan as it is carried out. A standing breast hangs: what is straight and short in it bends
/// and runs far on the table. So of a plan made on a standing scan the tumour goes to the table
/// with the tissue, and the piece around it is laid there, as a surgeon would.
surgery::Plan carried_out(const Case& patient) {
  surgery::Plan plan = patient.plan();
  return plan.frame == surgery::Frame::Upright
             ? in_frame(plan, surgery::Frame::Supine, CaseView(patient))
             : plan;
}

}  // namespace

StageNotes run_surgery(const StageInput& in) {
  const surgery::Plan plan = carried_out(in.patient);
  const meshing::BreastModel model = load_model(in.from(Stage::Mesh) / "model.bin");
  const mechanics::Shape supine = load_shape(in.from(Stage::Supine) / "shape.bin").shape;
  const std::span<const Vec3> supine_points = vertices(model.mesh, supine);
  // Fractions belong to cells: a plan drawn in prone travels to the table with the tissue.
  const std::span<const Vec3> pose = plan.frame == surgery::Frame::Supine
                                         ? supine_points
                                         : std::span<const Vec3>(model.mesh.points);
  const surgery::Wound wound = surgery::resect(plan, model.mesh, pose, model.midline_x_m, in.ctx);
  if (std::ranges::none_of(wound.fraction, [](double f) { return f >= 0.5; })) {
    throw Error(Fault::Input, "the planned resection is smaller than the elements of the mesh",
                "set a larger margin or a smaller mesh.near_edge_mm");
  }
  save_wound(wound, in.out / "wound.bin");
  write_text(in.out / "plan.json", surgery::write_plan(plan));

  io::Fields fields;
  fields.cell.push_back(io::scalar_field("wound_fraction", wound.fraction));
  fields.cell.push_back(io::scalar_field("fibroglandular_fraction", model.fibroglandular));
  io::write_vtu(model.mesh, supine_points, fields, in.out / "wound.vtu",
                io::LengthUnit::Millimetre);
  io::write_vtp(level_set(model.mesh, supine_points,
                          to_vertices(model.mesh, supine_points, wound.fraction), 0.5),
                {}, in.out / "wound_surface.vtp", io::LengthUnit::Millimetre);
  std::vector<double> incision(model.mesh.points.size(), 0.0);
  for (const std::vector<int>& line : wound.incision_vertices) {
    for (const int vertex : line) {
      incision[static_cast<std::size_t>(vertex)] = 1.0;
    }
  }
  io::Fields marks;
  marks.point.push_back(io::scalar_field("incision", incision));
  write_skin(model.mesh, supine_points, marks, in.out / "incision.vtp");
  StageNotes notes;
  notes.warnings = wound.warnings;
  notes.numbers = {{"excised_cm3", 1e6 * wound.excised_m3},
                   {"exact_cm3", 1e6 * wound.exact_m3},
                   {"min_skin_distance_mm", 1e3 * wound.min_skin_distance_m},
                   {"min_chest_distance_mm", 1e3 * wound.min_chest_distance_m}};
  return notes;
}

}  // namespace sanatrix::pipeline
