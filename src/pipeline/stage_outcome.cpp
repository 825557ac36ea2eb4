// What the surgeon reads: outcome.json, the tissue table, the figures' data and pictures.
#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/files.hpp"
#include "outcome/discretisation.hpp"
#include "outcome/outcome.hpp"
#include "pipeline/body.hpp"
#include "pipeline/cosmetics.hpp"
#include "pipeline/result.hpp"
#include "pipeline/scans.hpp"
#include "pipeline/stages.hpp"
#include "pipeline/wall_range.hpp"

namespace sanatrix::pipeline {
namespace {

using nlohmann::json;
using Volumes = std::array<outcome::TissueVolumes, 2>;  // [0] right, [1] left
constexpr auto scan_poses = "scan_poses.bin";
constexpr std::array side_letter{"R", "L"};

/// Vertices of the operated breast.
std::vector<bool> operated_vertices(const CaseResult& result) {
  const TetMesh& mesh = result.model.mesh;
  std::vector<bool> used(mesh.points.size(), false);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (result.model.in_breast[c] && result.model.side[c] == result.side()) {
      for (const int vertex : mesh.cells[c]) {
        used[static_cast<std::size_t>(vertex)] = true;
      }
    }
  }
  return used;
}

double skin_mass_g(const CaseResult& result, const mechanics::Skin& skin) {
  const Surface surface =
      extract_surface(result.model.mesh, result.points(result.unloaded), {"skin"});
  return 1e3 * surface_area(surface.mesh) * skin.thickness * skin.density;
}

std::string tissue_table(const Volumes& volumes, double mass_g) {
  std::string text =
      "side,breast_cm3,adipose_cm3,fibroglandular_cm3,fibroglandular_to_adipose,model_cm3\n";
  for (const std::size_t side : {1U, 0U}) {
    const outcome::TissueVolumes& v = volumes[side];
    text += fmt::format("{},{:.2f},{:.2f},{:.2f},{:.4f},{:.2f}\n", side_letter[side], v.breast_cm3,
                        v.adipose_cm3, v.fibroglandular_cm3, v.fibroglandular_cm3 / v.adipose_cm3,
                        v.model_cm3);
  }
  return text + fmt::format("skin_mass_g,{:.1f},,,,\n", mass_g);
}

std::string volume_history(const CaseResult& result) {
  std::string text = "t_day,wound_volume_ratio,max_displacement_mm\n";
  for (const recovery::HistoryRow& row : result.history) {
    text += fmt::format("{},{:.6f},{:.4f}\n", row.species.t_day, row.volume_ratio,
                        row.max_displacement_mm);
  }
  return text;
}

json collect_warnings(const Case& patient) {
  json warnings = json::array();
  for (const StageInfo& stage : all_stages()) {
    const auto record = stage.id == Stage::Outcome ? std::nullopt : read_record(patient, stage.id);
    for (const std::string& warning : record ? record->warnings : std::vector<std::string>{}) {
      warnings.push_back(stage.name + ": " + warning);
    }
  }
  return warnings;
}

json collect_seconds(const Case& patient) {
  json seconds = json::object();
  for (const StageInfo& stage : all_stages()) {
    if (const auto record = read_record(patient, stage.id); record && stage.id != Stage::Outcome) {
      seconds[stage.name] = record->seconds;
    }
  }
  return seconds;
}

/// Of the change of shape by surgery and healing, over the operated breast.
json discretisation_error(const CaseResult& result, const outcome::SkinDisplacement& moved) {
  const TetMesh& mesh = result.model.mesh;
  const auto before = result.points(result.before);
  const auto after = result.points(result.after);
  std::vector<Vec3> change(before.size());
  std::ranges::transform(after, before, change.begin(),
                         [](const Vec3& a, const Vec3& b) { return a - b; });
  std::vector<bool> used(mesh.cells.size());
  for (std::size_t c = 0; c < used.size(); ++c) {
    used[c] = result.model.in_breast[c] && result.model.side[c] == result.side();
  }
  const double relative = outcome::relative_displacement_error(mesh, before, change, used);
  return {{"relative", relative},
          {"max_displacement_upright_mm", relative * moved.max_mm},
          {"mean_displacement_upright_mm", relative * moved.mean_mm},
          {"method",
           "recovered gradients (Zienkiewicz-Zhu), squared; mesh error of the change of "
           "shape, without the errors of images, labels and tissue"}};
}

/// When half of the final change of the wound's volume has happened; 0 when nothing changes.
double half_contraction_day(const std::vector<recovery::HistoryRow>& history) {
  const double half = 0.5 * (1.0 + history.back().volume_ratio);
  const bool shrinks = history.back().volume_ratio < 1.0;
  for (std::size_t i = 1; i < history.size(); ++i) {
    const double before = history[i - 1].volume_ratio;
    const double now = history[i].volume_ratio;
    if (before != now && (shrinks ? now <= half : now >= half)) {
      return std::lerp(history[i - 1].species.t_day, history[i].species.t_day,
                       (half - before) / (now - before));
    }
  }
  return 0.0;
}

double min_jacobian(const CaseResult& r) {
  return std::min({r.unloaded.min_jacobian, r.supine.min_jacobian, r.healed.min_jacobian,
                   r.before.min_jacobian, r.after.min_jacobian});
}

json outcome_json(const Case& patient, const CaseResult& result, const Volumes& volumes,
                  double mass_g) {
  const TetMesh& mesh = result.model.mesh;
  const outcome::SkinDisplacement moved = outcome::skin_displacement(
      mesh, result.points(result.before), result.points(result.after), operated_vertices(result));
  const std::size_t side = result.side() > 0 ? 1 : 0;
  const double excised_cm3 = 1e6 * result.wound.excised_m3;
  json j{{"format", "sanatrix-outcome"},
         {"case", patient.pseudonym},
         {"notice", "research use only, not a medical device"},
         {"operated_side", side_letter[side]},
         {"breast_volume_cm3", json::object()},
         {"tissue_cm3", json::object()},
         {"excised_cm3", excised_cm3},
         {"excised_exact_cm3", 1e6 * result.wound.exact_m3},
         {"excised_percent", 100 * excised_cm3 / volumes[side].breast_cm3},
         {"resection_to_skin_mm", 1e3 * result.wound.min_skin_distance_m},
         {"resection_to_chest_mm", 1e3 * result.wound.min_chest_distance_m},
         {"wound_volume_ratio_final", result.history.back().volume_ratio},
         {"wound_half_contraction_day", half_contraction_day(result.history)},
         {"max_displacement_upright_mm", moved.max_mm},
         {"mean_displacement_upright_mm", moved.mean_mm},
         {"discretisation_error", discretisation_error(result, moved)},
         {"min_jacobian", min_jacobian(result)},
         {"skin_mass_g", mass_g},
         {"mesh", {{"vertices", mesh.points.size()}, {"cells", mesh.cells.size()}}}};
  for (const std::size_t s : {0U, 1U}) {
    j["breast_volume_cm3"][side_letter[s]] = volumes[s].breast_cm3;
    j["tissue_cm3"][side_letter[s]] = {{"adipose", volumes[s].adipose_cm3},
                                       {"fibroglandular", volumes[s].fibroglandular_cm3},
                                       {"model", volumes[s].model_cm3}};
  }
  return j;
}

void write_fig7(const CaseResult& result, const std::filesystem::path& file) {
  io::Fields moved;
  moved.point.push_back(displacement_mm(result.points(result.before), result.points(result.after)));
  write_skin(result.model.mesh, result.points(result.after), moved, file);
}

}  // namespace

