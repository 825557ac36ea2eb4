// Step B: labels on an isotropic grid with landmarks, from given labels or from the image itself.
#include <nlohmann/json.hpp>

#include "core/files.hpp"
#include "io/image_file.hpp"
#include "pipeline/segmentation_store.hpp"
#include "pipeline/stages.hpp"
#include "pipeline/tumour.hpp"
#include "render/overlay.hpp"

namespace sanatrix::pipeline {
namespace {

using nlohmann::json;

json quality_json(const imaging::Quality& q) {
  return {{"soft_tissue_cm3", {{"R", q.soft_cm3[0]}, {"L", q.soft_cm3[1]}}},
          {"fibroglandular_cm3", {{"R", q.glandular_cm3[0]}, {"L", q.glandular_cm3[1]}}},
          {"chest_wall_contrast", q.wall_contrast},
          {"chest_wall_seen_share", q.wall_seen},
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
  render::write_overlay(image, found.segmentation.labels, in.out / "overlay.png");
  notes.numbers = {{"chest_wall_seen_share", found.quality.wall_seen},
                   {"fat_gland_separation_sd", found.quality.separation},
                   {"fibroglandular_left_cm3", found.quality.glandular_cm3[1]},
                   {"fibroglandular_right_cm3", found.quality.glandular_cm3[0]}};
  return std::move(found.segmentation);
}

}  // namespace

StageNotes run_segment(const StageInput& in) {
  StageNotes notes;
  const imaging::Segmentation segmentation =
      in.patient.inputs.contains("labels")
          ? imaging::segment_given_labels(in.patient.input("labels"),
                                          imaging::parse_label_preset(in.patient.label_preset),
                                          in.parameters().number("segment.spacing_mm"), in.ctx)
          : from_image(in, notes);
  save_segmentation(segmentation, in.out);
  notes.warnings = segmentation.warnings;
  notes.numbers.emplace_back("midline_x_mm", segmentation.midline_x_mm);
  return notes;
}

}  // namespace sanatrix::pipeline
