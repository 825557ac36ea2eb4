// Steps C and D: the two-breast tetrahedral model of the prone patient.
#include <fmt/format.h>

#include "pipeline/artefacts.hpp"
#include "pipeline/focus.hpp"
#include "pipeline/segmentation_store.hpp"
#include "pipeline/stages.hpp"
#include "pipeline/standing_scan.hpp"
#include "standing/skin_check.hpp"

namespace sanatrix::pipeline {
namespace {

struct MeshPreset {
  int vertices;
  double near_edge_m;
};
constexpr MeshPreset standard_mesh{10000, 0.003}, paper_mesh{5000, 0.004};

/// A model made of a scan must stand as in the scan; where it does not is said.
void check_skin(const StageInput& in, const TetMesh& mesh, StageNotes& notes) {
  constexpr double most_m = 0.004;  // twice the rounding of labels, iso-surface and usual edges
  std::vector<Vec3> skin;
  for (const int v : vertices_on(mesh, "skin")) {
    skin.push_back(mesh.points[static_cast<std::size_t>(v)]);
  }
  const standing::SkinDistance off =
      standing::distance_from_scan(skin, load_standing_scan(in.patient).skin);
  notes.numbers.emplace_back("skin_from_scan_p95_mm", 1e3 * off.p95);
  notes.numbers.emplace_back("skin_from_scan_max_mm", 1e3 * off.largest);
  if (off.largest > most_m) {
    const Vec3 at = 1e3 * off.worst;
    notes.warnings.push_back(
        fmt::format("the model's skin is up to {:.1f} mm away from the scan, at {:.0f} {:.0f} "
                    "{:.0f} mm: look at the scan there",
                    1e3 * off.largest, at[0], at[1], at[2]));
  }
}

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
  if (in.patient.scan_only()) {
    check_skin(in, model.mesh, notes);
  }
  return notes;
}

}  // namespace sanatrix::pipeline