StageNotes run_outcome(const StageInput& in) {
  const auto start = std::chrono::steady_clock::now();
  const CaseResult result = load_result(in.patient);
  const Volumes volumes = outcome::tissue_volumes(result.model.mesh, result.model.mesh.points,
                                                  result.model.fibroglandular, result.model.side,
                                                  result.model.in_breast);
  const double mass_g = skin_mass_g(result, tissue_values(in.parameters()).skin);
  json j = outcome_json(in.patient, result, volumes, mass_g);
  write_text(in.out / "tissue_table.csv", tissue_table(volumes, mass_g));
  write_text(in.out / "volume_history.csv", volume_history(result));
  write_fig7(result, in.out / "skin_displacement.vtp");
  const Skin skin = skin_of(result);
  const Scans scans = load_scans(in.patient, result, skin, in.from(Stage::Outcome) / scan_poses,
                                 in.out / scan_poses, in.ctx);
  j["scans"] = scans_json(scans);
  if (in.patient.scan_only()) {
    j["scan_only"] = json::parse(read_text(in.from(Stage::Segment) / "scan_only.json"));
  }
  const Cosmetics cosmetics = cosmetics_of(result, skin);
  j["cosmetics"] = cosmetics_json(cosmetics);
  add_wall_range(in.patient, j);
  write_text(in.out / "metrics.csv", cosmetics_csv(cosmetics));
  if (scans.followup) {
    write_text(in.out / "table1.csv", table1_csv(*scans.followup));
  }

  StageNotes notes;
  if (in.parameters().text("outcome.pictures") == "yes") {
    in.ctx.at(0.5, "pictures");
    if (const auto reason = write_pictures(result, in.out, in.ctx)) {
      notes.warnings.push_back("no pictures: " + *reason);
    }
  }
  if (in.patient.scan_only() && j["wall_range"].is_null()) {
    notes.warnings.emplace_back(
        "what the unknown chest wall does to the displacements was not computed; run --set "
        "outcome.wall_range=yes (two more runs)");
  }
  j["warnings"] = collect_warnings(in.patient);
  for (const std::string& warning : notes.warnings) {
    j["warnings"].push_back("outcome: " + warning);
  }
  j["seconds"] = collect_seconds(in.patient);
  j["seconds"]["outcome"] =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  write_text(in.out / "outcome.json", j.dump(2) + "\n");
  return notes;
}

}  // namespace sanatrix::pipeline
