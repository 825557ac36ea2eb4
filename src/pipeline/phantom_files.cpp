#include "pipeline/phantom_files.hpp"

#include <tuple>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/image_file.hpp"
#include "outcome/outcome.hpp"
#include "outcome/scan_target.hpp"
#include "pipeline/artefacts.hpp"
#include "pipeline/standing_scan.hpp"

namespace sanatrix::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json half_volumes(const phantom::Phantom& p, std::span<const Vec3> points) {
  const std::vector<double> volumes = cell_volumes(p.mesh, points);
  std::array<double, 2> half{}, fibroglandular{};  // right, left
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    double x = 0.0;
    for (const int vertex : p.mesh.cells[c]) {
      x += p.mesh.points[static_cast<std::size_t>(vertex)][0];
    }
    half[x > 0 ? 1 : 0] += 1e6 * volumes[c];
    fibroglandular[x > 0 ? 1 : 0] += 1e6 * volumes[c] * p.fibroglandular[c];
  }
  return {{"R", {{"model", half[0]}, {"fibroglandular", fibroglandular[0]}}},
          {"L", {{"model", half[1]}, {"fibroglandular", fibroglandular[1]}}}};
}

/// The case's skin over both breasts (`side` 0) or one (-1 right, 1 left), from cells that belong
/// to a breast.
TriMesh breast_skin(const meshing::BreastModel& model, std::span<const Vec3> pose, int side) {
  std::vector<bool> used(model.mesh.points.size(), false);
  for (std::size_t c = 0; c < model.mesh.cells.size(); ++c) {
    for (const int vertex : model.mesh.cells[c]) {
      used[static_cast<std::size_t>(vertex)] =
          used[static_cast<std::size_t>(vertex)] ||
          (model.in_breast[c] && (side == 0 || model.side[c] == side));
    }
  }
  TetMesh breasts = model.mesh;
  std::erase_if(breasts.faces, [&](const BoundaryFace& face) {
    return !(used[static_cast<std::size_t>(face.vertex[0])] &&
             used[static_cast<std::size_t>(face.vertex[1])] &&
             used[static_cast<std::size_t>(face.vertex[2])]);
  });
  return extract_surface(breasts, pose, {"skin"}).mesh;
}

double largest_change_mm(const phantom::TrueSkin& skin) {
  double largest = 0.0;
  for (std::size_t v = 0; v < skin.upright.points.size(); ++v) {
    largest = std::max(largest, norm(skin.upright_after.points[v] - skin.upright.points[v]));
  }
  return 1e3 * largest;
}

TriMesh truth_of(const fs::path& phantom_folder, const std::string& name) {
  return io::read_surface_vtp(phantom_folder / "truth" / (name + "_skin.vtp"));
}

PoseScore pose_score(const std::string& name, const TriMesh& skin, const TriMesh& truth) {
  const outcome::SurfaceDistance d = outcome::surface_distance(skin, truth);
  return {name, 1e3 * d.mean, 1e3 * d.p50, 1e3 * d.p90, 1e3 * d.p95, 1e3 * d.max};
}

/// Why the case's result after surgery and the truth are of two different operations, or nothing.
std::string other_operation(const Case& patient, const fs::path& phantom_folder) {
  if (!patient.has_plan()) {
    return "the case has no plan";
  }
  if (!fs::exists(patient.stage_folder(Stage::Upright) / "after.bin")) {
    return "the case has not been run to the upright pose after surgery";
  }
  if (!fs::exists(phantom_folder / "truth/upright_after_skin.vtp")) {
    return "the phantom was written before its shape after surgery was part of the truth";
  }
  const surgery::Plan ours = patient.plan();
  const surgery::Plan theirs =
      surgery::read_plan(read_text(phantom_folder / "plan.json"), "plan.json");
  const auto shape = [](const surgery::Plan& p) {
    return std::tuple(p.side, p.frame, p.tumour_centre, p.tumour_radius, p.margin, p.clearance,
                      p.radius, p.axis, p.outline);
  };
  return shape(ours) == shape(theirs) ? "" : "the case's plan is not the phantom's";
}

/// Over the skin of the treated breast, from the case's vertices to the truth beside them.
ChangeScore change_score(const meshing::BreastModel& model, int side, std::span<const Vec3> before,
                         std::span<const Vec3> after, const TriMesh& true_before,
                         const TriMesh& true_after) {
  const TriMesh skin = breast_skin(model, before, side), later = breast_skin(model, after, side);
  const SurfaceTree tree(true_before);
  std::vector<double> wanted, found, error;
  for (std::size_t v = 0; v < skin.points.size(); ++v) {
    const SurfaceTree::Hit hit = tree.closest(skin.points[v]);
    const std::array<double, 3> w = outcome::weights_in(true_before, hit.triangle, hit.point);
    Vec3 moved{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto corner = static_cast<std::size_t>(
          true_before.triangles[static_cast<std::size_t>(hit.triangle)][k]);
      moved += w[k] * (true_after.points[corner] - true_before.points[corner]);
    }
    const Vec3 predicted = later.points[v] - skin.points[v];
    wanted.push_back(norm(moved));
    found.push_back(norm(predicted));
    error.push_back(norm(predicted - moved));
  }
  const std::vector<double> areas = outcome::vertex_areas(skin);
  const auto of_wanted = outcome::statistics(wanted, areas);
  const auto of_found = outcome::statistics(found, areas);
  const auto of_error = outcome::statistics(error, areas);
  return {1e3 * of_wanted.mean, 1e3 * of_wanted.max, 1e3 * of_found.mean, 1e3 * of_found.max,
          1e3 * of_error.mean,  1e3 * of_error.p95,  1e3 * of_error.max};
}

}  // namespace

