// What a plan would remove, answered from memory while the surgeon is still drawing. The same code
// as stage `surgery`.
#pragma once

#include "pipeline/case_view.hpp"

namespace sanatrix::pipeline {

/// In the surgeon's words: where the tumour is, seen from the nipple of the standing patient.
struct TumourPlace {
  std::string quadrant;                        ///< "upper outer", "central"
  double clock_hour = 0.0;                     ///< 0..12, as seen by somebody facing the patient
  double from_nipple_mm = 0.0;                 ///< straight
  double to_skin_mm = 0.0, to_chest_mm = 0.0;  ///< from the tumour's surface
};

struct PlanPreview {
  surgery::Wound wound;
  double excised_g = 0.0;
  double breast_cm3 = 0.0;  ///< of the operated breast, prone, as in outcome.json
  TumourPlace place;
  TriMesh surface;                           ///< of what is removed, in the plan's pose [m]
  std::vector<std::vector<Vec3>> incisions;  ///< on the skin, in the plan's pose [m]
};

PlanPreview preview(const surgery::Plan& plan, const CaseView& view, const Parameters& parameters,
                    surgery::Detail detail);
/// A usual incision for this plan, in the plan's frame: "circumareolar", "radial", "inframammary".
/// Error{Input} for other words.
std::vector<Vec3> usual_incision(const std::string& kind, const surgery::Plan& plan,
                                 const CaseView& view);
TumourPlace tumour_place(const surgery::Plan& plan, const CaseView& view);

}  // namespace sanatrix::pipeline
