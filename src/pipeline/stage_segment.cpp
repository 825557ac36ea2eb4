// Step B: labels on an isotropic grid with landmarks, from given labels or from the image itself.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/files.hpp"
#include "imaging/moved_wall.hpp"
#include "imaging/skin_landmarks.hpp"
#include "io/image_file.hpp"
#include "pipeline/segmentation_store.hpp"
#include "pipeline/stages.hpp"
#include "pipeline/standing_scan.hpp"
#include "pipeline/tumour.hpp"
#include "render/overlay.hpp"
#include "standing/standing_body.hpp"

namespace sanatrix::pipeline {
namespace {

using nlohmann::json;

json quality_json(const imaging::Quality& q) {
  return {{"soft_tissue_cm3", {{"R", q.soft_cm3[0]}, {"L", q.soft_cm3[1]}}},
          {"fibroglandular_cm3", {{"R", q.glandular_cm3[0]}, {"L", q.glandular_cm3[1]}}},
          {"chest_wall_contrast", q.wall_contrast},
          {"chest_wall_seen_share", q.wall_seen},
          {"chest_wall_blind_share", q.wall_blind},
          {"open_slices", q.open_slices},
          {"chest_wall_roughness_mm", q.wall_roughness_mm},
          {"fat_gland_separation_sd", q.separation},
          {"doubts", q.doubts}};
}

imaging::Segmentation from_image(const StageInput& in, StageNotes& notes) {
  const Image3<float> image = io::read_image(in.patient.input("image"));
  std::optional<imaging::TumourSphere> tumour;
  if (in.patient.inputs.contains("tumour")) {
    tumour = tumour_from(read_text(in.patient.input("tumour")));
  }
  imaging::ImageSegmentation found = imaging::segment_image(
      image, in.parameters().number("segment.spacing_mm"), tumour, in.ctx.part(0.0, 0.9));
  write_text(in.out / "quality.json", quality_json(found.quality).dump(2) + "\n");
  std::vector<Vec3> marks;
  for (const imaging::SkinLandmark& mark : imaging::skin_landmarks(found.segmentation)) {
    if (mark.at_mm) {
      marks.push_back(*mark.at_mm);
    }
  }
  render::write_overlay(image, found.segmentation.labels, marks, in.out / "overlay.png");
  notes.numbers = {{"chest_wall_seen_share", found.quality.wall_seen},
                   {"fat_gland_separation_sd", found.quality.separation},
                   {"fibroglandular_left_cm3", found.quality.glandular_cm3[1]},
                   {"fibroglandular_right_cm3", found.quality.glandular_cm3[0]}};
  return std::move(found.segmentation);
}

/// Volume fraction of fibroglandular tissue in a breast of a density class;
/// docs/theory/scan-only.md
double gland_share(const std::string& density) {
  return density == "a" ? 0.12 : density == "b" ? 0.20 : density == "c" ? 0.35 : 0.55;
}

/// From nothing but the scanned skin: what is estimated is said wherever results are read.
imaging::Segmentation from_scan(const StageInput& in, StageNotes& notes) {
  const StandingScan scan = load_standing_scan(in.patient);
  const std::string density = in.parameters().text("segment.density");
  const double depth_mm = in.parameters().number("segment.wall_depth_mm") +
                          in.parameters().number("segment.wall_shift_mm");
  standing::StandingBody body =
      standing::build_body(scan.skin, scan.nipple,
                           {.spacing_mm = in.parameters().number("segment.spacing_mm"),
                            .gland_share = gland_share(density),
                            .wall_depth_mm = depth_mm},
                           in.ctx.part(0.0, 0.9));
  const auto sides = [](const std::array<double, 2>& v) {
    return json{{"R", v[0]}, {"L", v[1]}};
  };
  const json j{{"chest_wall",
                {{"estimated", true},
                 {"depth_beside_breasts_mm", depth_mm},
                 {"doubt_mm", standing::wall_doubt_mm}}},
               {"breast_volume_doubt_cm3", sides(body.breast_doubt_cm3)},
               {"density_class", density},
               {"fibroglandular_share", gland_share(density)},
               {"scan_unit", scan.unit},
               {"nipples", json::parse(scan.nipples)},
               {"scan_not_seen_share", body.unseen_share},
               {"notes", scan.notes}};
  write_text(in.out / "scan_only.json", j.dump(2) + "\n");
  auto& warnings = body.segmentation.warnings;
  warnings.push_back(fmt::format(
      "no image: the chest wall is estimated from the skin, +-{:.0f} mm (1 sd), and with it the "
      "volumes of the breasts, R +-{:.0f} cm3, L +-{:.0f} cm3",
      standing::wall_doubt_mm, body.breast_doubt_cm3[0], body.breast_doubt_cm3[1]));
  warnings.push_back(fmt::format(
      "no image: tissue is taken as an even mixture, {:.0f} % fibroglandular (density class {})",
      100 * gland_share(density), density));
  warnings.insert(warnings.end(), scan.notes.begin(), scan.notes.end());
  notes.numbers = {{"labelled_breast_right_cm3", body.breast_cm3[0]},
                   {"labelled_breast_left_cm3", body.breast_cm3[1]},
                   {"scan_not_seen_share", body.unseen_share}};
  return std::move(body.segmentation);
}

}  // namespace

StageNotes run_segment(const StageInput& in) {
  StageNotes notes;
  imaging::Segmentation segmentation =
      in.patient.inputs.contains("labels")
          ? imaging::segment_given_labels(in.patient.input("labels"),
                                          imaging::parse_label_preset(in.patient.label_preset),
                                          in.parameters().number("segment.spacing_mm"), in.ctx)
      : in.patient.scan_only() ? from_scan(in, notes)
                               : from_image(in, notes);
  const double shift_mm = in.parameters().number("segment.wall_shift_mm");
  if (shift_mm != 0 && !in.patient.scan_only()) {
    imaging::move_wall(segmentation, shift_mm);
  }
  save_segmentation(segmentation, in.out);
  notes.warnings = segmentation.warnings;
  notes.numbers.emplace_back("midline_x_mm", segmentation.midline_x_mm);
  return notes;
}

}  // namespace sanatrix::pipeline