void make_phantom_folder(const fs::path& folder) {
  std::error_code problem;
  fs::create_directories(folder / "truth", problem);
  if (problem) {
    throw Error(Fault::Resource,
                fmt::format("{}: the phantom's folder cannot be made: {}",
                            folder.filename().string(), problem.message()),
                "give another folder");
  }
}

std::string write_phantom(const phantom::Phantom& p, const phantom::Options& options,
                          const fs::path& folder) {
  make_phantom_folder(folder);
  io::write_labels(p.labels, folder / "labels.nii.gz");
  write_text(folder / "plan.json", p.plan_json);
  const fs::path truth = folder / "truth";
  io::Fields fields;
  fields.cell.push_back(io::scalar_field("fibroglandular_fraction", p.fibroglandular));
  io::write_vtu(p.mesh, p.mesh.points, fields, truth / "unloaded.vtu", io::LengthUnit::Millimetre);
  for (const auto& [name, skin] : {std::pair{"unloaded", &p.skin.unloaded},
                                   {"prone", &p.skin.prone},
                                   {"supine", &p.skin.supine},
                                   {"upright", &p.skin.upright},
                                   {"upright_after", &p.skin.upright_after}}) {
    io::write_vtp(*skin, {}, truth / fmt::format("{}_skin.vtp", name), io::LengthUnit::Millimetre);
    // Also as what a surface camera would deliver, for --scan and --followup.
    io::write_surface(*skin, truth / fmt::format("{}_skin.ply", name));
  }
  static const std::array density{"fatty", "scattered", "heterogeneous", "dense"};
  const json j{{"seed", options.seed},
               {"volume_cm3", options.volume_cm3},
               {"density", density[static_cast<std::size_t>(options.density)]},
               {"unloaded_cm3", half_volumes(p, p.mesh.points)},
               {"prone_cm3", half_volumes(p, p.prone)},
               {"excised_cm3", 1e6 * p.excised_m3},
               {"upright_after_max_mm", largest_change_mm(p.skin)},
               {"mesh", {{"vertices", p.mesh.points.size()}, {"cells", p.mesh.cells.size()}}}};
  std::string text = j.dump(2) + "\n";
  write_text(truth / "truth.json", text);
  return text;
}

Score score(const Case& patient, const fs::path& phantom_folder) {
  const meshing::BreastModel model = load_model(patient.stage_folder(Stage::Mesh) / "model.bin");
  const auto load = [&](Stage stage, const char* file) {
    return load_shape(patient.stage_folder(stage) / file);
  };
  // A case from the phantom's scan has its own frame.
  const Rigid to_case = patient.scan_only() ? load_standing_scan(patient).to_patient : Rigid{};
  const auto truth_in_case = [&](const std::string& name) {
    return moved(truth_of(phantom_folder, name), to_case);
  };
  Score result;
  const auto add = [&](const std::string& name, const std::string& truth,
                       std::span<const Vec3> pose) {
    result.poses.push_back(pose_score(name, breast_skin(model, pose, 0), truth_in_case(truth)));
  };
  const SolvedShape unloaded = load(Stage::Unload, "shape.bin");
  const SolvedShape supine = load(Stage::Supine, "shape.bin");
  const SolvedShape before = load(Stage::Upright, "before.bin");
  if (patient.scan_only()) {
    add("scanned", "upright", model.mesh.points);
  } else {
    add("prone", "prone", model.mesh.points);
  }
  add("unloaded", "unloaded", vertices(model.mesh, unloaded.shape));
  add("supine", "supine", vertices(model.mesh, supine.shape));
  add("upright", "upright", vertices(model.mesh, before.shape));
  result.note = other_operation(patient, phantom_folder);
  if (result.note.empty()) {
    const SolvedShape after = load(Stage::Upright, "after.bin");
    add("upright after surgery", "upright_after", vertices(model.mesh, after.shape));
    result.change =
        change_score(model, patient.plan().side == surgery::Side::Left ? 1 : -1,
                     vertices(model.mesh, before.shape), vertices(model.mesh, after.shape),
                     truth_in_case("upright"), truth_in_case("upright_after"));
  }
  return result;
}

}  // namespace sanatrix::pipeline
