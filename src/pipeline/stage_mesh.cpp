// Steps C and D: the two-breast tetrahedral model of the prone patient.
#include "pipeline/artefacts.hpp"
#include "pipeline/focus.hpp"
#include "pipeline/segmentation_store.hpp"
#include "pipeline/stages.hpp"

namespace sanatrix::pipeline {
namespace {

struct MeshPreset {
  int vertices;
  double near_edge_m;
};
constexpr MeshPreset standard_mesh{10000, 0.003}, paper_mesh{5000, 0.004};

}  // namespace

meshing::MeshOptions mesh_options(const Parameters& p) {
  const MeshPreset& preset = p.text("mesh.preset") == "paper" ? paper_mesh : standard_mesh;
  meshing::MeshOptions options;
  options.target_vertices =
      p.has("mesh.target_vertices") ? p.integer("mesh.target_vertices") : preset.vertices;
  options.near_edge_m =
      p.has("mesh.near_edge_mm") ? 1e-3 * p.number("mesh.near_edge_mm") : preset.near_edge_m;
  options.far_edge_m = 1e-3 * p.number("mesh.far_edge_mm");
  options.slab_half_height_m = 1e-3 * p.number("mesh.slab_half_height_mm");
  options.time_limit_s = p.number("mesh.time_limit_s");
  return options;
}

StageNotes run_mesh(const StageInput& in) {
  const imaging::Segmentation labels = load_segmentation(in.from(Stage::Segment));
  StageNotes notes;
  meshing::MeshOptions options = mesh_options(in.parameters());
  options.standing = in.patient.scan_only();
  if (in.patient.focus) {
    options.focus = place(*in.patient.focus, labels.labels, labels.midline_x_mm);
    if (!options.focus) {
      notes.warnings.push_back(
          "the plan is drawn in supine and the labels hold no tumour: the mesh is not refined "
          "around the resection");
    }
  }
  const meshing::BreastModel model = meshing::mesh_breasts(
      labels.labels, labels.fibroglandular, labels.midline_x_mm, labels.nipple_mm, options, in.ctx);
  save_model(model, in.out / "model.bin");
  const std::string pose = in.patient.scan_only() ? "scanned" : "prone";
  write_pose(model, model.mesh.points, model.mesh.points, in.out / (pose + ".vtu"));
  write_skin(model.mesh, model.mesh.points, {}, in.out / (pose + "_skin.vtp"));
  const meshing::MeshQuality quality = meshing::measure_quality(model, options.focus);
  notes.warnings.insert(notes.warnings.end(), model.warnings.begin(), model.warnings.end());
  notes.numbers = {{"vertices", static_cast<double>(model.mesh.points.size())},
                   {"cells", static_cast<double>(model.mesh.cells.size())},
                   {"min_dihedral_deg", quality.min_dihedral_deg},
                   {"p01_dihedral_deg", quality.p01_dihedral_deg},
                   {"min_edge_mm", 1e3 * quality.min_edge_m},
                   {"mean_edge_mm", 1e3 * quality.mean_edge_m},
                   {"max_edge_mm", 1e3 * quality.max_edge_m},
                   {"mean_edge_in_focus_mm", 1e3 * quality.mean_edge_in_focus_m},
                   {"skin_roughness_deg", quality.skin_roughness_deg}};
  return notes;
}

}  // namespace sanatrix::pipeline
