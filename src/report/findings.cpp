#include "report/findings.hpp"

#include "core/error.hpp"
#include "core/files.hpp"
#include "pipeline/body.hpp"

namespace sanatrix::report {

using pipeline::Stage;

Findings find(const pipeline::Case& patient, const Context& ctx) {
  for (const auto& stage : pipeline::all_stages()) {
    const pipeline::StageStatus status = pipeline::status(patient, stage.id);
    if (status.state != pipeline::State::Fresh) {
      throw Error(Fault::Input,
                  fmt::format("{}: its stage {} is {} ({})", patient.folder.filename().string(),
                              stage.name, pipeline::name_of(status.state), status.reason),
                  "bring the case up to date with `sanatrix run` first");
    }
  }
  Findings f{.patient = patient,
             .result = pipeline::load_result(patient),
             .skin = {},
             .scans = {},
             .outcome = {},
             .folder = std::filesystem::absolute(patient.folder).lexically_normal().filename()};
  if (f.folder.empty()) {
    f.folder =
        std::filesystem::absolute(patient.folder).lexically_normal().parent_path().filename();
  }
  f.skin = pipeline::skin_of(f.result);
  const auto outcome = patient.stage_folder(Stage::Outcome);
  f.scans = pipeline::load_scans(patient, f.result, f.skin, outcome / "scan_poses.bin", {}, ctx);
  f.outcome = nlohmann::json::parse(read_text(outcome / "outcome.json"));
  return f;
}

namespace {

surgery::Place place_as_imaged(const pipeline::CaseResult& r) {
  const TetMesh& mesh = r.model.mesh;
  Vec3 centre = r.plan.tumour_centre;
  if (r.plan.frame == surgery::Frame::Supine) {
    const TetLocator::Place at = TetLocator(mesh, r.points(r.supine)).nearest(centre);
    centre = {};
    for (std::size_t k = 0; k < 4; ++k) {
      const int vertex = mesh.cells[static_cast<std::size_t>(at.cell)][k];
      centre += at.barycentric[k] * mesh.points[static_cast<std::size_t>(vertex)];
    }
  }
  const bool left = r.side() > 0;
  const auto nipple = static_cast<std::size_t>(r.model.nipple_vertex[left ? 1 : 0]);
  return surgery::place_of(centre, mesh.points[nipple],
                           left ? surgery::Side::Left : surgery::Side::Right);
}

}  // namespace

PlanInWords in_words(const Findings& f) {
  const pipeline::CaseResult& r = f.result;
  PlanInWords words;
  const int side = r.side();
  words.side = side > 0 ? "LEFT" : "RIGHT";
  const bool supine = r.plan.frame == surgery::Frame::Supine;
  words.place = place_as_imaged(r);
  words.margin_mm = 1e3 * r.plan.margin;
  words.radius_mm = 1e3 * r.plan.radius.value_or(r.plan.tumour_radius + r.plan.margin);
  words.excised_cm3 = 1e6 * r.wound.excised_m3;
  words.excised_percent = f.outcome.at("excised_percent");
  words.skin_mm = 1e3 * r.wound.min_skin_distance_m;
  words.chest_mm = 1e3 * r.wound.min_chest_distance_m;
  const auto tissue = pipeline::tissue_values(f.patient.parameters);
  const std::vector<double> volumes = cell_volumes(
      r.model.mesh, supine ? r.points(r.supine) : std::span<const Vec3>(r.model.mesh.points));
  double mass = 0, volume = 0;
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    const double share = r.model.fibroglandular[c];
    const double density =
        share * tissue.fibroglandular.density + (1 - share) * tissue.adipose.density;
    mass += r.wound.fraction[c] * volumes[c] * density;
    volume += r.wound.fraction[c] * volumes[c];
  }
  words.excised_g = volume > 0 ? 1e3 * mass / volume * r.wound.excised_m3 : 0.0;
  return words;
}

}  // namespace sanatrix::report
