#include "pipeline/phantom_files.hpp"

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/image_file.hpp"
#include "outcome/outcome.hpp"
#include "pipeline/artefacts.hpp"

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

/// The case's skin over both breasts, from cells that belong to a breast.
TriMesh breast_skin(const meshing::BreastModel& model, std::span<const Vec3> pose) {
  std::vector<bool> used(model.mesh.points.size(), false);
  for (std::size_t c = 0; c < model.mesh.cells.size(); ++c) {
    for (const int vertex : model.mesh.cells[c]) {
      used[static_cast<std::size_t>(vertex)] =
          used[static_cast<std::size_t>(vertex)] || model.in_breast[c];
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

}  // namespace

std::string write_phantom(const phantom::Phantom& p, const phantom::Options& options,
                          const fs::path& folder) {
  std::error_code problem;
  fs::create_directories(folder / "truth", problem);
  if (problem) {
    throw Error(Fault::Resource,
                fmt::format("the phantom's folder cannot be made: {}", problem.message()));
  }
  io::write_labels(p.labels, folder / "labels.nii.gz");
  write_text(folder / "plan.json", p.plan_json);
  const fs::path truth = folder / "truth";
  io::Fields fields;
  fields.cell.push_back(io::scalar_field("fibroglandular_fraction", p.fibroglandular));
  io::write_vtu(p.mesh, p.mesh.points, fields, truth / "unloaded.vtu", io::LengthUnit::Millimetre);
  for (const auto& [name, skin] : {std::pair{"unloaded", &p.skin.unloaded},
                                   {"prone", &p.skin.prone},
                                   {"supine", &p.skin.supine},
                                   {"upright", &p.skin.upright}}) {
    io::write_vtp(*skin, {}, truth / fmt::format("{}_skin.vtp", name), io::LengthUnit::Millimetre);
    // Also as what a surface camera would deliver, for --scan.
    io::write_surface(*skin, truth / fmt::format("{}_skin.ply", name));
  }
  static const std::array density{"fatty", "scattered", "heterogeneous", "dense"};
  const json j{{"seed", options.seed},
               {"volume_cm3", options.volume_cm3},
               {"density", density[static_cast<std::size_t>(options.density)]},
               {"unloaded_cm3", half_volumes(p, p.mesh.points)},
               {"prone_cm3", half_volumes(p, p.prone)},
               {"mesh", {{"vertices", p.mesh.points.size()}, {"cells", p.mesh.cells.size()}}}};
  const std::string text = j.dump(2) + "\n";
  write_text(truth / "truth.json", text);
  return text;
}

std::vector<PoseScore> score(const Case& patient, const fs::path& phantom_folder) {
  struct Pose {
    std::string name;
    Stage stage;
    std::string file;
  };
  const std::vector<Pose> poses{{"unloaded", Stage::Unload, "shape.bin"},
                                {"supine", Stage::Supine, "shape.bin"},
                                {"upright", Stage::Upright, "before.bin"}};
  const meshing::BreastModel model = load_model(patient.stage_folder(Stage::Mesh) / "model.bin");
  const auto measure = [&](const std::string& name, std::span<const Vec3> pose) {
    const TriMesh truth = io::read_surface_vtp(phantom_folder / "truth" / (name + "_skin.vtp"));
    const outcome::SurfaceDistance d = outcome::surface_distance(breast_skin(model, pose), truth);
    return PoseScore{name, 1e3 * d.mean, 1e3 * d.p50, 1e3 * d.p90, 1e3 * d.p95, 1e3 * d.max};
  };
  std::vector<PoseScore> scores{measure("prone", model.mesh.points)};
  for (const Pose& pose : poses) {
    const SolvedShape solved = load_shape(patient.stage_folder(pose.stage) / pose.file);
    scores.push_back(measure(pose.name, vertices(model.mesh, solved.shape)));
  }
  return scores;
}

}  // namespace sanatrix::pipeline
