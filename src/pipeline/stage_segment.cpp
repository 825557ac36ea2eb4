// Step B for given labels: checked, resampled to an isotropic grid, landmarks found.
#include "pipeline/segmentation_store.hpp"
#include "pipeline/stages.hpp"

namespace sanatrix::pipeline {

StageNotes run_segment(const StageInput& in) {
  const imaging::Segmentation segmentation = imaging::segment_given_labels(
      in.patient.input("labels"), imaging::parse_label_preset(in.patient.label_preset),
      in.parameters().number("segment.spacing_mm"), in.ctx);
  save_segmentation(segmentation, in.out);
  StageNotes notes;
  notes.warnings = segmentation.warnings;
  notes.numbers = {{"midline_x_mm", segmentation.midline_x_mm}};
  return notes;
}

}  // namespace sanatrix::pipeline
